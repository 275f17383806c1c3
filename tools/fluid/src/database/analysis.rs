//! What is found out about a video from its frames alone.

use crate::{
    appearance::view::{self, Sizes},
    features::{CELLS, CHANNELS},
    motion::{
        cells::cells,
        field::{LumaFrames, MotionField},
        flow::Flow,
    },
    patch::{PatchRef, SIDE, Version},
    plane::Plane,
    video::{
        luma,
        suitability::{Refusal, check_scene, check_size},
    },
};
use image::RgbImage;
use rayon::prelude::*;

/// A patch without its words.
#[derive(Clone, Debug, PartialEq)]
pub struct Moving {
    /// Which patch.
    pub patch: PatchRef,
    /// Standard deviation of the luminance of the sharp frame, in levels.
    pub contrast: f32,
    /// See [`crate::features::Features::motion`].
    pub motion: [[f32; CHANNELS]; CELLS * CELLS],
}

/// A video that was looked at.
#[derive(Clone, Debug)]
pub struct Analysis {
    /// The mean of its frames.
    pub mean: RgbImage,
    /// The number of the frame with the most detail.
    pub sharp: u32,
    /// Its motion.
    pub field: MotionField,
    /// Its patches, by version, row and column, for a video of number 0.
    pub patches: Vec<Moving>,
}

/// Looks at a video whose frames are denoised. `forced` takes what only doubts speak against.
///
/// About 4 s of one core for 125 frames of 640 × 360 pixels.
///
/// # Errors
///
/// Why it does not suit.
pub fn analyse(frames: &[RgbImage], forced: bool) -> Result<Analysis, Refusal> {
    let (width, height) = frames.first().map_or((0, 0), RgbImage::dimensions);
    check_size(width, height, frames.len())?;
    let lumas: Vec<Vec<u8>> = frames.par_iter().map(luma).collect();
    let (width, height) = (width as usize, height as usize);
    let flows: Vec<Flow> =
        lumas.par_windows(2).map(|pair| Flow::between(&pair[0], &pair[1], width, height)).collect();
    let luma = LumaFrames { width, height, frames: &lumas };
    if !forced {
        check_scene(luma, &flows)?;
    }
    let field = MotionField::of(luma, &flows);
    let sharp = sharpest(luma);
    let patches = patches(&field, &plane(luma, sharp));
    if patches.is_empty() {
        return Err(Refusal::Still);
    }
    Ok(Analysis { mean: mean(frames), sharp: sharp as u32, field, patches })
}

/// A frame's luminance.
fn plane(luma: LumaFrames<'_>, index: usize) -> Plane {
    let values = luma.frames[index].iter().map(|level| f32::from(*level)).collect();
    Plane { width: luma.width, height: luma.height, values }
}

/// The frame whose neighbouring pixels differ most; of those, the first.
fn sharpest(luma: LumaFrames<'_>) -> usize {
    let detail = |frame: &Vec<u8>| {
        let rows = frame.chunks_exact(luma.width);
        rows.flat_map(|row| row.windows(2))
            .map(|pair| u64::from(pair[0].abs_diff(pair[1])).pow(2))
            .sum::<u64>()
    };
    let details: Vec<u64> = luma.frames.par_iter().map(detail).collect();
    (0..details.len()).max_by_key(|index| (details[*index], std::cmp::Reverse(*index))).unwrap_or(0)
}

/// The mean of frames of one size, rounded.
fn mean(frames: &[RgbImage]) -> RgbImage {
    let mut mean = frames[0].clone();
    let count = frames.len() as u32;
    mean.par_chunks_mut(1 << 14).enumerate().for_each(|(block, values)| {
        let first = block << 14;
        let mut sums = vec![count / 2; values.len()];
        for frame in frames {
            sums.iter_mut().zip(&frame.as_raw()[first..]).for_each(|(sum, level)| *sum += u32::from(*level));
        }
        values.iter_mut().zip(sums).for_each(|(value, sum)| *value = (sum / count) as u8);
    });
    mean
}

fn patches(field: &MotionField, sharp: &Plane) -> Vec<Moving> {
    let (width, height) = (sharp.width, sharp.height);
    let sizes = Sizes::of(sharp);
    let versions: Vec<Version> = Version::all().collect();
    let moving = |patch: PatchRef| {
        let motion = cells(field, patch, width, height)?;
        Some(Moving { patch, contrast: contrast(sizes.of_version(patch.version), patch), motion })
    };
    let of_version = |version: &Version| {
        let patches: Vec<PatchRef> = view::patches(0, *version, width, height).collect();
        patches.into_par_iter().filter_map(moving).collect::<Vec<_>>()
    };
    versions.par_iter().flat_map(of_version).collect()
}

/// Standard deviation of what a patch shows.
fn contrast(sharp: &Plane, patch: PatchRef) -> f32 {
    let (mut sum, mut squares) = (0.0f64, 0.0f64);
    let first = 0.5 - SIDE as f32 / 2.0;
    for row in 0..SIDE {
        for column in 0..SIDE {
            let (x, y) =
                (f32::from(patch.x) + first + column as f32, f32::from(patch.y) + first + row as f32);
            let (x, y) = view::place(patch.version, x, y, sharp.width, sharp.height);
            let level = f64::from(sharp.sample(x, y));
            sum += level;
            squares += level * level;
        }
    }
    let count = (SIDE * SIDE) as f64;
    (squares / count - (sum / count).powi(2)).max(0.0).sqrt() as f32
}
