//! The motion of a patch: a field looked at through a version.

use super::{
    GRID,
    field::{BANDS, MotionField},
};
use crate::{
    appearance::view,
    features::{CELLS, CHANNELS},
    patch::{PatchRef, SIDE, Version},
};

/// Share of a patch's pixels that must be fluid.
const FLUID_SHARE: f32 = 0.3;

/// Places of a cell that are looked at, across and down: every fourth pixel of the version.
const PLACES: usize = 3;

/// Pixels from one to the next.
const SPACING: f32 = (SIDE / CELLS / PLACES) as f32;

/// The motion of a patch of a video of this field, or none if too little of the patch is fluid.
pub fn cells(
    field: &MotionField,
    patch: PatchRef,
    width: usize,
    height: usize,
) -> Option<[[f32; CHANNELS]; CELLS * CELLS]> {
    let mut cells = [[0.0; CHANNELS + 1]; CELLS * CELLS];
    let mut fluid = 0;
    let across = CELLS * PLACES;
    let first = -(SIDE as f32) / 2.0 + SPACING / 2.0;
    for row in 0..across {
        for column in 0..across {
            let (x, y) = (
                f32::from(patch.x) + first + column as f32 * SPACING,
                f32::from(patch.y) + first + row as f32 * SPACING,
            );
            let point = point(field, view::place(patch.version, x, y, width, height));
            fluid += usize::from(field.fluid[point]);
            add(&mut cells[row / PLACES * CELLS + column / PLACES], field, point);
        }
    }
    if (fluid as f32) < FLUID_SHARE * (across * across) as f32 {
        return None;
    }
    Some(cells.map(|cell| seen(cell.map(|sum| sum / (PLACES * PLACES) as f32), patch.version)))
}

/// The nearest point of the grid.
fn point(field: &MotionField, (x, y): (f32, f32)) -> usize {
    let nearest = |place: f32, count: usize| (((place + 0.5) / GRID as f32).max(0.0) as usize).min(count - 1);
    nearest(y, field.rows) * field.columns + nearest(x, field.columns)
}

/// What the video has at a point: the signed mean, the bands, and one more level of texture than a patch.
type Sums = [f32; CHANNELS + 1];

/// Where the levels of texture begin.
const TEXTURE: usize = 2 + BANDS.len();

fn add(sums: &mut Sums, field: &MotionField, point: usize) {
    let parts = field.mean[point].iter().chain(&field.bands[point]).chain(&field.texture[point]);
    for (sum, value) in sums.iter_mut().zip(parts) {
        *sum += value;
    }
}

/// A cell of the video as the version shows it.
fn seen(cell: Sums, version: Version) -> [f32; CHANNELS] {
    let (map, scale) = (version.from_video(), version.scale());
    // What is fine in the version is coarser in the video, by so many octaves.
    let octaves = -scale.log2();
    core::array::from_fn(|channel| match channel {
        0 | 1 => map[channel][0] * cell[0] + map[channel][1] * cell[1],
        _ if channel < TEXTURE => scale * cell[channel],
        _ => cell[channel] + (cell[channel + 1] - cell[channel]) * octaves,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All of it moves by (1, −2), in the third band by 4 pixels, with levels of 1, 2, 3, 4, 5.
    fn field(fluid: impl Fn(usize) -> bool) -> MotionField {
        let points = 40 * 30;
        MotionField {
            columns: 40,
            rows: 30,
            mean: vec![[1.0, -2.0]; points],
            bands: vec![[0.0, 0.0, 4.0, 0.0, 0.0, 0.0]; points],
            texture: vec![[1.0, 2.0, 3.0, 4.0, 5.0]; points],
            change: vec![9.0; points],
            fluid: (0..points).map(fluid).collect(),
            noise: 0.3,
        }
    }

    fn of(version: u8) -> [f32; CHANNELS] {
        let patch = PatchRef { video: 0, version: Version::new(version).unwrap(), x: 0, y: 0 };
        cells(&field(|_| true), patch, 160, 120).unwrap()[5]
    }

    #[test]
    fn versions_turn_mirror_and_scale_what_moves() {
        assert_eq!(of(0)[..5], [1.0, -2.0, 0.0, 0.0, 4.0]);
        assert_eq!(of(1)[..5], [-1.0, -2.0, 0.0, 0.0, 4.0], "mirrored");
        assert_eq!(of(4)[..5], [0.5, -1.0, 0.0, 0.0, 2.0], "half the size");
        assert_eq!(of(4)[8..], [2.0, 3.0, 4.0, 5.0], "one octave coarser");
        let turned = of(12);
        let angle = |motion: &[f32]| motion[1].atan2(motion[0]);
        assert!((angle(&turned) - angle(&of(0)) - core::f32::consts::FRAC_PI_8).abs() < 1e-5);
    }

    #[test]
    fn a_patch_with_too_little_fluid_is_left_out() {
        let patch = |x| PatchRef { video: 0, version: Version::new(0).unwrap(), x, y: 0 };
        let left = field(|point| point % 40 < 20);
        assert!(cells(&left, patch(0), 160, 120).is_some(), "half of it");
        assert!(cells(&left, patch(16), 160, 120).is_none(), "a sixth of it");
    }
}
