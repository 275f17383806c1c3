//! Which structures move at which frequency, and in which direction.

use crate::{Clip, Region};
use rustfft::{Fft, FftPlanner, num_complex::Complex};
use std::{f32::consts::TAU, sync::Arc};

/// Side of a block in pixels.
const SIDE: usize = 45;

/// Frames of a block.
const FRAMES: usize = 24;

/// First temporal frequency of each band, in 1/24 of the frame rate, and the one after the last.
const TEMPORAL: [usize; 5] = [1, 2, 4, 7, 13];

/// First spatial frequency of each ring, in cycles a block, and the end of the last. What is slower than the first ring is a band of its own.
const RADIAL: [f32; 4] = [0.8, 3.0, 8.0, 22.5];

/// Directions in which a structure can travel.
const DIRECTIONS: usize = 8;

/// Bands of space for every band of time.
const BANDS: usize = 1 + 3 * DIRECTIONS;

/// As for the temporal spectra.
const FLOOR: f32 = 0.3;

/// Pools the power of blocks.
struct Pool {
    row: Arc<dyn Fft<f32>>,
    time: Arc<dyn Fft<f32>>,
    window: Vec<f32>,
    /// 1 by the power of the window.
    scale: f32,
    /// The band of every frequency of space.
    bands: Vec<u8>,
    block: Vec<Complex<f32>>,
    lane: Vec<Complex<f32>>,
}

impl Pool {
    fn new() -> Self {
        let mut planner = FftPlanner::new();
        let hann = |length: usize| {
            (0..length).map(move |i| 0.5 - 0.5 * (TAU * (i as f32 + 0.5) / length as f32).cos())
        };
        let (space, time): (Vec<f32>, Vec<f32>) = (hann(SIDE).collect(), hann(FRAMES).collect());
        let mut window = Vec::with_capacity(SIDE * SIDE * FRAMES);
        for t in &time {
            for y in &space {
                window.extend(space.iter().map(|x| t * y * x));
            }
        }
        let scale = 1.0 / window.iter().map(|w| w * w).sum::<f32>();
        let signed = |k: usize| if k > SIDE / 2 { k as f32 - SIDE as f32 } else { k as f32 };
        let bands = (0..SIDE * SIDE).map(|i| band(signed(i % SIDE), signed(i / SIDE))).collect();
        Self {
            row: planner.plan_fft_forward(SIDE),
            time: planner.plan_fft_forward(FRAMES),
            window,
            scale,
            bands,
            block: vec![Complex::default(); SIDE * SIDE * FRAMES],
            lane: vec![Complex::default(); SIDE.max(FRAMES)],
        }
    }

    /// log10 of the mean power of each band, of the block whose first frame is `first`.
    fn block(&mut self, clip: &Clip, (x, y): (usize, usize), first: usize) -> Vec<f32> {
        self.load(clip, (x, y), first);
        for number in 0..SIDE * FRAMES {
            self.row.process(&mut self.block[number * SIDE..][..SIDE]);
        }
        for frame in 0..FRAMES {
            for column in 0..SIDE {
                transform(
                    &mut self.block,
                    &mut self.lane,
                    &*self.row,
                    frame * SIDE * SIDE + column,
                    SIDE,
                    SIDE,
                );
            }
        }
        for place in 0..SIDE * SIDE {
            transform(&mut self.block, &mut self.lane, &*self.time, place, SIDE * SIDE, FRAMES);
        }
        let mut pooled = Vec::with_capacity(4 * BANDS);
        for range in TEMPORAL.windows(2) {
            let (mut power, mut count) = ([0.0; BANDS], [0.0; BANDS]);
            for frame in range[0]..range[1] {
                let spectrum = &self.block[frame * SIDE * SIDE..][..SIDE * SIDE];
                for (value, &band) in spectrum.iter().zip(&self.bands) {
                    if usize::from(band) < BANDS {
                        power[usize::from(band)] += value.norm_sqr() * self.scale;
                        count[usize::from(band)] += 1.0;
                    }
                }
            }
            pooled.extend(power.iter().zip(&count).map(|(power, count)| (power / count + FLOOR).log10()));
        }
        pooled
    }

    /// The block without what stands still in it, under the window.
    fn load(&mut self, clip: &Clip, (x, y): (usize, usize), first: usize) {
        let frames = &clip.frames[first..first + FRAMES];
        for row in 0..SIDE {
            for column in 0..SIDE {
                let pixel = (y + row) * clip.width + x + column;
                let mean = frames.iter().map(|frame| frame[pixel]).sum::<f32>() / FRAMES as f32;
                for (number, frame) in frames.iter().enumerate() {
                    let place = (number * SIDE + row) * SIDE + column;
                    self.block[place] = Complex::new((frame[pixel] - mean) * self.window[place], 0.0);
                }
            }
        }
    }
}

