//! Clips as files, read and written: pictures whose fluid moves. [`crate::effect::fluid::clip`] has their layout.

use super::{
    once::once,
    output::StagedFile,
    photo::{self, Fault, PhotoError},
};
use crate::{
    effect::fluid::{
        Clip, ClipError, Header, Shape, Source, Tint, clip,
        code::{Extent, Planes, encode, most_bytes},
    },
    frame::Size,
};
use image::{
    ExtendedColorType, ImageEncoder,
    codecs::png::{CompressionType, FilterType, PngEncoder},
};
use log::Level;
use std::{
    error::Error,
    fmt,
    fs::File,
    io::{self, BufWriter, Seek, SeekFrom, Write},
    os::unix::fs::FileExt,
    path::Path,
    sync::Arc,
};

/// The file of a clip, read piece by piece where it is.
#[derive(Clone, Debug)]
pub struct ClipFile {
    file: Arc<File>,
    length: u64,
    /// For messages.
    name: Arc<str>,
}

impl Source for ClipFile {
    fn len(&self) -> u64 {
        self.length
    }

    fn read(&self, at: u64, into: &mut [u8]) -> bool {
        self.file.read_exact_at(into, at).is_ok()
    }

    fn damaged(&self, frame: u32) {
        let name = &self.name;
        log::debug!("{name}: frame {frame} is damaged");
        let line = "frames of the clip are damaged or cannot be read: those before them stay; copy it again";
        once(Level::Warn, format!("{name}: {line}"));
    }
}

/// Opens the clip at `path`; `None` if the file is none. Only regular files are opened, and nothing blocks.
///
/// # Errors
/// One line that names the file, what is wrong with its header or index and the cure.
pub fn open(path: &Path) -> Result<Option<Clip<ClipFile>>, PhotoError> {
    let name = path.to_string_lossy().into();
    let file = photo::open_regular(path)?;
    let length = file.metadata().map_or(0, |metadata| metadata.len());
    let source = ClipFile { file: Arc::new(file), length, name };
    let mut magic = [0; 3];
    if !source.read(0, &mut magic) || magic != clip::MAGIC[..3] {
        return Ok(None);
    }
    let named = |error| PhotoError::new(&path.to_string_lossy(), Fault::Clip(error));
    Clip::open(source).map(Some).map_err(named)
}

/// The base of a clip, as the bytes of a photo's file of at the most `limit` bytes.
pub(super) fn picture(clip: &Clip<ClipFile>, limit: u64) -> Result<Vec<u8>, Fault> {
    let needed = u64::from(clip.header().picture);
    let too_large = Fault::TooMuchMemory { needed, limit };
    let mut bytes = Vec::new();
    if needed > limit || bytes.try_reserve_exact(needed as usize).is_err() {
        return Err(too_large);
    }
    bytes.resize(needed as usize, 0);
    clip.read_picture(&mut bytes).map_err(Fault::Clip)?;
    Ok(bytes)
}

/// Writes a clip, frame by frame. The file has its name when [`Self::finish`] has given it; a writer that is dropped leaves nothing.
pub struct ClipWriter {
    staged: StagedFile,
    out: BufWriter<File>,
    header: Header,
    index: Vec<u8>,
    extents: Vec<Extent>,
    /// The frame and the one before it.
    change: Vec<i8>,
    before: Vec<i8>,
    residuals: Vec<u8>,
    packed: Vec<u8>,
    clipped: u64,
    products: Products,
}

/// Sums over frames and those that follow them.
#[derive(Default)]
struct Products {
    own: i64,
    following: i64,
    mixed: i64,
}

impl Products {
    fn add(&mut self, before: &[i8], after: &[i8]) {
        for (&a, &b) in before.iter().zip(after) {
            let (a, b) = (i32::from(a), i32::from(b));
            self.own += i64::from(a * a);
            self.following += i64::from(b * b);
            self.mixed += i64::from(a * b);
        }
    }

    /// The correlation, at least 0, in units of 2^-15. Frames that do not move go over into each other as they are.
    fn correlation(&self) -> u16 {
        let spread = (self.own as f64).sqrt() * (self.following as f64).sqrt();
        let correlation = if spread > 0.0 { self.mixed as f64 / spread } else { 1.0 };
        (correlation.clamp(0.0, 1.0) * 32_768.0).round() as u16
    }
}

/// What a clip has become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Written {
    /// How many frames.
    pub frames: u32,
    /// How many bytes.
    pub bytes: u64,
    /// Values of all frames that were cut to the range of the format.
    pub clipped: u64,
}

impl ClipWriter {
    /// Begins the clip at `path`: the `base` in sRGB, 3 bytes a pixel; the `matte`, a byte for each pixel of the grid, 0 where it stands still for ever and
    /// takes no room, 255 where it moves fully; the `tint` of a clip of luma.
    ///
    /// # Errors
    /// Measures that cannot be, a base or matte of another length, or a place that takes no file.
    pub fn create(
        path: &Path,
        shape: &Shape,
        base: &[u8],
        matte: &[u8],
        tint: &Tint,
    ) -> Result<Self, WriteError> {
        shape.check()?;
        WriteError::check("the base", base.len(), shape.base.pixels() * 3)?;
        WriteError::check("the matte", matte.len(), shape.grid.pixels())?;
        let values = shape.values();
        let mut packed = vec![0; most_bytes(values)];
        let mut residuals = vec![0; values];
        let length = pack_matte(matte, shape.grid, &mut residuals, &mut packed);
        let picture = png(base, shape.base)?;
        let staged = StagedFile::create(path)?;
        let mut out = BufWriter::new(staged.open()?);
        let tint = tint.0.as_flattened();
        for part in [&[0; clip::HEADER], tint, &packed[..length], &picture] {
            out.write_all(part)?;
        }
        let checksums = [
            clip::part_checksum(tint),
            clip::part_checksum(&packed[..length]),
            clip::part_checksum(&picture),
            0,
        ];
        let header = Header {
            shape: *shape,
            correlation: 0,
            frames: 0,
            matte: length as u32,
            picture: picture.len() as u32,
            longest: 0,
            length: (clip::HEADER + tint.len() + length + picture.len()) as u64,
            checksums,
        };
        Ok(Self {
            staged,
            out,
            header,
            index: Vec::new(),
            extents: matte.chunks_exact(shape.grid.width as usize).map(Extent::of).collect(),
            change: vec![0; values],
            before: vec![0; values],
            residuals,
            packed,
            clipped: 0,
            products: Products::default(),
        })
    }

