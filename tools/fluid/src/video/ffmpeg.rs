//! The ffmpeg program, by pipe.

use super::{Clip, MOST_HEIGHT, MOST_WIDTH};
use image::RgbImage;
use std::{
    ffi::{OsStr, OsString},
    io::{self, BufRead, BufReader, Read},
    path::Path,
    process::{Child, Command, Stdio},
};

/// Frames a second of a video that does not say how many.
const NOMINAL_RATE: f32 = 25.0;

/// Longest line of a picture's header that is looked at.
const HEADER_LINE: u64 = 32;

/// The first seconds of a video's first picture stream.
pub(super) fn read(path: &Path, seconds: f32) -> io::Result<Clip> {
    let mut child = start("ffmpeg", &arguments(path, seconds))?;
    let mut clip = Clip { frames: Vec::new(), rate: rate(path)? };
    let mut pipe = BufReader::with_capacity(1 << 20, child.stdout.take().ok_or(io::ErrorKind::BrokenPipe)?);
    let frames = loop {
        match read_picture(&mut pipe) {
            Ok(Some(frame))
                if clip.frames.first().is_none_or(|first| first.dimensions() == frame.dimensions()) =>
            {
                clip.push(frame)
            }
            Ok(Some(_)) => break Err(io::Error::other("its frames are of several sizes")),
            Ok(None) => break Ok(()),
            Err(error) => break Err(error),
        }
    };
    // A program that still writes would wait for a reader for ever.
    drop(pipe);
    let complaint = last_words(child)?;
    if clip.frames.is_empty() {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            format!("ffmpeg finds no picture in it: {complaint}"),
        ));
    }
    frames.map(|()| clip)
}

fn arguments(path: &Path, seconds: f32) -> Vec<OsString> {
    let fit = format!(
        "scale=w='min({MOST_WIDTH},iw)':h='min({MOST_HEIGHT},ih)':force_original_aspect_ratio=decrease:force_divisible_by=2"
    );
    let mut arguments: Vec<OsString> = ["-v", "error", "-nostdin"].map(OsString::from).into();
    arguments.extend(input(path));
    let seconds = format!("{seconds}");
    // Each picture with a header of its own: the size is known when it comes, rotated phone videos included.
    let output = [
        "-map",
        "0:v:0",
        "-t",
        &seconds,
        "-vf",
        &fit,
        "-pix_fmt",
        "rgb24",
        "-c:v",
        "ppm",
        "-f",
        "image2pipe",
        "pipe:1",
    ];
    arguments.extend(output.map(OsString::from));
    arguments
}

/// Only the file itself: a hostile playlist must not make ffmpeg ask the network.
fn input(path: &Path) -> [OsString; 4] {
    let mut name = OsString::from("file:");
    name.push(path);
    ["-protocol_whitelist".into(), "file,pipe".into(), "-i".into(), name]
}

fn start(program: &str, arguments: &[impl AsRef<OsStr>]) -> io::Result<Child> {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => io::Error::new(
            io::ErrorKind::NotFound,
            format!("the program {program}, which decodes videos, is not installed: apt-get install ffmpeg (folders of frames need none)"),
        ),
        _ => io::Error::new(error.kind(), format!("{program}: {error}")),
    })
}

/// Frames a second, as ffprobe tells.
fn rate(path: &Path) -> io::Result<f32> {
    let mut arguments: Vec<OsString> = ["-v", "error"].map(OsString::from).into();
    arguments.extend(input(path));
    let asked =
        ["-select_streams", "v:0", "-show_entries", "stream=avg_frame_rate", "-of", "default=nk=1:nw=1"];
    arguments.extend(asked.map(OsString::from));
    let output = start("ffprobe", &arguments)?.wait_with_output()?;
    Ok(parse_rate(&String::from_utf8_lossy(&output.stdout)).unwrap_or(NOMINAL_RATE))
}

