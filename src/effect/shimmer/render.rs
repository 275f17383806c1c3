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
    effect::{
        self, Area,
        paint::{self, Painter, each_span},
    },
    frame::{
        FrameMut, PixelFormat, Size,
        pack::{Block, pack_block, thresholds},
    },
    math::{
        Factor,
        lanes::{LANES, Lanes, Task, fetch, on_widest},
        q15,
    },
    noise::drive::Drive,
};
use core::{marker::PhantomData, ops::Range};

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

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        let end = self.photo.size.width as usize;
        on_widest(Run { swing: self.swing, from: self.blocks(x..end, y), to: blocks });
    }

    fn paint(&self, area: Area, out: &mut FrameMut<'_>) {
        let in_blocks = match area {
            Area::Moving => true,
            Area::Rect(rect) => (rect.x as usize).is_multiple_of(LANES),
        };
        match out.layout().format {
            PixelFormat::Xrgb8888 | PixelFormat::Rgb565 if in_blocks => {
                on_widest(Frame { moment: self, area, out });
            }
            _ => paint::by_runs(self, area, out),
        }
    }
}

/// Fills `to` with the colours of blocks.
struct Run<'a> {
    swing: Swing,
    from: &'a [Packed],
    to: &'a mut [Block],
}

impl Task for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for ([red, green, blue], block) in self.to.iter_mut().zip(self.from) {
            fetch(block, AHEAD);
            let colours: [L; 3] = self.swing.colours(block);
            colours[0].store(red);
            colours[1].store(green);
            colours[2].store(blue);
        }
    }
}

/// Paints in the formats that panels commonly have, without a stop in memory, in whole blocks.
struct Frame<'a, 'b, 'c> {
    moment: &'a Moment<'b>,
    area: Area,
    out: &'a mut FrameMut<'c>,
}

impl Task for Frame<'_, '_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        match self.out.layout().format {
            PixelFormat::Xrgb8888 => self.spans::<L>(PixelFormat::Xrgb8888),
            _ => self.spans::<L>(PixelFormat::Rgb565),
        }
    }
}

impl Frame<'_, '_, '_> {
    #[inline(always)]
    fn spans<L: Lanes>(self, format: PixelFormat) {
        let Self { moment, area, out } = self;
        each_span(moment, area, &mut Spans { moment, format, out, lanes: PhantomData::<L> });
    }
}

struct Spans<'a, 'b, 'c, L> {
    moment: &'a Moment<'b>,
    format: PixelFormat,
    out: &'a mut FrameMut<'c>,
    lanes: PhantomData<L>,
}

impl<L: Lanes> Painter for Spans<'_, '_, '_, L> {
    /// While a span is painted, the next one is fetched.
    #[inline(always)]
    fn announce(&self, columns: &Range<usize>, y: u32) {
        let blocks = self.moment.blocks(columns.clone(), y);
        if blocks.len() <= SHORT {
            for block in blocks {
                fetch(block, 0);
            }
        }
    }

    #[inline(always)]
    fn columns(&mut self, columns: Range<usize>, y: u32) {
        let bytes = self.format.bytes_per_pixel();
        let thresholds: L = thresholds(y);
        let (swing, mut blocks) = (self.moment.swing, self.moment.blocks(columns.clone(), y).iter());
        let long = blocks.len() > SHORT;
        let row = &mut self.out.row(y)[columns.start * bytes..columns.end * bytes];
        let mut pixels = row.chunks_exact_mut(LANES * bytes);
        for (out, block) in (&mut pixels).zip(&mut blocks) {
            if long {
                fetch(block, AHEAD);
            }
            pack_block(self.format, swing.colours(block), thresholds, out);
        }
        let rest = pixels.into_remainder();
        if let Some(block) = blocks.next()
            && !rest.is_empty()
        {
            let mut whole = [0; LANES * 4];
            pack_block(self.format, swing.colours(block), thresholds, &mut whole[..LANES * bytes]);
            rest.copy_from_slice(&whole[..rest.len()]);
        }
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
        let (a, b) = (L::splat(self.sine), L::splat(self.cosine));
        let [[pu, qu, cu], [pv, qv, cv]] = block.slopes();
        let (u, v) = (shade::slope(a, pu, b, qu, cu), shade::slope(a, pv, b, qv, cv));
        let mut gain = self.light.shade(u, v).plus(L::load(&block.base));
        if let Some(onset) = self.onset {
            gain = gain.minus(L::splat(ONE)).times(L::splat(onset)).plus(L::splat(ONE));
        }
        let [red, green, blue] = &block.colours;
        [L::load_q7(red).times(gain), L::load_q7(green).times(gain), L::load_q7(blue).times(gain)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        effect::{
            Effect as _, Photo,
            shimmer::{Range, Settings, storage_len},
        },
        frame::{Layout, Rect},
        math::{Turns, lanes::on_each},
    };
    use proptest::prelude::*;

    /// A [`Frame`] in memory of its own, which starts at an odd address.
    struct Painted<'a, 'b> {
        moment: &'a Moment<'b>,
        area: Area,
        layout: Layout,
    }

    impl Task for Painted<'_, '_> {
        type Output = Vec<u8>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u8> {
            let mut bytes = vec![7; 1 + self.layout.len_bytes()];
            let out = &mut FrameMut::new(&mut bytes[1..], self.layout).unwrap();
            Frame { moment: self.moment, area: self.area, out }.run::<L>();
            bytes
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn every_instruction_set_paints_what_runs_of_colours_make(
            width in 1_u32..70, height in 1_u32..4, padding in 0_usize..5, seed: u64, phase: u32, onset in 0..=4_i32
        ) {
            let size = Size::new(width, height);
            let noise = |i: usize| (seed.wrapping_mul(2 * i as u64 + 1) >> 33) as u8;
            let rgb: Vec<u8> = (0..3 * size.pixels()).map(noise).collect();
            let mask: Vec<u8> = (0..size.pixels()).map(|i| noise(i + 7).saturating_sub(60)).collect();
            let settings = Settings { range: Range::NAMES[seed as usize % 3].1, ..Settings::default() };
            let photo = Photo { size, rgb: &rgb, mask: &mask };
            let mut shimmer = Shimmer::prepare(photo, &settings, vec![0; storage_len(size)]).unwrap();
            let onset = Factor::from_num(onset) / 4;
            let drive = Drive { amplitude: Factor::ONE, frequency: Factor::ONE, phase: Turns(phase), onset };
            let moment = shimmer.at(drive);
            for (format, area) in [PixelFormat::Xrgb8888, PixelFormat::Rgb565]
                .into_iter()
                .flat_map(|format| [Area::Moving, Area::Rect(Rect::whole(size))].map(|area| (format, area)))
            {
                let stride = width as usize * format.bytes_per_pixel() + padding;
                let layout = Layout::new(size, format, Some(stride)).unwrap();
                let mut plain = vec![7; 1 + layout.len_bytes()];
                paint::by_runs(&moment, area, &mut FrameMut::new(&mut plain[1..], layout).unwrap());
                for (name, painted) in on_each(|| Painted { moment: &moment, area, layout }) {
                    prop_assert_eq!(&painted, &plain, "{} {} {:?}", name, format, area);
                }
            }
        }
    }
}
