//! How much sun comes through to a leaf: the accumulated sunlight mask (the paper's fig. 5).
//!
//! L = exp(−0.055·n), n the leaves between the sun and the place, counted in columns along the sun's rays. The figure 0.055 is for
//! the 12,288 leaves of the maple; of trees with more leaves each weighs less.

use super::{
    grow::{Twig, Visit},
    plates::decay,
    space::{Vector, times},
    species::Species,
    storage::ADDRESSES,
    view::View,
};
use crate::effect::shimmer::Light;

const SIDE: usize = 32;
const LAYERS: usize = 64;
const _: () = assert!(SIDE * SIDE * LAYERS == ADDRESSES);

/// What a leaf of 12,288 takes of the light: 0.055 in steps of 2^-16.
const ABSORBED: u64 = 3_604;
const USUAL_LEAVES: u64 = 12_288;

/// The leaves of a tree, counted in columns along the rays of the sun.
pub(super) struct Columns<'a> {
    counts: &'a mut [u32],
    species: &'a Species,
    view: View,
    /// Across the rays, and towards the sun.
    axes: [Vector; 3],
}

impl<'a> Columns<'a> {
    pub(super) fn new(counts: &'a mut [u32], species: &'a Species, view: View, sun: Light) -> Self {
        counts.fill(0);
        let one = |angle: crate::math::Factor| angle.to_bits() >> 4;
        let (up, level) = (one(sun.elevation.sin()), one(sun.elevation.cos()));
        let (sin, cos) = (one(sun.azimuth.sin()), one(sun.azimuth.cos()));
        let axes = [
            [cos, -sin, 0],
            [times(-up, sin), times(-up, cos), level],
            [times(level, sin), times(level, cos), up],
        ];
        Self { counts, species, view, axes }
    }

    /// The column and the layer of a place, numbered; the next layer towards the sun has the next number.
    fn number(&self, [x, y, z]: Vector) -> usize {
        let place = [x, y - self.view.middle, z];
        let reach = i64::from(self.view.reach);
        let along = |axis: Vector, cells: usize| {
            let at: i64 = (0..3).map(|i| i64::from(times(axis[i], place[i]))).sum();
            ((at + reach) * cells as i64 / (2 * reach)).clamp(0, cells as i64 - 1) as usize
        };
        (along(self.axes[0], SIDE) * SIDE + along(self.axes[1], SIDE)) * LAYERS + along(self.axes[2], LAYERS)
    }

    /// After all leaves were counted: of every place, the leaves above it.
    pub(super) fn add_up(&mut self) {
        for column in self.counts.chunks_exact_mut(LAYERS) {
            let mut above = 0;
            for count in column.iter_mut().rev() {
                above += core::mem::replace(count, above);
            }
        }
    }

    /// L at a place, 255 being all light.
    pub(super) fn light(&self, place: Vector) -> u8 {
        let leaves = self.species.twigs() as u64 * u64::from(self.species.leaves);
        let above = u64::from(self.counts[self.number(place)]);
        ((decay((above * ABSORBED * USUAL_LEAVES / leaves.max(1)).min(u32::MAX.into()) as u32) * 255) >> 16)
            as u8
    }
}

impl Visit for Columns<'_> {
    fn twig(&mut self, twig: &Twig) {
        for leaf in twig.leaves(self.species) {
            let number = self.number(leaf.place);
            self.counts[number] += 1;
        }
    }
}

/// All light, everywhere.
pub(super) const NO_SHADE: u8 = 255;
