//! From moments to frames: one picture, or one that fades into another.

use super::{Moment, RUN};
use crate::{
    frame::{
        FrameMut, Rect, Size,
        pack::{self, Block, clipped},
    },
    math::{
        Factor,
        lanes::{LANES, Lanes, Task, on_widest},
        q15,
    },
};
use core::ops::Range;

/// What part of a frame must be painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Every pixel: what the frame holds is unknown.
    Everything,
    /// What moves: the frame holds an earlier frame of the same effect, prepared as it is now and as bright.
    Motion,
}

/// Where is painted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Area {
    /// Where something moves, and what shares a block of 16 pixels with it.
    Moving,
    /// These pixels, which are within the picture, and no others.
    Rect(Rect),
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
        Dimmed { moment, share: q15(brightness) }.paint(area, out);
    } else {
        moment.paint(area, out);
    }
}

/// Something that paints pixels side by side.
pub(super) trait Painter {
    /// These columns of row `y` are painted after the next ones.
    #[inline(always)]
    fn announce(&self, _columns: &Range<usize>, _y: u32) {}

    /// Paints the columns of row `y`.
    fn columns(&mut self, columns: Range<usize>, y: u32);
}

/// Has what is in `area` of `moment` painted; what moves in whole blocks: the still pixels among them become what they are.
#[inline(always)]
pub(super) fn each_span(moment: &(impl Moment + ?Sized), area: Area, painter: &mut impl Painter) {
    match area {
        Area::Moving => {
            let Size { width, height } = moment.size();
            let mut last: Option<(Range<usize>, u32)> = None;
            for y in 0..height {
                for span in moment.moving(y) {
                    let whole =
                        span.start / LANES * LANES..span.end.next_multiple_of(LANES).min(width as usize);
                    painter.announce(&whole, y);
                    if let Some((span, y)) = last.replace((whole, y)) {
                        painter.columns(span, y);
                    }
                }
            }
            if let Some((span, y)) = last {
                painter.columns(span, y);
            }
        }
        // No closure: it would be compiled without the instruction set of the painter.
        Area::Rect(rect) => {
            for y in rect.rows() {
                painter.columns(rect.columns(), y);
            }
        }
    }
}

/// [`Moment::paint`] by [`Moment::colours`].
pub(super) fn by_runs(moment: &(impl Moment + ?Sized), area: Area, out: &mut FrameMut<'_>) {
    each_span(moment, area, &mut Runs { moment, blocks: [[[0; LANES]; 3]; RUN], out });
}

struct Runs<'a, 'b, M: ?Sized> {
    moment: &'a M,
    blocks: [Block; RUN],
    out: &'a mut FrameMut<'b>,
}

impl<M: Moment + ?Sized> Painter for Runs<'_, '_, M> {
    fn columns(&mut self, columns: Range<usize>, y: u32) {
        let format = self.out.layout().format;
        let bytes = format.bytes_per_pixel();
        let mut x = columns.start / LANES * LANES;
        while x < columns.end {
            let end = columns.end.min(x + RUN * LANES);
            let blocks = &mut self.blocks[..(end - x).div_ceil(LANES)];
            self.moment.colours(x, y, blocks);
            let start = columns.start.max(x);
            pack::pack(format, blocks, start - x, y, &mut self.out.row(y)[start * bytes..end * bytes]);
            x = end;
        }
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

    fn colours(&self, _: usize, _: u32, blocks: &mut [Block]) {
        blocks.fill(self.colour.map(|level| [i16::from(level) << 4; LANES]));
    }
}

/// A picture that is not fully lit.
struct Dimmed<'a, M> {
    moment: &'a M,
    /// The share of its levels, Q15.
    share: i16,
}

impl<M: Moment> Moment for Dimmed<'_, M> {
    fn size(&self) -> Size {
        self.moment.size()
    }

    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        self.moment.moving(y)
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        self.moment.colours(x, y, blocks);
        on_widest(Dim { blocks, share: self.share });
    }
}

struct Dim<'a> {
    blocks: &'a mut [Block],
    share: i16,
}

impl Task for Dim<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for levels in self.blocks.as_flattened_mut() {
            clipped(L::load(levels)).times(L::splat(self.share)).store(levels);
        }
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
    fn size(&self) -> Size {
        self.to.size()
    }

    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        core::iter::once(0..self.size().width as usize)
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        let mut old = [[[0; LANES]; 3]; RUN];
        let from = &mut old[..blocks.len()];
        self.from.colours(x, y, from);
        self.to.colours(x, y, blocks);
        on_widest(Blend { from, to: blocks, share: self.share });
    }
}

/// Blends what is in `to` with what is in `from`.
struct Blend<'a> {
    from: &'a [Block],
    to: &'a mut [Block],
    share: i16,
}

impl Task for Blend<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (from, to) in self.from.as_flattened().iter().zip(self.to.as_flattened_mut()) {
            let (old, new) = (clipped(L::load(from)), clipped(L::load(to)));
            old.plus(new.minus(old).times(L::splat(self.share))).store(to);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        frame::{FrameRef, Layout, PixelFormat},
        math::lanes::on_each,
    };
    use proptest::prelude::*;

    /// A picture of one grey.
    struct Flat(i16);

    impl Moment for Flat {
        fn size(&self) -> Size {
            Size::new(300, 2)
        }

        fn moving(&self, _: u32) -> impl Iterator<Item = core::ops::Range<usize>> {
            [10..20, 200..300].into_iter()
        }

        fn colours(&self, _: usize, _: u32, blocks: &mut [Block]) {
            blocks.fill([[self.0 * 16; LANES]; 3]);
        }
    }

    fn painted(paint: impl FnOnce(&mut FrameMut<'_>)) -> Vec<u8> {
        let layout = Layout::new(Size::new(300, 2), PixelFormat::Xrgb8888, None).unwrap();
        let mut bytes = vec![7; layout.len_bytes()];
        paint(&mut FrameMut::new(&mut bytes, layout).unwrap());
        let frame = FrameRef::new(&bytes, layout).unwrap();
        (0..600).map(|i| frame.rgb(i % 300, i / 300)[1]).collect()
    }

    /// [`Dim`], then [`Blend`], of blocks of one's own.
    #[derive(Clone)]
    struct DimAndBlend {
        from: [Block; 3],
        to: [Block; 3],
        shares: [i16; 2],
    }

    impl Task for DimAndBlend {
        type Output = [Block; 3];

        #[inline(always)]
        fn run<L: Lanes>(mut self) -> [Block; 3] {
            Dim { blocks: &mut self.from, share: self.shares[0] }.run::<L>();
            Blend { from: &self.from, to: &mut self.to, share: self.shares[1] }.run::<L>();
            self.to
        }
    }

    proptest! {
        #[test]
        fn every_instruction_set_dims_and_blends_as_plain_rust_does(
            from: [Block; 3], to: [Block; 3], shares in [0..=i16::MAX, 0..=i16::MAX]
        ) {
            let all = on_each(|| DimAndBlend { from, to, shares });
            for (name, blocks) in &all {
                prop_assert_eq!(blocks, &all[0].1, "{}", name);
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
