//! What a video's flow is over its length: its mean, its spectrum, and where there is fluid.

use super::{GRID, flow::Flow, pyramid::halved};
use crate::{features::CHANNELS, plane::Plane};
use rayon::prelude::*;
use rustfft::{FftPlanner, num_complex::Complex};

/// Upper ends of the bands of the spectrum, in cycles a frame. Octaves where motion is slow; the fastest octave in two, as flames and
/// spray have most of theirs there.
pub const BANDS: [f32; 6] = [1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0, 3.0 / 8.0, 1.0 / 2.0];

/// Levels of the Laplacian pyramid that a patch knows.
pub const LEVELS: usize = CHANNELS - 2 - BANDS.len();

/// Levels of the video: the smallest version looks one octave up.
const VIDEO_LEVELS: usize = LEVELS + 1;

/// Frames whose texture is looked at, spread over the video: it changes little from frame to frame.
const TEXTURE_FRAMES: usize = 6;

/// Mean speed from which a point moves, in pixels a frame.
const MOVES: f32 = 0.15;

/// How many times the noise the luminance of a point must change by, both as standard deviations over time.
const CHANGES: f32 = 3.0;

/// Mean size of the two finest levels of the pyramid from which a point shows something, in levels: flow in flat black is chance.
const TEXTURE: f32 = 0.6;

/// Frames as luminance, row by row.
#[derive(Clone, Copy, Debug)]
pub struct LumaFrames<'a> {
    /// Pixels of a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The frames.
    pub frames: &'a [Vec<u8>],
}

/// The motion of a video, on every [`GRID`]th pixel.
#[derive(Clone, Debug)]
pub struct MotionField {
    /// Points of a row.
    pub columns: usize,
    /// Rows of points.
    pub rows: usize,
    /// Signed mean of u and v, in pixels a frame.
    pub mean: Vec<[f32; 2]>,
    /// Root mean square of the motion in each of the [`BANDS`], the mean taken off, in pixels a frame.
    pub bands: Vec<[f32; BANDS.len()]>,
    /// Mean size of the levels of the Laplacian pyramid, finest first, in levels of luminance.
    pub texture: Vec<[f32; VIDEO_LEVELS]>,
    /// Standard deviation of the luminance over time, in levels.
    pub change: Vec<f32>,
    /// Whether there is fluid: it moves, changes and shows something.
    pub fluid: Vec<bool>,
    /// Noise of the luminance over time: the standard deviation of the stillest points.
    pub noise: f32,
}

impl MotionField {
    /// Joins the flows of a video. Points without fluid do not move.
    ///
    /// About 0.15 s for 125 frames of 640 × 360 pixels on one core.
    pub fn of(luma: LumaFrames<'_>, flows: &[Flow]) -> Self {
        let (columns, rows) = (luma.width / GRID, luma.height / GRID);
        let texture = texture(luma, columns, rows);
        let change = change(luma, columns, rows);
        let noise = noise(&change);
        let (mean, mut bands, speed) = spectra(flows, columns * rows);
        let shows = |levels: &[f32; VIDEO_LEVELS]| levels[0] + levels[1] > TEXTURE;
        let fluid: Vec<bool> = (0..columns * rows)
            .map(|point| speed[point] > MOVES && change[point] > CHANGES * noise && shows(&texture[point]))
            .collect();
        let mut mean = mean;
        for (point, _) in fluid.iter().enumerate().filter(|(_, fluid)| !**fluid) {
            mean[point] = [0.0; 2];
            bands[point] = [0.0; BANDS.len()];
        }
        Self { columns, rows, mean, bands, texture, change, fluid, noise }
    }

    /// Share of the points that are fluid.
    pub fn fluid_share(&self) -> f32 {
        self.fluid.iter().filter(|fluid| **fluid).count() as f32 / self.fluid.len().max(1) as f32
    }
}

