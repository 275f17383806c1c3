//! The frames of a video in one file: an animated PNG.
//!
//! Every frame is packed by itself, so that any one can be read alone; its chunk's checksum is looked at whenever it is read. The still
//! image, which is no frame, is the mean. The notes tell what the catalogue knows, so that it can be made anew from these files alone.
//!
//! About 5 ms a frame of 640 × 360 pixels to pack and 3 ms to unpack; a third to a half of the size of its pixels.

use super::{DatabaseError, lock};
use crate::footage::Class;
use image::{ImageFormat, RgbImage};
use png::{BitDepth, ColorType, Compression, Encoder};
use rayon::prelude::*;
use std::{
    fs::{self, File},
    io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write},
    path::{Path, PathBuf},
    sync::Mutex,
};

const SIGNATURE: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Bytes before the packed pixels in a frame's chunk: its place in the sequence.
const SEQUENCE: usize = 4;

/// Largest chunk that is believed: more than twice the pixels of the largest frame.
const MOST_CHUNK: usize = 2_000_000;

/// Where the frames of the video of this content are.
pub(super) fn path(directory: &Path, content: &str) -> PathBuf {
    directory.join("frames").join(format!("{content}.png"))
}

/// What a file of frames tells about itself.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Notes {
    /// The source's checksum.
    pub(super) content: String,
    /// The source's path.
    pub(super) source: String,
    pub(super) class: Class,
    /// Who said so.
    pub(super) class_by: String,
    pub(super) rate: f32,
}

impl Notes {
    fn pairs(&self) -> [(&'static str, String); 5] {
        [
            ("Content", self.content.clone()),
            ("Source", self.source.clone()),
            ("Class", self.class.name().to_owned()),
            ("Class by", self.class_by.clone()),
            ("Rate", self.rate.to_string()),
        ]
    }

    fn from_pairs(pairs: &[(String, String)]) -> Option<Self> {
        let value = |name: &str| pairs.iter().find(|(key, _)| key == name).map(|(_, value)| value.clone());
        Some(Self {
            content: value("Content")?,
            source: value("Source")?,
            class: Class::by_name(&value("Class")?)?,
            class_by: value("Class by")?,
            rate: value("Rate")?.parse().ok()?,
        })
    }
}

/// Writes a file of frames. It has its name only when it is whole and on the disk.
pub(super) fn write(
    path: &Path,
    notes: &Notes,
    mean: &RgbImage,
    frames: &[RgbImage],
) -> Result<(), DatabaseError> {
    let part = path.with_extension("part");
    let written = write_part(&part, notes, mean, frames).and_then(|()| fs::rename(&part, path));
    written.map_err(|error| {
        // What is left of it would only be in the way; the first error is the one to tell.
        let _ = fs::remove_file(&part);
        DatabaseError::File(path.to_owned(), error)
    })
}

fn write_part(part: &Path, notes: &Notes, mean: &RgbImage, frames: &[RgbImage]) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(part)?);
    let (width, height) = mean.dimensions();
    file.write_all(&SIGNATURE)?;
    write_chunk(&mut file, *b"IHDR", &header(width, height))?;
    let count = u32::try_from(frames.len()).map_err(io::Error::other)?;
    write_chunk(&mut file, *b"acTL", &[count.to_be_bytes(), 0u32.to_be_bytes()].concat())?;
    for (name, text) in notes.pairs() {
        // Keyword, not packed, no language, no translated keyword.
        write_chunk(&mut file, *b"iTXt", &[name.as_bytes(), b"\0\0\0\0\0", text.as_bytes()].concat())?;
    }
    write_chunk(&mut file, *b"IDAT", &packed(mean)?)?;
    let mut sequence = 0u32;
    // Some at a time: packing is for all cores, and memory is not for all frames twice.
    for frames in frames.chunks(16) {
        for pixels in frames.par_iter().map(packed).collect::<Vec<_>>() {
            write_chunk(&mut file, *b"fcTL", &frame_control(sequence, width, height, notes.rate))?;
            write_chunk(&mut file, *b"fdAT", &[&(sequence + 1).to_be_bytes()[..], &pixels?].concat())?;
            sequence += 2;
        }
    }
    write_chunk(&mut file, *b"IEND", &[])?;
    file.into_inner()?.sync_all()
}

fn header(width: u32, height: u32) -> Vec<u8> {
    // 8 bits, RGB, the one way to pack, to filter, and no interlacing.
    [&width.to_be_bytes()[..], &height.to_be_bytes(), &[8, 2, 0, 0, 0]].concat()
}