    /// Adds a frame: how far each pixel of the grid is from the base, in levels, plane after plane: one of luma, or red, green and blue. It is
    /// rounded to the steps of the clip and cut to 127 of them; what lies beyond the matte is left out.
    ///
    /// # Errors
    /// Another number of values, too many frames, or a disk that takes no more.
    pub fn frame(&mut self, change: &[f32]) -> Result<(), WriteError> {
        WriteError::check("a frame", change.len(), self.change.len())?;
        if self.header.frames == *clip::FRAMES.end() {
            return Err(ClipError::Frames(self.header.frames + 1).into());
        }
        self.quantise(change);
        if self.header.frames > 0 {
            self.products.add(&self.before, &self.change);
        }
        let planes = Planes {
            width: self.header.shape.grid.width as usize,
            extents: &self.extents,
            count: self.header.shape.kind.planes(),
        };
        let length = encode(&planes, &mut self.change, &mut self.residuals, &mut self.packed);
        let bytes = &self.packed[..length];
        self.out.write_all(bytes)?;
        self.index.extend(clip::Entry::of(self.header.length, bytes).write());
        self.header.length += length as u64;
        self.header.longest = self.header.longest.max(length as u32);
        self.header.frames += 1;
        std::mem::swap(&mut self.change, &mut self.before);
        Ok(())
    }

    fn quantise(&mut self, change: &[f32]) {
        let step = f32::from(self.header.shape.step);
        self.change.fill(0);
        let width = self.header.shape.grid.width as usize;
        let rows = self.change.chunks_exact_mut(width).zip(change.chunks_exact(width));
        for ((to, from), extent) in rows.zip(self.extents.iter().cycle()) {
            let columns = usize::from(extent.start)..extent.end.into();
            for (to, from) in to[columns.clone()].iter_mut().zip(&from[columns]) {
                let units = (from / step).round();
                self.clipped += u64::from(units.abs() > 127.0);
                // What is no number does not move.
                *to = units.clamp(-127.0, 127.0) as i8;
            }
        }
    }

    /// Ends the clip and gives it its name, in the place of a file that has it already.
    ///
    /// # Errors
    /// Fewer than two frames, or a disk that takes no more.
    pub fn finish(mut self) -> Result<Written, WriteError> {
        if !clip::FRAMES.contains(&self.header.frames) {
            return Err(ClipError::Frames(self.header.frames).into());
        }
        self.out.write_all(&self.index)?;
        self.header.length += self.index.len() as u64;
        self.header.checksums[3] = clip::part_checksum(&self.index);
        self.header.correlation = self.products.correlation();
        self.out.seek(SeekFrom::Start(0))?;
        self.out.write_all(&self.header.write())?;
        self.out.into_inner().map_err(io::IntoInnerError::into_error)?;
        self.staged.commit()?;
        let Header { frames, length, .. } = self.header;
        Ok(Written { frames, bytes: length, clipped: self.clipped })
    }
}

/// Codes the matte as one plane without extents; gives its bytes.
fn pack_matte(matte: &[u8], grid: Size, residuals: &mut [u8], packed: &mut [u8]) -> usize {
    let extents = vec![Extent { start: 0, end: grid.width as u16 }; grid.height as usize];
    let planes = Planes { width: grid.width as usize, extents: &extents, count: 1 };
    let mut matte: Vec<i8> = bytemuck::cast_slice(matte).to_vec();
    encode(&planes, &mut matte, residuals, packed)
}

fn png(rgb: &[u8], size: Size) -> Result<Vec<u8>, WriteError> {
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive);
    encoder.write_image(rgb, size.width, size.height, ExtendedColorType::Rgb8).map_err(io::Error::other)?;
    Ok(bytes)
}

/// Why a clip cannot be written.
#[derive(Debug)]
pub enum WriteError {
    /// Measures or frames that no clip has.
    Clip(ClipError),
    /// A part of another length than the measures ask for.
    Length {
        /// Which part.
        part: &'static str,
        /// How many values it has.
        got: usize,
        /// How many it must have.
        needed: usize,
    },
    /// The disk takes it not.
    Disk(io::Error),
}

impl WriteError {
    fn check(part: &'static str, got: usize, needed: usize) -> Result<(), Self> {
        if got == needed { Ok(()) } else { Err(Self::Length { part, got, needed }) }
    }
}

impl From<ClipError> for WriteError {
    fn from(error: ClipError) -> Self {
        Self::Clip(error)
    }
}

impl From<io::Error> for WriteError {
    fn from(error: io::Error) -> Self {
        Self::Disk(error)
    }
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clip(error) => error.fmt(f),
            Self::Length { part, got, needed } => {
                write!(f, "{part} of the clip has {got} values, and its measures ask for {needed}")
            }
            Self::Disk(error) => write!(f, "the clip cannot be written: {error}"),
        }
    }
}

impl Error for WriteError {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::Disk(error) => Some(error),
            Self::Clip(_) | Self::Length { .. } => None,
        }
    }
}
