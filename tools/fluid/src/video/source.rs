//! Where videos come from: files, and folders of frames.

use super::{Clip, MOST_HEIGHT, MOST_WIDTH, ffmpeg};
use crate::footage::Class;
use image::{RgbImage, imageops};
use sha2::{Digest, Sha256};
use std::{
    ffi::OsStr,
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
};

/// Names of files that are taken for videos when a folder is searched. A file that is named itself may have any.
const VIDEOS: [&str; 14] =
    ["avi", "gif", "m4v", "mkv", "mov", "mp4", "mpeg", "mpg", "mts", "ogv", "ts", "webm", "wmv", "y4m"];

/// Names of files that are taken for frames.
const FRAMES: [&str; 8] = ["bmp", "jpeg", "jpg", "pgm", "png", "ppm", "tif", "tiff"];

/// A folder with so many pictures is a folder of frames and not of videos.
const FRAMES_OF_A_FOLDER: usize = 2;

/// How much of a video is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Seconds from its beginning.
    pub seconds: f32,
    /// Frames a second of a folder of frames.
    pub rate: f32,
}

/// A video that can be read.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Source {
    path: PathBuf,
    /// The frames of a folder, in the order of their names.
    frames: Vec<PathBuf>,
}

impl Source {
    /// All videos under these paths, in the order of their names in each.
    ///
    /// # Errors
    ///
    /// A path that is not there, or cannot be listed; a path under which there is no video.
    pub fn list(paths: &[PathBuf]) -> io::Result<Vec<Self>> {
        let mut sources = Vec::new();
        for path in paths {
            let before = sources.len();
            collect(path, true, &mut sources).map_err(|error| at(path, &error))?;
            if sources.len() == before {
                return Err(io::Error::new(
                    io::ErrorKind::NotFound,
                    format!(
                        "no video in {}: name a video file, a folder with some, or a folder of frames",
                        path.display()
                    ),
                ));
            }
        }
        Ok(sources)
    }

