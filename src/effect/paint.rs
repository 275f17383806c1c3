//! From moments to frames: one picture, or one that fades into another.

use super::{Moment, RUN};
use crate::{
    frame::{
        FrameMut, Rect,
        pack::{Level, Levels, pack},
    },
    math::{Factor, mul_q15, q15},
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

/// Paints `moment` into `out`, at a share of its `brightness` of 0..=1.
pub fn one(moment: &impl Moment, paint: Paint, brightness: Factor, out: &mut FrameMut<'_>) {
    match paint {
        Paint::Everything => part(moment, Rect::whole(moment.size()), brightness, out),
        Paint::Motion => {
            let dim = Dim::new(brightness);
            for y in 0..moment.size().height {
                moment.moving(y).for_each(|span| one_span(moment, span, y, dim, out));
            }
        }
    }
}

/// Paints all of `moment` that lies in `rect`, which is within it.
pub fn part(moment: &impl Moment, rect: Rect, brightness: Factor, out: &mut FrameMut<'_>) {
    let dim = Dim::new(brightness);
    for y in rect.rows() {
        one_span(moment, rect.columns(), y, dim, out);
    }
}

#[inline(always)]
fn one_span(moment: &impl Moment, span: Range<usize>, y: u32, dim: Dim, out: &mut FrameMut<'_>) {
    runs(span, y, out, |x, levels| {
        moment.levels(x, y, levels);
        dim.apply(levels);
    });
}

/// Paints all that lies in `rect` of `from` faded into `to` by `share` of 0..=1, both of the size of `out`.
pub fn fade(
    (from, to): (&impl Moment, &impl Moment),
    share: Factor,
    rect: Rect,
    brightness: Factor,
    out: &mut FrameMut<'_>,
) {
    let (share, dim) = (q15(share), Dim::new(brightness));
    let mut new = [[0; RUN]; 3];
    for y in rect.rows() {
        runs(rect.columns(), y, out, |x, levels| {
            let [red, green, blue] = new.each_mut().map(|plane| &mut plane[..levels.red.len()]);
            let mut new = Levels { red, green, blue };
            from.levels(x, y, levels);
            to.levels(x, y, &mut new);
            for (old, new) in levels.planes().into_iter().zip(new.planes()) {
                for (old, &mut new) in old.iter_mut().zip(new) {
                    let step = mul_q15(new as i16 - *old as i16, share);
                    *old = (*old as i16 + step) as Level;
                }
            }
            dim.apply(levels);
        });
    }
}

/// Paints `rect` in one sRGB `colour`.
pub fn plain(colour: [u8; 3], rect: Rect, brightness: Factor, out: &mut FrameMut<'_>) {
    let dim = Dim::new(brightness);
    for y in rect.rows() {
        runs(rect.columns(), y, out, |_, levels| {
            for (plane, level) in levels.planes().into_iter().zip(colour) {
                plane.fill(Level::from(level) << 4);
            }
            dim.apply(levels);
        });
    }
}

/// Fills the columns `span` of row `y`, a run at a time.
#[inline(always)]
fn runs(span: Range<usize>, y: u32, out: &mut FrameMut<'_>, mut fill: impl FnMut(usize, &mut Levels<'_>)) {
    let format = out.layout().format;
    let bytes = format.bytes_per_pixel();
    let pixels = out.row(y)[span.start * bytes..span.end * bytes].chunks_mut(RUN * bytes);
    let mut planes = [[0; RUN]; 3];
    for (x, pixels) in (span.start..).step_by(RUN).zip(pixels) {
        let [red, green, blue] = planes.each_mut().map(|plane| &mut plane[..pixels.len() / bytes]);
        let mut levels = Levels { red, green, blue };
        fill(x, &mut levels);
        pack(format, &levels, x as u32, y, pixels);
    }
}

/// A share of the brightness, of the coded levels.
#[derive(Clone, Copy)]
struct Dim(Option<i16>);

impl Dim {
    fn new(brightness: Factor) -> Self {
        Self((brightness < Factor::ONE).then(|| q15(brightness)))
    }

    #[inline(always)]
    fn apply(self, levels: &mut Levels<'_>) {
        let Self(Some(share)) = self else { return };
        for plane in levels.planes() {
            plane.iter_mut().for_each(|level| *level = mul_q15(*level as i16, share) as Level);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{FrameRef, Layout, PixelFormat, Size};

    /// A picture of one grey.
    struct Flat(Level);

    impl Moment for Flat {
        fn size(&self) -> Size {
            Size::new(300, 2)
        }

        fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
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

    #[test]
    fn motion_paints_what_moves_and_nothing_else() {
        let frame = painted(|out| one(&Flat(100), Paint::Motion, Factor::ONE, out));
        for (x, &level) in frame.iter().enumerate().take(300) {
            let moves = (10..20).contains(&x) || x >= 200;
            assert_eq!(level, if moves { 100 } else { 7 }, "column {x}");
        }
    }

    #[test]
    fn a_part_or_a_plain_rectangle_leaves_the_rest_alone() {
        let rect = Rect { x: 130, y: 1, size: Size::new(140, 1) };
        let part = painted(|out| part(&Flat(100), rect, Factor::ONE / 2, out));
        let plain = painted(|out| plain([9, 80, 9], rect, Factor::ONE, out));
        for (i, (part, plain)) in part.into_iter().zip(plain).enumerate() {
            let want = if (430..570).contains(&i) { (50, 80) } else { (7, 7) };
            assert_eq!((part, plain), want, "pixel {i}");
        }
    }

    #[test]
    fn a_fade_starts_at_the_old_picture_and_ends_at_the_new() {
        for (share, level) in [(0, 200), (1, 175), (2, 150), (4, 100)] {
            let share = Factor::from_num(share) / 4;
            let frame = painted(|out| {
                fade((&Flat(200), &Flat(100)), share, Rect::whole(Size::new(300, 2)), Factor::ONE, out)
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