/// The band of a frequency of space: 0 is nearly the same everywhere, the rest are three rings of eight directions; 255 is beyond the last ring.
fn band(x: f32, y: f32) -> u8 {
    let radius = x.hypot(y);
    let Some(ring) = RADIAL.iter().rposition(|&least| radius >= least) else { return 0 };
    if ring + 1 >= RADIAL.len() {
        return u8::MAX;
    }
    let turn = y.atan2(x).rem_euclid(TAU) / TAU;
    let direction = ((turn * DIRECTIONS as f32).round() as usize) % DIRECTIONS;
    (1 + ring * DIRECTIONS + direction) as u8
}

/// Transforms `count` values that lie `step` apart.
fn transform(
    block: &mut [Complex<f32>],
    lane: &mut [Complex<f32>],
    fft: &dyn Fft<f32>,
    start: usize,
    step: usize,
    count: usize,
) {
    for (number, value) in lane[..count].iter_mut().enumerate() {
        *value = block[start + number * step];
    }
    fft.process(&mut lane[..count]);
    for (number, value) in lane[..count].iter().enumerate() {
        block[start + number * step] = *value;
    }
}

/// st: the mean over blocks of 45×45 pixels and 24 frames and 100 bands (4 of time by 1 + 3 rings × 8 directions of space) of |log10(power + 0.3) of one −
/// that of the other|, where each block's log power is the mean over the times at which a block starts. Both clips must have the same size; `None` if
/// no block counts or a clip has fewer than 24 frames.
pub fn distance(clip: &Clip, truth: &Clip, region: &Region) -> Option<f32> {
    assert_eq!((clip.width, clip.height), (truth.width, truth.height), "clips of two sizes");
    let squares = region.squares(SIDE);
    if clip.frames.len().min(truth.frames.len()) < FRAMES || squares.is_empty() {
        return None;
    }
    let mut pool = Pool::new();
    let mut sum = 0.0;
    for &square in &squares {
        let (ours, theirs) = (over_time(&mut pool, clip, square), over_time(&mut pool, truth, square));
        sum += ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).sum::<f32>();
    }
    Some(sum / (squares.len() * 4 * BANDS) as f32)
}

fn over_time(pool: &mut Pool, clip: &Clip, square: (usize, usize)) -> Vec<f32> {
    let mut mean = vec![0.0; 4 * BANDS];
    let starts: Vec<usize> = (0..=clip.frames.len() - FRAMES).step_by(FRAMES / 2).collect();
    for &first in &starts {
        let block = pool.block(clip, square, first);
        mean.iter_mut().zip(block).for_each(|(mean, value)| *mean += value / starts.len() as f32);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::tests::noise;

    /// A pattern that travels by (dx, dy) pixels a frame.
    fn travelling(dx: f32, dy: f32) -> Clip {
        let mut clip = noise(45, 45, 24, 0.0, 1);
        for (number, frame) in clip.frames.iter_mut().enumerate() {
            for (index, value) in frame.iter_mut().enumerate() {
                let (x, y) =
                    ((index % 45) as f32 - dx * number as f32, (index / 45) as f32 - dy * number as f32);
                *value = 128.0
                    + 30.0 * (TAU * (x + 0.5 * y) / 9.0).sin()
                    + 30.0 * (TAU * (y - 0.3 * x) / 7.0).sin();
            }
        }
        clip
    }

    #[test]
    fn what_travels_the_other_way_is_far_though_each_pixel_moves_alike() {
        let (down, up) = (travelling(0.0, 1.0), travelling(0.0, -1.0));
        let region = Region::whole(&down);
        assert_eq!(distance(&down, &down, &region), Some(0.0));
        let far = distance(&up, &down, &region).expect("a block");
        assert!(far > 0.2, "{far}");
    }

    #[test]
    fn every_band_has_its_frequencies() {
        let pool = Pool::new();
        for band in 0..BANDS as u8 {
            assert!(pool.bands.contains(&band), "band {band} is empty");
        }
    }

    #[test]
    fn white_noise_has_its_variance_in_every_band() {
        let clip = noise(45, 45, 240, 10.0, 2);
        // A block's mean takes some of the lowest frequency of time.
        for (number, value) in over_time(&mut Pool::new(), &clip, (0, 0)).into_iter().enumerate().skip(BANDS)
        {
            assert!((value - 2.0).abs() < 0.3, "band {number}: {value}");
        }
    }

    #[test]
    fn too_little_footage_has_no_distance() {
        let clip = noise(45, 45, 20, 10.0, 3);
        assert_eq!(distance(&clip, &clip, &Region::whole(&clip)), None);
    }
}
