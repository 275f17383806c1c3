//! The frame kernel: two swings in, pixels out.
//!
//! Everything is 16-bit lanes ([`crate::math::lanes`]), sixteen pixels at a time, from one stream of blocks: 13 bytes a pixel are
//! read and 2 to 4 written. `yurameki-bench --instructions` counts the instructions of x86-64.
//!
//! # What was tried (x86-64 server of November 2026, in the cache of the third level, on one core)
//! A copy that reads 8 and writes 8 bytes takes 0.55 ns a pixel up to 1920×1080. Reading blocks of n bytes a pixel and writing four, with no
//! arithmetic but sums, takes 1.36 copies with 18 bytes, 1.11 to 1.15 with 14, 1.05 to 1.08 with 13, 0.99 to 1.03 with 12. So it is the bytes
//! that count: with its data in the cache of the second level, the kernel of 18 bytes took 0.44 ns a pixel.
//! - Slopes of 16 bits, a word for the base and a byte for the mask (18 bytes): 1.4 copies. [`Packed`] needs 8 instructions more for a block, the
//!   mask, which scales P and Q instead of the gain, 3 less; the largest error stays 1.3 levels, and its root mean square 0.41.
//! - Slopes of 8 bits with a scale a block (12 bytes less 6 with 18): computed, not built. At full texture each errs by up to 0.4 % of the
//!   steepest slope, which makes 3.7 levels in the worst pixel; the bound is 2. Of 9 bits (12 bytes, with 10 for C, and a mask of 6): 2.3.
//! - Fetching ahead into the second level, twice or half as far, or fetching the frame that is written: no difference. By `prefetchnta`: 2.3 to
//!   6.5 copies. No fetching: 1.16 to 1.18 at 1024×600 instead of 1.08 to 1.14.
//! - A span fetched as a whole while the one before is painted: where a fifth moves, 0.46 to 0.53 of the full frame instead of 0.60 to
//!   0.80. Two spans ahead, and where they go as well: 0.48 to 0.60. In the second level's cache it is 0.30 (and 0.33): the rest is waiting
//!   for memory.
//! - Loops that the compiler vectorises: 2.6 ns with AVX2 ([`crate::math::lanes`] says why). One `flat_map` over all spans: ten times as slow, because
//!   its closures are compiled without the instruction set.
//! - AVX-512, 32 pixels at a time: no gain with 18 bytes; its blocks of 32 pixels touch a third of the memory where a fifth of it moves in spans
//!   of 48 pixels, blocks of 16 a quarter.
//! - Stores that go past the cache: a sixth slower with 18 bytes, and no gain at 3840×2160 either.
//! - A polynomial of degree 5, for slopes of up to 60°: float64 differs by 1.3 levels at worst and 0.40 rms with degree 4, and dithering alone
//!   by 0.94 and √(1/6) = 0.41. There is nothing to win.

use super::{
    Shimmer,
    shade::{self, Light, ONE},
    storage::{Packed, Planes, Prepared},
};
use crate::{
    effect::{self, paint},
    frame::{Size, pack::Levels},
    math::{
        Factor,
        lanes::{LANES, Lanes},
        q15,
    },
    noise::drive::Drive,
};
use core::{marker::PhantomData, ops::Range, slice};

/// A shimmering photo at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    photo: Prepared<'a>,
    swing: Swing,
}

/// What a moment has in common for all pixels.
#[derive(Clone, Copy, Debug)]
struct Swing {
    /// X_A·sin θ, Q15.
    sine: i16,
    /// X_A·cos θ, Q15.
    cosine: i16,
    /// The share of the strength, Q15, while it is not yet whole.
    onset: Option<i16>,
    light: Light,
}

impl<'a> Moment<'a> {
    pub(super) fn new<S: AsMut<[u64]>>(shimmer: &'a mut Shimmer<S>, drive: Drive) -> Self {
        let swing = Swing {
            sine: q15(drive.amplitude * drive.phase.sin()),
            cosine: q15(drive.amplitude * drive.phase.cos()),
            onset: (drive.onset < Factor::ONE).then(|| q15(drive.onset)),
            light: shimmer.light,
        };
        let Ok(planes) = Planes::carve(shimmer.size, shimmer.storage.as_mut()) else {
            unreachable!("the storage was long enough when the photo was prepared")
        };
        Self { photo: Prepared::new(planes), swing }
    }
}

impl Moment<'_> {
    #[inline(always)]
    fn blocks(&self, columns: Range<usize>, y: u32) -> &[Packed] {
        &self.photo.row(y as usize)[columns.start / LANES..columns.end.div_ceil(LANES)]
    }
}

impl effect::Moment for Moment<'_> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.photo.size
    }

    #[inline(always)]
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let spans = self.photo.spans(y as usize).iter();
        spans.take_while(|span| span.start < span.end).map(|span| span.start.into()..span.end.into())
    }

    #[inline(always)]
    fn fetch<L: Lanes>(&self, columns: Range<usize>, y: u32) {
        let blocks = self.blocks(columns, y);
        if blocks.len() <= SHORT {
            blocks.iter().for_each(|block| L::fetch(block, 0));
        }
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        paint::levels_of_blocks(self, x, y, levels);
    }

    #[inline(always)]
    fn colours<L: Lanes>(&self, columns: Range<usize>, y: u32) -> impl Iterator<Item = [L; 3]> {
        let blocks = self.blocks(columns, y);
        Colours { blocks: blocks.iter(), long: blocks.len() > SHORT, swing: self.swing, lanes: PhantomData }
    }
}

/// The colours of a run of blocks.
struct Colours<'a, L> {
    blocks: slice::Iter<'a, Packed>,
    /// Whether there is more to fetch than [`effect::Moment::fetch`] did.
    long: bool,
    swing: Swing,
    lanes: PhantomData<L>,
}

impl<L: Lanes> Iterator for Colours<'_, L> {
    type Item = [L; 3];

    #[inline(always)]
    fn next(&mut self) -> Option<[L; 3]> {
        let block = self.blocks.next()?;
        if self.long {
            L::fetch(block, AHEAD);
        }
        Some(self.swing.colours(block))
    }
}

/// How far ahead blocks are fetched, in bytes. The processors' own fetching ahead stops at the end of a page of 4096.
const AHEAD: usize = 4_608;

/// The most blocks of a span that are fetched as a whole, before it is painted.
const SHORT: usize = 16;

impl Swing {
    /// The colours of a block, with 4 fractional bits, unclipped.
    #[inline(always)]
    fn colours<L: Lanes>(self, block: &Packed) -> [L; 3] {
        let [a, b] = [self.sine, self.cosine].map(L::splat);
        let [u, v] = block.slopes().map(|[p, q, c]| shade::slope(a, p, b, q, c));
        let mut gain = self.light.shade(u, v).plus(L::load(&block.base));
        if let Some(onset) = self.onset {
            gain = gain.minus(L::splat(ONE)).times(L::splat(onset)).plus(L::splat(ONE));
        }
        block.colours.each_ref().map(|channel| L::load_q7(channel).times(gain))
    }
}