    /// The video that was taken from this path.
    ///
    /// # Errors
    ///
    /// There is no such video any more.
    pub fn again(path: &Path) -> io::Result<Self> {
        let sources = Self::list(&[path.to_owned()])?;
        sources.into_iter().find(|source| source.path == path).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    /// The file or folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it is called: the last part of its path.
    pub fn name(&self) -> String {
        self.path.file_name().unwrap_or(self.path.as_os_str()).to_string_lossy().into_owned()
    }

    /// The class that its name begins with, or else that of the folder that it lies in: `water_fountain.mp4`, `smoke/3.mp4`.
    pub fn class_by_name(&self) -> Option<Class> {
        let folder = self.path.parent().and_then(Path::file_name);
        [self.path.file_stem(), folder].into_iter().flatten().find_map(class_of_name)
    }

    /// The SHA-256 of what is in it, in hexadecimal: the same video under another name has the same.
    ///
    /// # Errors
    ///
    /// It cannot be read.
    pub fn content(&self) -> io::Result<String> {
        let mut hash = Sha256::new();
        let files = if self.frames.is_empty() { std::slice::from_ref(&self.path) } else { &self.frames };
        let mut block = vec![0; 1 << 16];
        for path in files {
            let mut file = File::open(path).map_err(|error| at(path, &error))?;
            loop {
                match file.read(&mut block).map_err(|error| at(path, &error))? {
                    0 => break,
                    count => hash.update(&block[..count]),
                }
            }
        }
        Ok(hexadecimal(&hash.finalize()))
    }

    /// Reads its beginning, made smaller if it is larger than 640 × 360.
    ///
    /// # Errors
    ///
    /// No ffmpeg program; nothing that it can decode; frames that cannot be read or are of several sizes.
    pub fn read(&self, extent: Extent) -> io::Result<Clip> {
        if self.frames.is_empty() {
            ffmpeg::read(&self.path, extent.seconds)
        } else {
            self.read_frames(extent)
        }
    }

    fn read_frames(&self, extent: Extent) -> io::Result<Clip> {
        let mut clip = Clip { frames: Vec::new(), rate: extent.rate };
        let most = (extent.seconds * extent.rate).ceil() as usize;
        for path in self.frames.iter().take(most.max(1)) {
            let frame = image::open(path).map_err(|error| at(path, &io::Error::other(error)))?;
            let frame = fitted(frame.into_rgb8());
            if clip.frames.first().is_some_and(|first| first.dimensions() != frame.dimensions()) {
                return Err(at(path, &io::Error::other("a frame of another size than the first one")));
            }
            clip.push(frame);
        }
        Ok(clip)
    }
}

/// Bytes as hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn at(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

fn fitted(frame: RgbImage) -> RgbImage {
    let (width, height) = frame.dimensions();
    if width <= MOST_WIDTH && height <= MOST_HEIGHT {
        return frame;
    }
    let share = (f64::from(MOST_WIDTH) / f64::from(width)).min(f64::from(MOST_HEIGHT) / f64::from(height));
    let side = |side: u32| ((f64::from(side) * share) as u32).max(1);
    imageops::resize(&frame, side(width), side(height), imageops::FilterType::CatmullRom)
}

fn collect(path: &Path, named: bool, sources: &mut Vec<Source>) -> io::Result<()> {
    if !fs::metadata(path)?.is_dir() {
        if named || has_extension(path, &VIDEOS) {
            sources.push(Source { path: path.to_owned(), frames: Vec::new() });
        }
        return Ok(());
    }
    let mut entries: Vec<PathBuf> =
        fs::read_dir(path)?.map(|entry| entry.map(|entry| entry.path())).collect::<io::Result<_>>()?;
    entries.sort_by(|a, b| in_order(a.as_os_str(), b.as_os_str()));
    let frames: Vec<PathBuf> =
        entries.iter().filter(|entry| has_extension(entry, &FRAMES)).cloned().collect();
    if frames.len() >= FRAMES_OF_A_FOLDER {
        sources.push(Source { path: path.to_owned(), frames });
    } else {
        for entry in &entries {
            // A link that leads nowhere is no video.
            match collect(entry, false, sources) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
    }
    Ok(())
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().and_then(OsStr::to_str).map(str::to_ascii_lowercase);
    extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
}

/// Numbers by their value, so that frame 10 comes after frame 9; else by bytes.
fn in_order(a: &OsStr, b: &OsStr) -> std::cmp::Ordering {
    let runs = |name: &OsStr| {
        let name = name.to_string_lossy().into_owned();
        let mut runs: Vec<(u128, String)> = vec![(0, String::new())];
        for letter in name.chars() {
            let Some((number, text)) = runs.last_mut() else { break };
            match letter.to_digit(10) {
                Some(digit) if text.is_empty() => {
                    *number = number.saturating_mul(10).saturating_add(u128::from(digit))
                }
                Some(digit) => runs.push((u128::from(digit), String::new())),
                None => text.push(letter),
            }
        }
        runs
    };
    runs(a).cmp(&runs(b)).then_with(|| a.cmp(b))
}

fn class_of_name(name: &OsStr) -> Option<Class> {
    let name = name.to_string_lossy().to_lowercase();
    let word = name.split(|letter: char| !letter.is_alphabetic()).next()?;
    Some(match word {
        "water" | "river" | "sea" | "waterfall" | "fountain" => Class::Water,
        "fire" | "flame" | "flames" => Class::Fire,
        "smoke" | "steam" | "cloud" | "clouds" | "fog" => Class::Smoke,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::Rgb;

    fn extent(seconds: f32) -> Extent {
        Extent { seconds, rate: 10.0 }
    }

    #[test]
    fn a_folder_of_frames_is_read_in_the_order_of_their_numbers() {
        let folder = tempfile::tempdir().unwrap();
        for number in [10, 9, 1, 2] {
            RgbImage::from_pixel(8, 6, Rgb([number; 3]))
                .save(folder.path().join(format!("frame{number}.png")))
                .unwrap();
        }
        let sources = Source::list(&[folder.path().to_owned()]).unwrap();
        let frames = sources[0].read(extent(1.0)).unwrap().frames;
        assert_eq!(frames.iter().map(|frame| frame.get_pixel(0, 0).0[0]).collect::<Vec<_>>(), [1, 2, 9, 10]);
        assert_eq!(sources[0].read(extent(0.3)).unwrap().frames.len(), 3);
    }

    #[test]
    fn large_frames_are_made_smaller_and_frames_of_another_size_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for number in 1..=2 {
            RgbImage::from_pixel(1280, 400, Rgb([number; 3]))
                .save(folder.path().join(format!("{number}.png")))
                .unwrap();
        }
        let source = &Source::list(&[folder.path().to_owned()]).unwrap()[0];
        assert_eq!(source.read(extent(1.0)).unwrap().frames[0].dimensions(), (640, 200));
        RgbImage::new(1280, 410).save(folder.path().join("3.png")).unwrap();
        let source = &Source::list(&[folder.path().to_owned()]).unwrap()[0];
        let error = source.read(extent(1.0)).unwrap_err().to_string();
        assert!(error.contains("3.png") && error.contains("another size"), "{error}");
    }

    #[test]
    fn a_folder_without_videos_says_so() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("notes.txt"), "none").unwrap();
        let error = Source::list(&[folder.path().to_owned()]).unwrap_err().to_string();
        assert!(error.starts_with("no video in "), "{error}");
        assert!(Source::list(&[folder.path().join("gone")]).unwrap_err().to_string().contains("gone"));
    }

    #[test]
    fn the_content_and_not_the_name_tells_videos_apart() {
        let folder = tempfile::tempdir().unwrap();
        let file = |name: &str, content: &str| {
            let path = folder.path().join(name);
            fs::write(&path, content).unwrap();
            Source::list(&[path]).unwrap()[0].content().unwrap()
        };
        assert_eq!(file("a.mp4", "one"), file("b.mp4", "one"));
        assert_ne!(file("c.mp4", "two"), file("b.mp4", "one"));
    }

    #[test]
    fn names_and_folders_tell_the_class() {
        let class = |path: &str| Source { path: path.into(), frames: Vec::new() }.class_by_name();
        assert_eq!(class("x/water_fountain.mp4"), Some(Class::Water));
        assert_eq!(class("x/clouds_moor.mp4"), Some(Class::Smoke));
        assert_eq!(class("fire/0001.mp4"), Some(Class::Fire));
        assert_eq!(class("x/fireplace.mp4"), None);
    }
}
