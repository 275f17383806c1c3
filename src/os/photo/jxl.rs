//! JPEG XL (ISO/IEC 18181), of which animations show the first frame. The cargo feature `jxl`.

use super::{
    Fault, Limits,
    decode::{self, Decoded},
    fit::Turn,
};
use crate::frame::Size;
use image::ImageDecoder as _;
use jxl_oxide::{JxlImage, integration::JxlDecoder};

/// What the decoder needs beside its result, in bytes a pixel. Measured with photos of 12 megapixels and three channels: 25 (jxl-oxide
/// 0.12.6, 2026-11); a fourth channel takes a third more.
const BYTES_PER_PIXEL: u64 = 34;

/// Decodes a file. The decoder turns photos itself, and what their EXIF data says of that does not count (18181-2).
pub(super) fn decode(bytes: &[u8], limits: &Limits) -> Result<Decoded, Fault> {
    let mut decoder = JxlDecoder::new(bytes).map_err(decode::from_image)?;
    let (width, height) = decoder.dimensions();
    let size = Size::new(width, height);
    decode::check_size(size, limits)?;
    let samples = decoder.color_type();
    let pixels = size.pixels() as u64;
    let needed = bytes.len() as u64 + pixels * (u64::from(samples.bytes_per_pixel()) + BYTES_PER_PIXEL);
    if needed > limits.bytes {
        return Err(Fault::TooMuchMemory { needed, limit: limits.bytes });
    }
    // Of a file that is cut the decoder would give what there is.
    let parsed = JxlImage::builder().read(bytes).map_err(|_| Fault::Broken)?;
    if parsed.num_loaded_keyframes() == 0 {
        return Err(Fault::Cut);
    }
    drop(parsed);
    let icc = decoder.icc_profile().ok().flatten();
    let bytes = decode::read_pixels(decoder, size, samples, limits)?;
    Ok(Decoded { full: size, size, turn: Turn::from_exif(1), samples, bytes, icc })
}
