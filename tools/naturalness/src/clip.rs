//! A recording in memory: the luminance of its frames.

use std::{
    error, fmt,
    io::{self, BufRead},
    path::{Path, PathBuf},
};

/// The luminance of every frame, in levels of 0..=255.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Frames a second.
    pub rate: f32,
    /// `width * height` values each, row by row.
    pub frames: Vec<Vec<f32>>,
}

/// Why there is no clip.
#[derive(Debug)]
pub enum ClipError {
    /// The file or folder cannot be read.
    Unreadable(PathBuf, io::Error),
    /// A frame is no picture.
    Frame(PathBuf, image::ImageError),
    /// A frame has another size than the first.
    Size(PathBuf),
    /// Nothing that could be shown.
    Empty,
    /// What is read is not Y4M, or not one that is understood: the reason.
    NotY4m(String),
}

impl fmt::Display for ClipError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable(path, error) => write!(f, "{} cannot be read: {error}", path.display()),
            Self::Frame(path, error) => write!(f, "{} is no picture: {error}", path.display()),
            Self::Size(path) => write!(f, "{} has another size than the frame before it", path.display()),
            Self::Empty => write!(f, "there are no frames; give a folder of pictures or a Y4M film"),
            Self::NotY4m(reason) => {
                write!(f, "this is no Y4M film: {reason}; make one with ffmpeg -i FILM film.y4m")
            }
        }
    }
}

impl error::Error for ClipError {}

impl Clip {
    /// Pixels of a frame.
    pub fn pixels(&self) -> usize {
        self.width * self.height
    }

    /// The frames from `first` on, `count` of them at the most.
    pub fn part(&self, first: usize, count: usize) -> Self {
        Self { frames: self.frames.iter().skip(first).take(count).cloned().collect(), ..*self }
    }

    /// The first frame, as often as there are frames: what stands still.
    pub fn still(&self) -> Self {
        Self { frames: vec![self.frames[0].clone(); self.frames.len()], ..*self }
    }

    /// The mean of the frames.
    pub fn mean(&self) -> Vec<f32> {
        let mut mean = vec![0.0; self.pixels()];
        for frame in &self.frames {
            for (sum, value) in mean.iter_mut().zip(frame) {
                *sum += value;
            }
        }
        let share = 1.0 / self.frames.len().max(1) as f32;
        mean.iter_mut().for_each(|sum| *sum *= share);
        mean
    }

    /// The pictures of a folder, in the order of their names.
    pub fn from_folder(folder: &Path, rate: f32) -> Result<Self, ClipError> {
        let unreadable = |error| ClipError::Unreadable(folder.to_path_buf(), error);
        let mut paths = Vec::new();
        for entry in folder.read_dir().map_err(unreadable)? {
            let path = entry.map_err(unreadable)?.path();
            if image::ImageFormat::from_path(&path).is_ok() {
                paths.push(path);
            }
        }
        paths.sort();
        let mut clip = Self { width: 0, height: 0, rate, frames: Vec::new() };
        for path in paths {
            let frame = image::open(&path).map_err(|error| ClipError::Frame(path.clone(), error))?.to_rgb8();
            let size = (frame.width() as usize, frame.height() as usize);
            if clip.frames.is_empty() {
                (clip.width, clip.height) = size;
            } else if size != (clip.width, clip.height) {
                return Err(ClipError::Size(path));
            }
            clip.frames.push(frame.pixels().map(|pixel| luminance(pixel.0)).collect());
        }
        if clip.frames.is_empty() { Err(ClipError::Empty) } else { Ok(clip) }
    }

    /// A Y4M film, of which the luma is read: 8 bits, any subsampling of the colours.
    pub fn from_y4m(mut film: impl BufRead) -> Result<Self, ClipError> {
        let mut line = Vec::new();
        read_line(&mut film, &mut line)?;
        let header =
            std::str::from_utf8(&line).map_err(|_| ClipError::NotY4m("its first line is not text".into()))?;
        let format = Format::parse(header)?;
        let mut clip =
            Self { width: format.width, height: format.height, rate: format.rate, frames: Vec::new() };
        let mut frame = vec![0; format.frame_bytes];
        loop {
            line.clear();
            if read_line(&mut film, &mut line)? == 0 {
                break;
            }
            if !line.starts_with(b"FRAME") {
                return Err(ClipError::NotY4m("a frame does not start with FRAME".into()));
            }
            film.read_exact(&mut frame).map_err(|_| ClipError::NotY4m("its last frame is cut".into()))?;
            // Luma is coded in 16..=235.
            let luma = &frame[..clip.width * clip.height];
            clip.frames.push(luma.iter().map(|&y| (f32::from(y) - 16.0) * (255.0 / 219.0)).collect());
        }
        if clip.frames.is_empty() { Err(ClipError::Empty) } else { Ok(clip) }
    }
}

/// The luma of Rec. 709 of three sRGB levels.
pub fn luminance([red, green, blue]: [u8; 3]) -> f32 {
    0.2126 * f32::from(red) + 0.7152 * f32::from(green) + 0.0722 * f32::from(blue)
}

