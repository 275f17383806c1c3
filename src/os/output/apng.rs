//! PNG, APNG and folders of PNG files, by the `png` crate.

use super::{Encode, Film, changed::Rect, staged::frame_name};
use crate::frame::Size;
use png::{BitDepth, BlendOp, ColorType, Compression, DisposeOp, SrgbRenderingIntent};
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
            encoder.set_animated(film.frames, 0)?;
            encoder.set_frame_delay(film.rate.seconds(), film.rate.frames())?;
            encoder.set_blend_op(BlendOp::Source)?;
            encoder.set_dispose_op(DisposeOp::None)?;
        }
        Ok(Self { png: encoder.write_header()?, size: film.size, before: Vec::new(), cut: Vec::new() })
    }
}

impl<W: Write> Encode for Encoder<W> {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        if self.before.is_empty() {
            self.png.write_image_data(rgb)?;
        } else {
            let width = self.size.width;
            let rect = Rect::changed::<3>(&self.before, rgb, width).unwrap_or(Rect::first_pixel());
            self.png.reset_frame_position()?;
            self.png.set_frame_dimension(rect.width, rect.height)?;
            self.png.set_frame_position(rect.left, rect.top)?;
            rect.cut::<3>(rgb, width, &mut self.cut);
            self.png.write_image_data(&self.cut)?;
        }
        self.before.clear();
        self.before.extend_from_slice(rgb);
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(self.png.finish()?)
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
        let mut png = header(&mut file, self.size).write_header()?;
        png.write_image_data(rgb)?;
        png.finish()?;
        file.into_inner()?.sync_all()?;
        self.next += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<()> {
        Ok(())
    }
}
