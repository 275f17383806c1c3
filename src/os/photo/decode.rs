//! From the bytes of a file to samples, within limits.

#[cfg(feature = "jxl")]
use super::jxl;
use super::{
    Fault, Limits,
    colour::Colour,
    fit::Turn,
    format::{self, JpegOutline},
    scale, shrunk_jpeg,
};
use crate::{
    frame::{Size, resample::MAX_SIDE},
    os::panics::without_panic,
};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageReader, metadata::Orientation};
use std::io::{Cursor, ErrorKind};

/// A decoded photo, as its file stores it.
pub(super) struct Decoded {
    /// The size in the file.
    pub(super) full: Size,
    /// The stored size: that in the file, or less where it was shrunk while it was decoded.
    pub(super) size: Size,
    /// How it is turned to be shown.
    pub(super) turn: Turn,
    pub(super) samples: ColorType,
    pub(super) bytes: Vec<u8>,
    pub(super) icc: Option<Vec<u8>>,
}

/// Decodes a file. It may come out smaller than it is, but not below the size that `least` says will do for a photo of the
/// given size; both are those of the photo as it is shown.
pub(super) fn decode(bytes: &[u8], limits: &Limits, least: impl Fn(Size) -> Size) -> Result<Decoded, Fault> {
    #[cfg(feature = "jxl")]
    if format::is_jxl(bytes) {
        return without_panic(|| jxl::decode(bytes, limits)).unwrap_or(Err(Fault::Broken));
    }
    let format = format::guess(bytes)?;
    // A panic in a decoder concerns nothing but what it was building, which is dropped.
    without_panic(|| decode_as(format, bytes, limits, least)).unwrap_or(Err(Fault::Broken))
}

fn decode_as(
    format: ImageFormat,
    bytes: &[u8],
    limits: &Limits,
    least: impl Fn(Size) -> Size,
) -> Result<Decoded, Fault> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut ceiling = image::Limits::no_limits();
    ceiling.max_alloc = Some(limits.bytes);
    reader.limits(ceiling);
    let mut decoder = reader.into_decoder().map_err(from_image)?;
    let (width, height) = decoder.dimensions();
    let size = Size::new(width, height);
    let samples = decoder.color_type();
    check_size(size, limits)?;

    // Broken metadata is no reason not to show a photo.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let turn = Turn::from_exif(orientation.to_exif());
    let icc = decoder.icc_profile().ok().flatten();
    if format == ImageFormat::Jpeg {
        let outline = JpegOutline::new(bytes);
        if !outline.whole {
            return Err(Fault::Cut);
        }
        let least = turn.undo(least(turn.undo(size)));
        // What one decoder gives up in disorder, the other may still read.
        let shrunk = without_panic(|| shrunk_jpeg::decode(bytes, least, samples, outline, limits));
        if let Some((stored, pixels)) = shrunk.ok().flatten() {
            return Ok(Decoded { full: size, size: stored, turn, samples, bytes: pixels, icc });
        }
    }
    check_memory(format, bytes, size, samples, limits)?;
    let bytes = read_pixels(decoder, size, samples, limits)?;
    Ok(Decoded { full: size, size, turn, samples, bytes, icc })
}

/// The samples of a photo whose decoder was checked to be within `limits`.
pub(super) fn read_pixels(
    mut decoder: impl ImageDecoder,
    size: Size,
    samples: ColorType,
    limits: &Limits,
) -> Result<Vec<u8>, Fault> {
    let len = size.pixels() * usize::from(samples.bytes_per_pixel());
    let mut pixels = Vec::new();
    let too_large = |_| Fault::TooMuchMemory { needed: len as u64, limit: limits.bytes };
    pixels.try_reserve_exact(len).map_err(too_large)?;
    pixels.resize(len, 0);
    let mut ceiling = image::Limits::no_limits();
    ceiling.max_alloc = Some(limits.bytes - len as u64);
    decoder.set_limits(ceiling).map_err(from_image)?;
    decoder.read_image(&mut pixels).map_err(from_image)?;
    Ok(pixels)
}

/// Refuses what has no pixels or too many.
pub(super) fn check_size(size: Size, limits: &Limits) -> Result<(), Fault> {
    let pixels = u64::from(size.width) * u64::from(size.height);
    if pixels == 0 {
        return Err(Fault::NoPixels);
    }
    if pixels > limits.pixels {
        return Err(Fault::TooManyPixels { size, limit: limits.pixels });
    }
    if size.width.max(size.height) > MAX_SIDE {
        return Err(Fault::SideTooLong(size));
    }
    Ok(())
}

/// Refuses what takes too much memory, before it is taken.
fn check_memory(
    format: ImageFormat,
    bytes: &[u8],
    size: Size,
    samples: ColorType,
    limits: &Limits,
) -> Result<(), Fault> {
    let pixels = u64::from(size.width) * u64::from(size.height);
    let sample_bytes = u64::from(samples.bytes_per_pixel());
    let file = bytes.len() as u64;
    let decoder = match format {
        ImageFormat::Jpeg if JpegOutline::new(bytes).progressive => file + pixels * sample_bytes * 2,
        ImageFormat::Jpeg => file,
        ImageFormat::WebP => pixels * 8,
        ImageFormat::Gif => pixels * 4,
        ImageFormat::Tiff => pixels * sample_bytes,
        _ => 0,
    };
    let needed = file + pixels * sample_bytes + decoder;
    if needed > limits.bytes {
        return Err(Fault::TooMuchMemory { needed, limit: limits.bytes });
    }
    Ok(())
}

