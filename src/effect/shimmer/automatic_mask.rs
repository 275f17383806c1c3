//! The automatic mask: what of a single photo plausibly moves in a breeze or flows.
//!
//! A rule made by hand, not a trained classifier; it knows colour, texture and place, and no thing by name. On a grid of at
//! most 320 × 320 cells, whatever the panel:
//!
//! 1. *Features* (`features.rs`), all box means: colour; fine and coarse texture of the luma; coherence and direction of the
//!    gradients (structure tensor, Förstner and Gülch 1987); how far they fall into two directions at right angles (their
//!    fourth harmonic); how dark the surround is; and the sky, grown from the upper edge over smooth cells that are not green.
//! 2. *The rule* (`rule.rs`): a cell is as likely to move as the likeliest of six things, each a product of soft conditions.
//!    Foliage is green with some texture. Dry grass, twigs and fur are yellowish brown with much texture; autumn leaves are
//!    saturated red to yellow with texture; neither may be built (right angles), outlined (one direction) or woven. Water is
//!    blue with texture, or grey with level streaks, and below if there is sky above. Falls and spray are pale or blue with
//!    upright streaks. Flame is red to yellow, or white at its core, where much around is dark. Nothing else moves: skin and
//!    walls are smooth, sky is sky, stone and snow are grey and without streaks.
//! 3. *Gathering*: gaps inside what moves close, and specks with little of their kind around them go.
//! 4. *Edges* (`refine.rs`): a guided filter with the photo's luma as its guide, computed on the grid and applied at full size,
//!    then a contrast curve so that most pixels are plainly still or plainly moving.
//!
//! Where it fails: grey stone with streaks, and blue far mountains without sky above them, pass for water; blue clothes with
//! folds and the rims of clouds for spray; brown rough ground, rough wood and hair for dry grass; orange things in dark rooms
//! for flames. Smooth petals, autumn leaves out of focus, smoke, grey fur, muddy water and the smooth core of a fall are
//! missed; trunks and sky within a crown move with it. Paint a mask for those.

mod features;
mod grid;
mod refine;
mod rule;

use crate::frame::Size;
use features::Features;
use grid::{BoxFilter, Grid};
use refine::Coefficients;

/// See [`moving_per_mille`]: a fiftieth of the picture.
pub const HARDLY_ANYTHING_PER_MILLE: u32 = 20;

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
/// The cost is that of the grid and two passes over the pixels: 24 ms at 1920×1080, 62 ms at 3840×2160 (one core of an
/// x86-64 server, optimised, 2026-11).
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

/// Gaps are closed by the mean over 13 × 13 cells, a twenty-fifth of the longest side.
const GAP_RADIUS: usize = 6;
/// Specks are what is less than [`SPECK_NONE`] of 255 over 25 × 25 cells; [`SPECK_FULL`] keeps a lone
/// candle's flame.
const SPECK_RADIUS: usize = 12;
const SPECK_NONE: i32 = 20;
const SPECK_FULL: i32 = 60;

/// Smooths the score and damps what has little of its kind around it: specks go, holes in a crown close.
fn gather(filter: &mut BoxFilter<'_>, score: &mut [i32], support: &mut [i32]) {
    filter.mean_in_place(score, 1);
    filter.mean(score, GAP_RADIUS, support);
    for (score, support) in score.iter_mut().zip(&*support) {
        *score = (*score).max((*score + *support) / 2);
    }
    filter.mean(score, SPECK_RADIUS, support);
    for (score, support) in score.iter_mut().zip(&*support) {
        *score =
            *score * (*support - SPECK_NONE).clamp(0, SPECK_FULL - SPECK_NONE) / (SPECK_FULL - SPECK_NONE);
    }
}

/// The share of the picture that moves, in thousandths: the mean of `mask`. Under [`HARDLY_ANYTHING_PER_MILLE`] the photo
/// has next to nothing for an effect to move, and the caller does well to say so.
pub fn moving_per_mille(mask: &[u8]) -> u32 {
    let sum: u64 = mask.iter().map(|&m| u64::from(m)).sum();
    (sum * 1000 / (mask.len().max(1) as u64 * 255)) as u32
}
