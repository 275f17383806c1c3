//! Measures the frame kernels as ratios, each against its yardstick in turn within one run: machines differ and are shared, ratios
//! stay.
//!
//! `copy16` is a plain copy that reads 8 and writes 8 bytes for each pixel. `naive` is the shimmer as one would first write it:
//! float32, a sine and a square root a pixel, the gradient of the heights taken anew in every frame.

mod naive;

use clap::Parser;
use std::{error::Error, fs, hint::black_box, path::PathBuf, time::Instant};
use yurameki::{
    effect::{
        Effect, Paint, Photo,
        shimmer::{Range, Settings, Shimmer, storage_len},
    },
    frame::{FrameMut, Layout, PixelFormat, Size},
    math::{Factor, Turns},
    noise::drive::{Drive, Oscillator},
};

/// Prints how long frames take, relative to a plain copy of memory.
#[derive(Parser)]
struct Args {
    /// Rounds of each measurement; the median counts.
    #[arg(long, default_value_t = 15)]
    rounds: usize,
    /// Write the table as CSV too.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

/// One line of the table.
struct Ratio {
    what: String,
    yardstick: &'static str,
    ratio: f64,
    milliseconds: f64,
}

const SIZES: [(u32, u32); 4] = [(640, 480), (1024, 600), (1920, 1080), (3840, 2160)];

fn main() -> Result<(), Box<dyn Error>> {
    let args = Args::parse();
    let mut table = Vec::new();
    for (width, height) in SIZES {
        let scene = Scene::new(Size::new(width, height));
        for format in [PixelFormat::Xrgb8888, PixelFormat::Rgb565] {
            for range in [Range::Full, Range::Travelling] {
                show(&mut table, scene.against_copy(range, format, 255, args.rounds)?);
            }
        }
        show(&mut table, scene.masked(args.rounds)?);
        if height <= 1080 {
            show(&mut table, scene.against_naive(args.rounds)?);
        }
        show(&mut table, scene.prepare(args.rounds)?);
    }
    show(&mut table, drive(args.rounds));
    if let Some(path) = args.csv {
        let lines = table
            .iter()
            .map(|r| format!("{},{},{:.4},{:.4}\n", r.what, r.yardstick, r.ratio, r.milliseconds));
        fs::write(path, format!("what,yardstick,ratio,milliseconds\n{}", lines.collect::<String>()))?;
    }
    Ok(())
}

fn show(table: &mut Vec<Ratio>, line: Ratio) {
    println!("{:<44} / {:<8} {:>7.3}   ({:.3} ms)", line.what, line.yardstick, line.ratio, line.milliseconds);
    table.push(line);
}

/// The medians, in milliseconds, of two things done in turn, after a round that does not count.
fn in_turn(rounds: usize, mut first: impl FnMut(u32), mut second: impl FnMut()) -> [f64; 2] {
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..=rounds as u32 {
        let start = Instant::now();
        first(round);
        let middle = Instant::now();
        second();
        if round > 0 {
            times[0].push((middle - start).as_secs_f64() * 1e3);
            times[1].push(middle.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

/// A picture with texture everywhere.
struct Scene {
    size: Size,
    rgb: Vec<u8>,
}

impl Scene {
    fn new(size: Size) -> Self {
        let pixel =
            |i: u32| (i % size.width * 7 + i / size.width * 5) ^ (i.wrapping_mul(2_654_435_761) >> 27);
        let rgb =
            (0..size.pixels() as u32).flat_map(|i| [pixel(i), pixel(i) + 20, pixel(i) / 2].map(|c| c as u8));
        Self { size, rgb: rgb.collect() }
    }

    fn against_copy(
        &self,
        range: Range,
        format: PixelFormat,
        mask: u8,
        rounds: usize,
    ) -> Result<Ratio, Box<dyn Error>> {
        let mut frame = Frame::new(self, range, format, &vec![mask; self.size.pixels()])?;
        let source = vec![1_u64; self.size.pixels()];
        let mut target = vec![0_u64; self.size.pixels()];
        let [shimmer, copy] = in_turn(
            rounds,
            |round| frame.render(round),
            || black_box(&mut target).copy_from_slice(black_box(&source)),
        );
        let what = format!("shimmer {range} {}x{} {format}", self.size.width, self.size.height);
        Ok(Ratio { what, yardstick: "copy16", ratio: shimmer / copy, milliseconds: shimmer })
    }

    /// A fifth of the pixels moves, in ragged spans of 48 pixels among gaps of 192.
    fn masked(&self, rounds: usize) -> Result<Ratio, Box<dyn Error>> {
        let ragged = |i: usize| {
            let (x, y) = (i % self.size.width as usize, i / self.size.width as usize);
            if (x + y * 37) % 240 < 48 { 255 } else { 0 }
        };
        let mask: Vec<u8> = (0..self.size.pixels()).map(ragged).collect();
        let mut part = Frame::new(self, Range::Travelling, PixelFormat::Xrgb8888, &mask)?;
        let mut whole = Frame::new(self, Range::Travelling, PixelFormat::Xrgb8888, &vec![255; mask.len()])?;
        let mut count = 0;
        let [masked, full] = in_turn(
            rounds,
            |round| part.render(round),
            || {
                count += 1;
                whole.render(count);
            },
        );
        let what = format!("shimmer {}x{}, 20 % moving", self.size.width, self.size.height);
        Ok(Ratio { what, yardstick: "all", ratio: masked / full, milliseconds: masked })
    }

    fn against_naive(&self, rounds: usize) -> Result<Ratio, Box<dyn Error>> {
        let mut frame = Frame::new(self, Range::Full, PixelFormat::Xrgb8888, &vec![255; self.size.pixels()])?;
        let mut naive = naive::Naive::new(self.size, &self.rgb);
        let mut count = 0;
        let [shimmer, slow] = in_turn(
            rounds.min(5),
            |round| frame.render(round),
            || {
                count += 1;
                black_box(naive.render(count));
            },
        );
        let what = format!("shimmer full {}x{} XRGB8888", self.size.width, self.size.height);
        Ok(Ratio { what, yardstick: "naive", ratio: shimmer / slow, milliseconds: shimmer })
    }

    fn prepare(&self, rounds: usize) -> Result<Ratio, Box<dyn Error>> {
        let mask = vec![255; self.size.pixels()];
        let photo = Photo { size: self.size, rgb: &self.rgb, mask: &mask };
        let mut storage = vec![0; storage_len(self.size)];
        let mut neighbourhood = storage.clone();
        let settings = |range| Settings { range, ..Settings::default() };
        Shimmer::prepare(photo, &settings(Range::Travelling), &mut storage)?;
        // The storage is long enough: the line above would have said.
        let [travelling, other] = in_turn(
            rounds.min(5),
            |_| drop(black_box(Shimmer::prepare(photo, &settings(Range::Travelling), &mut storage))),
            || drop(black_box(Shimmer::prepare(photo, &settings(Range::Neighbourhood), &mut neighbourhood))),
        );
        let what = format!("prepare travelling {}x{}", self.size.width, self.size.height);
        Ok(Ratio { what, yardstick: "neighb.", ratio: travelling / other, milliseconds: travelling })
    }
}

/// A shimmer and the frame that it renders into.
struct Frame {
    shimmer: Shimmer<Vec<u64>>,
    pixels: Vec<u8>,
    layout: Layout,
}

impl Frame {
    fn new(scene: &Scene, range: Range, format: PixelFormat, mask: &[u8]) -> Result<Self, Box<dyn Error>> {
        let photo = Photo { size: scene.size, rgb: &scene.rgb, mask };
        let storage = vec![0; storage_len(scene.size)];
        let shimmer = Shimmer::prepare(photo, &Settings { range, ..Settings::default() }, storage)?;
        let layout = Layout::new(scene.size, format, None)?;
        Ok(Self { shimmer, pixels: vec![0; layout.len_bytes()], layout })
    }

    fn render(&mut self, round: u32) {
        let amplitude = Factor::ONE / 2;
        let phase = Turns(round.wrapping_mul(214_748_365));
        let drive = Drive { amplitude, frequency: Factor::ONE, phase, onset: Factor::ONE };
        if let Ok(mut out) = FrameMut::new(black_box(&mut self.pixels), self.layout) {
            self.shimmer.render(drive, Paint::Motion, &mut out);
        }
    }
}

/// A hundred thousand steps of the default drive, in nanoseconds a step.
fn drive(rounds: usize) -> Ratio {
    const STEPS: u32 = 100_000;
    let mut oscillator = Oscillator::new(Default::default(), 1);
    let mut sum = Turns::default();
    let run = |_| (0..STEPS).for_each(|_| sum = sum.plus(oscillator.step().phase));
    let [drive, _] = in_turn(rounds, run, || {});
    black_box(sum);
    let each = drive / f64::from(STEPS);
    Ratio {
        what: "drive step, brown/brown".into(),
        yardstick: "60 ns",
        ratio: each * 1e6 / 60.0,
        milliseconds: each,
    }
}
