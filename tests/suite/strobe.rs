//! What could harm people with photosensitive epilepsy, looked for in frames as they are shown.

use crate::stage::{Staging, Still};
use std::f64::consts::TAU;
use yurameki::{
    config::Life,
    display::sim::Buffering,
    effect::{
        Effect,
        shimmer::{self, Range, Shimmer, storage_len},
    },
    frame::{Layout, PixelFormat, Size},
    math::Factor,
    noise::{
        Kind,
        drive::{self, Oscillator, PhaseForm},
        guard::Guard,
    },
};

const SIZE: Size = Size::new(320, 192);
const CELL: usize = 16;
const FPS: u32 = 30;

/// The mean linear luminance (a gamma of 2) of every cell of 16 pixels in each of two seconds' frames, the first second left out where it comes alive.
fn cells(life: Life) -> Vec<Vec<f64>> {
    let still = Still::demo(SIZE);
    let layout = Layout::new(SIZE, PixelFormat::Bgr888, None).expect("a layout");
    let staging =
        Staging { life, frames_per_second: FPS, seed: 3, layout, buffering: Buffering::Single, presses: &[] };
    let columns = SIZE.width as usize / CELL;
    let mut frames = Vec::new();
    staging.show(&still, 3 * FPS, 0, |_, frame| {
        let mut cells = vec![0.; columns * (SIZE.height as usize / CELL)];
        for (y, row) in frame.rows().enumerate() {
            for (x, bgr) in row.as_chunks::<3>().0.iter().enumerate() {
                let [b, g, r] = bgr.map(f64::from);
                let luma = (0.2126 * r + 0.7152 * g + 0.0722 * b) / 255.;
                cells[y / CELL * columns + x / CELL] += luma * luma / (CELL * CELL) as f64;
            }
        }
        frames.push(cells);
    });
    frames
}

fn wild(range: Range, phase: PhaseForm) -> Life {
    Life {
        drive: drive::Settings {
            amplitude: Kind::White,
            frequency: Kind::White,
            period_frames: 4,
            response_frames: 0,
            glide_frames: 0,
            phase,
        },
        shimmer: shimmer::Settings { range, strength: Factor::from_num(4), ..shimmer::Settings::default() },
        ..Life::default()
    }
}

/// The largest share of cells that one component of 3 Hz and more modulates by over a tenth, and the largest step of the mean.
fn flashes(frames: &[Vec<f64>]) -> (f64, f64) {
    let mean = |frame: &Vec<f64>| frame.iter().sum::<f64>() / frame.len() as f64;
    let step = frames.windows(2).map(|pair| (mean(&pair[1]) - mean(&pair[0])).abs()).fold(0., f64::max);
    let count = frames[0].len();
    let seconds = frames.chunks_exact(FPS as usize).skip(1);
    let worst = seconds.flat_map(|second| {
        (3..=FPS / 2).map(|hertz| {
            let over = (0..count).filter(|&cell| {
                let level = second.iter().map(|frame| frame[cell]).sum::<f64>() / f64::from(FPS);
                let (mut re, mut im, mut power) = (0., 0., 0.);
                for (i, frame) in second.iter().enumerate() {
                    let turn = TAU * i as f64 / f64::from(FPS);
                    // Hann: the ends of a window need not meet.
                    let weight = 1. - turn.cos();
                    re += weight * (frame[cell] - level) * (turn * f64::from(hertz)).cos();
                    im += weight * (frame[cell] - level) * (turn * f64::from(hertz)).sin();
                    power += weight;
                }
                2. * f64::hypot(re, im) / power / level.max(0.01) > 0.1
            });
            over.count() as f64 / count as f64
        })
    });
    (worst.fold(0., f64::max), step)
}

#[test]
fn the_wildest_drive_makes_no_strobe() {
    for range in [Range::Full, Range::Neighbourhood, Range::Travelling] {
        for phase in [PhaseForm::Integrated, PhaseForm::Literal] {
            let (area, step) = flashes(&cells(wild(range, phase)));
            assert!(area <= 0.25, "{range:?}, {phase:?}: {area} of the picture flashes");
            assert!(step <= 0.02, "{range:?}, {phase:?}: the mean steps by {step}");
        }
    }
}

#[test]
fn the_usual_drive_of_the_demo_photo_is_not_slowed() {
    let still = Still::demo(Size::new(1024, 600));
    let life = Life::default();
    let shimmer = Shimmer::prepare(still.photo(), &life.shimmer, vec![0; storage_len(still.size)]);
    let sensitivity = shimmer.expect("enough storage").sensitivity();
    println!("{sensitivity:?}");
    let (mut guard, mut oscillator) = (Guard::default(), Oscillator::new(life.drive, 7));
    guard.set(sensitivity, 12);
    for _ in 0..10_000 {
        let drive = oscillator.step();
        assert_eq!(guard.limit(drive), drive);
    }
}
