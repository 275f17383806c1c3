use super::{PixelFormat, Size};
use core::fmt;

/// Where the pixels of a frame lie in memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Width and height in pixels.
    pub size: Size,
    /// How a pixel's channels lie in memory.
    pub format: PixelFormat,
    /// Bytes from the start of a row to the start of the next. fbdev calls this `line_length`, KMS `pitch`; it may exceed
    /// width × bytes per pixel.
    pub stride_bytes: usize,
}

/// A layout or a piece of memory that cannot hold a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayoutError {
    /// Width or height is zero, or over [`Layout::MAX_SIDE`].
    Size(Size),
    /// Rows would overlap.
    Stride {
        /// Bytes from row to row as asked for.
        stride_bytes: usize,
        /// Bytes that the pixels of a row take.
        needed: usize,
    },
    /// The memory is too short for the layout.
    Memory {
        /// Bytes that the layout takes.
        needed: usize,
        /// Bytes there are.
        got: usize,
    },
}

impl fmt::Display for LayoutError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Size(size) => {
                write!(f, "a frame of {size} pixels: each side must be 1 to {}", Layout::MAX_SIDE)
            }
            Self::Stride { stride_bytes, needed } => {
                write!(f, "a stride of {stride_bytes} bytes: the pixels of a row take {needed}")
            }
            Self::Memory { needed, got } => {
                write!(f, "a frame buffer of {got} bytes: the frame takes {needed}")
            }
        }
    }
}

impl core::error::Error for LayoutError {}

impl Layout {
    /// The longest side of a frame, in pixels: 16K. It keeps every product of the kernels within 32 bits.
    pub const MAX_SIDE: u32 = 16_384;

    /// A checked layout; `stride_bytes` of `None` packs the rows without a gap.
    pub fn new(size: Size, format: PixelFormat, stride_bytes: Option<usize>) -> Result<Self, LayoutError> {
        let sides = 1..=Self::MAX_SIDE;
        if !sides.contains(&size.width) || !sides.contains(&size.height) {
            return Err(LayoutError::Size(size));
        }
        let needed = size.width as usize * format.bytes_per_pixel();
        let stride_bytes = stride_bytes.unwrap_or(needed);
        if stride_bytes < needed || stride_bytes > usize::MAX / Self::MAX_SIDE as usize {
            return Err(LayoutError::Stride { stride_bytes, needed });
        }
        Ok(Self { size, format, stride_bytes })
    }

    /// Bytes that the pixels of one row take.
    pub const fn row_bytes(&self) -> usize {
        self.size.width as usize * self.format.bytes_per_pixel()
    }

    /// Bytes from the first pixel to the end of the last. The last row's padding is not needed.
    pub const fn len_bytes(&self) -> usize {
        self.stride_bytes * (self.size.height as usize - 1) + self.row_bytes()
    }

    fn check(&self, got: usize) -> Result<(), LayoutError> {
        let needed = self.len_bytes();
        if got < needed { Err(LayoutError::Memory { needed, got }) } else { Ok(()) }
    }
}

/// The pixels of a frame, to be read.
#[derive(Clone, Copy, Debug)]
pub struct FrameRef<'a> {
    layout: Layout,
    bytes: &'a [u8],
}

impl<'a> FrameRef<'a> {
    /// A view of `bytes`, which must hold [`Layout::len_bytes`].
    pub fn new(bytes: &'a [u8], layout: Layout) -> Result<Self, LayoutError> {
        layout.check(bytes.len())?;
        Ok(Self { layout, bytes })
    }

    /// Where the pixels lie.
    pub const fn layout(&self) -> Layout {
        self.layout
    }

    /// The rows from top to bottom, each without its padding.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = &'a [u8]> + use<'a> {
        let (stride, row_bytes, bytes) = (self.layout.stride_bytes, self.layout.row_bytes(), self.bytes);
        (0..self.layout.size.height as usize).map(move |y| &bytes[y * stride..][..row_bytes])
    }

    /// The colour at column `x`, row `y` as 8-bit red, green, blue.
    pub fn rgb(&self, x: u32, y: u32) -> [u8; 3] {
        let bytes_per_pixel = self.layout.format.bytes_per_pixel();
        let start = y as usize * self.layout.stride_bytes + x as usize * bytes_per_pixel;
        self.layout.format.unpack(&self.bytes[start..start + bytes_per_pixel])
    }
}

/// The pixels of a frame, to be filled.
#[derive(Debug)]
pub struct FrameMut<'a> {
    layout: Layout,
    bytes: &'a mut [u8],
}

impl<'a> FrameMut<'a> {
    /// A view of `bytes`, which must hold [`Layout::len_bytes`].
    pub fn new(bytes: &'a mut [u8], layout: Layout) -> Result<Self, LayoutError> {
        layout.check(bytes.len())?;
        Ok(Self { layout, bytes })
    }

    /// Where the pixels lie.
    pub const fn layout(&self) -> Layout {
        self.layout
    }

    /// Row `y` without its padding.
    pub fn row(&mut self, y: u32) -> &mut [u8] {
        let start = y as usize * self.layout.stride_bytes;
        &mut self.bytes[start..start + self.layout.row_bytes()]
    }

    /// The same pixels, to be read.
    pub fn as_ref(&self) -> FrameRef<'_> {
        FrameRef { layout: self.layout, bytes: self.bytes }
    }

    /// The same pixels, lent on.
    pub fn reborrow(&mut self) -> FrameMut<'_> {
        FrameMut { layout: self.layout, bytes: self.bytes }
    }
}