/// What a decoder's `error` means for people.
pub(super) fn from_image(error: ImageError) -> Fault {
    match &error {
        ImageError::IoError(cause) if cause.kind() == ErrorKind::UnexpectedEof => Fault::Cut,
        ImageError::Unsupported(_) => Fault::Feature(error),
        _ => Fault::Damaged(error),
    }
}

impl Decoded {
    /// The size in the file, once it is turned.
    pub(super) fn oriented_size(&self) -> Size {
        self.turn.undo(self.full)
    }

    /// How many planes it has: grey or red, green and blue, and alpha last if there is any.
    pub(super) fn channels(&self) -> usize {
        usize::from(self.samples.channel_count())
    }

    /// How its samples become linear light. A profile that cannot be used is told once and ignored.
    pub(super) fn colour(&self, name: &str) -> Colour {
        let entries = if self.bytes_per_sample() == 1 { 1 << 8 } else { 1 << 16 };
        let grey = !self.samples.has_color();
        let profile = self.icc.as_ref().map(|icc| {
            // The profile comes from outside too.
            without_panic(|| Colour::from_icc(icc, grey, entries))
                .unwrap_or_else(|_| Err("it is broken".to_owned()))
        });
        match profile {
            Some(Ok(colour)) => return colour,
            Some(Err(why)) => log::warn!("{name}: its colour profile is ignored: {why}"),
            None => {}
        }
        Colour::srgb(entries)
    }

    /// Row `y` as linear light, plane after plane, multiplied by alpha where there is any.
    pub(super) fn linear_row(&self, y: u32, colour: &Colour, planes: &mut [u16]) {
        self.row(y, planes, |channel, value| colour.curve(channel)[usize::from(value)]);
        let width = self.size.width as usize;
        if self.samples.has_alpha() {
            let (colours, alphas) = planes.split_at_mut((self.channels() - 1) * width);
            for plane in colours.chunks_exact_mut(width) {
                plane.iter_mut().zip(&*alphas).for_each(|(value, &alpha)| *value = scale(*value, alpha));
            }
        }
    }

    /// Row `y` as luma (Rec. 709, of the codes as they are) times alpha; `planes` is memory for a row of every channel.
    pub(super) fn luma_row(&self, y: u32, planes: &mut [u16], luma: &mut [u16]) {
        /// Shares of red, green and blue, of 256.
        const REC_709: [u32; 3] = [54, 183, 19];
        let widen = if self.bytes_per_sample() == 1 { 257 } else { 1 };
        self.row(y, planes, |_, value| value * widen);
        let width = self.size.width as usize;
        for (x, out) in luma.iter_mut().enumerate() {
            let at = |channel: usize| planes[channel * width + x];
            let sum = (0..3).map(|c| u32::from(at(c.min(self.colours() - 1))) * REC_709[c]).sum::<u32>();
            let alpha = if self.samples.has_alpha() { at(self.colours()) } else { u16::MAX };
            *out = scale(((sum + 128) / 256) as u16, alpha);
        }
    }

    /// How many planes it has without alpha.
    fn colours(&self) -> usize {
        self.channels() - usize::from(self.samples.has_alpha())
    }

    fn bytes_per_sample(&self) -> usize {
        usize::from(self.samples.bytes_per_pixel()) / self.channels()
    }

    /// Row `y`, plane after plane: colours as `light` makes them of a channel's samples (0..=255 or 0..=65,535), and alpha from
    /// 0 to 65,535.
    pub(super) fn row(&self, y: u32, planes: &mut [u16], light: impl Fn(usize, u16) -> u16) {
        let row_bytes = self.size.width as usize * usize::from(self.samples.bytes_per_pixel());
        let row = &self.bytes[y as usize * row_bytes..][..row_bytes];
        for (channel, plane) in planes.chunks_exact_mut(self.size.width as usize).enumerate() {
            let light = |value| light(channel, value);
            match (self.bytes_per_sample(), channel < self.colours()) {
                (1, true) => self.plane(row, channel, plane, |[byte]| light(u16::from(byte))),
                (1, false) => self.plane(row, channel, plane, |[byte]| u16::from(byte) * 257),
                (2, true) => self.plane(row, channel, plane, |bytes| light(u16::from_ne_bytes(bytes))),
                (2, false) => self.plane(row, channel, plane, u16::from_ne_bytes),
                (_, true) => self.plane(row, channel, plane, |bytes| light(from_float(bytes))),
                (_, false) => self.plane(row, channel, plane, from_float),
            }
        }
    }

    /// One plane of a row whose samples have `BYTES` bytes.
    fn plane<const BYTES: usize>(
        &self,
        row: &[u8],
        channel: usize,
        plane: &mut [u16],
        value: impl Fn([u8; BYTES]) -> u16,
    ) {
        for (pixel, out) in row.chunks_exact(BYTES * self.channels()).zip(plane) {
            if let Some((bytes, _)) = pixel[channel * BYTES..].split_first_chunk() {
                *out = value(*bytes);
            }
        }
    }
}

/// A sample of 0.0 to 1.0 in 16 bits; no number is black.
fn from_float(bytes: [u8; 4]) -> u16 {
    (f32::from_ne_bytes(bytes).clamp(0.0, 1.0) * 65_535.0).round() as u16
}
