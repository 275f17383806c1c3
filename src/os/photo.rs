//! # Photos
//!
//! From a file to the pixels of the panel, and the mask beside it.
//!
//! A photo is JPEG, PNG, WebP, GIF (of animations the first frame), BMP or TIFF, told by its content and never by its name,
//! of 8 or 16 bits or floating point, colour or grey, with or without transparency. Its EXIF orientation (1 to 8) is
//! applied, an embedded ICC profile of three primaries or of grey is converted to sRGB, and it is resampled in linear light.
//! JPEG XL is, with the cargo feature `jxl`. Of a clip ([`crate::os::clip`]) it is the base. HEIC, AVIF and camera RAW are recognised and **not** supported.
//!
//! Memory: the size is read from the header first, and a photo over the [`Limits`] is refused before memory is taken. A JPEG
//! that is twice as large as its place on the panel, or more, is shrunk to a half, a quarter or an eighth while it is decoded.
//! The peak for `w` × `h` pixels (those left) of `b` bytes each (3 for a usual JPEG; 1 to 16 else) is the file (twice for JPEG) + `w·h·b` +
//! the decoder's own (up to 6 bytes a pixel for a progressive JPEG, 8 for WebP, 4 for GIF, `b` for TIFF in one strip) +
//! 3 bytes for each pixel of the panel + a few rows ([`crate::frame::resample::storage_len`]). There is no second copy of
//! the whole photo: rows become linear light while they are resampled.

mod border;
mod colour;
mod decode;
mod error;
mod file;
mod fit;
mod folder;
mod format;
#[cfg(feature = "jxl")]
mod jxl;
mod mask;
mod shrunk_jpeg;

pub use error::{Fault, PhotoError};
pub use fit::{Fit, UnknownFit};
pub(super) use folder::{Found, find};
pub use folder::{list, list_telling};
pub use mask::{load_mask, mask_from_bytes, mask_path};

use super::clip;
use crate::frame::{
    Layout, Rect, Size,
    resample::{resample, storage_len},
    srgb,
};
use decode::Decoded;
use fit::Placement;
use std::{fs::File, path::Path};

/// A photo as the panel shows it.
#[derive(Clone, Debug)]
pub struct Photo {
    /// Red, green and blue of every pixel in sRGB, row after row without a gap; exactly the panel's size.
    pub rgb: Vec<u8>,
    /// The size of the panel.
    pub size: Size,
    /// Where on the panel the photo itself lies; the rest is border.
    pub picture: Rect,
    /// The size of the photo in its file, once turned as its EXIF orientation says.
    pub source_size: Size,
    /// How it was fitted to the panel.
    pub fit: Fit,
    /// The name of the file, for messages.
    pub name: String,
}

impl Photo {
    /// The shares of its width and height, as fractions, that are shown: its middle.
    pub fn shown(&self) -> [(u64, u64); 2] {
        Placement::new(self.source_size, self.size, self.fit).shown()
    }
}

/// How photos are loaded.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The size of the panel, or of what else is to be filled.
    pub size: Size,
    /// How a photo of another shape is fitted to it.
    pub fit: Fit,
    /// The sRGB colour of a plain border, and behind transparent photos.
    pub background: [u8; 3],
    /// What is too large.
    pub limits: Limits,
}

impl Options {
    /// The default way to load photos for a panel of `size`: blurred borders, black background, default limits.
    pub fn new(size: Size) -> Self {
        Self { size, fit: Fit::default(), background: [0; 3], limits: Limits::default() }
    }
}

/// What is too large to be loaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// The most pixels of a photo.
    pub pixels: u64,
    /// The most memory that a file and its decoding may take, in bytes.
    pub bytes: u64,
}

impl Default for Limits {
    /// 100 megapixels, which is more than any phone or full-frame camera gives, and 1 GiB, which is what a progressive JPEG of that
    /// size takes.
    fn default() -> Self {
        Self { pixels: 100_000_000, bytes: 1 << 30 }
    }
}

/// Loads the photo at `path`. Only regular files are opened, and nothing blocks.
///
/// # Errors
/// One line that names the file, what is wrong and the cure.
pub fn load(path: &Path, options: &Options) -> Result<Photo, PhotoError> {
    let named = |fault| PhotoError::new(&path.to_string_lossy(), fault);
    let decoded = {
        let bytes = content(path, options.limits.bytes)?;
        decode_for(&bytes, options).map_err(named)?
    };
    Ok(place(&path.to_string_lossy(), decoded, options))
}

/// Loads a photo from the `bytes` of a file; `name` stands for it in messages.
///
/// # Errors
/// As [`load`].
pub fn from_bytes(name: &str, bytes: &[u8], options: &Options) -> Result<Photo, PhotoError> {
    let decoded = decode_for(bytes, options).map_err(|fault| PhotoError::new(name, fault))?;
    Ok(place(name, decoded, options))
}

