//! Growing a tree: every word of the IFS, from the trunk to the twigs.

use super::{
    space::{AffineMap, Axis, BITS, Matrix, ONE, Vector, times},
    species::Species,
    text::Number,
};
use crate::math::{Turns, random::scatter};

/// A piece of wood, tapered, slightly bent.
#[derive(Clone, Copy, Debug)]
pub(super) struct Branch {
    pub(super) from: Vector,
    pub(super) to: Vector,
    /// How far its middle lies beside the straight line.
    pub(super) bend: Vector,
    /// Its radius at either end.
    pub(super) radii: [i32; 2],
    /// How many branchings it is away from the trunk.
    pub(super) order: u32,
    /// How much wood of the same bough lies before it.
    pub(super) start: i32,
    /// Shared by the pieces of a bough.
    pub(super) key: u64,
}

/// The end of a word: where leaves hang.
#[derive(Clone, Copy, Debug)]
pub(super) struct Twig {
    /// Its address, a number of M digits.
    pub(super) number: usize,
    pub(super) map: AffineMap,
    pub(super) key: u64,
}

/// A leaf of a twig.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leaf {
    pub(super) place: Vector,
    /// Half the side of its stencil.
    pub(super) half: i32,
    pub(super) key: u64,
}

/// What looks at a tree while it grows.
pub(super) trait Visit {
    /// A piece of wood.
    fn branch(&mut self, _: &Branch) {}
    /// The end of a twig.
    fn twig(&mut self, twig: &Twig);
}

/// Grows the tree of `species`; the same `seed` grows the same tree.
pub(super) fn grow(species: &Species, seed: u64, visit: &mut impl Visit) {
    let root = Twig { number: 0, map: AffineMap::IDENTITY, key: scatter(seed) };
    // Half the width, in steps of 2^-24.
    let radius = species.width.to_bits() << (BITS - Number::FRAC_NBITS - 1);
    fork(species, &root, radius, 0, visit);
}

fn fork(species: &Species, at: &Twig, radius: i32, order: u32, visit: &mut impl Visit) {
    if order == species.depth {
        return visit.twig(at);
    }
    let thin = ((i64::from(radius) << Number::FRAC_NBITS) / i64::from(species.taper.to_bits())) as i32;
    let pieces = species.rule.wood.len() as i32;
    let mut start = 0;
    for (piece, wood) in species.rule.wood.iter().enumerate() {
        let key = scatter(at.key ^ 0x00d0 ^ (piece as u64) << 32);
        let radius_at = |end: i32| radius - (radius - thin) * end / pieces;
        let (from, to) = (at.map.apply(wood.from), at.map.apply(wood.to));
        visit.branch(&Branch {
            from,
            to,
            bend: bend(species, from, to, key),
            radii: [radius_at(piece as i32), radius_at(piece as i32 + 1)],
            order,
            start,
            key: at.key,
        });
        start += length(core::array::from_fn(|i| to[i] - from[i]));
    }
    for symbol in 0..species.rule.boughs.len() {
        let key = scatter(at.key ^ (symbol as u64 + 1));
        let map = at.map.after(&strayed(species, symbol, key));
        let number = at.number * species.rule.boughs.len() + symbol;
        fork(species, &Twig { number, map, key }, thin, order + 1, visit);
    }
}

/// A share of `most` between −1 and 1, by 16 bits of `key`.
pub(super) fn sway_of(key: u64, most: i32) -> i32 {
    (((i64::from(key as u16) - (1 << 15)) * i64::from(most)) >> 15) as i32
}

/// A long piece of wood is bent to a side, by a tenth of its length where forks stray by 11°.
fn bend(species: &Species, from: Vector, to: Vector, key: u64) -> Vector {
    let length = (0..3).map(|i| (to[i] - from[i]).abs()).max().unwrap_or(0);
    let most = (i64::from(length) * i64::from(species.stray.to_bits()) / (110 << 16)) as i32;
    let flat = species.rule.is_flat;
    [sway_of(key, most), sway_of(key >> 16, most) / 3, if flat { 0 } else { sway_of(key >> 32, most) }]
}

/// The map of a bough, turned a little within its own orientation, and up to an eighth shorter. It stays contracting. The last bough of a
/// rule goes on with the trunk, and strays least.
fn strayed(species: &Species, symbol: usize, key: u64) -> AffineMap {
    let bough = &species.rule.boughs[symbol];
    if species.stray == 0 {
        return *bough;
    }
    let is_trunk = symbol + 1 == species.rule.boughs.len();
    let degrees = species.stray.to_bits() / if is_trunk { 3 } else { 1 };
    let most = ((i64::from(degrees) << 16) / 360) as i32;
    let angle = |bits: u64| Turns(sway_of(bits, most) as u32);
    let turned = match species.rule.is_flat {
        true => Matrix::rotation(Axis::Viewer, angle(key)),
        false => Matrix::rotation(Axis::Heading, Turns(angle(key).0.wrapping_mul(2)))
            .after(&Matrix::rotation(Axis::Right, angle(key >> 16)))
            .after(&Matrix::rotation(Axis::Viewer, angle(key >> 32))),
    };
    let scale = ONE - ONE / 16 + sway_of(key >> 48, ONE / 16);
    AffineMap { matrix: bough.matrix.after(&turned.scaled(scale)), shift: bough.shift }
}

/// How far leaves lie around the end of their twig, in lengths of it. With 1 they hide each other, and the crown shows gaps.
const SPREAD: i32 = 2 * ONE;

impl Twig {
    /// Its leaves, around its end.
    pub(super) fn leaves(&self, species: &Species) -> impl Iterator<Item = Leaf> {
        let (twig, flat) = (*self, species.rule.is_flat);
        let size = species.size.to_bits() << (BITS - Number::FRAC_NBITS - 1);
        let length = length(twig.map.matrix.0[1]);
        (0..u64::from(species.leaves)).map(move |leaf| {
            let key = scatter(twig.key ^ 0x1eaf ^ leaf << 32);
            // The sum of two even spreads is near enough to a bell.
            let spread = |bits: u64| sway_of(bits, ONE / 2) + sway_of(scatter(bits), ONE / 2);
            let offset = [spread(key), spread(key >> 16), if flat { 0 } else { spread(key >> 32) }]
                .map(|x| times(x, SPREAD));
            // 0.7 to 1.2.
            let scale = ONE * 19 / 20 + sway_of(key >> 40, ONE / 4);
            Leaf { place: twig.map.apply(offset), half: times(times(length, size), scale), key: scatter(key) }
        })
    }
}

/// The length of a vector.
fn length(vector: Vector) -> i32 {
    let square: u64 = vector.iter().map(|&x| (i64::from(x) * i64::from(x)) as u64).sum();
    square.isqrt() as i32
}
