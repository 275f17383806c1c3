//! From moments to frames: one picture, or one that fades into another.

use super::{Moment, RUN};
use crate::{
    frame::{
        FrameMut, PixelFormat, Rect, Size,
        pack::{self, Level, Levels, pack_block},
    },
    math::{
        Factor,
        lanes::{self, LANES, Lanes, Task, on_widest},
        q15,
    },
};
use core::{marker::PhantomData, ops::Range};

/// What part of a frame must be painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Every pixel: what the frame holds is unknown.
    Everything,
    /// What moves: the frame holds an earlier frame of the same effect, prepared as it is now and as bright.
    Motion,
}

/// Paints `moment` into `out`, at a share of its `brightness` of 0..=1.
pub fn one(moment: &impl Moment, paint: Paint, brightness: Factor, out: &mut FrameMut<'_>) {
    match paint {
        Paint::Everything => part(moment, Rect::whole(moment.size()), brightness, out),
        Paint::Motion => place(moment, Area::Moving, brightness, out),
    }
}

/// Paints all of `moment` that lies in `rect`, which is within it.
pub fn part(moment: &impl Moment, rect: Rect, brightness: Factor, out: &mut FrameMut<'_>) {
    place(moment, Area::Rect(rect), brightness, out);
}

/// Paints all that lies in `rect` of `from` faded into `to` by `share` of 0..=1, both of the size of `out`.
pub fn fade(
    (from, to): (&impl Moment, &impl Moment),
    share: Factor,
    rect: Rect,
    brightness: Factor,
    out: &mut FrameMut<'_>,
) {
    part(&Faded { from, to, share: q15(share) }, rect, brightness, out);
}

/// Paints `rect` in one sRGB `colour`.
pub fn plain(colour: [u8; 3], rect: Rect, brightness: Factor, out: &mut FrameMut<'_>) {
    part(&Plain { colour, size: out.layout().size }, rect, brightness, out);
}

fn place(moment: &impl Moment, area: Area, brightness: Factor, out: &mut FrameMut<'_>) {
    if brightness < Factor::ONE {
        on_widest(Frame { moment: &Dimmed { moment, share: q15(brightness) }, area, out });
    } else {
        on_widest(Frame { moment, area, out });
    }
}

/// Where is painted.
#[derive(Clone, Copy)]
enum Area {
    /// Where something moves, and what shares a block with it.
    Moving,
    /// These pixels, and no others.
    Rect(Rect),
}

struct Frame<'a, 'b, M> {
    moment: &'a M,
    area: Area,
    out: &'a mut FrameMut<'b>,
}

impl<M: Moment> Task for Frame<'_, '_, M> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        // A loop for each of the formats that panels commonly have.
        match self.out.layout().format {
            PixelFormat::Xrgb8888 => self.rows::<L>(PixelFormat::Xrgb8888),
            PixelFormat::Rgb565 => self.rows::<L>(PixelFormat::Rgb565),
            format => self.rows::<L>(format),
        }
    }
}

impl<M: Moment> Frame<'_, '_, M> {
    #[inline(always)]
    fn rows<L: Lanes>(mut self, format: PixelFormat) {
        match self.area {
            Area::Moving => self.moving::<L>(format),
            Area::Rect(rect) => {
                for y in rect.rows() {
                    let mut span = rect.columns();
                    if !span.start.is_multiple_of(LANES) {
                        span.start = self.end_of_block::<L>(span.clone(), y, format);
                    }
                    self.span::<L>(span, y, format);
                }
            }
        }
    }

    /// Paints what moves, in whole blocks: the still pixels among them become what they are. While a span is painted, the next one is
    /// fetched.
    #[inline(always)]
    fn moving<L: Lanes>(&mut self, format: PixelFormat) {
        let moment = self.moment;
        let Size { width, height } = moment.size();
        let mut last: Option<(Range<usize>, u32)> = None;
        for y in 0..height {
            for span in moment.moving(y) {
                let whole = span.start / LANES * LANES..span.end.next_multiple_of(LANES).min(width as usize);
                moment.fetch::<L>(whole.clone(), y);
                if let Some((span, y)) = last.replace((whole, y)) {
                    self.span::<L>(span, y, format);
                }
            }
        }
        if let Some((span, y)) = last {
            self.span::<L>(span, y, format);
        }
    }

