//! What a frame costs: allocations, counted, and instructions, as valgrind counts them.

use crate::Failure;
use stats_alloc::{INSTRUMENTED_SYSTEM, Region, StatsAlloc};
use std::{alloc::System, env, hint::black_box, process::Command};
use yurameki::{
    effect::{
        Effect, Moment, Photo, RUN,
        kaleidoscope::{
            Kaleidoscope, Mode, Moving, Reference, Settings, Still, moving_storage_len, storage_len,
        },
    },
    frame::Size,
    math::lanes::LANES,
    noise::drive::{self, Oscillator},
};

#[global_allocator]
static ALLOCATOR: &StatsAlloc<System> = &INSTRUMENTED_SYSTEM;

/// Allocations in a hundred frames of all modes.
pub(super) fn allocations() -> usize {
    let counted = |&(_, mode): &(&str, Mode)| {
        let mut film = Film::new(mode, 128);
        let region = Region::new(ALLOCATOR);
        (0..100).for_each(|_| film.frame());
        region.change().allocations
    };
    Mode::NAMES.iter().map(counted).sum()
}

/// Renders frames for valgrind to count: those of a source that moves, or of a mode.
pub(super) fn render(frames: u32, mode: Mode, side: u32, moving: bool) {
    if moving {
        return render_moving(frames, side);
    }
    let mut film = Film::new(mode, side);
    (0..frames).for_each(|_| film.frame());
}

/// Prints the instructions of a pixel and of an entry of the table of every mode, without those of packing.
pub(super) fn table() -> Result<(), Failure> {
    /// Frames more and less; what preparing takes is in both.
    const FRAMES: [u32; 2] = [2, 26];
    const SIDES: [u32; 2] = [64, 256];
    const ENTRIES: f64 = 4096.0;
    println!("instructions: mode, a pixel, an entry of the table");
    let ways = Mode::NAMES.iter().map(|&(name, mode)| (name, mode, false));
    for (name, mode, moving) in ways.chain([("moving", Mode::Tonal, true)]) {
        let frame = |side| -> Result<f64, Failure> {
            let [few, many] = FRAMES.map(|frames| counted(mode, side, frames, moving));
            Ok((many? - few?) / f64::from(FRAMES[1] - FRAMES[0]))
        };
        let (small, large) = (frame(SIDES[0])?, frame(SIDES[1])?);
        let pixels = SIDES.map(|side| f64::from(side * side));
        let pixel = (large - small) / (pixels[1] - pixels[0]);
        println!("  {name:12} {pixel:6.2} {:6.1}", (small - pixel * pixels[0]) / ENTRIES);
    }
    Ok(())
}

/// The instructions of a whole run of this program.
fn counted(mode: Mode, side: u32, frames: u32, moving: bool) -> Result<f64, Failure> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(env::current_exe()?)
        .args(["kaleidoscope", "--counted-frames", &frames.to_string()])
        .args(["--counted-mode", mode.name(), "--counted-side", &side.to_string()])
        .args(moving.then_some("--counted-moving"))
        .output()
        .map_err(|error| format!("valgrind: {error}; install it, or leave --instructions out"))?;
    let text = String::from_utf8_lossy(&output.stderr);
    let line = text.lines().find_map(|line| line.split_once("Collected : "));
    let count = line.and_then(|(_, count)| count.trim().parse().ok());
    count.ok_or_else(|| format!("valgrind counted nothing: {text}").into())
}

/// Waves of which every block moves, by turns in two pictures.
fn render_moving(frames: u32, side: u32) {
    let size = Size::new(side, side);
    let film = [0_u32, 5].map(|shift| -> Vec<u8> {
        let wave = |i: u32| 40 + ((i + shift) % 64).abs_diff(32) * 2;
        let level = |i: u32| (wave(i % side) + wave(i / side)) as u8;
        (0..size.pixels() as u32).flat_map(|i| [level(i); 3]).collect()
    });
    let still = |frame: u32| Still { size, rgb: &film[frame as usize % 2] };
    let reference = Reference { size, rgb: &film[0] };
    let storage = vec![0; moving_storage_len(size)];
    let Ok(mut moving) = Moving::prepare(&still(0), reference, &Settings::default(), storage) else {
        unreachable!("the storage has the length of the formula")
    };
    let mut oscillator = Oscillator::new(drive::Settings::default(), 7);
    for frame in 0..frames {
        moving.see(&still(frame));
        show(&moving.at(oscillator.step()));
    }
}

/// A film of coloured noise in the colours of itself.
struct Film {
    kaleidoscope: Kaleidoscope<Vec<u64>>,
    oscillator: Oscillator,
}

impl Film {
    fn new(mode: Mode, side: u32) -> Self {
        let size = Size::new(side, side);
        let rgb: Vec<u8> = (0..size.pixels() * 3).map(|i| (i * i / 7 % 256) as u8).collect();
        let settings = Settings { mode, ..Settings::default() };
        let storage = vec![0; storage_len(size, &settings)];
        let photo = Photo { size, rgb: &rgb, mask: &[] };
        let reference = Reference { size, rgb: &rgb };
        let Ok(kaleidoscope) = Kaleidoscope::prepare(photo, reference, &settings, storage, |_| ()) else {
            unreachable!("the storage has the length of the formula")
        };
        Self { kaleidoscope, oscillator: Oscillator::new(drive::Settings::default(), 7) }
    }

    fn frame(&mut self) {
        show(&self.kaleidoscope.at(self.oscillator.step()));
    }
}

fn show(moment: &impl Moment) {
    let size = moment.size();
    let mut blocks = [[[0; LANES]; 3]; RUN];
    for y in 0..size.height {
        for x in (0..size.width as usize).step_by(RUN * LANES) {
            let count = (size.width as usize - x).div_ceil(LANES).min(RUN);
            moment.colours(x, y, &mut blocks[..count]);
            black_box(&blocks);
        }
    }
}
