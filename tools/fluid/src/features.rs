//! What is known of a patch: how it looks and how it moves.

use crate::patch::PatchRef;

/// Places of a patch where a descriptor is taken: a grid of 9 by 9.
pub const PLACES: usize = 81;

/// Words of the vocabulary, and one more for places that show nothing.
pub const WORDS: usize = 201;

/// Cells of a patch in which motion is pooled, across and down: 12 pixels each. An overlap of neighbours is two of them wide.
pub const CELLS: usize = 4;

/// Numbers a cell: the signed mean of u and of v; 6 bands of the spectrum of u + iv over time; 4 levels of the Laplacian pyramid.
pub const CHANNELS: usize = 12;

/// The visual words of a patch, row by row: 0..[`WORDS`].
pub type WordMap = [u8; PLACES];

/// The features of one patch of the database.
#[derive(Clone, Debug, PartialEq)]
pub struct Features {
    /// Which patch.
    pub patch: PatchRef,
    /// Its words in the mean of the frames, and in one sharp frame.
    pub words: [WordMap; 2],
    /// Standard deviation of the luminance of a frame, in levels.
    pub contrast: f32,
    /// Motion and texture of every cell, row by row. u and v in pixels a frame; magnitudes of the spectrum in the same unit; the pyramid in
    /// levels.
    pub motion: [[f32; CHANNELS]; CELLS * CELLS],
}
