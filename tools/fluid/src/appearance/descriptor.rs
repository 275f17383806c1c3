//! Descriptors on a dense grid.
//!
//! Lowe 2004, section 6: histograms of 8 gradient orientations in 4 by 4 bins, normalised, cut at 0.2 and normalised again, as bytes.
//! Departs: 1) upright and of one size, on a grid (Lazebnik and others 2006, as the paper does); 2) no Gaussian window, whose effect on
//! a grid is small; 3) a descriptor of hardly any gradient is all zeros.

use crate::plane::Plane;
use rayon::prelude::*;

/// Pixels from one descriptor to the next, across and down.
pub const SPACING: usize = 6;

/// A normalised descriptor: 4 by 4 bins, row by row, of 8 orientations each. Flat places have zeros only.
pub type Descriptor = [u8; 128];

/// Pixels of a bin: a descriptor looks at 16 by 16 pixels, and at 4 more with falling weight.
const BIN: usize = 4;

/// Orientations of the gradient.
const ORIENTATIONS: usize = 8;

/// Weights of the 8 pixels around the centre of a bin: a tent that is one at the centre and zero at the centres of the next bins.
const TENT: [f32; 2 * BIN] = [0.125, 0.375, 0.625, 0.875, 0.875, 0.625, 0.375, 0.125];

/// Mean gradient, in levels a pixel, under which a place counts as flat: what is left of codec noise after denoising stays below it.
const FLAT: f32 = 1.0;

/// Largest share of one entry in the length of a descriptor, against the glare of one edge (Lowe).
const CUT: f32 = 0.2;

/// The length of a descriptor as bytes. Entries of more than 255 are rare and are cut.
const LENGTH: f32 = 512.0;

/// How far the first bin's centre lies before the descriptor's: one and a half bins.
const REACH: usize = BIN + BIN / 2;

/// Bin centres lie on every second pixel border.
const STEP: usize = 2;

const _: () = assert!(SPACING.is_multiple_of(STEP) && BIN.is_multiple_of(STEP) && REACH.is_multiple_of(STEP));

type Histogram = [f32; ORIENTATIONS];

/// The descriptors of a picture.
#[derive(Clone, Debug)]
pub struct Descriptors {
    /// Descriptors of a row.
    pub columns: usize,
    /// Rows of them.
    pub rows: usize,
    /// Row by row; the one of column i and row j is centred on the pixel border [`SPACING`]·i, [`SPACING`]·j.
    pub values: Vec<Descriptor>,
}

impl Descriptors {
    /// Describes a picture from its upper left corner on.
    pub fn of(luma: &Plane) -> Self {
        let bins = Bins::of(luma);
        let (columns, rows) = (luma.width / SPACING + 1, luma.height / SPACING + 1);
        let mut values = vec![[0; 128]; columns * rows];
        for (row, line) in values.chunks_exact_mut(columns).enumerate() {
            for (column, descriptor) in line.iter_mut().enumerate() {
                *descriptor = bins.descriptor(column, row);
            }
        }
        Self { columns, rows, values }
    }
}

/// Orientation histograms of a tent's weight around every second pixel border, from [`REACH`] before the picture to [`REACH`] after it.
struct Bins {
    columns: usize,
    values: Vec<Histogram>,
}

impl Bins {
    fn of(luma: &Plane) -> Self {
        let columns = (luma.width + 2 * REACH) / STEP + 1;
        let rows = (luma.height + 2 * REACH) / STEP + 1;
        // First along the rows, then down.
        let mut narrow = vec![[0.0; ORIENTATIONS]; columns * luma.height];
        narrow.par_chunks_mut(columns).enumerate().for_each_init(
            || vec![[0.0; ORIENTATIONS]; luma.width],
            |gradients, (y, line)| {
                orient(luma, y, gradients);
                for (column, bin) in line.iter_mut().enumerate() {
                    gather(bin, column, luma.width, |x| &gradients[x]);
                }
            },
        );
        let mut values = vec![[0.0; ORIENTATIONS]; columns * rows];
        values.par_chunks_mut(columns).enumerate().for_each(|(row, line)| {
            for (column, bin) in line.iter_mut().enumerate() {
                gather(bin, row, luma.height, |y| &narrow[y * columns + column]);
            }
        });
        Self { columns, values }
    }