/// Standard deviation over time of the luminance at every point, the mean of four by four pixels' deviations.
fn change(luma: LumaFrames<'_>, columns: usize, rows: usize) -> Vec<f32> {
    let count = luma.frames.len() as f32;
    let mut change = vec![0.0; columns * rows];
    change.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        let first = row * GRID * luma.width;
        let mut sums = vec![(0u32, 0u32); GRID * luma.width];
        for frame in luma.frames {
            for (sum, level) in sums.iter_mut().zip(&frame[first..]) {
                let level = u32::from(*level);
                *sum = (sum.0 + level, sum.1 + level * level);
            }
        }
        for (index, (sum, squares)) in sums.into_iter().enumerate() {
            let mean = sum as f32 / count;
            if let Some(change) = line.get_mut(index % luma.width / GRID) {
                *change += (squares as f32 / count - mean * mean).max(0.0).sqrt() / (GRID * GRID) as f32;
            }
        }
    });
    change
}

/// The deviation that a tenth of the points stay under. Where fluid is everywhere that says nothing, so it is held under a level; a
/// levels' rounding alone gives 0.3.
fn noise(change: &[f32]) -> f32 {
    let mut sorted = change.to_vec();
    sorted.sort_by(f32::total_cmp);
    sorted.get(sorted.len() / 10).map_or(0.3, |deviation| deviation.clamp(0.3, 1.0))
}

/// Signed mean, bands and mean speed of every point.
type Spectra = (Vec<[f32; 2]>, Vec<[f32; BANDS.len()]>, Vec<f32>);

fn spectra(flows: &[Flow], points: usize) -> Spectra {
    let length = flows.len().max(1);
    let transform = FftPlanner::<f32>::new().plan_fft_forward(length);
    let new =
        || (vec![Complex::default(); length], vec![Complex::default(); transform.get_inplace_scratch_len()]);
    let point = |(series, scratch): &mut (Vec<Complex<f32>>, Vec<Complex<f32>>), point: usize| {
        for (value, flow) in series.iter_mut().zip(flows) {
            let [u, v] = flow.values[point].map(|part| f32::from(part) / Flow::UNIT);
            *value = Complex::new(u, v);
        }
        let speed = series.iter().map(|value| value.norm()).sum::<f32>() / length as f32;
        transform.process_with_scratch(series, scratch);
        let mean = series[0] / length as f32;
        let mut bands = [0.0; BANDS.len()];
        for (index, value) in series.iter().enumerate().skip(1) {
            // Frequencies beyond the middle are the negative ones: motion that turns the other way.
            let frequency = index.min(length - index) as f32 / length as f32;
            let band = BANDS.iter().position(|end| frequency <= *end).unwrap_or(BANDS.len() - 1);
            bands[band] += value.norm_sqr();
        }
        ([mean.re, mean.im], bands.map(|power| power.sqrt() / length as f32), speed)
    };
    let all: Vec<_> = (0..points).into_par_iter().with_min_len(256).map_init(new, point).collect();
    let mean = all.iter().map(|(mean, ..)| *mean).collect();
    let bands = all.iter().map(|(_, bands, _)| *bands).collect();
    (mean, bands, all.iter().map(|(.., speed)| *speed).collect())
}

/// The mean size of the Laplacian pyramid's levels over some frames.
fn texture(luma: LumaFrames<'_>, columns: usize, rows: usize) -> Vec<[f32; VIDEO_LEVELS]> {
    let every = luma.frames.len().div_ceil(TEXTURE_FRAMES).max(1);
    let frames: Vec<&Vec<u8>> = luma.frames.iter().step_by(every).collect();
    let pyramids: Vec<Vec<Plane>> = frames
        .par_iter()
        .map(|frame| {
            let values = frame.iter().map(|level| f32::from(*level)).collect();
            laplacian_sizes(Plane { width: luma.width, height: luma.height, values })
        })
        .collect();
    let share = 1.0 / frames.len().max(1) as f32;
    let mut texture = vec![[0.0; VIDEO_LEVELS]; columns * rows];
    texture.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
        for (column, levels) in line.iter_mut().enumerate() {
            let centre = |index: usize| (index * GRID) as f32 + (GRID as f32 - 1.0) / 2.0;
            for (level, size) in levels.iter_mut().enumerate() {
                // The level's pixels are 2^level wide; its first one has its centre at half of that.
                let scale = (1 << level) as f32;
                let place = |index: usize| (centre(index) + 0.5) / scale - 0.5;
                *size = pyramids
                    .iter()
                    .map(|pyramid| pyramid[level].sample(place(column), place(row)))
                    .sum::<f32>()
                    * share;
            }
        }
    });
    texture
}