/// Loads the photo at `path` in its own shape: at its own size or, where it is larger, shrunk to lie within `bounds`. There
/// is no border.
///
/// # Errors
/// As [`load`].
pub fn load_within(path: &Path, bounds: Size, limits: &Limits) -> Result<Photo, PhotoError> {
    let name = path.to_string_lossy();
    let named = |fault| PhotoError::new(&name, fault);
    check_panel(bounds).map_err(named)?;
    let bytes = content(path, limits.bytes)?;
    let decoded = decode::decode(&bytes, limits, |size| size.within(bounds)).map_err(named)?;
    drop(bytes);
    let size = decoded.oriented_size().within(bounds);
    let options = Options { limits: *limits, ..Options::new(size) };
    Ok(place(&name, decoded, &options))
}

/// Decodes a photo no larger than its place on the panel asks for.
fn decode_for(bytes: &[u8], options: &Options) -> Result<Decoded, Fault> {
    check_panel(options.size)?;
    decode::decode(bytes, &options.limits, |size| Placement::new(size, options.size, options.fit).whole())
}

fn check_panel(size: Size) -> Result<(), Fault> {
    let sides = 1..=Layout::MAX_SIDE;
    let known = sides.contains(&size.width) && sides.contains(&size.height);
    if known { Ok(()) } else { Err(Fault::PanelSize(size)) }
}

/// The bytes of the file at `path`, at the most `limit`. Only regular files are opened, and nothing blocks.
///
/// # Errors
/// As [`load`].
pub fn read(path: &Path, limit: u64) -> Result<Vec<u8>, PhotoError> {
    file::read(path, limit).map_err(|fault| PhotoError::new(&path.to_string_lossy(), fault))
}

/// The bytes of the photo at `path`, at the most `limit`: those of a clip are those of its base.
fn content(path: &Path, limit: u64) -> Result<Vec<u8>, PhotoError> {
    let named = |fault| PhotoError::new(&path.to_string_lossy(), fault);
    match clip::open(path)? {
        Some(clip) => clip::picture(&clip, limit).map_err(named),
        None => read(path, limit),
    }
}

/// Opens the file at `path`. Only regular files are opened, and nothing blocks.
pub(super) fn open_regular(path: &Path) -> Result<File, PhotoError> {
    file::open(path).map_err(|fault| PhotoError::new(&path.to_string_lossy(), fault))
}

/// Resamples a photo to its place on the panel and fills the border.
fn place(name: &str, photo: Decoded, options: &Options) -> Photo {
    let Options { size, fit, background, .. } = *options;
    let source_size = photo.oriented_size();
    let placement = Placement::new(source_size, size, fit);
    let mut rgb = background.repeat(size.pixels());
    paint(&photo, name, &placement, size, background, &mut rgb);
    drop(photo);
    let picture = placement.picture;
    if fit == Fit::Blurred && picture.size != size {
        border::blur(&mut rgb, size, picture);
    }
    Photo { rgb, size, picture, source_size, fit, name: name.to_owned() }
}

/// Resamples a photo into its rectangle of `rgb`, turned as its EXIF orientation says.
fn paint(
    photo: &Decoded,
    name: &str,
    placement: &Placement,
    size: Size,
    background: [u8; 3],
    rgb: &mut [u8],
) {
    let colour = photo.colour(name);
    let turn = photo.turn;
    let (columns, rows) = placement.axes(photo.size, turn);
    let channels = photo.channels();
    let width = turn.undo(placement.picture.size).width as usize;
    let background = background.map(srgb::to_linear);
    let mut storage = vec![0; storage_len(columns, rows, channels)];
    let drawn = resample(
        columns,
        rows,
        channels,
        &mut storage,
        |y, planes| photo.linear_row(y, &colour, planes),
        |y, planes| {
            for x in 0..width {
                let at = |channel: usize| planes[channel * width + x];
                let (light, alpha) = match channels {
                    1 => ([at(0); 3], u16::MAX),
                    2 => ([at(0); 3], at(1)),
                    3 => ([at(0), at(1), at(2)], u16::MAX),
                    _ => ([at(0), at(1), at(2)], at(3)),
                };
                let light = over(colour.to_srgb_primaries(light), alpha, background);
                let pixel = turn.index(placement.picture, size, x as u32, y);
                rgb[3 * pixel..][..3].copy_from_slice(&light.map(srgb::to_srgb));
            }
        },
    );
    debug_assert_eq!(drawn, Ok(()), "the storage has the length of the formula");
}

/// A colour that is already multiplied by its alpha, over a background.
fn over(light: [u16; 3], alpha: u16, background: [u16; 3]) -> [u16; 3] {
    if alpha == u16::MAX {
        return light;
    }
    std::array::from_fn(|c| light[c].saturating_add(scale(background[c], u16::MAX - alpha)))
}

/// `value` × `share` / 65,535, rounded.
fn scale(value: u16, share: u16) -> u16 {
    ((u32::from(value) * u32::from(share) + 32_767) / 65_535) as u16
}
