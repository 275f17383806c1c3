//! Measures the frame kernels as ratios, each against its yardstick in turn within one run: machines differ and are shared, ratios
//! stay.
//!
//! `copy16` is a plain copy that reads 8 and writes 8 bytes for each pixel. `naive` is the shimmer as one would first write it:
//! float32, a sine and a square root a pixel, the gradient of the heights taken anew in every frame. `H.264` is the CPU time that ffmpeg
//! takes on one thread to decode the same frames.

mod h264;
mod instructions;
mod naive;
mod scene;

use clap::Parser;
use scene::{Frame, Scene};
use std::{error::Error, fs, hint::black_box, path::PathBuf, process::ExitCode, time::Instant};
use yurameki::{
    effect::{
        Photo,
        shimmer::{Range, Settings, Shimmer, storage_len},
    },
    frame::{PixelFormat, Size},
    math::Turns,
    noise::{
        Kind,
        drive::{self, Oscillator},
    },
};

/// Prints how long frames take, relative to a plain copy of memory.
#[derive(Parser)]
struct Args {
    /// Rounds of each measurement.
    #[arg(long, default_value_t = 25)]
    rounds: usize,
    /// Write the table as CSV too.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Count instructions by valgrind instead, and fail if they are more than tools/bench/ceilings.txt allows.
    #[arg(long)]
    instructions: bool,
    /// Only repeat one task of tools/bench/ceilings.txt.
    #[arg(long, value_name = "TASK", hide = true)]
    repeat: Option<String>,
    #[arg(long, value_name = "COUNT", default_value_t = 1, hide = true)]
    repeats: u32,
}

/// One line of the table.
struct Line {
    what: String,
    yardstick: &'static str,
    time: Times,
    of_yardstick: Times,
}

/// Milliseconds of the rounds, in order of size.
struct Times(Vec<f64>);

impl Times {
    fn new(mut milliseconds: Vec<f64>) -> Self {
        milliseconds.sort_by(f64::total_cmp);
        Self(milliseconds)
    }

    /// The round that a tenth of the rounds beat: on a machine that others use too, what the work takes when nobody disturbs it.
    fn undisturbed(&self) -> f64 {
        self.0[self.0.len() / 10]
    }

    fn median(&self) -> f64 {
        self.0[self.0.len() / 2]
    }
}

const SIZES: [(u32, u32); 5] = [(640, 480), (1024, 600), (1280, 800), (1920, 1080), (3840, 2160)];