/// How large the Laplacian is on every level, as means over two by two points of the grid or one pixel of the level, whichever is more.
fn laplacian_sizes(mut plane: Plane) -> Vec<Plane> {
    let mut sizes = Vec::with_capacity(VIDEO_LEVELS);
    for _ in 0..VIDEO_LEVELS {
        if plane.width < 4 || plane.height < 4 {
            // Nothing so coarse in so small a picture.
            sizes.push(Plane::new(1, 1));
            continue;
        }
        let half = halved(&plane);
        let mut size = Plane::new(plane.width, plane.height);
        for (y, row) in size.values.chunks_exact_mut(plane.width).enumerate() {
            for (x, value) in row.iter_mut().enumerate() {
                let coarse = half.sample((x as f32 + 0.5) / 2.0 - 0.5, (y as f32 + 0.5) / 2.0 - 0.5);
                *value = (plane.row(y)[x] - coarse).abs();
            }
        }
        sizes.push(pooled(&size, sizes.len()));
        plane = half;
    }
    sizes
}

/// The mean around each pixel, over as many pixels as make about a point of the grid on this level.
fn pooled(plane: &Plane, level: usize) -> Plane {
    let reach = GRID >> (level + 1);
    if reach == 0 {
        return plane.clone();
    }
    let mut result = Plane::new(plane.width, plane.height);
    for y in 0..plane.height {
        let rows = y.saturating_sub(reach)..(y + reach + 1).min(plane.height);
        for x in 0..plane.width {
            let columns = x.saturating_sub(reach)..(x + reach + 1).min(plane.width);
            let count = (rows.len() * columns.len()) as f32;
            let sum: f32 = rows.clone().map(|row| plane.row(row)[columns.clone()].iter().sum::<f32>()).sum();
            result.values[y * plane.width + x] = sum / count;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flow that is `at(frame, point)` pixels a frame.
    fn flows(frames: usize, at: impl Fn(usize, usize) -> [f32; 2]) -> Vec<Flow> {
        (0..frames)
            .map(|frame| {
                let values = (0..30 * 24)
                    .map(|point| at(frame, point).map(|part| (part * Flow::UNIT) as i16))
                    .collect();
                Flow { columns: 30, rows: 24, values }
            })
            .collect()
    }

    /// Noise that is another one in every frame.
    fn frames(count: usize) -> Vec<Vec<u8>> {
        let level = |seed: usize| (seed.wrapping_mul(2_654_435_761) >> 7) as u8;
        (0..count).map(|frame| (0..120 * 96).map(|pixel| level(pixel / 3 + frame * 7919)).collect()).collect()
    }

    #[test]
    fn the_mean_has_a_sign_and_a_circling_motion_its_band() {
        let turning = |frame: usize, _: usize| {
            let angle = core::f32::consts::TAU * frame as f32 * 3.0 / 32.0;
            [0.5 + angle.cos(), -1.0 + angle.sin()]
        };
        let frames = frames(33);
        let field =
            MotionField::of(LumaFrames { width: 120, height: 96, frames: &frames }, &flows(32, turning));
        assert!(field.fluid.iter().all(|fluid| *fluid));
        for (mean, bands) in field.mean.iter().zip(&field.bands) {
            assert!((mean[0] - 0.5).abs() < 0.01 && (mean[1] + 1.0).abs() < 0.01, "{mean:?}");
            assert!((bands[2] - 1.0).abs() < 0.01 && bands[0] + bands[1] + bands[3] < 0.03, "{bands:?}");
        }
    }

    #[test]
    fn points_that_are_still_or_do_not_change_are_no_fluid() {
        let mut frames = frames(20);
        // The right half is a still photo.
        let first = frames[0].clone();
        for frame in &mut frames {
            for (pixel, level) in frame.iter_mut().enumerate().filter(|(pixel, _)| pixel % 120 >= 60) {
                *level = first[pixel];
            }
        }
        let upper = |_: usize, point: usize| if point < 30 * 12 { [1.0, 0.0] } else { [0.05, 0.05] };
        let field =
            MotionField::of(LumaFrames { width: 120, height: 96, frames: &frames }, &flows(19, upper));
        for row in 0..24 {
            for column in 0..30 {
                assert_eq!(field.fluid[row * 30 + column], row < 12 && column < 15, "{column}, {row}");
            }
        }
        assert_eq!(field.mean[20], [0.0, 0.0]);
    }
}
