//! # Rendered frames, written to files
//!
//! A [`Target`] says where frames go and in which format; a [`Writer`] takes them one by one and keeps no more than two of
//! them. Nothing appears under the target's name before [`Writer::finish`]: frames go to a temporary name beside it, which a
//! dropped writer removes. A [`FrameHash`] condenses the same frames to one number.
//!
//! Animations loop for ever. APNG, GIF and WebP store only the rectangle that changed from frame to frame.

mod apng;
mod changed;
mod dither;
mod error;
mod gif;
mod hash;
mod packed;
mod palette;
mod rate;
mod staged;
mod target;
mod webp;
mod y4m;

pub use error::{OutputError, Problem};
pub use hash::FrameHash;
pub use rate::{FrameRate, ParseFrameRateError};
pub use target::{FileFormat, Target, TargetError};

use crate::frame::{FrameRef, Layout, PixelFormat, Size};
pub(super) use staged::StagedFile;
use staged::StagedFolder;
use std::{
    fs::File,
    io::{self, BufWriter, Seek, Write},
    os::fd::AsFd,
    path::Path,
};

/// Writes a whole file, which appears under its name when it is whole.
///
/// # Errors
///
/// A place that takes no more bytes. Then nothing is left behind, and a file that was there before stays as it was.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let written = StagedFile::create(path).and_then(|staged| {
        staged.open()?.write_all(bytes)?;
        staged.commit()
    });
    written.map_err(|error| OutputError::new(&path.to_string_lossy(), Problem::Io(error)))
}

/// One file format being written: takes frames as packed 8-bit red, green, blue.
trait Encode {
    /// Adds a frame.
    fn frame(&mut self, rgb: &[u8]) -> io::Result<()>;

    /// Writes what is left and hands everything to the operating system.
    fn finish(self: Box<Self>) -> io::Result<()>;
}

/// What every encoder must know before the first frame.
#[derive(Clone, Copy, Debug)]
struct Film {
    size: Size,
    rate: FrameRate,
    frames: u32,
}

/// Where the bytes of a [`Writer`] go until it is finished.
enum Place {
    Stdout,
    File(StagedFile),
    Folder(StagedFolder),
}

/// Writes frames to a [`Target`], each when it comes.
///
/// Dropped before [`Writer::finish`], it leaves nothing behind, and a file that was there before stays as it was; what went to
/// stdout cannot be called back.
pub struct Writer {
    // Before `place`: an encoder may flush when it is dropped, and its temporary file must go after that.
    encoder: Box<dyn Encode>,
    place: Place,
    name: String,
    film: Film,
    written: u32,
    rgb: Vec<u8>,
}

impl Writer {
    /// Opens `target` for `frames` frames of `size`, of which `rate` are shown a second.
    ///
    /// # Errors
    ///
    /// A place that cannot be written, a folder that holds other files, a size no [`Layout`] takes, or no frames at all.
    pub fn create(target: &Target, size: Size, rate: FrameRate, frames: u32) -> Result<Self, OutputError> {
        let name = target.to_string();
        let fail = |problem| OutputError::new(&name, problem);
        if Layout::new(size, PixelFormat::Bgr888, None).is_err() {
            return Err(fail(Problem::Size { promised: size, got: size }));
        }
        if frames == 0 {
            return Err(fail(Problem::Count { promised: 0, written: 0 }));
        }
        let film = Film { size, rate, frames };
        let opened: Result<(Place, Box<dyn Encode>), Problem> = (|| match target {
            Target::Stdout => {
                let stdout = File::from(io::stdout().as_fd().try_clone_to_owned()?);
                Ok((Place::Stdout, Box::new(y4m::Encoder::new(BufWriter::new(stdout), film)?) as _))
            }
            Target::File { path, format } => {
                let file = StagedFile::create(path)?;
                let encoder = encoder(*format, BufWriter::with_capacity(1 << 16, file.open()?), film)?;
                Ok((Place::File(file), encoder))
            }
            Target::Folder(path) => {
                let folder = StagedFolder::create(path)?;
                let encoder = Box::new(apng::Folder::new(folder.path(), film));
                Ok((Place::Folder(folder), encoder as _))
            }
        })();
        let (place, encoder) = opened.map_err(fail)?;
        Ok(Self::new(name, film, place, encoder))
    }

    fn new(name: String, film: Film, place: Place, encoder: Box<dyn Encode>) -> Self {
        Self { encoder, place, name, film, written: 0, rgb: Vec::new() }
    }

    /// Adds the next frame, in any pixel format and with any stride.
    ///
    /// # Errors
    ///
    /// A frame of another size, one more than promised, or a place that takes no more bytes.
    pub fn write(&mut self, frame: FrameRef<'_>) -> Result<(), OutputError> {
        let Film { size, frames, .. } = self.film;
        let got = frame.layout().size;
        if got != size {
            return Err(OutputError::new(&self.name, Problem::Size { promised: size, got }));
        }
        if self.written == frames {
            let problem = Problem::Count { promised: frames, written: frames + 1 };
            return Err(OutputError::new(&self.name, problem));
        }
        packed::pack_rgb(frame, &mut self.rgb);
        self.encoder.frame(&self.rgb).map_err(|e| OutputError::new(&self.name, Problem::Io(e)))?;
        self.written += 1;
        Ok(())
    }

