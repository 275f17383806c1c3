//! The automatic mask: what of a single photo plausibly moves in a breeze or flows.
//!
//! (rule to be described)

mod features;
mod grid;
mod refine;
mod rule;

use crate::frame::Size;
use features::Features;
use grid::{BoxFilter, Grid};
use refine::Coefficients;

/// Planes of the grid in the lent memory: the features, the score, the filter's rows, and two at work.
const PLANES: usize = features::PLANES + 4;

/// Words of scratch memory that [`automatic_mask`] needs for a photo of `size`: 15 a cell and 3 a column of its grid of at
/// most 320 × 320 cells, so at most 6.2 MB, and 3.5 MB for a panel of 16:9.
pub const fn scratch_len(size: Size) -> usize {
    let grid = Grid::of(size);
    grid.cells() * PLANES + 3 * grid.width
}

/// Writes to `mask` what of the photo moves: 255 moves, 0 stays, soft between. `rgb` is the photo as it is shown, three
/// bytes a pixel in sRGB; `mask` holds a byte a pixel; `scratch` at least [`scratch_len`] words.
///
/// # Panics
/// Where a slice is shorter than `size` asks for.
pub fn automatic_mask(rgb: &[u8], size: Size, scratch: &mut [i32], mask: &mut [u8]) {
    if size.pixels() == 0 {
        return;
    }
    let rgb = &rgb[..size.pixels() * 3];
    let mask = &mut mask[..size.pixels()];
    let grid = Grid::of(size);
    let (planes, row) = scratch[..scratch_len(size)].split_at_mut(grid.cells() * PLANES);
    let mut planes = planes.chunks_exact_mut(grid.cells());
    let mut plane = || planes.next().unwrap_or_default();
    let mut features = Features {
        grid,
        red: plane(),
        green: plane(),
        blue: plane(),
        luma: plane(),
        fine: plane(),
        coarse: plane(),
        coherence: plane(),
        upright: plane(),
        squareness: plane(),
        dark: plane(),
        sky: plane(),
    };
    let (score, rows, a, b) = (plane(), plane(), plane(), plane());
    let (columns, row) = row.split_at_mut(grid.width);
    let mut filter = BoxFilter { grid, rows, columns };

    grid::reduce(rgb, size, grid, [features.red, features.green, features.blue]);
    features.measure(&mut filter, [&mut *a, &mut *b]);
    let sky_share = features.sky_share();
    for (i, score) in score.iter_mut().enumerate() {
        *score = rule::likelihood(&features.cell(i), sky_share).min(255);
    }
    gather(&mut filter, score, a);
    let mut coefficients = Coefficients { slope: features.coarse, offset: features.fine };
    coefficients.fit(features.luma, score, &mut filter, [a, b]);
    coefficients.apply(rgb, size, grid, row, mask);
}

/// Smooths the score and damps what has little of its kind around it: specks go, holes in a crown close.
fn gather(filter: &mut BoxFilter<'_>, score: &mut [i32], support: &mut [i32]) {
    filter.mean_in_place(score, 1);
    filter.mean(score, 6, support);
    for (score, support) in score.iter_mut().zip(&*support) {
        *score = (*score).max((*score + *support) / 2);
    }
    filter.mean(score, 12, support);
    for (score, support) in score.iter_mut().zip(&*support) {
        *score = *score * (*support - 20).clamp(0, 40) / 40;
    }
}

/// The share of the picture that moves, in thousandths: the mean of `mask`.
pub fn moving_per_mille(mask: &[u8]) -> u32 {
    let sum: u64 = mask.iter().map(|&m| u64::from(m)).sum();
    (sum * 1000 / (mask.len().max(1) as u64 * 255)) as u32
}
