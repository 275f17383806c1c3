//! Numbers of a clip that a formula of a line gives.

use crate::{Clip, Region};

/// The deviation of every pixel over time, in levels.
pub fn deviation(clip: &Clip) -> Vec<f32> {
    let mean = clip.mean();
    let mut sum = vec![0.0; clip.pixels()];
    for frame in &clip.frames {
        for ((sum, value), mean) in sum.iter_mut().zip(frame).zip(&mean) {
            *sum += (value - mean).powi(2);
        }
    }
    sum.iter().map(|sum| (sum / clip.frames.len().max(1) as f32).sqrt()).collect()
}

/// log10 of the deviation over time by the truth's: the median over cells of 15 pixels. Under −0.15 a clip is too calm. `None` if no cell counts.
pub fn amplitude_ratio(clip: &Clip, truth: &Clip, region: &Region) -> Option<f32> {
    const CELL: usize = 15;
    /// Rounding to levels: so that a still has a finite ratio.
    const ROUNDING: f32 = 0.29;
    let (ours, theirs) = (deviation(clip), deviation(truth));
    let power = |deviation: &[f32], (x, y): (usize, usize)| {
        let rows = (y..y + CELL).flat_map(|row| &deviation[row * clip.width + x..][..CELL]);
        rows.map(|value| value * value).sum::<f32>() / (CELL * CELL) as f32 + ROUNDING * ROUNDING
    };
    let ratios = region
        .squares(CELL)
        .into_iter()
        .map(|square| 0.5 * (power(&ours, square) / power(&theirs, square)).log10());
    median(ratios.collect())
}

/// The correlation of what changes from frame to frame at two pixels that are `pixels` apart, across and down. Tiles that pop, and jelly, have more of
/// it than the truth. `None` if nothing changes.
pub fn coherence(clip: &Clip, region: &Region, pixels: usize) -> Option<f32> {
    let (mut common, mut power, mut pairs, mut count) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
    for frames in clip.frames.windows(2) {
        let change = |index: usize| f64::from(frames[1][index] - frames[0][index]);
        for y in 0..clip.height {
            for x in (0..clip.width).filter(|&x| region.contains(x, y)) {
                let here = change(y * clip.width + x);
                power += here * here;
                count += 1.0;
                for (x, y) in [(x + pixels, y), (x, y + pixels)] {
                    if x < clip.width && y < clip.height && region.contains(x, y) {
                        common += here * change(y * clip.width + x);
                        pairs += 1.0;
                    }
                }
            }
        }
    }
    (power > 0.0 && pairs > 0.0).then(|| ((common / pairs) / (power / count)) as f32)
}

/// The correlation of a pixel's level with itself `lag` frames later, over the region. `None` if nothing moves or the clip is no longer than `lag`.
pub fn autocorrelation(clip: &Clip, region: &Region, lag: usize) -> Option<f32> {
    let mean = clip.mean();
    let (mut common, mut power) = (0.0f64, 0.0f64);
    let late = clip.frames.get(lag..)?;
    for (now, later) in clip.frames.iter().zip(late) {
        for index in (0..mean.len()).filter(|&index| region.pixels()[index]) {
            let (a, b) = (f64::from(now[index] - mean[index]), f64::from(later[index] - mean[index]));
            common += a * b;
            power += 0.5 * (a * a + b * b);
        }
    }
    // What is left of a still is rounding.
    (power > 1e-6 * mean.len() as f64).then(|| (common / power) as f32)
}

/// The root mean square of the difference of the last frame to the first, by the mean of that of neighbours: above 1.2 the loop has a cut.
/// `None` if nothing moves.
pub fn seam(clip: &Clip) -> Option<f32> {
    let difference = |a: &[f32], b: &[f32]| {
        let sum: f64 = a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum();
        (sum / a.len().max(1) as f64).sqrt()
    };
    let steps: Vec<f64> = clip.frames.windows(2).map(|pair| difference(&pair[0], &pair[1])).collect();
    let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
    let cut = difference(clip.frames.last()?, clip.frames.first()?);
    (mean > 0.0).then(|| (cut / mean) as f32)
}

/// The deviation of the mean luminance of frames over time, in levels.
pub fn flicker(clip: &Clip) -> f32 {
    let means: Vec<f64> =
        clip.frames.iter().map(|frame| mean(frame.iter().map(|&value| f64::from(value)))).collect();
    let whole = mean(means.iter().copied());
    mean(means.iter().map(|value| (value - whole).powi(2))).sqrt() as f32
}