fn frame_control(sequence: u32, width: u32, height: u32, rate: f32) -> Vec<u8> {
    let numbers = [sequence, width, height, 0, 0].map(u32::to_be_bytes);
    let delay = (1000.0 / rate.max(0.1)) as u16;
    [numbers.as_flattened(), &delay.to_be_bytes(), &1000u16.to_be_bytes(), &[0, 0]].concat()
}

fn write_chunk(file: &mut impl Write, kind: [u8; 4], content: &[u8]) -> io::Result<()> {
    file.write_all(&u32::try_from(content.len()).map_err(io::Error::other)?.to_be_bytes())?;
    file.write_all(&kind)?;
    file.write_all(content)?;
    file.write_all(&checksum(kind, content).to_be_bytes())
}

fn checksum(kind: [u8; 4], content: &[u8]) -> u32 {
    let mut hasher = crc32fast::Hasher::new();
    hasher.update(&kind);
    hasher.update(content);
    hasher.finalize()
}

/// The pixels of a picture as they are in a PNG.
fn packed(picture: &RgbImage) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut encoder = Encoder::new(&mut file, picture.width(), picture.height());
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(picture.as_raw())?;
    writer.finish()?;
    let mut chunks = Chunks { file: io::Cursor::new(file), place: SIGNATURE.len() as u64 };
    let mut pixels = Vec::new();
    while let Some(chunk) = chunks.next()? {
        if chunk.kind == *b"IDAT" {
            pixels.extend(chunks.content(&chunk)?);
        }
    }
    Ok(pixels)
}

/// Where a chunk is.
#[derive(Clone, Copy, Debug)]
struct Chunk {
    kind: [u8; 4],
    start: u64,
    length: usize,
}

/// The chunks of a file, one after the other.
struct Chunks<F> {
    file: F,
    place: u64,
}

impl<F: Read + Seek> Chunks<F> {
    /// The next one; none after the last. A file that was cut has an error instead of its end.
    fn next(&mut self) -> io::Result<Option<Chunk>> {
        let mut head = [0; 8];
        self.file.seek(SeekFrom::Start(self.place))?;
        self.file.read_exact(&mut head)?;
        let [l0, l1, l2, l3, kind @ ..] = head;
        let length = u32::from_be_bytes([l0, l1, l2, l3]) as usize;
        if length > MOST_CHUNK {
            return Err(damaged("a part of it is too long"));
        }
        let start = self.place + 8;
        self.place = start + length as u64 + 4;
        Ok((kind != *b"IEND").then_some(Chunk { kind, start, length }))
    }

    fn content(&mut self, chunk: &Chunk) -> io::Result<Vec<u8>> {
        read_chunk(&mut self.file, chunk)
    }
}

fn read_chunk(file: &mut (impl Read + Seek), chunk: &Chunk) -> io::Result<Vec<u8>> {
    let mut content = vec![0; chunk.length];
    let mut expected = [0; 4];
    file.seek(SeekFrom::Start(chunk.start))?;
    file.read_exact(&mut content)?;
    file.read_exact(&mut expected)?;
    if checksum(chunk.kind, &content) == u32::from_be_bytes(expected) {
        Ok(content)
    } else {
        Err(damaged("a checksum is wrong"))
    }
}

fn damaged(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.to_owned())
}

/// A file of frames, open for reading.
#[derive(Debug)]
pub(super) struct FrameFile {
    path: PathBuf,
    file: Mutex<BufReader<File>>,
    header: Vec<u8>,
    mean: Chunk,
    frames: Vec<Chunk>,
    pub(super) notes: Notes,
}

