//! # Effects
//!
//! An effect turns a photo into frames. It is prepared once per photo, in memory that is lent to it, and may fail then;
//! after that it renders any frame from a [`Drive`], cannot fail and allocates nothing. Knows sizes, strides and the drive;
//! knows no device, file or clock.

pub mod autumn;
mod checksum;
pub mod fluid;
pub mod kaleidoscope;
pub mod paint;
mod sensitivity;
pub mod shimmer;
mod storage;

pub use paint::{Area, Paint};

use crate::{
    frame::{FrameMut, Size, pack::Block},
    math::Factor,
    noise::{drive::Drive, guard::Sensitivity},
};
use core::{fmt, ops::Range};

/// A picture that moves.
pub trait Effect {
    /// The picture at one moment.
    type Moment<'a>: Moment
    where
        Self: 'a;

    /// The picture at the moment of `drive`.
    fn at(&mut self, drive: Drive) -> Self::Moment<'_>;

    /// How much of what it shows depends on the drive. Where an effect does not say, it is taken for a picture that was not measured.
    fn sensitivity(&self) -> Sensitivity {
        Sensitivity::default()
    }

    /// Renders the frame for `drive` into `out`, whose size is the one the effect was prepared for.
    fn render(&mut self, drive: Drive, paint: Paint, out: &mut FrameMut<'_>) {
        paint::one(&self.at(drive), paint, Factor::ONE, out);
    }
}

/// A picture that stands still for one frame: its rows, to be painted, blended with another's, or dimmed.
pub trait Moment {
    /// Width and height in pixels.
    fn size(&self) -> Size;

    /// The columns of row `y` that can differ from those of the moments before and after.
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>>;

    /// Fills `blocks`, at most [`RUN`] of them, with the colours of row `y` from column `x` on, which is a multiple of 16 and within the row. What is
    /// beyond the row's end may be anything.
    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]);

    /// Paints what of it is in `area`.
    ///
    /// Colours go from [`Moment::colours`] into the frame by way of the first-level cache. An effect for which that is too slow overrides this.
    fn paint(&self, area: Area, out: &mut FrameMut<'_>) {
        paint::by_runs(self, area, out);
    }
}

/// The most blocks that are computed at a time: 512 pixels, which with a second picture take 6 KB of the first-level cache.
pub const RUN: usize = 32;

/// A photo as the panel shows it.
#[derive(Clone, Copy, Debug)]
pub struct Photo<'a> {
    /// Width and height in pixels: those of the panel.
    pub size: Size,
    /// Red, green, blue of every pixel, row by row, sRGB: 3 bytes a pixel.
    pub rgb: &'a [u8],
    /// How far every pixel may move, row by row: 0 stays, 255 moves fully.
    pub mask: &'a [u8],
}

/// The lent memory does not hold what the effect keeps for a photo.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StorageTooSmall {
    /// Words of 64 bits that it takes.
    pub needed: usize,
    /// Words there are.
    pub got: usize,
}

impl fmt::Display for StorageTooSmall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the effect needs {} bytes for this photo and was lent {}", self.needed * 8, self.got * 8)
    }
}

impl core::error::Error for StorageTooSmall {}