    /// Paints the columns `span` of row `y`, from the start of a block on.
    #[inline(always)]
    fn span<L: Lanes>(&mut self, span: Range<usize>, y: u32, format: PixelFormat) {
        let bytes = format.bytes_per_pixel();
        let thresholds = pack::thresholds(y);
        let mut colours = self.moment.colours::<L>(span.clone(), y);
        let row = &mut self.out.row(y)[span.start * bytes..span.end * bytes];
        let mut blocks = row.chunks_exact_mut(LANES * bytes);
        for out in &mut blocks {
            let Some(colours) = colours.next() else { return };
            pack_block(format, colours, thresholds, out);
        }
        let rest = blocks.into_remainder();
        if !rest.is_empty()
            && let Some(colours) = colours.next()
        {
            let mut whole = [0; LANES * 4];
            pack_block(format, colours, thresholds, &mut whole[..LANES * bytes]);
            rest.copy_from_slice(&whole[..rest.len()]);
        }
    }

    /// Paints the columns `span` of row `y` up to the end of the block that they start in; gives that end.
    #[inline(always)]
    fn end_of_block<L: Lanes>(&mut self, span: Range<usize>, y: u32, format: PixelFormat) -> usize {
        let start = span.start / LANES * LANES;
        let columns = span.start..span.end.min(start + LANES);
        if let Some(colours) = self.moment.colours::<L>(start..columns.end, y).next() {
            let bytes = format.bytes_per_pixel();
            let mut whole = [0; LANES * 4];
            pack_block(format, colours, pack::thresholds(y), &mut whole[..LANES * bytes]);
            self.out.row(y)[columns.start * bytes..columns.end * bytes]
                .copy_from_slice(&whole[(columns.start - start) * bytes..(columns.end - start) * bytes]);
        }
        columns.end
    }
}

/// A picture of one colour.
struct Plain {
    colour: [u8; 3],
    size: Size,
}

impl Moment for Plain {
    fn size(&self) -> Size {
        self.size
    }

    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        core::iter::empty()
    }

    fn levels(&self, _: usize, _: u32, levels: &mut Levels<'_>) {
        for (plane, level) in levels.planes().into_iter().zip(self.colour) {
            plane.fill(Level::from(level) << 4);
        }
    }
}

/// A picture that is not fully lit.
struct Dimmed<'a, M> {
    moment: &'a M,
    /// The share of its levels, Q15.
    share: i16,
}

impl<M: Moment> Moment for Dimmed<'_, M> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.moment.size()
    }

    #[inline(always)]
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        self.moment.moving(y)
    }

    #[inline(always)]
    fn fetch<L: Lanes>(&self, columns: Range<usize>, y: u32) {
        self.moment.fetch::<L>(columns, y);
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        levels_of_blocks(self, x, y, levels);
    }

    #[inline(always)]
    fn colours<L: Lanes>(&self, columns: Range<usize>, y: u32) -> impl Iterator<Item = [L; 3]> {
        Dim { colours: self.moment.colours(columns, y), share: L::splat(self.share) }
    }
}

struct Dim<C, L> {
    colours: C,
    share: L,
}

impl<L: Lanes, C: Iterator<Item = [L; 3]>> Iterator for Dim<C, L> {
    type Item = [L; 3];

    #[inline(always)]
    fn next(&mut self) -> Option<[L; 3]> {
        let [red, green, blue] = self.colours.next()?;
        let dim = |levels: L| pack::clipped(levels).times(self.share);
        Some([dim(red), dim(green), dim(blue)])
    }
}

/// A picture that turns into another.
struct Faded<'a, A, B> {
    from: &'a A,
    to: &'a B,
    /// How far it has, Q15.
    share: i16,
}

impl<A: Moment, B: Moment> Moment for Faded<'_, A, B> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.to.size()
    }

    #[inline(always)]
    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        core::iter::once(0..self.size().width as usize)
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        levels_of_blocks(self, x, y, levels);
    }

    #[inline(always)]
    fn colours<L: Lanes>(&self, columns: Range<usize>, y: u32) -> impl Iterator<Item = [L; 3]> {
        let (from, to) = (self.from.colours(columns.clone(), y), self.to.colours(columns, y));
        Blend { from, to, share: L::splat(self.share) }
    }
}

struct Blend<A, B, L> {
    from: A,
    to: B,
    share: L,
}

impl<L: Lanes, A: Iterator<Item = [L; 3]>, B: Iterator<Item = [L; 3]>> Iterator for Blend<A, B, L> {
    type Item = [L; 3];

    #[inline(always)]
    fn next(&mut self) -> Option<[L; 3]> {
        let (from, to) = (self.from.next()?, self.to.next()?);
        let blend = |from: L, to: L| {
            let (from, to) = (pack::clipped(from), pack::clipped(to));
            from.plus(to.minus(from).times(self.share))
        };
        Some([blend(from[0], to[0]), blend(from[1], to[1]), blend(from[2], to[2])])
    }
}

