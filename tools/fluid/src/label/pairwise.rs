//! What two patches of the database cost beside each other: W of the paper (eq. 2, 3, 6) and a mended form of it.
//!
//! M̂_1 -> channels 0 and 1, M̂_f -> channels 2..8, T -> channels 8..12, pooled in cells instead of pixels. σ and ρ -> each of the three
//! parts is divided by its standard deviation over all labels, as the paper gives neither. Departures of [`Pairwise::Relative`]: 1) the
//! mean motion has its sign, where the paper's power takes up for down; 2) the squared difference is divided by what both are, since by
//! itself it prefers patches in which nothing happens.

use super::candidates::Candidate;
use crate::features::{CELLS, CHANNELS, Features};

/// Which form is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Pairwise {
    /// |a − b|² / (|a|² + |b|² + c): how unlike they are for what they are.
    #[default]
    Relative,
    /// |a − b|² of powers, as the paper prints it.
    Literal,
}

/// c: two patches that hardly move may differ in how they do so. A part's variance is 1.
const FLOOR: f32 = 0.05;

/// The overlap of two neighbours is half of the cells.
const LENGTH: usize = CELLS * CELLS / 2 * CHANNELS;

/// Labels of the second node that are compared at once.
const LANES: usize = 16;

/// Where one patch lies from another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    Right,
    Below,
}

/// The numbers of two patches where they overlap.
type Overlap = [f32; LENGTH];

/// Compares patches.
pub(super) struct Comparison<'a> {
    features: &'a [Features],
    form: Pairwise,
    /// What every channel is multiplied by.
    scales: [f32; CHANNELS],
}

/// The channels of the three parts: mean motion, spectrum, texture.
const PARTS: [std::ops::Range<usize>; 3] = [0..2, 2..8, 8..CHANNELS];

impl<'a> Comparison<'a> {
    /// Weighs the parts by the variance that they have over these labels.
    pub(super) fn new(features: &'a [Features], form: Pairwise, lists: &[Vec<Candidate>]) -> Self {
        let mut patches: Vec<_> = lists.iter().flatten().map(|candidate| candidate.patch).collect();
        patches.sort_unstable();
        patches.dedup();
        let (mut sums, mut squares) = ([0.0f64; CHANNELS], [0.0f64; CHANNELS]);
        let cells = || patches.iter().flat_map(|&patch| &features[patch as usize].motion);
        for cell in cells() {
            for (channel, value) in form.channels(cell).into_iter().enumerate() {
                sums[channel] += f64::from(value);
                squares[channel] += f64::from(value) * f64::from(value);
            }
        }
        let count = (patches.len() * CELLS * CELLS).max(1) as f64;
        let mut scales = [0.0; CHANNELS];
        for part in PARTS {
            let variance: f64 =
                part.clone().map(|c| (squares[c] / count - (sums[c] / count).powi(2)).max(0.0)).sum();
            // A part that is the same everywhere says nothing.
            let scale =
                if variance > 0.0 { (variance * (CELLS * CELLS / 2) as f64).sqrt().recip() } else { 0.0 };
            scales[part].fill(scale as f32);
        }
        Self { features, form, scales }
    }

    /// A row for each label of the first patch, a column for each of the one beside it. O(labels² · 96).
    pub(super) fn table(&self, first: &[Candidate], second: &[Candidate], side: Side) -> Vec<f32> {
        let rows: Vec<_> = first.iter().map(|candidate| self.overlap(candidate.patch, side, true)).collect();
        let columns: Vec<_> =
            second.iter().map(|candidate| self.overlap(candidate.patch, side, false)).collect();
        let squares: Vec<_> = columns.iter().map(square).collect();
        let tiles: Vec<_> = columns.chunks(LANES).map(transposed).collect();
        let mut table = Vec::with_capacity(rows.len() * columns.len());
        for row in &rows {
            let own = square(row);
            for (tile, squares) in tiles.iter().zip(squares.chunks(LANES)) {
                let dots = dots(row, tile);
                table.extend(squares.iter().zip(dots).map(|(&square, dot)| self.cost(own, square, dot)));
            }
        }
        table
    }

    fn cost(&self, a: f32, b: f32, dot: f32) -> f32 {
        let difference = (a + b - 2.0 * dot).max(0.0);
        match self.form {
            Pairwise::Relative => difference / (a + b + FLOOR),
            Pairwise::Literal => difference,
        }
    }

    /// The cells of a patch that the other lies on: the right or lower half of the first, the left or upper half of the second.
    fn overlap(&self, patch: u32, side: Side, first: bool) -> Overlap {
        let motion = &self.features[patch as usize].motion;
        let start = if first { CELLS / 2 } else { 0 };
        let mut out = [0.0; LENGTH];
        for (index, out) in out.chunks_exact_mut(CHANNELS).enumerate() {
            let cell = match side {
                Side::Right => index / (CELLS / 2) * CELLS + start + index % (CELLS / 2),
                Side::Below => start * CELLS + index,
            };
            let channels = self.form.channels(&motion[cell]);
            out.iter_mut()
                .zip(channels)
                .zip(self.scales)
                .for_each(|((out, value), scale)| *out = value * scale);
        }
        out
    }
}

impl Pairwise {
    /// The numbers of a cell that are compared.
    fn channels(self, cell: &[f32; CHANNELS]) -> [f32; CHANNELS] {
        match self {
            Self::Relative => *cell,
            Self::Literal => core::array::from_fn(|channel| match channel {
                0 => cell[0] * cell[0] + cell[1] * cell[1],
                1 => 0.0,
                2..8 => cell[channel] * cell[channel],
                _ => cell[channel],
            }),
        }
    }
}

/// |a|², in the order of [`dots`], so that the difference of equal patches is exactly 0.
fn square(a: &Overlap) -> f32 {
    a.iter().fold(0.0, |sum, value| sum + value * value)
}

/// Up to [`LANES`] patches, number by number.
fn transposed(patches: &[Overlap]) -> Vec<[f32; LANES]> {
    let number =
        |index: usize| core::array::from_fn(|lane| patches.get(lane).map_or(0.0, |patch| patch[index]));
    (0..LENGTH).map(number).collect()
}

/// The products of one patch with those of a tile.
fn dots(row: &Overlap, tile: &[[f32; LANES]]) -> [f32; LANES] {
    let mut sums = [0.0; LANES];
    for (&value, others) in row.iter().zip(tile) {
        for lane in 0..LANES {
            sums[lane] += value * others[lane];
        }
    }
    sums
}