/// The energy of the gradients of the frames by that of `photo`: the mean, the least and the most. 0.9 to 1.1 is as sharp as the photo; a wide range
/// is breathing.
pub fn sharpness(clip: &Clip, photo: &[f32]) -> (f32, f32, f32) {
    let energy = |frame: &[f32]| {
        let rows = frame
            .chunks_exact(clip.width)
            .flat_map(|row| row.windows(2).map(|pair| f64::from(pair[1] - pair[0])));
        let columns = frame.iter().zip(&frame[clip.width..]).map(|(above, below)| f64::from(below - above));
        rows.chain(columns).map(|step| step * step).sum::<f64>()
    };
    let whole = energy(photo).max(f64::MIN_POSITIVE);
    let ratios: Vec<f64> = clip.frames.iter().map(|frame| energy(frame) / whole).collect();
    let least = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let most = ratios.iter().copied().fold(0.0, f64::max);
    (mean(ratios.iter().copied()) as f32, least as f32, most as f32)
}

/// The largest difference of any frame to `photo` outside of `region`, in levels: 0 for a picture whose still parts stand still.
pub fn leak(clip: &Clip, photo: &[f32], region: &Region) -> f32 {
    let outside = |frame: &Vec<f32>| {
        let pixels = frame.iter().zip(photo).zip(region.pixels());
        pixels.filter(|(_, inside)| !**inside).map(|((a, b), _)| (a - b).abs()).fold(0.0, f32::max)
    };
    clip.frames.iter().map(outside).fold(0.0, f32::max)
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    if count > 0.0 { sum / count } else { 0.0 }
}

/// The middle one of some numbers.
pub fn median(mut values: Vec<f32>) -> Option<f32> {
    values.sort_by(f32::total_cmp);
    values.get(values.len() / 2).copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::tests::noise;

    #[test]
    fn half_the_swing_is_a_ratio_of_minus_0_3() {
        let truth = noise(30, 30, 64, 8.0, 1);
        let mean = truth.mean();
        let mut calm = truth.clone();
        for frame in &mut calm.frames {
            frame.iter_mut().zip(&mean).for_each(|(value, mean)| *value = mean + 0.5 * (*value - mean));
        }
        let ratio = amplitude_ratio(&calm, &truth, &Region::whole(&truth)).expect("cells");
        assert!((ratio + 0.301).abs() < 0.01, "{ratio}");
    }

    #[test]
    fn noise_is_incoherent_and_a_popping_tile_is_not() {
        let clip = noise(32, 32, 16, 5.0, 2);
        let region = Region::whole(&clip);
        assert!(coherence(&clip, &region, 8).expect("changes").abs() < 0.05);
        let mut tile = clip.clone();
        for (number, frame) in tile.frames.iter_mut().enumerate() {
            frame.fill((number * 7 % 5) as f32);
        }
        assert!((coherence(&tile, &region, 8).expect("changes") - 1.0).abs() < 1e-3);
        assert_eq!(coherence(&clip.still(), &region, 8), None);
    }

    #[test]
    fn a_loop_without_a_cut_has_a_seam_of_one() {
        let mut clip = noise(8, 8, 40, 0.0, 3);
        for (number, frame) in clip.frames.iter_mut().enumerate() {
            frame.fill(100.0 + 50.0 * (number as f32 / 40.0 * std::f32::consts::TAU).sin());
        }
        assert!(
            (seam(&clip).expect("moves") - 1.55).abs() < 0.2,
            "a step at the steepest place: {:?}",
            seam(&clip)
        );
        clip.frames.truncate(30);
        assert!(seam(&clip).expect("moves") > 5.0);
    }

    #[test]
    fn what_moves_outside_of_the_mask_is_a_leak() {
        let clip = noise(4, 4, 3, 2.0, 4).still();
        let photo = clip.frames[0].clone();
        let mut mask = [0; 16];
        mask[5] = 255;
        let region = Region::of_mask(4, &mask);
        let mut moving = clip.clone();
        moving.frames[1][5] += 9.0;
        assert_eq!(leak(&moving, &photo, &region), 0.0);
        moving.frames[2][6] += 1.0;
        assert!((leak(&moving, &photo, &region) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_blurred_clip_is_less_sharp() {
        let clip = noise(16, 16, 4, 9.0, 5);
        let photo = clip.frames[0].clone();
        assert!((sharpness(&clip.still(), &photo).0 - 1.0).abs() < 1e-6);
        let grey = Clip { frames: vec![vec![7.0; 256]; 4], ..clip };
        assert_eq!(sharpness(&grey, &photo), (0.0, 0.0, 0.0));
    }

    #[test]
    fn noise_forgets_itself_after_a_frame_and_a_still_never_moves() {
        let clip = noise(16, 16, 64, 9.0, 6);
        let region = Region::whole(&clip);
        assert_eq!(autocorrelation(&clip, &region, 0), Some(1.0));
        assert!(autocorrelation(&clip, &region, 1).expect("moves").abs() < 0.05);
        assert_eq!(autocorrelation(&clip.still(), &region, 1), None);
        assert!(flicker(&clip.still()) == 0.0 && flicker(&clip) > 0.1);
    }
}
