//! The distribution of small blocks of space and time.

use crate::{Clip, Region};
use rand::{RngExt, SeedableRng, rngs::Xoshiro256PlusPlus};

/// Side of a block in pixels and frames.
const SIDE: usize = 5;

/// Values of a block.
const VALUES: usize = SIDE * SIDE * SIDE;

/// Directions in which the blocks are looked at.
const DIRECTIONS: usize = 64;

/// Blocks a clip and level.
const BLOCKS: usize = 4096;

/// Levels of the pyramid.
const LEVELS: usize = 3;

/// The sliced Wasserstein distance (Rabin and others, 2011) of the blocks of 5×5×5 of two clips, in levels: the mean over 64 directions and three levels of a
/// pyramid of halves of the mean difference of sorted projections. `None` if a clip has fewer than five frames or no block lies in the region.
/// The clips may have different lengths. The same number on every run.
pub fn distance(clip: &Clip, truth: &Clip, region: &Region) -> Option<f32> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let (mut ours, mut theirs, mut region) = (clip.clone(), truth.clone(), region.clone());
    let (mut sum, mut levels) = (0.0, 0.0);
    for _ in 0..LEVELS {
        let (a, b) = (blocks(&ours, &region, &mut rng), blocks(&theirs, &region, &mut rng));
        if let (Some(a), Some(b)) = (a, b) {
            let slices = (0..DIRECTIONS).map(|_| slice(&a, &b, &direction(&mut rng)));
            sum += slices.sum::<f32>() / DIRECTIONS as f32;
            levels += 1.0;
        }
        (ours, theirs, region) = (halve(&ours), halve(&theirs), halve_region(&region, ours.width));
    }
    (levels > 0.0).then(|| sum / levels)
}

/// Blocks at random places of the region, each without its mean.
fn blocks(clip: &Clip, region: &Region, rng: &mut Xoshiro256PlusPlus) -> Option<Vec<[f32; VALUES]>> {
    let places: Vec<usize> = (0..clip.pixels())
        .filter(|&index| {
            let (x, y) = (index % clip.width, index / clip.width);
            x + SIDE <= clip.width && y + SIDE <= clip.height && region.contains(x + SIDE / 2, y + SIDE / 2)
        })
        .collect();
    if places.is_empty() || clip.frames.len() < SIDE {
        return None;
    }
    let block = |_| {
        let place = places[rng.random_range(0..places.len())];
        let first = rng.random_range(0..=clip.frames.len() - SIDE);
        let mut values = [0.0; VALUES];
        for (number, value) in values.iter_mut().enumerate() {
            let (x, y, t) = (number % SIDE, number / SIDE % SIDE, number / (SIDE * SIDE));
            *value = clip.frames[first + t][place + y * clip.width + x];
        }
        let mean = values.iter().sum::<f32>() / VALUES as f32;
        values.map(|value| value - mean)
    };
    Some((0..BLOCKS).map(block).collect())
}

/// A direction, all equally likely: of numbers with a normal distribution (by the sum of twelve).
fn direction(rng: &mut Xoshiro256PlusPlus) -> [f32; VALUES] {
    let mut values = [0.0; VALUES];
    values.fill_with(|| (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0);
    let length = values.iter().map(|value| value * value).sum::<f32>().sqrt();
    values.map(|value| value / length)
}

fn slice(a: &[[f32; VALUES]], b: &[[f32; VALUES]], direction: &[f32; VALUES]) -> f32 {
    let project = |blocks: &[[f32; VALUES]]| {
        let mut along: Vec<f32> = blocks
            .iter()
            .map(|block| block.iter().zip(direction).map(|(value, unit)| value * unit).sum())
            .collect();
        along.sort_by(f32::total_cmp);
        along
    };
    project(a).iter().zip(&project(b)).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32
}

fn halve(clip: &Clip) -> Clip {
    let (width, height) = (clip.width / 2, clip.height / 2);
    let frame = |frame: &Vec<f32>| {
        let pixel = |index: usize| {
            let place = 2 * (index / width) * clip.width + 2 * (index % width);
            0.25 * (frame[place]
                + frame[place + 1]
                + frame[place + clip.width]
                + frame[place + clip.width + 1])
        };
        (0..width * height).map(pixel).collect()
    };
    Clip { width, height, rate: clip.rate, frames: clip.frames.iter().map(frame).collect() }
}

fn halve_region(region: &Region, width: usize) -> Region {
    let height = region.pixels().len() / width.max(1);
    let pixel = |index: usize| {
        let (x, y) = (index % (width / 2), index / (width / 2));
        if region.contains(2 * x, 2 * y) { 255 } else { 0 }
    };
    let mask: Vec<u8> = (0..(width / 2) * (height / 2)).map(pixel).collect();
    Region::of_mask(width / 2, &mask)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip::tests::noise;

    #[test]
    fn another_recording_of_the_same_is_near_and_a_still_is_far() {
        let truth = noise(40, 40, 20, 8.0, 1);
        let region = Region::whole(&truth);
        let near = distance(&noise(40, 40, 20, 8.0, 2), &truth, &region).expect("blocks");
        let far = distance(&noise(40, 40, 20, 4.0, 3), &truth, &region).expect("blocks");
        assert!(near < 0.3 && far > 5.0 * near, "{near} {far}");
        assert_eq!(distance(&truth, &truth, &region), distance(&truth, &truth, &region));
    }

    #[test]
    fn a_clip_of_four_frames_has_no_blocks() {
        let clip = noise(40, 40, 4, 8.0, 1);
        assert_eq!(distance(&clip, &clip, &Region::whole(&clip)), None);
    }
}
