//! How much moves at which frequency, pixel by pixel.

use crate::{Clip, Region};
use rustfft::{FftPlanner, num_complex::Complex};
use std::f32::consts::TAU;

/// Side of a cell over which the spectra of pixels are averaged.
const CELL: usize = 15;

/// Frames of a window; half as many frequencies come of it. Shorter clips take what they have.
const WINDOW: usize = 48;

/// Added to a power before its logarithm is taken: about that of rounding to levels and of a camera's noise, below which nobody sees anything.
const FLOOR: f32 = 0.3;

/// The power of a pixel's levels at the frequencies 1/n..1/2 of the frame rate: white noise of deviation σ has σ² at each.
pub struct Spectrum {
    window: Vec<f32>,
    fft: std::sync::Arc<dyn rustfft::Fft<f32>>,
    lane: Vec<Complex<f32>>,
    scratch: Vec<Complex<f32>>,
    power: Vec<f32>,
}

impl Spectrum {
    /// With windows of `length` frames (Hann).
    pub fn new(length: usize) -> Self {
        let fft = FftPlanner::new().plan_fft_forward(length);
        let window: Vec<f32> =
            (0..length).map(|i| 0.5 - 0.5 * (TAU * (i as f32 + 0.5) / length as f32).cos()).collect();
        Self {
            lane: vec![Complex::default(); length],
            scratch: vec![Complex::default(); fft.get_inplace_scratch_len()],
            power: vec![0.0; length / 2],
            window,
            fft,
        }
    }

    /// The mean over windows that overlap by half (Welch). `values` must hold a window at least.
    pub fn of(&mut self, values: impl Fn(usize) -> f32, count: usize) -> &[f32] {
        let length = self.window.len();
        assert!(count >= length, "{count} frames are less than a window of {length}");
        self.power.fill(0.0);
        let scale = 1.0 / self.window.iter().map(|w| w * w).sum::<f32>();
        let mut windows = 0.0;
        for start in (0..=count - length).step_by((length / 2).max(1)) {
            let mean = (start..start + length).map(&values).sum::<f32>() / length as f32;
            for (i, (lane, weight)) in self.lane.iter_mut().zip(&self.window).enumerate() {
                *lane = Complex::new((values(start + i) - mean) * weight, 0.0);
            }
            self.fft.process_with_scratch(&mut self.lane, &mut self.scratch);
            for (power, value) in self.power.iter_mut().zip(&self.lane[1..]) {
                *power += value.norm_sqr() * scale;
            }
            windows += 1.0;
        }
        self.power.iter_mut().for_each(|power| *power /= windows);
        &self.power
    }
}

/// Frames of a window that fits into both clips, and is even.
fn common_window(a: &Clip, b: &Clip) -> usize {
    WINDOW.min(a.frames.len()).min(b.frames.len()) & !1
}

/// The mean power of the pixels of a square at each frequency.
fn cell(clip: &Clip, spectrum: &mut Spectrum, (x, y): (usize, usize)) -> Vec<f32> {
    let mut sum = vec![0.0; spectrum.power.len()];
    for row in y..y + CELL {
        for pixel in row * clip.width + x..row * clip.width + x + CELL {
            let power = spectrum.of(|frame| clip.frames[frame][pixel], clip.frames.len());
            sum.iter_mut().zip(power).for_each(|(sum, power)| *sum += power);
        }
    }
    sum.iter_mut().for_each(|sum| *sum /= (CELL * CELL) as f32);
    sum
}

