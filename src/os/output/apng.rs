//! PNG, APNG and folders of PNG files, by the `png` crate.

use super::{Encode, Film, changed::Rect, staged::frame_name};
use crate::frame::Size;
use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, EncodingError, SrgbRenderingIntent};
use std::{
    fs::File,
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
};

fn header<W: Write>(to: W, size: Size) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(to, size.width, size.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Balanced);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

/// One PNG file: still with one frame, else animated.
pub(super) struct Encoder<W: Write> {
    png: png::Writer<W>,
    size: Size,
    before: Vec<u8>,
    cut: Vec<u8>,
}

impl<W: Write> Encoder<W> {
    pub(super) fn new(to: W, film: Film) -> io::Result<Self> {
        let mut encoder = header(to, film.size);
        if film.frames > 1 {
            encoder.set_animated(film.frames, 0).map_err(io_error)?;
            encoder.set_frame_delay(film.rate.seconds(), film.rate.frames()).map_err(io_error)?;
            encoder.set_blend_op(BlendOp::Source).map_err(io_error)?;
            encoder.set_dispose_op(DisposeOp::None).map_err(io_error)?;
        }
        Ok(Self {
            png: encoder.write_header().map_err(io_error)?,
            size: film.size,
            before: Vec::new(),
            cut: Vec::new(),
        })
    }
}

impl<W: Write> Encode for Encoder<W> {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        if self.before.is_empty() {
            self.png.write_image_data(rgb).map_err(io_error)?;
        } else {
            let width = self.size.width;
            let rect = Rect::changed::<3>(&self.before, rgb, width).unwrap_or(Rect::first_pixel());
            self.png.reset_frame_position().map_err(io_error)?;
            self.png.set_frame_dimension(rect.width, rect.height).map_err(io_error)?;
            self.png.set_frame_position(rect.left, rect.top).map_err(io_error)?;
            rect.cut::<3>(rgb, width, &mut self.cut);
            self.png.write_image_data(&self.cut).map_err(io_error)?;
        }
        self.before.clear();
        self.before.extend_from_slice(rgb);
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        self.png.finish().map_err(io_error)
    }
}

/// A folder with one PNG file a frame.
pub(super) struct Folder {
    path: PathBuf,
    size: Size,
    next: u32,
}

impl Folder {
    pub(super) fn new(path: &Path, film: Film) -> Self {
        Self { path: path.into(), size: film.size, next: 0 }
    }
}

impl Encode for Folder {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        let mut file = BufWriter::new(File::create(self.path.join(frame_name(self.next)))?);
        let mut png = header(&mut file, self.size).write_header().map_err(io_error)?;
        png.write_image_data(rgb).map_err(io_error)?;
        png.finish().map_err(io_error)?;
        file.into_inner()?.sync_all()?;
        self.next += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(())
    }
}

/// The error of the operating system within `error`, with its kind; the crate's own conversion keeps only the text.
fn io_error(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        other => io::Error::other(other),
    }
}
