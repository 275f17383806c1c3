//! Instructions, counted by callgrind: the same on every run, however busy the machine.
//!
//! This program runs itself under valgrind twice, with a task repeated n and 2n times: what the second run has more is n times the
//! task. The counts hold for the code that this processor runs; the ceilings are those of x86-64 with AVX2.

use crate::scene::{Frame, Scene};
use std::{env, error::Error, hint::black_box, process::Command};
use yurameki::{
    effect::shimmer::Range,
    frame::{PixelFormat, Size},
    math::Turns,
    noise::{
        Kind,
        drive::{Oscillator, Settings},
    },
};

/// The most that each task may take, a line each: its name, and instructions.
const CEILINGS: &str = include_str!("../ceilings.txt");

/// Frames are counted by the pixel, at a size that callgrind manages.
const SIZE: Size = Size::new(320, 96);

/// Steps of the drive, whose noises take now more, now less, and frames, which all take the same.
const STEPS: u32 = 20_000;
const FRAMES: u32 = 20;

/// Counts every task of the ceilings. Tells whether all stay below theirs.
pub(crate) fn check() -> Result<bool, Box<dyn Error>> {
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("skipped: there is no valgrind to count instructions with");
        return Ok(true);
    }
    #[cfg(target_arch = "x86_64")]
    let has_avx2 = is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    let has_avx2 = false;
    if !has_avx2 {
        println!("skipped: the ceilings are those of a processor with AVX2");
        return Ok(true);
    }
    let mut all_below = true;
    for line in CEILINGS.lines().filter(|line| !line.starts_with('#')) {
        let (task, ceiling) = line.rsplit_once(' ').ok_or("ceilings.txt: a line without a number")?;
        let ceiling: f64 = ceiling.parse()?;
        let (repeats, parts, of) = match task.starts_with("drive") {
            true => (STEPS, 1, "a step"),
            false => (FRAMES, SIZE.pixels(), "a pixel"),
        };
        let more = run_counted(task, 2 * repeats)? - run_counted(task, repeats)?;
        let each = more as f64 / f64::from(repeats) / parts as f64;
        let verdict = if each <= ceiling { "" } else { "   TOO MANY" };
        println!("{task:<28} {each:>9.3} instructions {of:<7} (at most {ceiling}){verdict}");
        all_below &= each <= ceiling;
    }
    Ok(all_below)
}

fn run_counted(task: &str, repeats: u32) -> Result<i64, Box<dyn Error>> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(env::current_exe()?)
        .args(["--repeat", task, "--repeats", &repeats.to_string()])
        .output()?;
    let log = String::from_utf8_lossy(&output.stderr);
    let count = log.lines().find_map(|line| line.split_once("Collected : ")).map(|(_, count)| count.trim());
    count.ok_or_else(|| format!("valgrind counted nothing:\n{log}"))?.parse().map_err(Into::into)
}

/// Does a task again and again.
pub(crate) fn repeat(task: &str, repeats: u32) -> Result<(), Box<dyn Error>> {
    if let Some(kind) = task.strip_prefix("drive ") {
        let kind: Kind = kind.parse().map_err(|_| format!("there is no noise called {kind}"))?;
        let settings = Settings { amplitude: kind, frequency: kind, ..Settings::default() };
        let mut oscillator = Oscillator::new(settings, 1);
        let sum = (0..repeats).fold(Turns::default(), |sum, _| sum.plus(oscillator.step().phase));
        black_box(sum);
        return Ok(());
    }
    let scene = Scene::new(SIZE);
    if let Some(range) = task.strip_prefix("prepare ") {
        let range: Range = range.parse().map_err(|_| format!("there is no range mode called {range}"))?;
        let mask = scene.everything();
        return (0..repeats)
            .try_for_each(|_| scene.shimmer(range, &mask).map(|shimmer| drop(black_box(shimmer))));
    }
    let mut frame = match task {
        "frame XRGB8888" => Frame::whole(&scene, PixelFormat::Xrgb8888)?,
        "frame RGB565" => Frame::whole(&scene, PixelFormat::Rgb565)?,
        "fade XRGB8888" => Frame::fading(&scene, PixelFormat::Xrgb8888)?,
        "a fifth moving XRGB8888" => {
            Frame::new(&scene, Default::default(), PixelFormat::Xrgb8888, &scene.a_fifth())?
        }
        _ => return Err(format!("there is no task called {task}").into()),
    };
    (0..repeats).for_each(|round| frame.render(round));
    Ok(())
}
