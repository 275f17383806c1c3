//! The guided filter (He, Sun and Tang 2010), in the fast form of He and Sun (2015): its coefficients are found on the
//! reduced grid and applied at full size, so that the mask's edges follow the picture's.

use super::grid::{BoxFilter, Grid};
use crate::frame::Size;

/// Cells: about a hundredth of the picture's longest side.
const RADIUS: usize = 4;
/// Regularisation ε in squared levels: edges of the luma weaker than √ε = 10 levels do not shape the mask.
const EPSILON: i32 = 100;

/// The coefficients of mask ≈ slope · luma + offset for every cell: slope in 4096ths, offset in 16ths of a level.
pub(super) struct Coefficients<'a> {
    pub(super) slope: &'a mut [i32],
    pub(super) offset: &'a mut [i32],
}

impl Coefficients<'_> {
    /// Fits `mask` (0..=255) to `luma` (sixteenths of a level); `a` and `b` are lent.
    pub(super) fn fit(
        &mut self,
        luma: &[i32],
        mask: &[i32],
        filter: &mut BoxFilter<'_>,
        [a, b]: [&mut [i32]; 2],
    ) {
        // Covariances in sixteenths, from luma and mask in levels.
        for i in 0..luma.len() {
            let level = (luma[i] + 8) >> 4;
            a[i] = level * level * 16;
            b[i] = level * mask[i] * 16;
            self.slope[i] = level * 16;
            self.offset[i] = mask[i] * 16;
        }
        for plane in [&mut *a, &mut *b, &mut *self.slope, &mut *self.offset] {
            filter.mean_in_place(plane, RADIUS);
        }
        for i in 0..luma.len() {
            let (mean_luma, mean_mask) = (self.slope[i], self.offset[i]);
            let variance = a[i] - mean_luma * mean_luma / 16;
            let covariance = b[i] - mean_luma * mean_mask / 16;
            let slope = i64::from(covariance) * 4096 / i64::from(variance.max(0) + EPSILON * 16);
            self.slope[i] = slope as i32;
            self.offset[i] = mean_mask - ((slope * i64::from(mean_luma)) >> 12) as i32;
        }
        filter.mean_in_place(self.slope, RADIUS);
        filter.mean_in_place(self.offset, RADIUS);
    }

    /// Writes the mask at full size. `row` is lent, two values a column.
    pub(super) fn apply(&self, rgb: &[u8], size: Size, grid: Grid, row: &mut [i32], mask: &mut [u8]) {
        let (width, height) = (size.width as usize, size.height as usize);
        let (slopes, offsets) = row.split_at_mut(grid.width);
        let rows = rgb.chunks_exact(width * 3).zip(mask.chunks_exact_mut(width));
        for (y, (photo, out)) in rows.enumerate().take(height) {
            let (upper, lower, part) = place(y, height, grid.height);
            for x in 0..grid.width {
                let mix =
                    |plane: &[i32]| lerp(plane[upper * grid.width + x], plane[lower * grid.width + x], part);
                slopes[x] = mix(self.slope);
                offsets[x] = mix(self.offset);
            }
            for (x, (&[r, g, b], out)) in photo.as_chunks::<3>().0.iter().zip(out).enumerate() {
                let (left, right, part) = place(x, width, grid.width);
                let luma = (77 * i32::from(r) + 150 * i32::from(g) + 29 * i32::from(b)) >> 8;
                let slope = lerp(slopes[left], slopes[right], part);
                let offset = lerp(offsets[left], offsets[right], part);
                let raw = (((slope * luma) >> 8) + offset + 8) >> 4;
                *out = settle(raw);
            }
        }
    }
}

/// Scores up to 56 of 255 are still, from 168 on moving: doubt about a region is no half motion.
const STILL: i32 = 56;
const MOVING: i32 = 168;

fn settle(raw: i32) -> u8 {
    ((raw - STILL).clamp(0, MOVING - STILL) * 255 / (MOVING - STILL)) as u8
}

/// The two cells between whose centres the centre of pixel `at` lies, and its place between them in 256ths.
fn place(at: usize, pixels: usize, cells: usize) -> (usize, usize, i32) {
    let twice = ((2 * at + 1) * cells * 256) / pixels; // Twice the cell coordinate, in 256ths.
    let from_centre = (twice / 2).saturating_sub(128);
    let cell = (from_centre >> 8).min(cells - 1);
    (cell, (cell + 1).min(cells - 1), (from_centre & 255) as i32)
}

fn lerp(from: i32, to: i32, part: i32) -> i32 {
    from + (((to - from) * part) >> 8)
}
