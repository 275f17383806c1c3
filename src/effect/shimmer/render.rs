//! The frame kernel: two swings in, pixels out.
//!
//! Everything is 16-bit lanes ([`crate::math::lanes`]), sixteen pixels at a time, from one stream of blocks: 18 bytes a pixel are
//! read and 2 to 4 written. A pixel takes 6.0 instructions on aarch64 and XRGB8888 (96 a block, counted in the loop's assembly), 8.0 on
//! RGB565; `yurameki-bench --instructions` counts those of x86-64.
//!
//! # What was tried (x86-64 server of November 2026, 640×480, in the cache; nanoseconds a pixel)
//! A copy that reads 8 and writes 8 bytes took 0.54. Reading the blocks and writing four bytes a pixel, with no arithmetic but sums, took
//! 0.75, reading alone 0.61: so 1.4 copies is the floor of 18 bytes, and the kernel is at it: 0.75.
//! - Loops that the compiler vectorises: 2.6 with AVX2 ([`crate::math::lanes`] says why).
//! - AVX-512, 32 pixels at a time: 0.75 too; its blocks of 32 pixels touch a third of the memory where a fifth of it moves in spans of 48
//!   pixels, blocks of 16 a quarter.
//! - Stores that go past the cache: 0.87; no gain at 3840×2160 either.
//! - No fetching ahead: 0.77 to 0.83 there, and 0.96 to 1.3 instead of 0.75 to 0.81 at 1024×600.
//! - Slopes of 8 bits with a scale a block (12 bytes less 6): computed, not built. At full texture each errs by up to 0.4 % of the steepest
//!   slope, which makes 3.7 levels in the worst pixel; the bound is 2.
//! - A polynomial of degree 5, for slopes of up to 60°: float64 differs by 1.3 levels at worst and 0.40 rms with degree 4, and dithering alone
//!   by 0.94 and √(1/6) = 0.41. There is nothing to win.

use super::{
    Shimmer,
    shade::{self, Light, ONE},
    spans,
    storage::{Block, Bytes, Planes, Words},
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
    planes: Planes<'a>,
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
        Self { planes, swing }
    }
}

impl effect::Moment for Moment<'_> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.planes.blocks.size
    }

    #[inline(always)]
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let most = spans::most(self.planes.blocks.size.width);
        let spans = self.planes.spans[y as usize * most..][..most].iter();
        spans.take_while(|span| span.start < span.end).map(|span| span.start.into()..span.end.into())
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        paint::levels_of_blocks(self, x, y, levels);
    }

    #[inline(always)]
    fn colours<L: Lanes>(&self, columns: Range<usize>, y: u32) -> impl Iterator<Item = [L; 3]> {
        let blocks = &self.planes.blocks.row(y as usize)[columns.start / LANES..columns.end.div_ceil(LANES)];
        Colours { blocks: blocks.iter(), swing: self.swing, lanes: PhantomData }
    }
}

/// The colours of a run of blocks.
struct Colours<'a, L> {
    blocks: slice::Iter<'a, Block>,
    swing: Swing,
    lanes: PhantomData<L>,
}

impl<L: Lanes> Iterator for Colours<'_, L> {
    type Item = [L; 3];

    #[inline(always)]
    fn next(&mut self) -> Option<[L; 3]> {
        let block = self.blocks.next()?;
        L::fetch(block, AHEAD);
        Some(self.swing.colours(block))
    }
}

/// How far ahead blocks are fetched, in bytes. The processors' own fetching ahead stops at the end of a page of 4096.
const AHEAD: usize = 4_608;

impl Swing {
    /// The colours of a block, with 4 fractional bits, unclipped.
    #[inline(always)]
    fn colours<L: Lanes>(self, block: &Block) -> [L; 3] {
        let word = |which| L::load(block.words(which));
        let [a, b] = [self.sine, self.cosine].map(L::splat);
        let u = shade::slope(a, word(Words::SineU), b, word(Words::CosineU), word(Words::CentreU));
        let v = shade::slope(a, word(Words::SineV), b, word(Words::CosineV), word(Words::CentreV));
        let mask = L::load_q7(block.bytes(Bytes::Mask));
        let mut gain = self.light.shade(u, v).times(mask).plus(word(Words::Base));
        if let Some(onset) = self.onset {
            gain = gain.minus(L::splat(ONE)).times(L::splat(onset)).plus(L::splat(ONE));
        }
        [Bytes::Red, Bytes::Green, Bytes::Blue].map(|which| L::load_q7(block.bytes(which)).times(gain))
    }
}