fn parse_rate(text: &str) -> Option<f32> {
    let (frames, seconds) = text.lines().next()?.trim().split_once('/')?;
    let rate = frames.parse::<f32>().ok()? / seconds.parse::<f32>().ok()?;
    (rate.is_finite() && rate > 0.0).then_some(rate)
}

/// The last line that the program complained with, once it has ended.
fn last_words(child: Child) -> io::Result<String> {
    let output = child.wait_with_output()?;
    let text = String::from_utf8_lossy(&output.stderr);
    Ok(text.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or("no reason given").to_owned())
}

/// A binary PPM of 8 bits as ffmpeg writes it; none at the end.
fn read_picture(pipe: &mut impl BufRead) -> io::Result<Option<RgbImage>> {
    if pipe.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let mut line = || -> io::Result<String> {
        let mut line = String::new();
        pipe.by_ref().take(HEADER_LINE).read_line(&mut line)?;
        Ok(line)
    };
    let strange = || io::Error::new(io::ErrorKind::InvalidData, "ffmpeg wrote something that is no picture");
    let (magic, size, depth) = (line()?, line()?, line()?);
    let (width, height) = size.trim().split_once(' ').ok_or_else(strange)?;
    let side = |text: &str, most: u32| {
        text.parse::<u32>().ok().filter(|side| (1..=most).contains(side)).ok_or_else(strange)
    };
    let (width, height) = (side(width, MOST_WIDTH)?, side(height, MOST_HEIGHT)?);
    if magic.trim() != "P6" || depth.trim() != "255" {
        return Err(strange());
    }
    let mut pixels = vec![0; width as usize * height as usize * 3];
    pipe.read_exact(&mut pixels)?;
    RgbImage::from_raw(width, height, pixels).map(Some).ok_or_else(strange)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_read_one_after_the_other() {
        let mut bytes = b"P6\n2 1\n255\nabcdefP6\n1 1\n255\n\n\nP".to_vec();
        let mut pipe = &bytes[..];
        assert_eq!(read_picture(&mut pipe).unwrap().unwrap().into_raw(), b"abcdef");
        assert_eq!(read_picture(&mut pipe).unwrap().unwrap().into_raw(), b"\n\nP");
        assert!(read_picture(&mut pipe).unwrap().is_none());
        bytes.truncate(15);
        assert!(read_picture(&mut &bytes[..]).is_err(), "cut");
        assert!(read_picture(&mut &b"P6\n99999 99999\n255\n"[..]).is_err(), "too large");
    }

    #[test]
    fn rates_are_fractions() {
        assert_eq!(parse_rate("30000/1001\n"), Some(30000.0 / 1001.0));
        assert_eq!(parse_rate("0/0\n"), None);
        assert_eq!(parse_rate(""), None);
    }

    #[test]
    fn a_missing_program_is_named_with_its_cure() {
        let error = start("ffmpeg-that-is-not-there", &[""]).unwrap_err().to_string();
        assert!(
            error.contains("ffmpeg-that-is-not-there") && error.contains("apt-get install ffmpeg"),
            "{error}"
        );
    }

    #[test]
    fn a_real_video_is_read_where_there_is_ffmpeg() {
        if start("ffmpeg", &["-version"]).is_err() {
            eprintln!("skipped: there is no ffmpeg");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("-odd name:1.avi");
        let made = Command::new("ffmpeg")
            .args([
                "-v",
                "error",
                "-f",
                "lavfi",
                "-i",
                "testsrc=size=800x600:rate=12",
                "-t",
                "2",
                "-c:v",
                "mjpeg",
            ])
            .arg(&path)
            .status()
            .unwrap();
        assert!(made.success());
        let clip = read(&path, 1.5).unwrap();
        assert_eq!((clip.frames.len(), clip.rate), (18, 12.0));
        assert_eq!(clip.frames[0].dimensions(), (480, 360));
        std::fs::write(&path, "no video").unwrap();
        let error = read(&path, 1.5).unwrap_err().to_string();
        assert!(error.starts_with("ffmpeg finds no picture in it"), "{error}");
    }
}
