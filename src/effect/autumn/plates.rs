//! Stage plates: the seven pictures whose colours the leaves steal.
//!
//! The paper's SIFS cuts a picture into 2×2 tiles, again and again: the tile that belongs to the symbols σ1 σ2 ... is the cell of a
//! quadtree. A plate has five levels, 32×32 cells in the order of a quadtree (Morton's): three for a twig's finest symbols, so
//! that no two neighbouring leaves carry the same print, and two for the leaf's own.
//!
//! Without photos the plates are made from pigments (the formula is ours, in the manner of the paper's references 1 and 8):
//!
//! ```text
//! light = 0.035 + 0.915·exp(−(chlorophyll·e1 + carotenoids·e2 + anthocyanins·e3))
//! ```
//!
//! for red, green and blue, with the local stage = stage + 1.15·sin(π(stage + 1/2)/7)·fBm, so that leaves differ most in mid-season, and
//! anthocyanins that differ by another fBm, so that in the end one leaf is scarlet and another of the colour of wine. The 0.035 is what
//! a leaf's wax reflects of white light: without it summer is as green as paint.

use super::{
    noise::{self, fbm},
    species::Species,
    text::Number,
};
use crate::{frame::srgb, math::Turns};

/// Plates, from green to the last colour.
pub const STAGES: usize = 7;
/// Cells of a side of a plate.
pub const SIDE: usize = 32;
/// Cells of a plate.
pub const CELLS: usize = SIDE * SIDE;

/// Linear light, red, green, blue; 65,535 is full.
pub(super) type Light = [u16; 3];

/// What each pigment takes of red, green and blue.
const ABSORPTION: [[i64; 3]; 3] = [
    [hundredths(155), hundredths(75), hundredths(150)],
    [hundredths(2), hundredths(30), hundredths(320)],
    [hundredths(22), hundredths(230), hundredths(160)],
];

const fn hundredths(hundredths: i64) -> i64 {
    (hundredths << 16) / 100
}

/// A cell's column and row by its number in the order of a quadtree.
pub(super) fn place(cell: usize) -> (usize, usize) {
    let gather = |shift: usize| (0..5).map(|level| (cell >> (2 * level + shift) & 1) << level).sum();
    (gather(0), gather(1))
}

/// Fills `plates`, [`STAGES`] × [`CELLS`], from the pigments of `species`; `spotted`, or each of one colour.
pub(super) fn fill_synthetic(plates: &mut [Light], species: &Species, seed: u64, spotted: bool) {
    for (stage, plate) in plates.chunks_exact_mut(CELLS).enumerate() {
        // sin(π(stage + 1/2)/7) is half a turn over the season.
        let spread = Turns(((stage as u64 * 2 + 1) * (1 << 31) / 14) as u32).sin().to_bits() >> 12;
        for (cell, light) in plate.iter_mut().enumerate() {
            let (x, y) = place(cell);
            // A quarter of a cell of the noise a cell of the plate: two or three spots a leaf, and leaves unlike each other.
            let place = |at: usize| (at as i32) << (noise::BITS - 2);
            let noise = if spotted { i64::from(fbm(place(x), place(y), 3, seed)) } else { 0 };
            let local =
                ((stage as i64) << 16) + hundredths(115) * i64::from(spread) / (1 << 16) * noise / (1 << 15);
            let other = if spotted { i64::from(fbm(place(x), place(y), 2, seed ^ 0x3ed)) } else { 0 };
            let reds = (1 << 16) + hundredths(35) * other / (1 << 15);
            *light = reflected(species, local.clamp(0, 6 << 16) as u32, reds);
        }
    }
}

