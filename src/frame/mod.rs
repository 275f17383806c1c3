//! # Frames
//!
//! Pixels in memory: formats, views with any stride, resampling, dithering. Knows what a byte of a pixel means; knows no photo
//! file, effect or device.

pub mod dither;
mod format;
pub mod pack;
pub mod resample;
mod rotation;
pub mod srgb;
mod view;

pub use format::{PixelFormat, UnknownFormat};
pub use rotation::{Rotation, UnknownRotation, rotate};
pub use view::{FrameMut, FrameRef, Layout, LayoutError};

use core::ops::Range;

/// Width and height in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Size {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Size {
    /// A size of `width` × `height` pixels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// The number of pixels.
    pub const fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// This size turned by a quarter: width and height exchanged.
    #[must_use]
    pub const fn transposed(self) -> Self {
        Self { width: self.height, height: self.width }
    }

    /// The largest size of this shape that lies within `bounds` and is no larger than this one.
    #[must_use]
    pub const fn within(self, bounds: Self) -> Self {
        let (width, height) = (self.width as u64, self.height as u64);
        if width <= bounds.width as u64 && height <= bounds.height as u64 {
            return self;
        }
        let wide = width * bounds.height as u64 > height * bounds.width as u64;
        let (other, scaled) = match wide {
            true => (bounds.width, (height * bounds.width as u64 + width / 2) / width),
            false => (bounds.height, (width * bounds.height as u64 + height / 2) / height),
        };
        let scaled = if scaled == 0 { 1 } else { scaled as u32 };
        if wide { Self::new(other, scaled) } else { Self::new(scaled, other) }
    }
}

impl core::fmt::Display for Size {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}×{}", self.width, self.height)
    }
}

/// A rectangle of pixels within a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rect {
    /// Columns to the left of it.
    pub x: u32,
    /// Rows above it.
    pub y: u32,
    /// Its width and height.
    pub size: Size,
}

impl Rect {
    /// All of a frame of `size`.
    pub const fn whole(size: Size) -> Self {
        Self { x: 0, y: 0, size }
    }

    /// The columns that it takes.
    pub const fn columns(self) -> Range<usize> {
        self.x as usize..(self.x + self.size.width) as usize
    }

    /// The rows that it takes.
    pub const fn rows(self) -> Range<u32> {
        self.y..self.y + self.size.height
    }

    /// The smallest rectangle that holds both.
    #[must_use]
    pub fn hull(self, other: Self) -> Self {
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        let right = self.columns().end.max(other.columns().end) as u32;
        let size = Size::new(right - x, self.rows().end.max(other.rows().end) - y);
        Self { x, y, size }
    }
}
