//! The same frames as a film: how long software takes to decode it, on one thread, to the same format.

use crate::scene::{Frame, Scene};
use std::{
    env,
    error::Error,
    fs,
    io::Write,
    path::Path,
    process::{self, Command, Stdio},
};
use yurameki::frame::PixelFormat;

const FRAMES: u32 = 48;

/// CPU milliseconds that ffmpeg takes to decode a frame of `scene`; nothing, with a word on stderr, where it cannot be had.
pub(crate) fn decoding(scene: &Scene) -> Result<Option<f64>, Box<dyn Error>> {
    if Command::new("ffmpeg").arg("-version").stdout(Stdio::null()).status().is_err() {
        eprintln!("skipped: there is no ffmpeg to compare with");
        return Ok(None);
    }
    let film = env::temp_dir().join(format!("yurameki-bench-{}.mp4", process::id()));
    let milliseconds = encode(scene, &film).and_then(|()| decode(&film));
    // It is in the folder of temporary files: what stays there does no harm.
    let _ = fs::remove_file(&film);
    milliseconds
}

fn encode(scene: &Scene, film: &Path) -> Result<(), Box<dyn Error>> {
    let mut frame = Frame::whole(scene, PixelFormat::Xrgb8888)?;
    let mut encoder = Command::new("ffmpeg")
        .args(["-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "bgr0", "-r", "12", "-s"])
        .arg(format!("{}x{}", scene.size.width, scene.size.height))
        .args(["-i", "-", "-c:v", "libx264", "-preset", "veryfast", "-pix_fmt", "yuv420p"])
        .arg(film)
        .stdin(Stdio::piped())
        .spawn()?;
    if let Some(mut pipe) = encoder.stdin.take() {
        for round in 0..FRAMES {
            frame.render(round);
            pipe.write_all(frame.pixels())?;
        }
    }
    let status = encoder.wait()?;
    if status.success() { Ok(()) } else { Err(format!("ffmpeg could not encode: {status}").into()) }
}

fn decode(film: &Path) -> Result<Option<f64>, Box<dyn Error>> {
    let output = Command::new("ffmpeg")
        .args(["-benchmark", "-threads", "1", "-i"])
        .arg(film)
        .args([
            "-threads",
            "1",
            "-filter_threads",
            "1",
            "-f",
            "rawvideo",
            "-pix_fmt",
            "bgr0",
            "-y",
            "/dev/null",
        ])
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    // bench: utime=0.417s stime=0.021s rtime=0.440s
    let seconds = |name: &str| -> Option<f64> {
        let (_, after) = log.split_once(name)?;
        after.split('s').next()?.parse().ok()
    };
    let cpu = seconds("utime=").zip(seconds("stime=")).map(|(user, system)| user + system);
    let cpu = cpu.ok_or("ffmpeg did not say how long it took")?;
    Ok(Some(cpu * 1e3 / f64::from(FRAMES)))
}