/// The light that a leaf of `species` gives back at `stage`, which has `reds` times its anthocyanins; both in steps of 2^-16.
fn reflected(species: &Species, stage: u32, reds: i64) -> Light {
    let (index, rest) = ((stage >> 16) as usize, i64::from(stage & 0xffff));
    let mut amounts = species.pigments.map(|row| {
        let [from, to] =
            [index, (index + 1).min(STAGES - 1)].map(|stage: usize| i64::from(Number::to_bits(row[stage])));
        from + (((to - from) * rest) >> 16)
    });
    amounts[2] = (amounts[2] * reds.max(0)) >> 16;
    core::array::from_fn(|channel| {
        let depth: i64 = (0..3).map(|pigment| (amounts[pigment] * ABSORPTION[pigment][channel]) >> 16).sum();
        (u64::from(decay(depth as u32)) * 915 / 1_000 + 65_536 * 35 / 1_000) as u16
    })
}

/// exp(−x), `x` and the result in steps of 2^-16, within 2 steps.
///
/// The product of exp(−2^k) over the bits of x.
pub(super) fn decay(x: u32) -> u32 {
    /// exp(−2^k) for k from −16 to 3, in steps of 2^-32.
    const FACTORS: [u64; 20] = [
        4_294_901_760,
        4_294_836_226,
        4_294_705_160,
        4_294_443_040,
        4_293_918_848,
        4_292_870_656,
        4_290_775_039,
        4_286_586_875,
        4_278_222_805,
        4_261_543_595,
        4_228_380_000,
        4_162_825_044,
        4_034_748_382,
        3_790_295_335,
        3_344_923_893,
        2_605_029_347,
        1_580_030_169,
        581_260_615,
        78_665_070,
        1_440_801,
    ];
    let product = FACTORS.iter().enumerate().filter(|(bit, _)| x >> bit & 1 == 1);
    (product.fold(1 << 32, |product, (_, factor)| (product * factor) >> 32) >> 16) as u32
}

/// Fills `plates` from seven pictures of [`SIDE`] × [`SIDE`] pixels each, row by row, sRGB.
pub(super) fn fill_from_pictures(plates: &mut [Light], pictures: &[[[u8; 3]; CELLS]; STAGES]) {
    for (plate, picture) in plates.chunks_exact_mut(CELLS).zip(pictures) {
        for (cell, light) in plate.iter_mut().enumerate() {
            let (x, y) = place(cell);
            *light = picture[y * SIDE + x].map(srgb::to_linear);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decay_is_the_exponential() {
        for x in (0..16 << 16).step_by(37) {
            let exact = (-f64::from(x) / 65_536.).exp() * 65_536.;
            assert!((f64::from(decay(x)) - exact).abs() < 2., "{x}: {} is {exact}", decay(x));
        }
    }

    #[test]
    fn every_cell_of_a_plate_has_a_number_and_tiles_stay_together() {
        let mut seen = [false; CELLS];
        for cell in 0..CELLS {
            let (x, y) = place(cell);
            assert!(!core::mem::replace(&mut seen[y * SIDE + x], true));
            let (first_x, first_y) = place(cell & !15);
            assert!(x - first_x < 4 && y - first_y < 4, "the cells of one leaf lie in one tile");
        }
    }

    #[test]
    fn pigments_colour_as_the_formula_says() {
        let maple = Species::known("maple").unwrap();
        let exact = |amounts: [f64; 3], channel: usize| {
            let absorbed: f64 =
                (0..3).map(|pigment| amounts[pigment] * ABSORPTION[pigment][channel] as f64 / 65_536.).sum();
            (0.035 + 0.915 * (-absorbed).exp()) * 65_536.
        };
        for (stage, amounts) in [(0, [1.2, 0.55, 0.02]), (3, [0.2, 0.6, 0.03]), (6, [0.02, 0.45, 1.15])] {
            for (channel, light) in reflected(&maple, stage << 16, 1 << 16).into_iter().enumerate() {
                assert!(
                    (f64::from(light) - exact(amounts, channel)).abs() < 8.,
                    "stage {stage} channel {channel}"
                );
            }
        }
    }
}