fn read_line(film: &mut impl BufRead, line: &mut Vec<u8>) -> Result<usize, ClipError> {
    // A line of a film is short; what is longer is none.
    let mut short = io::Read::take(film, 1 << 10);
    short.read_until(b'\n', line).map_err(|error| ClipError::NotY4m(error.to_string()))
}

/// The first line of a Y4M film.
struct Format {
    width: usize,
    height: usize,
    rate: f32,
    frame_bytes: usize,
}

impl Format {
    /// The largest side of a frame: beyond it nobody measures.
    const LARGEST: usize = 8192;

    fn parse(header: &str) -> Result<Self, ClipError> {
        let refuse = |reason: &str| ClipError::NotY4m(reason.to_owned());
        let mut words = header.split_ascii_whitespace();
        if words.next() != Some("YUV4MPEG2") {
            return Err(refuse("it does not start with YUV4MPEG2"));
        }
        let (mut width, mut height, mut rate, mut colours) = (0, 0, 25.0, "420");
        for word in words {
            let (tag, value) =
                word.split_at_checked(1).ok_or_else(|| refuse("its first line is not ASCII"))?;
            match tag {
                "W" => width = value.parse().unwrap_or(0),
                "H" => height = value.parse().unwrap_or(0),
                "F" => rate = parse_rate(value).ok_or_else(|| refuse("its frame rate is no fraction"))?,
                "C" => colours = value,
                _ => {}
            }
        }
        if !(1..=Self::LARGEST).contains(&width) || !(1..=Self::LARGEST).contains(&height) {
            return Err(refuse("its width or height is missing, zero or above 8192"));
        }
        let luma = width * height;
        let half = |side: usize| side.div_ceil(2);
        let frame_bytes = match colours {
            "mono" => luma,
            "444" => 3 * luma,
            "422" => luma + 2 * half(width) * height,
            "420" | "420jpeg" | "420paldv" | "420mpeg2" => luma + 2 * half(width) * half(height),
            _ => return Err(refuse("its pixels are not 8 bits of 4:2:0, 4:2:2, 4:4:4 or mono")),
        };
        Ok(Self { width, height, rate, frame_bytes })
    }
}

fn parse_rate(value: &str) -> Option<f32> {
    let (frames, seconds) = value.split_once(':')?;
    let (frames, seconds): (f32, f32) = (frames.parse().ok()?, seconds.parse().ok()?);
    (frames > 0.0 && seconds > 0.0).then(|| frames / seconds)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};

    /// White noise about 128.
    pub(crate) fn noise(width: usize, height: usize, frames: usize, deviation: f32, seed: u64) -> Clip {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut frame = || {
            let normal = |_| (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0;
            (0..width * height).map(normal).map(|value| 128.0 + deviation * value).collect()
        };
        Clip { width, height, rate: 25.0, frames: (0..frames).map(|_| frame()).collect() }
    }

    #[test]
    fn the_luma_of_a_film_is_read() {
        let mut film = b"YUV4MPEG2 W3 H2 F30:1 C420jpeg\n".to_vec();
        for frame in 0..2u8 {
            film.extend(b"FRAME\n");
            film.extend([16 + frame, 235, 16, 16, 16, 125]);
            film.extend([128; 4]);
        }
        let clip = Clip::from_y4m(&film[..]).expect("a film");
        assert_eq!((clip.width, clip.height, clip.rate, clip.frames.len()), (3, 2, 30.0, 2));
        assert_eq!(clip.frames[0][..2], [0.0, 255.0]);
        assert!(clip.frames[1][0] > 1.0);
    }

    #[test]
    fn what_is_no_film_is_refused_by_its_fault() {
        let refused = |film: &[u8], fault: &str| {
            let error = Clip::from_y4m(film).expect_err(fault).to_string();
            assert!(error.contains(fault), "{error}");
        };
        refused(b"RIFF....", "YUV4MPEG2");
        refused(b"YUV4MPEG2 W0 H2\n", "width or height");
        refused(b"YUV4MPEG2 W99999999 H99999999\n", "width or height");
        refused(b"YUV4MPEG2 W2 H2 C420p10\n", "8 bits");
        refused(b"YUV4MPEG2 W2 H2\nFRAME\n12", "cut");
        refused(b"YUV4MPEG2 W2 H2\nPHOTO\n123456", "FRAME");
        assert!(matches!(Clip::from_y4m(&b"YUV4MPEG2 W2 H2\n"[..]), Err(ClipError::Empty)));
    }

    #[test]
    fn the_frames_of_a_folder_must_be_of_one_size() {
        let folder = tempfile::tempdir().expect("a folder");
        image::GrayImage::from_pixel(4, 3, image::Luma([9]))
            .save(folder.path().join("1.png"))
            .expect("a picture");
        let clip = Clip::from_folder(folder.path(), 25.0).expect("one frame");
        assert_eq!((clip.width, clip.height, clip.frames.len()), (4, 3, 1));
        assert!((clip.frames[0][0] - 9.0).abs() < 1e-4);
        image::GrayImage::new(5, 3).save(folder.path().join("2.png")).expect("a picture");
        assert!(matches!(Clip::from_folder(folder.path(), 25.0), Err(ClipError::Size(_))));
    }
}