/// Sizes above are too slow for the naive twin, and for a film.
const SMALL: u32 = 1080;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let args = Args::parse();
    if let Some(task) = args.repeat {
        instructions::repeat(&task, args.repeats)?;
        return Ok(ExitCode::SUCCESS);
    }
    if args.instructions {
        return Ok(if instructions::check()? { ExitCode::SUCCESS } else { ExitCode::FAILURE });
    }
    let mut table = Table { lines: Vec::new(), rounds: args.rounds.max(1) };
    println!("{:<40}   {:<9}    median  undisturbed", "", "yardstick");
    for (width, height) in SIZES {
        table.size(&Scene::new(Size::new(width, height)))?;
    }
    table.drives();
    if let Some(path) = args.csv {
        fs::write(path, table.csv())?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Does two things in turn, after a round that does not count.
fn in_turn(rounds: usize, mut first: impl FnMut(u32), mut second: impl FnMut(u32)) -> [Times; 2] {
    let mut times = [Vec::new(), Vec::new()];
    for round in 0..=rounds as u32 {
        let start = Instant::now();
        first(round);
        let middle = Instant::now();
        second(round);
        if round > 0 {
            times[0].push((middle - start).as_secs_f64() * 1e3);
            times[1].push(middle.elapsed().as_secs_f64() * 1e3);
        }
    }
    times.map(Times::new)
}

struct Table {
    lines: Vec<Line>,
    rounds: usize,
}

impl Table {
    fn size(&mut self, scene: &Scene) -> Result<(), Box<dyn Error>> {
        let all = scene.everything();
        let size = format!("{}x{}", scene.size.width, scene.size.height);
        for format in [PixelFormat::Xrgb8888, PixelFormat::Rgb565] {
            self.against_copy(format!("shimmer {size} {format}"), Frame::whole(scene, format)?);
        }
        let full = Frame::new(scene, Range::Full, PixelFormat::Xrgb8888, &all)?;
        self.against_copy(format!("shimmer full {size} XRGB8888"), full);
        self.against_copy(format!("fade {size} XRGB8888"), Frame::fading(scene, PixelFormat::Xrgb8888)?);
        self.masked(scene, &size)?;
        if scene.size.height <= SMALL {
            self.against_naive(scene, &size)?;
        }
        if scene.size.height == SMALL {
            self.against_film(scene, &size)?;
        }
        self.preparation(scene, &size)
    }

    fn add(&mut self, what: String, yardstick: &'static str, [time, of_yardstick]: [Times; 2]) {
        println!(
            "{what:<40} / {yardstick:<9} {:>9.3} {:>9.3}   ({:.3} ms)",
            time.median() / of_yardstick.median(),
            time.undisturbed() / of_yardstick.undisturbed(),
            time.undisturbed(),
        );
        self.lines.push(Line { what, yardstick, time, of_yardstick });
    }

    fn against_copy(&mut self, what: String, mut frame: Frame) {
        let pixels = frame.size().pixels();
        let source = vec![1_u64; pixels];
        let mut target = vec![0_u64; pixels];
        let copy = |_| black_box(&mut target).copy_from_slice(black_box(&source));
        let times = in_turn(self.rounds, |round| frame.render(round), copy);
        self.add(what, "copy16", times);
    }

    fn masked(&mut self, scene: &Scene, size: &str) -> Result<(), Box<dyn Error>> {
        let mut part = Frame::new(scene, Range::default(), PixelFormat::Xrgb8888, &scene.a_fifth())?;
        let mut whole = Frame::whole(scene, PixelFormat::Xrgb8888)?;
        let times = in_turn(self.rounds, |round| part.render(round), |round| whole.render(round));
        self.add(format!("shimmer {size}, 20 % moving"), "all", times);
        Ok(())
    }

    fn against_naive(&mut self, scene: &Scene, size: &str) -> Result<(), Box<dyn Error>> {
        let mut frame = Frame::whole(scene, PixelFormat::Xrgb8888)?;
        let mut naive = naive::Naive::new(scene.size, &scene.rgb);
        let slow = |round| {
            black_box(naive.render(round));
        };
        let times = in_turn(self.rounds.min(5), |round| frame.render(round), slow);
        self.add(format!("shimmer {size} XRGB8888"), "naive", times);
        Ok(())
    }

    fn against_film(&mut self, scene: &Scene, size: &str) -> Result<(), Box<dyn Error>> {
        let Some(decoding) = h264::decoding(scene)? else { return Ok(()) };
        let mut frame = Frame::whole(scene, PixelFormat::Xrgb8888)?;
        let [time, _] = in_turn(self.rounds, |round| frame.render(round), |_| {});
        self.add(format!("shimmer {size} XRGB8888"), "H.264", [time, Times(vec![decoding])]);
        Ok(())
    }

    fn preparation(&mut self, scene: &Scene, size: &str) -> Result<(), Box<dyn Error>> {
        let mask = scene.everything();
        let photo = Photo { size: scene.size, rgb: &scene.rgb, mask: &mask };
        let mut storage = vec![0; storage_len(scene.size)];
        Shimmer::prepare(photo, &Settings::default(), &mut storage)?;
        let source = vec![1_u64; scene.size.pixels()];
        let mut target = vec![0_u64; scene.size.pixels()];
        for range in [Range::Neighbourhood, Range::Travelling] {
            let settings = Settings { range, ..Settings::default() };
            // The storage is long enough: the line above would have said.
            let prepare = |_| drop(black_box(Shimmer::prepare(photo, &settings, &mut storage)));
            let copy = |_| black_box(&mut target).copy_from_slice(black_box(&source));
            let times = in_turn(self.rounds.min(5), prepare, copy);
            self.add(format!("prepare {range} {size}"), "copy16", times);
        }
        Ok(())
    }

    /// Ten thousand steps of the drive, with every noise for both of its generators.
    fn drives(&mut self) {
        const STEPS: u32 = 10_000;
        for kind in Kind::ALL {
            let settings = drive::Settings { amplitude: kind, frequency: kind, ..Default::default() };
            let mut oscillator = Oscillator::new(settings, 1);
            let mut sum = Turns::default();
            let steps = |_| (0..STEPS).for_each(|_| sum = sum.plus(oscillator.step().phase));
            let [time, _] = in_turn(self.rounds, steps, |_| {});
            black_box(sum);
            let each = time.0.iter().map(|ms| ms / f64::from(STEPS)).collect();
            self.add(format!("drive step, {kind}/{kind}"), "60 ns", [Times(each), Times(vec![60e-6])]);
        }
    }

    fn csv(&self) -> String {
        let lines = self.lines.iter().map(|line| {
            let (median, undisturbed) = (line.time.median(), line.time.undisturbed());
            format!(
                "{},{},{:.4},{:.4},{median:.6}\n",
                line.what.replace(',', ""),
                line.yardstick,
                median / line.of_yardstick.median(),
                undisturbed / line.of_yardstick.undisturbed(),
            )
        });
        format!("what,yardstick,median ratio,undisturbed ratio,median ms\n{}", lines.collect::<String>())
    }
}