    /// Writes the end, makes sure that everything is on the disk, and gives it its name.
    ///
    /// # Errors
    ///
    /// Fewer frames than promised, or a place that takes no more bytes. Then nothing is left behind.
    pub fn finish(self) -> Result<(), OutputError> {
        let Self { encoder, place, name, film, written, .. } = self;
        if written < film.frames {
            let problem = Problem::Count { promised: film.frames, written };
            return Err(OutputError::new(&name, problem));
        }
        let finished = encoder.finish().and_then(|()| match place {
            Place::Stdout => Ok(()),
            Place::File(file) => file.commit(),
            Place::Folder(folder) => folder.commit(),
        });
        finished.map_err(|e| OutputError::new(&name, Problem::Io(e)))
    }
}

/// The encoder for `format` that writes to `to`.
fn encoder<W: Write + Seek + 'static>(format: FileFormat, to: W, film: Film) -> io::Result<Box<dyn Encode>> {
    Ok(match format {
        FileFormat::Png => Box::new(apng::Encoder::new(to, film)?),
        FileFormat::Gif => Box::new(gif::Encoder::new(to, film)),
        FileFormat::WebP => Box::new(webp::Encoder::new(to, film)?),
        FileFormat::Y4m => Box::new(y4m::Encoder::new(to, film)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::{fs, io::Cursor, path::Path};

    const SIZE: Size = Size::new(16, 9);

    /// A disk with `room` for so many bytes.
    struct Disk {
        file: Cursor<Vec<u8>>,
        room: usize,
    }

    impl Write for Disk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            if self.file.get_ref().len() + bytes.len() > self.room {
                return Err(io::ErrorKind::StorageFull.into());
            }
            self.file.write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Disk {
        fn seek(&mut self, to: io::SeekFrom) -> io::Result<u64> {
            self.file.seek(to)
        }
    }

    fn film(frames: u32) -> Film {
        Film { size: SIZE, rate: FrameRate::new(30, 1).unwrap(), frames }
    }

    fn write_all(mut writer: Writer) -> Result<(), OutputError> {
        let layout = Layout::new(SIZE, PixelFormat::Bgr888, None).unwrap();
        for i in 0..writer.film.frames {
            let pixels: Vec<u8> =
                (0..layout.len_bytes()).map(|at| (at as u32 * 37 + i * at as u32 * 11) as u8).collect();
            writer.write(FrameRef::new(&pixels, layout).unwrap())?;
        }
        writer.finish()
    }

    /// A writer to `path` whose disk has `room` for so many bytes.
    fn writer_on_disk(
        path: &Path,
        format: FileFormat,
        frames: u32,
        room: usize,
    ) -> Result<Writer, OutputError> {
        let disk = Disk { file: Cursor::default(), room };
        let name = path.display().to_string();
        let encoder =
            encoder(format, disk, film(frames)).map_err(|e| OutputError::new(&name, Problem::Io(e)))?;
        let place = Place::File(StagedFile::create(path).unwrap());
        Ok(Writer::new(name, film(frames), place, encoder))
    }

    #[test]
    fn a_full_disk_is_named_and_the_file_of_before_stays() {
        for (format, frames) in FileFormat::ALL.into_iter().flat_map(|f| [(f, 1), (f, 3)]) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("film");
            fs::write(&path, "before").unwrap();
            // Fail in the header, in a frame, and with the last bytes.
            let mut room = 0;
            while let Err(error) = writer_on_disk(&path, format, frames, room).and_then(write_all) {
                let text = error.to_string();
                assert!(
                    text.contains("film: the disk is full; free"),
                    "{format:?} with {room} bytes: {text}"
                );
                assert_eq!(fs::read(&path).unwrap(), b"before", "{format:?} with {room} bytes");
                assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "{format:?} with {room} bytes");
                room += 31;
            }
            assert!(room > 100, "{format:?} never fills a disk");
        }
    }

    fn writer_to(file: File) -> Writer {
        let encoder = y4m::Encoder::new(BufWriter::new(file), film(3)).unwrap();
        Writer::new(Target::Stdout.to_string(), film(3), Place::Stdout, Box::new(encoder))
    }

    #[test]
    fn a_full_device_behind_stdout_is_named() {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let text = write_all(writer_to(full)).unwrap_err().to_string();
        assert_eq!(text, "standard output: the disk is full; free some space or write elsewhere");
    }

    #[test]
    fn a_closed_pipe_behind_stdout_is_named() {
        let (reader, writer) = io::pipe().unwrap();
        drop(reader);
        let text =
            write_all(writer_to(File::from(std::os::fd::OwnedFd::from(writer)))).unwrap_err().to_string();
        assert!(text.starts_with("standard output: the reader closed the pipe"), "{text}");
    }
}