/// tps: the mean over cells of 15 pixels and 24 frequencies of |log10(power + 0.3) of one − that of the other|. Both clips must have the same size;
/// `None` if no cell counts or a clip has fewer than four frames. Takes about a microsecond a pixel and window.
pub fn distance(clip: &Clip, truth: &Clip, region: &Region) -> Option<f32> {
    assert_eq!((clip.width, clip.height), (truth.width, truth.height), "clips of two sizes");
    let window = common_window(clip, truth);
    let squares = region.squares(CELL);
    if window < 4 || squares.is_empty() {
        return None;
    }
    let mut spectrum = Spectrum::new(window);
    let mut sum = 0.0;
    for &square in &squares {
        let (ours, theirs) = (cell(clip, &mut spectrum, square), cell(truth, &mut spectrum, square));
        sum += ours
            .iter()
            .zip(&theirs)
            .map(|(a, b)| ((a + FLOOR).log10() - (b + FLOOR).log10()).abs())
            .sum::<f32>();
    }
    Some(sum / (squares.len() * window / 2) as f32)
}

/// β of the power 1/f^β: the slope of a line through log power over log frequency, from 2/n to 0.35 of the frame rate, the median over cells.
/// `None` if no cell counts or a clip has fewer than 16 frames.
pub fn slope(clip: &Clip, region: &Region) -> Option<f32> {
    let window = common_window(clip, clip);
    if window < 16 {
        return None;
    }
    let mut spectrum = Spectrum::new(window);
    let mut slopes: Vec<f32> = region
        .squares(CELL)
        .into_iter()
        .filter_map(|square| {
            let power = cell(clip, &mut spectrum, square);
            fit(power.iter().enumerate().skip(1).map(|(i, &power)| ((i + 1) as f32 / window as f32, power)))
        })
        .collect();
    slopes.sort_by(f32::total_cmp);
    slopes.get(slopes.len() / 2).copied()
}

/// The slope, turned about, of the line of least squares through log power over log frequency.
fn fit(points: impl Iterator<Item = (f32, f32)>) -> Option<f32> {
    let points: Vec<(f32, f32)> = points
        .filter(|&(frequency, power)| frequency <= 0.35 && power > 0.0)
        .map(|(frequency, power)| (frequency.ln(), power.ln()))
        .collect();
    let count = points.len() as f32;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let spread: f32 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let common: f32 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    (points.len() >= 3 && spread > 0.0).then(|| -common / spread)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::tests::noise;

    #[test]
    fn white_noise_has_its_variance_at_every_frequency() {
        let clip = noise(30, 30, 192, 3.0, 1);
        let mut spectrum = Spectrum::new(WINDOW);
        let power = cell(&clip, &mut spectrum, (0, 0));
        assert_eq!(power.len(), 24);
        // The window's mean takes some of the lowest; the highest is half a band.
        for (number, power) in power.iter().enumerate().take(23).skip(1) {
            assert!((power / 9.0 - 1.0).abs() < 0.15, "frequency {number}: {power}");
        }
    }

    #[test]
    fn a_clip_is_no_distance_from_itself_and_far_from_a_still() {
        let clip = noise(45, 30, 96, 4.0, 2);
        let region = Region::whole(&clip);
        assert_eq!(distance(&clip, &clip, &region), Some(0.0));
        let other = distance(&noise(45, 30, 96, 4.0, 3), &clip, &region).expect("cells");
        let still = distance(&clip.still(), &clip, &region).expect("cells");
        // log10((16 + 0.3) / 0.3) = 1.735.
        assert!(other < 0.1 && (still - 1.735).abs() < 0.1, "{other} {still}");
    }

    #[test]
    fn the_slope_of_a_random_walk_is_two_and_of_white_noise_none() {
        let white = noise(30, 30, 192, 3.0, 4);
        let mut walk = white.clone();
        for frame in 1..walk.frames.len() {
            let (before, now) = walk.frames.split_at_mut(frame);
            now[0].iter_mut().zip(&before[frame - 1]).for_each(|(now, before)| *now += before - 128.0);
        }
        let region = Region::whole(&white);
        let (white, walk) = (slope(&white, &region).expect("cells"), slope(&walk, &region).expect("cells"));
        assert!(white.abs() < 0.1 && (walk - 1.9).abs() < 0.2, "{white} {walk}");
    }
}
