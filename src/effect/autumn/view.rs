//! How the tree stands in the picture.

use super::{
    grow::{Twig, Visit, grow},
    space::{BITS, ONE, Vector, times},
    species::Species,
};
use crate::{frame::Size, math::Turns};

/// Fractional bits of a place in the picture.
pub(super) const SPOT_BITS: u32 = 8;

/// The nearest and farthest depth of a tree; what lies on the ground before and behind it is outside.
pub(super) const TREE_DEPTHS: core::ops::RangeInclusive<u16> = 16_384..=49_151;

/// A place in the picture, in steps of 1/256 pixel, and how near it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Spot {
    pub(super) x: i32,
    pub(super) y: i32,
    pub(super) depth: u16,
}

/// Parallel projection from a level camera.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// How many steps of 1/256 pixel one is long.
    scale: i64,
    sin: i32,
    cos: i32,
    /// Where the root is, in steps of 1/256 pixel.
    pub(super) root: [i32; 2],
    /// Half the extent of the tree in every direction, and its middle's height.
    pub(super) reach: i32,
    pub(super) middle: i32,
}

/// How far the tree reaches.
struct Reach {
    high: i32,
    wide: i32,
    view: View,
}

impl Visit for Reach {
    fn twig(&mut self, twig: &Twig) {
        let [x, y, z] = self.view.turned(twig.map.shift);
        self.high = self.high.max(y);
        self.wide = self.wide.max(x.abs()).max(z.abs());
    }
}

impl View {
    /// The tree of `species` as large as fits, seen from `azimuth`.
    pub(super) fn fit(species: &Species, seed: u64, size: Size, azimuth: Turns) -> Self {
        let (sin, cos) = (azimuth.sin().to_bits() >> 4, azimuth.cos().to_bits() >> 4);
        let root = [size.width as i32 * 120, size.height as i32 * 222]; // of 256ths
        let view = Self { scale: 1, sin, cos, root, reach: ONE, middle: 0 };
        let mut reach = Reach { high: ONE, wide: ONE / 4, view };
        grow(species, seed, &mut reach);
        let Reach { high, wide, mut view } = reach;
        // Leaves reach a little beyond the twigs.
        let (tall, broad) = (i64::from(size.height) * 206, i64::from(size.width) * 112);
        view.scale = ((tall << BITS) / i64::from(high)).min((broad << BITS) / i64::from(wide));
        view.middle = high / 2;
        view.reach = wide.max(high / 2) / 8 * 9;
        view
    }

    fn turned(&self, [x, y, z]: Vector) -> Vector {
        [times(self.cos, x) + times(self.sin, z), y, times(self.cos, z) - times(self.sin, x)]
    }

    /// A length in steps of 1/256 pixel.
    pub(super) fn length(&self, length: i32) -> i32 {
        ((i64::from(length) * self.scale) >> BITS) as i32
    }

    /// Where a point is seen.
    pub(super) fn spot(&self, point: Vector) -> Spot {
        let [x, y, z] = self.turned(point);
        let (near, far) = (i64::from(*TREE_DEPTHS.end()), i64::from(*TREE_DEPTHS.start()));
        let depth = (near + far) / 2 + i64::from(z) * ((near - far) / 2) / i64::from(self.reach);
        Spot {
            x: self.root[0] + self.length(x),
            y: self.root[1] - self.length(y),
            depth: depth.clamp(far, near) as u16,
        }
    }
}