    fn descriptor(&self, column: usize, row: usize) -> Descriptor {
        let mut entries = [0.0; 128];
        for (index, bin) in entries.chunks_exact_mut(ORIENTATIONS).enumerate() {
            let (x, y) = (column * SPACING + index % 4 * BIN, row * SPACING + index / 4 * BIN);
            bin.copy_from_slice(&self.values[y / STEP * self.columns + x / STEP]);
        }
        // Each of the 16 bins weighs as much as 16 pixels.
        let mean_gradient = entries.iter().sum::<f32>() / 256.0;
        if mean_gradient < FLAT { [0; 128] } else { normalised(&mut entries) }
    }
}

/// The gradient of row `y`, shared between the two nearest orientations.
fn orient(luma: &Plane, y: usize, gradients: &mut [Histogram]) {
    let (above, row, below) =
        (luma.row(y.saturating_sub(1)), luma.row(y), luma.row((y + 1).min(luma.height - 1)));
    for (x, histogram) in gradients.iter_mut().enumerate() {
        let right = row[(x + 1).min(luma.width - 1)] - row[x.saturating_sub(1)];
        let down = below[x] - above[x];
        let turn = down.atan2(right) / core::f32::consts::TAU;
        let place = (turn + 1.0).fract() * ORIENTATIONS as f32;
        let first = place as usize % ORIENTATIONS;
        let share = place.fract();
        // A central difference spans two pixels.
        let magnitude = right.hypot(down) / 2.0;
        *histogram = [0.0; ORIENTATIONS];
        histogram[first] = magnitude * (1.0 - share);
        histogram[(first + 1) % ORIENTATIONS] = magnitude * share;
    }
}

/// Sums the histograms under the tent of bin number `bin`.
fn gather<'a>(sum: &mut Histogram, bin: usize, length: usize, at: impl Fn(usize) -> &'a Histogram) {
    for (tap, weight) in TENT.iter().enumerate() {
        let Some(place) = (bin * STEP + tap).checked_sub(REACH + BIN) else { continue };
        if place < length {
            for (sum, value) in sum.iter_mut().zip(at(place)) {
                *sum += weight * value;
            }
        }
    }
}

fn normalised(entries: &mut [f32; 128]) -> Descriptor {
    let length = |entries: &[f32; 128]| entries.iter().map(|entry| entry * entry).sum::<f32>().sqrt();
    let most = CUT * length(entries);
    for entry in entries.iter_mut() {
        *entry = entry.min(most);
    }
    let scale = LENGTH / length(entries);
    entries.map(|entry| (entry * scale + 0.5) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(width: usize, height: usize, value: impl Fn(f32, f32) -> f32) -> Plane {
        let mut plane = Plane::new(width, height);
        for y in 0..height {
            for x in 0..width {
                plane.values[y * width + x] = value(x as f32, y as f32);
            }
        }
        plane
    }

    #[test]
    fn a_flat_picture_has_flat_descriptors() {
        let descriptors = Descriptors::of(&plane(60, 48, |x, _| 100.0 + 0.4 * x));
        assert_eq!((descriptors.columns, descriptors.rows), (11, 9));
        assert!(descriptors.values.iter().all(|descriptor| *descriptor == [0; 128]));
    }

    #[test]
    fn a_slope_has_the_orientation_that_it_rises_in() {
        for (orientation, (dx, dy)) in [(0, (1.0, 0.0)), (2, (0.0, 1.0)), (4, (-1.0, 0.0)), (6, (0.0, -1.0))]
        {
            let descriptors = Descriptors::of(&plane(60, 60, |x, y| 128.0 + 2.0 * (dx * x + dy * y)));
            let middle = descriptors.values[5 * descriptors.columns + 5];
            for bin in middle.chunks_exact(8) {
                // 16 bins share the length of 512.
                assert_eq!(bin[orientation], 128, "{middle:?}");
                assert_eq!(bin.iter().map(|entry| u32::from(*entry)).sum::<u32>(), 128);
            }
        }
    }

    #[test]
    fn contrast_and_brightness_change_nothing() {
        let texture = |x: f32, y: f32| (0.7 * x + 0.2 * y).sin() + (0.5 * y - 0.1 * x).cos();
        let one = Descriptors::of(&plane(96, 72, |x, y| 100.0 + 20.0 * texture(x, y)));
        let two = Descriptors::of(&plane(96, 72, |x, y| 60.0 + 10.0 * texture(x, y)));
        for (one, two) in one.values.iter().zip(&two.values) {
            assert!(one.iter().zip(two).all(|(one, two)| one.abs_diff(*two) <= 1));
        }
    }
}
