//! # Fractal coding
//!
//! A grey picture as the fixed point of a contraction. The picture is cut into square **ranges** by a quadtree; each is described by a
//! **domain** of twice its side, shrunk 2:1, turned by one of eight isometries, and brought to its levels by a contrast and
//! a brightness:
//!
//! ```text
//! z'(x) = s·D(iso(x)) + o
//! ```
//!
//! Source: Fisher, "Fractal Image Compression", 1995, ch. 3; the isometries are those of the paper's table 1 (see
//! [`super`]). Here s = k/16 with |k| ≤ 15, so that the decoder always converges, and o has 7 bits over what s leaves possible.
//!
//! Everything is integers, and ties go to the lowest index: the same code on every machine.

mod block;
mod coder;
mod decoder;
pub mod file;
mod isometry;
mod search;

#[cfg(test)]
mod reference;

pub(super) use coder::follow;
pub use coder::{Options, encode, most_leaves, scratch_len};
pub use decoder::{contract, decode, sweep};
pub(super) use isometry::Strides;
pub use search::Search;

use crate::frame::Size;
use bytemuck::{Pod, Zeroable};
use isometry::Isometry;

/// The side of the largest ranges.
pub const LARGEST: usize = 16;

/// The side of the smallest ranges.
pub const SMALLEST: usize = 4;

/// The longest side of a plane: places of leaves are 16 bits, and half of them would do.
pub const LONGEST_SIDE: u32 = 16_384 + 2 * LARGEST as u32;

/// The size of the plane that holds a picture of `size` with its upper left corner at `shift`: multiples of [`LARGEST`], and room for
/// the domain of the largest range.
pub const fn plane_size(size: Size, shift: (u32, u32)) -> Size {
    const fn side(length: u32) -> u32 {
        let side = length.next_multiple_of(LARGEST as u32);
        if side < 2 * LARGEST as u32 { 2 * LARGEST as u32 } else { side }
    }
    Size::new(side(size.width + shift.0), side(size.height + shift.1))
}

/// Fills `plane`, of the size that [`plane_size`] gives, with the level of every pixel of a picture; what is beyond the picture repeats its
/// edge.
pub fn fill_plane(size: Size, shift: (u32, u32), plane: &mut [u8], level: impl Fn(usize) -> u8) {
    let padded = plane_size(size, shift);
    for (y, row) in (0_u32..).zip(plane.chunks_exact_mut(padded.width as usize)) {
        let start = y.saturating_sub(shift.1).min(size.height - 1) as usize * size.width as usize;
        for (x, out) in (0_u32..).zip(row) {
            *out = level(start + x.saturating_sub(shift.0).min(size.width - 1) as usize);
        }
    }
}

/// A range with what describes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Leaf {
    /// Where the range is, in pixels of the plane.
    x: u16,
    y: u16,
    /// Where its domain is, in pixels of the contracted plane.
    domain_x: u16,
    domain_y: u16,
    /// 16, 8 or 4; [`Leaf::COVERED`] or 0 only while a picture is coded.
    side: u8,
    isometry: u8,
    /// k, −15..=15.
    contrast: i8,
    /// 0..=127.
    brightness: u8,
}

impl Leaf {
    /// A place that a larger leaf covers.
    const COVERED: u8 = 255;

    /// The column, the row and the side of the range.
    pub const fn range(self) -> (usize, usize, usize) {
        (self.x as usize, self.y as usize, self.side as usize)
    }

    /// Whether it is one, and no place that a larger one covers.
    pub(super) const fn is_range(self) -> bool {
        self.side != 0 && self.side != Self::COVERED
    }

    /// k: 16 times the contrast.
    pub const fn contrast(self) -> i8 {
        self.contrast
    }

    /// The step of the brightness, 0..=127.
    pub const fn brightness(self) -> u8 {
        self.brightness
    }

    /// How the range's pixels, row by row, read the contracted plane of `width`.
    pub(super) const fn strides(self, width: usize) -> Strides {
        let corner = self.domain_y as usize * width + self.domain_x as usize;
        Isometry::from_index(self.isometry).strides(corner, width, self.side as usize)
    }

    /// The leaf of the range at (x, y) whose domain has the same centre, as far as the plane reaches.
    const fn concentric(x: u16, y: u16, side: u8, plane: Size) -> Self {
        const fn start(at: u16, side: u8, length: u32) -> u16 {
            let most = (length / 2) as u16 - side as u16;
            let start = (at / 2).saturating_sub(side as u16 / 4);
            if start > most { most } else { start }
        }
        Self {
            x,
            y,
            domain_x: start(x, side, plane.width),
            domain_y: start(y, side, plane.height),
            side,
            isometry: 0,
            contrast: 0,
            brightness: 0,
        }
    }

    fn is_concentric(self, plane: Size) -> bool {
        let other = Self::concentric(self.x, self.y, self.side, plane);
        (self.isometry, self.domain_x, self.domain_y) == (0, other.domain_x, other.domain_y)
    }
}

/// A coded picture: its leaves, in the order of the quadtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Code<'a> {
    /// The size of the plane that was coded.
    plane: Size,
    leaves: &'a [Leaf],
}

impl<'a> Code<'a> {
    /// The size of the plane: multiples of [`LARGEST`].
    pub const fn plane_size(&self) -> Size {
        self.plane
    }

    /// The leaves, in the order of the quadtree.
    pub const fn leaves(&self) -> &'a [Leaf] {
        self.leaves
    }
}

/// Where the cell of 4 × 4 pixels at (x, y) is in the order of the quadtree: blocks of 16 row by row, in each the four quarters, in each the
/// four cells.
const fn slot(x: usize, y: usize, plane: Size) -> usize {
    let block = y / LARGEST * (plane.width as usize / LARGEST) + x / LARGEST;
    let (x, y) = (x / SMALLEST, y / SMALLEST);
    block * 16 + ((y & 2) << 2 | (x & 2) << 1 | (y & 1) << 1 | x & 1)
}