impl FrameFile {
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        Self::scan(path).map_err(|error| named(path, &error))
    }

    fn scan(path: &Path) -> io::Result<Self> {
        let mut file = BufReader::new(File::open(path)?);
        let mut signature = [0; 8];
        file.read_exact(&mut signature)?;
        if signature != SIGNATURE {
            return Err(damaged("no PNG file"));
        }
        let mut chunks = Chunks { file, place: SIGNATURE.len() as u64 };
        let (mut header, mut mean, mut frames, mut pairs) = (Vec::new(), None, Vec::new(), Vec::new());
        while let Some(chunk) = chunks.next()? {
            match &chunk.kind {
                b"IHDR" => header = chunks.content(&chunk)?,
                b"IDAT" => mean = Some(chunk),
                b"fdAT" if chunk.length > SEQUENCE => frames.push(chunk),
                b"iTXt" => {
                    let text = chunks.content(&chunk)?;
                    let text = String::from_utf8_lossy(&text);
                    if let Some((name, text)) = text.split_once("\0\0\0\0\0") {
                        pairs.push((name.to_owned(), text.to_owned()));
                    }
                }
                _ => {}
            }
        }
        let mean = mean.ok_or_else(|| damaged("its mean is missing"))?;
        let notes = Notes::from_pairs(&pairs).ok_or_else(|| damaged("its notes are missing"))?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(chunks.file), header, mean, frames, notes })
    }

    /// Frames there are.
    pub(super) fn len(&self) -> usize {
        self.frames.len()
    }

    pub(super) fn mean(&self) -> io::Result<RgbImage> {
        self.unpacked(&self.mean, 0)
    }

    pub(super) fn frame(&self, index: u32) -> io::Result<RgbImage> {
        match self.frames.get(index as usize) {
            Some(chunk) => self.unpacked(chunk, SEQUENCE),
            None => Err(named(&self.path, &damaged(&format!("it has no frame {index}")))),
        }
    }

    /// All frames.
    pub(super) fn frames(&self) -> io::Result<Vec<RgbImage>> {
        (0..self.frames.len()).into_par_iter().map(|index| self.frame(index as u32)).collect()
    }

    /// Reads all of it for its checksums.
    pub(super) fn check(&self) -> io::Result<()> {
        let mut file = lock(&self.file);
        for chunk in std::iter::once(&self.mean).chain(&self.frames) {
            read_chunk(&mut *file, chunk).map_err(|error| named(&self.path, &error))?;
        }
        Ok(())
    }

    /// Makes a PNG file of a chunk, in memory, and reads that.
    fn unpacked(&self, chunk: &Chunk, skipped: usize) -> io::Result<RgbImage> {
        let content = read_chunk(&mut *lock(&self.file), chunk).map_err(|error| named(&self.path, &error))?;
        let mut png = Vec::with_capacity(content.len() + 64);
        png.extend(SIGNATURE);
        write_chunk(&mut png, *b"IHDR", &self.header)?;
        write_chunk(&mut png, *b"IDAT", &content[skipped..])?;
        write_chunk(&mut png, *b"IEND", &[])?;
        let picture = image::load_from_memory_with_format(&png, ImageFormat::Png);
        picture
            .map(image::DynamicImage::into_rgb8)
            .map_err(|error| named(&self.path, &io::Error::other(error)))
    }
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    let what = if error.kind() == io::ErrorKind::UnexpectedEof {
        "it was cut".to_owned()
    } else {
        error.to_string()
    };
    io::Error::new(
        error.kind(),
        format!("{}: {what}; `check` tells what is lost and `index` mends it", path.display()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    fn notes() -> Notes {
        Notes {
            content: "c0ffee".into(),
            source: "水/a.mp4".into(),
            class: Class::Water,
            class_by: "name".into(),
            rate: 29.97,
        }
    }

    fn written() -> (tempfile::TempDir, PathBuf, Vec<RgbImage>) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("v.png");
        let frames: Vec<RgbImage> = (0..20)
            .map(|frame| RgbImage::from_fn(33, 21, |x, y| Rgb([(x * y + frame) as u8, x as u8, frame as u8])))
            .collect();
        write(&path, &notes(), &frames[7], &frames).unwrap();
        (folder, path, frames)
    }

    #[test]
    fn every_frame_comes_back_alone() {
        let (_folder, path, frames) = written();
        let file = FrameFile::open(&path).unwrap();
        assert_eq!((file.len(), &file.notes), (20, &notes()));
        for index in [19, 0, 7] {
            assert_eq!(file.frame(index).unwrap(), frames[index as usize]);
        }
        assert_eq!(file.mean().unwrap(), frames[7]);
        assert!(file.frame(20).is_err());
        file.check().unwrap();
    }

    #[test]
    fn other_programs_see_an_animation() {
        let (_folder, path, frames) = written();
        let decoder =
            image::codecs::png::PngDecoder::new(BufReader::new(File::open(&path).unwrap())).unwrap();
        let all = image::AnimationDecoder::into_frames(decoder.apng().unwrap()).collect_frames().unwrap();
        assert_eq!(all.len(), 20);
        let third = image::DynamicImage::from(all[3].buffer().clone()).into_rgb8();
        assert_eq!(third, frames[3]);
    }

    #[test]
    fn a_cut_or_damaged_file_is_refused_by_name() {
        let (_folder, path, _) = written();
        let whole = fs::read(&path).unwrap();
        fs::write(&path, &whole[..whole.len() / 2]).unwrap();
        let error = FrameFile::open(&path).unwrap_err().to_string();
        assert!(error.contains("v.png: it was cut") && error.contains("index"), "{error}");
        let mut flipped = whole.clone();
        let middle = flipped.len() / 2;
        flipped[middle] ^= 1;
        fs::write(&path, &flipped).unwrap();
        let found = FrameFile::open(&path).and_then(|file| file.check());
        assert!(found.unwrap_err().to_string().contains("v.png"));
    }
}