/// [`Moment::levels`] of an effect that computes its pixels in blocks.
pub(super) fn levels_of_blocks(moment: &impl Moment, x: usize, y: u32, levels: &mut Levels<'_>) {
    let end = x + levels.red.len();
    let start = x / LANES * LANES;
    for (colours, start) in moment.colours::<lanes::Plain>(start..end, y).zip((start..).step_by(LANES)) {
        let columns = start.max(x)..(start + LANES).min(end);
        for (plane, colours) in levels.planes().into_iter().zip(colours.map(pack::clipped)) {
            let from = &colours[columns.start - start..columns.end - start];
            plane[columns.start - x..columns.end - x].copy_from_slice(bytemuck::cast_slice(from));
        }
    }
}

/// [`Moment::colours`] of an effect that computes its levels a run at a time.
pub(super) struct Runs<'a, M: ?Sized, L> {
    moment: &'a M,
    y: u32,
    /// The columns that are still to be filled in.
    columns: Range<usize>,
    planes: [[Level; RUN]; 3],
    /// Where the next block stands in `planes`.
    next: usize,
    lanes: PhantomData<L>,
}

impl<'a, M: Moment + ?Sized, L> Runs<'a, M, L> {
    #[inline(always)]
    pub(super) fn new(moment: &'a M, columns: Range<usize>, y: u32) -> Self {
        let columns = columns.start..columns.end.min(moment.size().width as usize);
        Self { moment, y, columns, planes: [[0; RUN]; 3], next: RUN, lanes: PhantomData }
    }

    fn fill(&mut self) {
        let end = self.columns.end.min(self.columns.start + RUN);
        let length = end - self.columns.start;
        let [red, green, blue] = self.planes.each_mut().map(|plane| &mut plane[..length]);
        self.moment.levels(self.columns.start, self.y, &mut Levels { red, green, blue });
        (self.columns.start, self.next) = (end, 0);
    }
}

