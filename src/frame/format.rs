use core::{fmt, str::FromStr};

/// How a pixel's channels lie in memory. The names are those of DRM's FourCC codes: most significant channel first in a
/// little-endian word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PixelFormat {
    /// 32 bits: 8 unused (written as 255), red, green, blue; bytes B, G, R, X. Most panels of today.
    Xrgb8888,
    /// 32 bits: 8 unused (written as 255), blue, green, red; bytes R, G, B, X.
    Xbgr8888,
    /// 24 bits: red, green, blue; bytes B, G, R.
    Rgb888,
    /// 24 bits: blue, green, red; bytes R, G, B.
    Bgr888,
    /// 16 bits: red 5, green 6, blue 5. The default console of a Raspberry Pi.
    Rgb565,
    /// 16 bits: blue 5, green 6, red 5.
    Bgr565,
    /// 32 bits: 2 unused (written as ones), red 10, green 10, blue 10.
    Xrgb2101010,
}

impl PixelFormat {
    /// Every format, in the order in which they are listed to people.
    pub const ALL: [Self; 7] = [
        Self::Xrgb8888,
        Self::Xbgr8888,
        Self::Rgb888,
        Self::Bgr888,
        Self::Rgb565,
        Self::Bgr565,
        Self::Xrgb2101010,
    ];

    /// The size of a pixel in memory.
    pub const fn bytes_per_pixel(self) -> usize {
        match self {
            Self::Xrgb8888 | Self::Xbgr8888 | Self::Xrgb2101010 => 4,
            Self::Rgb888 | Self::Bgr888 => 3,
            Self::Rgb565 | Self::Bgr565 => 2,
        }
    }

    /// The name as people type it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Xrgb8888 => "XRGB8888",
            Self::Xbgr8888 => "XBGR8888",
            Self::Rgb888 => "RGB888",
            Self::Bgr888 => "BGR888",
            Self::Rgb565 => "RGB565",
            Self::Bgr565 => "BGR565",
            Self::Xrgb2101010 => "XRGB2101010",
        }
    }

    /// The colour of the pixel in `bytes` (at least [`Self::bytes_per_pixel`] of them) as 8-bit red, green, blue; channels of
    /// fewer bits are widened by repeating their upper bits, those of more bits are rounded.
    pub fn unpack(self, bytes: &[u8]) -> [u8; 3] {
        let word16 = || u32::from(u16::from_le_bytes([bytes[0], bytes[1]]));
        let widen5 = |v: u32| ((v << 3) | (v >> 2)) as u8;
        let widen6 = |v: u32| ((v << 2) | (v >> 4)) as u8;
        match self {
            Self::Xrgb8888 | Self::Rgb888 => [bytes[2], bytes[1], bytes[0]],
            Self::Xbgr8888 | Self::Bgr888 => [bytes[0], bytes[1], bytes[2]],
            Self::Rgb565 => {
                let word = word16();
                [widen5(word >> 11), widen6((word >> 5) & 63), widen5(word & 31)]
            }
            Self::Bgr565 => {
                let word = word16();
                [widen5(word & 31), widen6((word >> 5) & 63), widen5(word >> 11)]
            }
            Self::Xrgb2101010 => {
                let word = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
                [20, 10, 0].map(|shift| (((word >> shift & 1023) * 255 + 511) / 1023) as u8)
            }
        }
    }
}

impl fmt::Display for PixelFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A word that names no [`PixelFormat`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnknownFormat;

impl fmt::Display for UnknownFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("unknown pixel format; the known ones are ")?;
        for (i, format) in PixelFormat::ALL.iter().enumerate() {
            write!(f, "{}{format}", if i == 0 { "" } else { ", " })?;
        }
        Ok(())
    }
}

impl core::error::Error for UnknownFormat {}

impl FromStr for PixelFormat {
    type Err = UnknownFormat;

    fn from_str(word: &str) -> Result<Self, UnknownFormat> {
        Self::ALL.into_iter().find(|f| f.name().eq_ignore_ascii_case(word)).ok_or(UnknownFormat)
    }
}
