//! Where on a panel the frames of a clip lie.

use super::Shape;
use crate::frame::{Rect, Rotation, Size};
use bytemuck::{Pod, Zeroable};

/// Where on a panel a clip's base lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// How the panel is mounted.
    pub rotation: Rotation,
    /// Where the base lies on the panel as a person sees it.
    pub picture: Rect,
    /// The shares of its width and height, as fractions, that lie there: its middle.
    pub shown: [(u64, u64); 2],
}

impl View {
    /// All of the base on all of a panel of `size`.
    pub const fn whole(size: Size) -> Self {
        Self { rotation: Rotation::None, picture: Rect::whole(size), shown: [(1, 1); 2] }
    }

    /// The axes along the columns and the rows of the mounted panel, whose size is `panel`.
    pub(super) const fn axes(&self, shape: &Shape, panel: Size) -> [Axis; 2] {
        let Self { rotation, picture: Rect { x, y, size }, shown: [wide, high] } = *self;
        let seen = rotation.turned(panel);
        let Rect { x: left, y: top, size: part } = shape.rect;
        let across = Axis {
            panel: seen.width,
            start: x,
            length: size.width,
            shown: wide,
            base: shape.base.width,
            part: (left, part.width),
            grid: shape.grid.width,
            mirrored: false,
        };
        let down = Axis {
            panel: seen.height,
            start: y,
            length: size.height,
            shown: high,
            base: shape.base.height,
            part: (top, part.height),
            grid: shape.grid.height,
            mirrored: false,
        };
        match rotation {
            Rotation::None => [across, down],
            Rotation::Quarter => [down.mirrored(), across],
            Rotation::Half => [across.mirrored(), down.mirrored()],
            Rotation::ThreeQuarter => [down, across.mirrored()],
        }
    }
}

/// Fractional bits of positions: a pixel of the widest base in 1/2^20, times the largest grid, stays far below 2^63.
const POSITION_BITS: u32 = 20;

/// From pixels of the panel to pixels of the grid, along one side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    /// Pixels of the panel.
    panel: u32,
    /// Where the picture starts on it, and how long it is.
    start: u32,
    length: u32,
    /// The share of the base that is shown.
    shown: (u64, u64),
    base: u32,
    /// Where the part of the base starts that the grid covers, and how long it is.
    part: (u32, u32),
    grid: u32,
    /// Both run backwards on the mounted panel.
    mirrored: bool,
}

/// Between which two pixels of the grid a pixel of the panel lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Place {
    /// The first of them.
    pub(super) index: u16,
    /// How near to the second, Q15.
    pub(super) weight: i16,
}

impl Axis {
    const fn mirrored(self) -> Self {
        Self { mirrored: true, ..self }
    }

    /// Where pixel `at` of the mounted panel lies; `None` if it is not in the part that the grid covers.
    pub(super) fn place(&self, at: u32) -> Option<Place> {
        let upright = if self.mirrored { self.panel - 1 - at } else { at };
        let along = upright.checked_sub(self.start).filter(|&along| along < self.length)?;
        let base = i64::from(self.base) << POSITION_BITS;
        let (part, whole) = self.shown;
        let shown = (i128::from(base) * i128::from(part) / i128::from(whole)) as i64;
        let on_base = (base - shown) / 2 + shown * (2 * i64::from(along) + 1) / (2 * i64::from(self.length));
        let on_part = on_base - (i64::from(self.part.0) << POSITION_BITS);
        if !(0..i64::from(self.part.1) << POSITION_BITS).contains(&on_part) {
            return None;
        }
        let middle = on_part * i64::from(self.grid) / i64::from(self.part.1) - (1 << (POSITION_BITS - 1));
        let last = i64::from(self.grid - 1) << POSITION_BITS;
        let on_grid = middle.clamp(0, last);
        let on_grid = if self.mirrored { last - on_grid } else { on_grid };
        let index = on_grid >> POSITION_BITS;
        let weight = on_grid - (index << POSITION_BITS) >> (POSITION_BITS - 15);
        Some(Place { index: index as u16, weight: weight as i16 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effect::fluid::Kind;

    fn shape(base: Size, grid: Size, rect: Rect) -> Shape {
        Shape { kind: Kind::Luma, millihertz: 25_000, step: 1, base, grid, rect }
    }

    #[test]
    fn pixels_of_the_grids_own_size_are_its_pixels() {
        let size = Size::new(40, 30);
        let [across, down] = View::whole(size).axes(&shape(size, size, Rect::whole(size)), size);
        for x in 0..40 {
            assert_eq!(across.place(x), Some(Place { index: x as u16, weight: 0 }));
        }
        assert_eq!(down.place(29), Some(Place { index: 29, weight: 0 }));
    }

    #[test]
    fn only_the_part_that_the_grid_covers_has_a_place() {
        let size = Size::new(40, 30);
        let rect = Rect { x: 10, y: 5, size: Size::new(20, 10) };
        let [across, _] = View::whole(size).axes(&shape(size, Size::new(5, 5), rect), size);
        let inside: Vec<u32> = (0..40).filter(|&x| across.place(x).is_some()).collect();
        assert_eq!(inside, (10..30).collect::<Vec<_>>());
        assert_eq!(across.place(10), Some(Place { index: 0, weight: 0 }), "the edge repeats");
        assert_eq!(across.place(29).map(|place| place.index), Some(4));
    }

    #[test]
    fn a_panel_that_is_mounted_turned_sees_the_same_places_turned() {
        let (seen, grid) = (Size::new(40, 30), Size::new(7, 6));
        let rect = Rect { x: 3, y: 2, size: Size::new(30, 20) };
        let shape = shape(Size::new(44, 33), grid, rect);
        let exact =
            |axis: &Axis, at| axis.place(at).map(|p| f64::from(p.index) + f64::from(p.weight) / 32_768.0);
        let upright = View { picture: Rect { x: 1, y: 0, size: Size::new(38, 30) }, ..View::whole(seen) };
        let [across, down] = upright.axes(&shape, seen);
        for rotation in Rotation::ALL {
            let panel = rotation.turned(seen);
            let [columns, rows] = View { rotation, ..upright }.axes(&shape, panel);
            let turned_grid = rotation.turned(grid);
            for (x, y) in (0..40).flat_map(|x| (0..30).map(move |y| (x, y))) {
                let at = rotation.turned_place((x, y), seen);
                let (column, row) = (at as u32 % panel.width, at as u32 / panel.width);
                let want = exact(&across, x as u32).zip(exact(&down, y as u32));
                let got = exact(&columns, column).zip(exact(&rows, row));
                // Where on the turned grid the wanted place is.
                let want = want.map(|(gx, gy)| match rotation {
                    Rotation::None => (gx, gy),
                    Rotation::Quarter => (f64::from(turned_grid.width - 1) - gy, gx),
                    Rotation::Half => (f64::from(grid.width - 1) - gx, f64::from(grid.height - 1) - gy),
                    Rotation::ThreeQuarter => (gy, f64::from(turned_grid.height - 1) - gx),
                });
                let near = match (got, want) {
                    (Some(a), Some(b)) => (a.0 - b.0).abs() < 1e-4 && (a.1 - b.1).abs() < 1e-4,
                    (a, b) => a.is_none() && b.is_none(),
                };
                assert!(near, "{rotation}, {x}, {y}: {got:?} instead of {want:?}");
            }
        }
    }
}
