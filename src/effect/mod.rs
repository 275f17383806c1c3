//! # Effects
//!
//! An effect turns a photo into frames. It is prepared once per photo, in memory that is lent to it, and may fail then;
//! after that it renders any frame from a [`Drive`], cannot fail and allocates nothing. Knows sizes, strides and the drive;
//! knows no device, file or clock.

pub mod shimmer;

use crate::{
    frame::{FrameMut, Size},
    noise::drive::Drive,
};
use core::fmt;

/// What part of a frame an effect must paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Paint {
    /// Every pixel: what the frame holds is unknown.
    Everything,
    /// What moves: the frame holds an earlier frame of the same effect, prepared as it is now.
    Motion,
}

/// A picture that moves.
pub trait Effect {
    /// Renders the frame for `drive` into `out`, whose size is the one the effect was prepared for.
    fn render(&mut self, drive: Drive, paint: Paint, out: &mut FrameMut<'_>);
}

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