impl<M: Moment + ?Sized, L: Lanes> Iterator for Runs<'_, M, L> {
    type Item = [L; 3];

    #[inline(always)]
    fn next(&mut self) -> Option<[L; 3]> {
        if self.next == RUN {
            self.fill();
        }
        let at = self.next;
        self.next += LANES;
        let block =
            |plane: &[Level; RUN]| Some(L::load(bytemuck::cast_ref(plane[at..].first_chunk::<LANES>()?)));
        let [red, green, blue] = self.planes.each_ref();
        Some([block(red)?, block(green)?, block(blue)?])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        effect::{
            Effect, Photo,
            shimmer::{Range, Settings, Shimmer, storage_len},
        },
        frame::{FrameRef, Layout},
        math::{Turns, lanes::on_each},
        noise::drive::Drive,
    };
    use proptest::prelude::*;

    /// A picture of one grey.
    struct Flat(Level);

    impl Moment for Flat {
        fn size(&self) -> Size {
            Size::new(300, 2)
        }

        fn moving(&self, _: u32) -> impl Iterator<Item = core::ops::Range<usize>> {
            [10..20, 200..300].into_iter()
        }

        fn levels(&self, _: usize, _: u32, levels: &mut Levels<'_>) {
            levels.planes().into_iter().for_each(|plane| plane.fill(self.0 * 16));
        }
    }

    fn painted(paint: impl FnOnce(&mut FrameMut<'_>)) -> Vec<u8> {
        let layout = Layout::new(Size::new(300, 2), PixelFormat::Xrgb8888, None).unwrap();
        let mut bytes = vec![7; layout.len_bytes()];
        paint(&mut FrameMut::new(&mut bytes, layout).unwrap());
        let frame = FrameRef::new(&bytes, layout).unwrap();
        (0..600).map(|i| frame.rgb(i % 300, i / 300)[1]).collect()
    }

    /// A moment painted into memory that starts and goes on at odd addresses.
    struct Painted<'a, M> {
        moment: &'a M,
        layout: Layout,
    }

    impl<M: Moment> Task for Painted<'_, M> {
        type Output = Vec<u8>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u8> {
            let mut bytes = vec![7; 1 + self.layout.len_bytes()];
            let out = &mut FrameMut::new(&mut bytes[1..], self.layout).unwrap();
            Frame { moment: self.moment, area: Area::Rect(Rect::whole(self.layout.size)), out }.run::<L>();
            bytes
        }
    }

    /// The same by [`Moment::levels`] and [`pack::pack`], whole rows at a time.
    fn painted_plainly(moment: &impl Moment, layout: Layout) -> Vec<u8> {
        let mut bytes = vec![7; 1 + layout.len_bytes()];
        let mut out = FrameMut::new(&mut bytes[1..], layout).unwrap();
        for y in 0..layout.size.height {
            let mut planes = [(); 3].map(|()| vec![0; layout.size.width as usize]);
            let [red, green, blue] = planes.each_mut().map(|plane| &mut plane[..]);
            let mut levels = Levels { red, green, blue };
            moment.levels(0, y, &mut levels);
            pack::pack(layout.format, &levels, 0, y, out.row(y));
        }
        bytes
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn every_instruction_set_paints_what_plain_rust_does(
            width in 1_u32..70, height in 1_u32..4, padding in 0_usize..5, seed: u64, phase: u32, onset in 0..=4_i32
        ) {
            let size = Size::new(width, height);
            let noise = |i: usize| (seed.wrapping_mul(2 * i as u64 + 1) >> 33) as u8;
            let rgb: Vec<u8> = (0..3 * size.pixels()).map(noise).collect();
            let mask: Vec<u8> = (0..size.pixels()).map(|i| noise(i + 7).saturating_sub(60)).collect();
            let prepare = |range| {
                let settings = Settings { range, ..Settings::default() };
                Shimmer::prepare(Photo { size, rgb: &rgb, mask: &mask }, &settings, vec![0; storage_len(size)])
            };
            let (mut old, mut new) = (prepare(Range::Full).unwrap(), prepare(Range::Travelling).unwrap());
            let onset = Factor::from_num(onset) / 4;
            let drive = Drive { amplitude: Factor::ONE, frequency: Factor::ONE, phase: Turns(phase), onset };
            let (old, new) = (old.at(drive), new.at(drive));
            for format in PixelFormat::ALL {
                let stride = width as usize * format.bytes_per_pixel() + padding;
                let layout = Layout::new(size, format, Some(stride)).unwrap();
                let plain = painted_plainly(&new, layout);
                for (name, painted) in on_each(|| Painted { moment: &new, layout }) {
                    prop_assert_eq!(&painted, &plain, "{} {}", name, format);
                }
                let faded = Faded { from: &old, to: &new, share: 12_345 };
                let plain = painted_plainly(&faded, layout);
                for (name, painted) in on_each(|| Painted { moment: &faded, layout }) {
                    prop_assert_eq!(&painted, &plain, "fade, {} {}", name, format);
                }
            }
        }
    }

    #[test]
    fn motion_paints_the_blocks_that_move_and_nothing_else() {
        let frame = painted(|out| one(&Flat(100), Paint::Motion, Factor::ONE, out));
        for (x, &level) in frame.iter().enumerate().take(300) {
            let moves = (0..32).contains(&x) || x >= 192;
            assert_eq!(level, if moves { 100 } else { 7 }, "column {x}");
        }
    }

    #[test]
    fn a_part_is_painted_to_the_pixel() {
        for (x, width) in [(0, 300), (3, 5), (5, 30), (17, 1), (30, 4), (290, 10)] {
            let rect = Rect { x, y: 1, size: Size::new(width, 1) };
            let frame = painted(|out| part(&Flat(100), rect, Factor::ONE, out));
            for (i, &level) in frame.iter().enumerate() {
                let inside = i >= 300 && (x..x + width).contains(&(i as u32 - 300));
                assert_eq!(level, if inside { 100 } else { 7 }, "{rect:?}, pixel {i}");
            }
        }
    }

    #[test]
    fn a_fade_starts_at_the_old_picture_and_ends_at_the_new() {
        for (share, level) in [(0, 200), (1, 175), (2, 150), (4, 100)] {
            let share = Factor::from_num(share) / 4;
            let frame = painted(|out| {
                let whole = Rect::whole(Size::new(300, 2));
                fade((&Flat(200), &Flat(100)), share, whole, Factor::ONE, out);
            });
            assert!(frame.iter().all(|got| got.abs_diff(level) <= 1), "{share}: {frame:?}");
        }
    }

    #[test]
    fn brightness_dims_every_level_alike() {
        for (brightness, level) in [(Factor::ONE, 200), (Factor::ONE / 4, 50), (Factor::ZERO, 0)] {
            let frame = painted(|out| one(&Flat(200), Paint::Everything, brightness, out));
            assert!(frame.iter().all(|got| got.abs_diff(level) <= 1), "{brightness}: {frame:?}");
        }
    }
}
