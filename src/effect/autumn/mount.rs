//! A tree on a panel that is mounted turned.
//!
//! The tree is grown, painted and strewn in an upright picture; every pixel of that has its place on the panel. What a frame does
//! pixel by pixel is in the order of the panel.

use crate::frame::{Rect, Rotation, Size};
use core::ops::Range;

/// From the upright picture to the panel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mount {
    /// The panel's size.
    pub(super) panel: Size,
    rotation: Rotation,
}

impl Mount {
    /// A picture that is turned by `rotation` for the panel.
    pub(super) const fn new(panel: Size, rotation: Rotation) -> Self {
        Self { panel, rotation }
    }

    /// The size of the upright picture.
    pub(super) const fn upright(self) -> Size {
        self.rotation.turned(self.panel)
    }

    /// Where pixel (x, y) of the upright picture is on the panel, counted row by row.
    #[inline]
    pub(super) const fn index(self, x: i32, y: i32) -> usize {
        let (width, height) = (self.panel.width as usize, self.panel.height as usize);
        let (x, y) = (x as usize, y as usize);
        match self.rotation {
            Rotation::None => y * width + x,
            Rotation::Quarter => x * width + (width - 1 - y),
            Rotation::Half => (height - 1 - y) * width + (width - 1 - x),
            Rotation::ThreeQuarter => (height - 1 - x) * width + y,
        }
    }

    /// The pixel of the upright picture that is shown at (x, y) of the panel.
    #[inline]
    pub(super) const fn pixel(self, x: i32, y: i32) -> [i32; 2] {
        let (right, below) = (self.panel.width as i32 - 1 - x, self.panel.height as i32 - 1 - y);
        match self.rotation {
            Rotation::None => [x, y],
            Rotation::Quarter => [y, right],
            Rotation::Half => [right, below],
            Rotation::ThreeQuarter => [below, x],
        }
    }

    /// What goes right and down in the upright picture, as it goes on the panel.
    pub(super) const fn direction(self, [right, down]: [i32; 2]) -> [i32; 2] {
        match self.rotation {
            Rotation::None => [right, down],
            Rotation::Quarter => [-down, right],
            Rotation::Half => [-right, -down],
            Rotation::ThreeQuarter => [down, -right],
        }
    }

    /// The panel's columns and rows of a part of the upright picture.
    pub(super) fn part(self, [columns, rows]: [Range<i32>; 2]) -> [Range<i32>; 2] {
        let size = Size::new(columns.len() as u32, rows.len() as u32);
        let rect = Rect { x: columns.start as u32, y: rows.start as u32, size };
        let Rect { x, y, size } = self.rotation.turned_rect(rect, self.upright());
        [x as i32..(x + size.width) as i32, y as i32..(y + size.height) as i32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::rotate;

    #[test]
    fn every_pixel_is_where_the_turned_picture_has_it() {
        for rotation in Rotation::ALL {
            let mount = Mount::new(Size::new(5, 3), rotation);
            let upright = mount.upright();
            let numbers: [usize; 15] = core::array::from_fn(|i| i);
            let mut panel = [0; 15];
            rotate(rotation, &numbers, upright, &mut panel);
            for (at, number) in panel.into_iter().enumerate() {
                let (x, y) =
                    ((number % upright.width as usize) as i32, (number / upright.width as usize) as i32);
                assert_eq!(mount.index(x, y), at, "{rotation}");
                assert_eq!(mount.pixel((at % 5) as i32, (at / 5) as i32), [x, y], "{rotation}");
                let part = mount.part([x..x + 1, y..y + 1]).map(|range| range.start as usize);
                assert_eq!(part[1] * 5 + part[0], at, "{rotation}");
            }
            // The pixel to the right of the first one.
            let step = mount.index(1, 0) as i32 - mount.index(0, 0) as i32;
            let [right, down] = mount.direction([1, 0]);
            assert_eq!(down * 5 + right, step, "{rotation}");
        }
    }
}
