//! Lossless WebP. The `image-webp` crate encodes each frame (VP8L); the container around them is written here.
//!
//! Source: "WebP Container Specification", Google, sections "Extended File Format" and "Animation".

use super::{Encode, Film, changed::Rect};
use image_webp::{ColorType, EncodingError, WebPEncoder};
use std::io::{self, Seek, SeekFrom, Write};

/// A RIFF file header: `RIFF`, the size of what follows, `WEBP`.
const RIFF_HEADER_BYTES: usize = 12;
/// The bytes of `RIFF` and its size, which the size does not count.
const RIFF_SIZE_STARTS_AT: u64 = 8;
/// The flag of VP8X that promises an ANIM chunk.
const ANIMATION: u8 = 1 << 1;
/// The flag of ANMF by which a frame replaces what lies below, as it has no alpha.
const DO_NOT_BLEND: u8 = 1 << 1;

pub(super) struct Encoder<W: Write + Seek> {
    to: W,
    film: Film,
    delays_ms: Box<dyn Iterator<Item = u32>>,
    before: Vec<u8>,
    cut: Vec<u8>,
    still: Vec<u8>,
}

impl<W: Write + Seek> Encoder<W> {
    pub(super) fn new(mut to: W, film: Film) -> io::Result<Self> {
        if film.frames > 1 {
            to.write_all(b"RIFF\0\0\0\0WEBP")?;
            let mut extended = vec![ANIMATION, 0, 0, 0];
            extended.extend(u24(film.size.width - 1));
            extended.extend(u24(film.size.height - 1));
            write_chunk(&mut to, b"VP8X", &[&extended])?;
            // Background black, and 0 plays: for ever.
            write_chunk(&mut to, b"ANIM", &[&[0; 6]])?;
        }
        let delays_ms = Box::new(film.rate.delays(1000));
        Ok(Self { to, film, delays_ms, before: Vec::new(), cut: Vec::new(), still: Vec::new() })
    }

    /// A whole still WebP file with the pixels of `rect` in `self.still`.
    fn encode_still(&mut self, rgb: &[u8], rect: Rect) -> io::Result<()> {
        rect.cut::<3>(rgb, self.film.size.width, &mut self.cut);
        self.still.clear();
        let encoder = WebPEncoder::new(&mut self.still);
        encoder.encode(&self.cut, rect.width, rect.height, ColorType::Rgb8).map_err(|e| match e {
            EncodingError::IoError(e) => e,
            other => io::Error::other(other),
        })
    }
}

impl<W: Write + Seek> Encode for Encoder<W> {
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()> {
        if self.film.frames == 1 {
            self.encode_still(rgb, Rect::all(self.film.size))?;
            return self.to.write_all(&self.still);
        }
        let rect = if self.before.is_empty() {
            Rect::all(self.film.size)
        } else {
            // Frames start in even columns and rows: the container stores half of either number.
            let width = self.film.size.width;
            Rect::changed::<3>(&self.before, rgb, width).unwrap_or(Rect::first_pixel()).starting_even()
        };
        self.encode_still(rgb, rect)?;
        let place = [rect.left / 2, rect.top / 2, rect.width - 1, rect.height - 1];
        let mut frame: Vec<u8> = place.into_iter().flat_map(u24).collect();
        frame.extend(u24(self.delays_ms.next().unwrap_or_default()));
        frame.push(DO_NOT_BLEND);
        // The still file is its header and one VP8L chunk, which moves into the frame as it is.
        write_chunk(&mut self.to, b"ANMF", &[&frame, &self.still[RIFF_HEADER_BYTES..]])?;
        self.before.clear();
        self.before.extend_from_slice(rgb);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> io::Result<()> {
        if self.film.frames > 1 {
            let size = self.to.stream_position()? - RIFF_SIZE_STARTS_AT;
            let size = u32::try_from(size).map_err(|_| too_large())?;
            self.to.seek(SeekFrom::Start(4))?;
            self.to.write_all(&size.to_le_bytes())?;
        }
        self.to.flush()
    }
}

fn too_large() -> io::Error {
    io::Error::new(io::ErrorKind::FileTooLarge, "a WebP file holds at most 4 GiB")
}

const fn u24(value: u32) -> [u8; 3] {
    let [a, b, c, _] = value.to_le_bytes();
    [a, b, c]
}

/// A chunk whose contents are `parts` in turn, padded to an even length.
fn write_chunk(to: &mut impl Write, name: &[u8; 4], parts: &[&[u8]]) -> io::Result<()> {
    let length: usize = parts.iter().map(|part| part.len()).sum();
    to.write_all(name)?;
    to.write_all(&u32::try_from(length).map_err(|_| too_large())?.to_le_bytes())?;
    for part in parts {
        to.write_all(part)?;
    }
    to.write_all(if length % 2 == 1 { &[0] } else { &[] })
}
