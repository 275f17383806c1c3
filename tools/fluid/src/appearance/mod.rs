//! How patches look: descriptors on a grid, and the vocabulary that makes words of them (the paper, section 4).
//!
//! A descriptor stands at every [`SPACING`] pixels of a picture; a patch owns those at its 9 by 9 [places](crate::features::PLACES), the
//! outermost of which lie on its border and look at what is beyond it. Departures: places that show nothing have a word of their own.

pub mod descriptor;
pub mod view;
pub mod vocabulary;

use crate::{
    features::{PLACES, WordMap},
    label::Grid,
    patch::{SIDE, STRIDE},
    plane::Plane,
};
use descriptor::{Descriptors, SPACING};
use vocabulary::Vocabulary;

/// Places of a patch across, and down.
const ACROSS: usize = SIDE / SPACING + 1;

const _: () = assert!(ACROSS * ACROSS == PLACES && STRIDE.is_multiple_of(SPACING));

/// The words of a still picture's patches, row by row: one map for each patch of `grid`, which begins in the upper left corner. What of
/// a patch lies beyond the picture continues the picture's border.
///
/// About 0.1 s for 640 × 360 pixels on one core.
pub fn describe(luma: &Plane, grid: Grid, vocabulary: &Vocabulary) -> Vec<WordMap> {
    let covered = |patches: usize| patches.saturating_sub(1) * STRIDE + SIDE;
    let plane = extended(luma, covered(grid.columns), covered(grid.rows));
    let corners = (0..grid.rows).flat_map(|row| (0..grid.columns).map(move |column| (column, row)));
    let step = STRIDE / SPACING;
    describe_at(&plane, corners.map(|(column, row)| (column * step, row * step)), vocabulary)
}

/// The words of patches whose first places are at these columns and rows of places. They lie on the picture.
pub fn describe_at(
    luma: &Plane,
    corners: impl Iterator<Item = (usize, usize)>,
    vocabulary: &Vocabulary,
) -> Vec<WordMap> {
    let descriptors = Descriptors::of(luma);
    // Patches share places, and places without a patch need no word.
    let mut words: Vec<Option<u8>> = vec![None; descriptors.values.len()];
    corners
        .map(|(left, top)| {
            core::array::from_fn(|place| {
                let index = (top + place / ACROSS) * descriptors.columns + left + place % ACROSS;
                *words[index].get_or_insert_with(|| vocabulary.word(&descriptors.values[index]))
            })
        })
        .collect()
}

/// The upper left part of a picture, continued where it is too small.
fn extended(luma: &Plane, width: usize, height: usize) -> Plane {
    let mut plane = Plane::new(width, height);
    for (y, row) in plane.values.chunks_exact_mut(width).enumerate() {
        let source = luma.row(y.min(luma.height - 1));
        for (x, value) in row.iter_mut().enumerate() {
            *value = source[x.min(luma.width - 1)];
        }
    }
    plane
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::features::WORDS;

    /// Stripes on the left, checks on the right, nothing below.
    fn picture() -> Plane {
        let mut plane = Plane::new(150, 100);
        for y in 0..70 {
            for x in 0..150 {
                let lit = if x < 75 { x / 4 % 2 == 0 } else { (x / 5 + y / 5) % 2 == 0 };
                plane.values[y * 150 + x] = if lit { 180.0 } else { 60.0 };
            }
        }
        plane
    }

    #[test]
    fn a_patch_is_described_wherever_the_grid_puts_it() {
        let plane = picture();
        let descriptors = Descriptors::of(&plane);
        let vocabulary = Vocabulary::train(&descriptors.values);
        let grid = Grid { columns: 6, rows: 4 };
        let maps = describe(&plane, grid, &vocabulary);
        assert_eq!(maps.len(), 24);
        // The same picture two strides further on.
        let mut moved = Plane::new(102, 100);
        for y in 0..100 {
            moved.values[y * 102..][..102].copy_from_slice(&plane.row(y)[48..]);
        }
        let again = describe(&moved, Grid { columns: 4, rows: 4 }, &vocabulary);
        let inner = |map: &WordMap| {
            (0..PLACES).filter(|place| place % 9 > 2).map(|place| map[place]).collect::<Vec<_>>()
        };
        assert_eq!(
            inner(&again[0]),
            inner(&maps[2]),
            "what is left of the border is seen by the first places alone"
        );
        assert!(maps[18..].iter().all(|map| map[5 * 9..].iter().all(|word| usize::from(*word) == WORDS - 1)));
    }
}
