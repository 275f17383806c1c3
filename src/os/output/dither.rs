//! A dither that stands still: what a pixel becomes depends on its colour and its place alone, never on its neighbours or on
//! the time.
//!
//! For each colour a mix of palette entries is found as in T. Knoll's pattern dithering (US patent 6,606,166, expired 2019),
//! and a mask of blue noise says which entry of the mix a place takes. Departs: the error carried from entry to entry is
//! limited, and the mask is blue noise instead of a Bayer matrix, whose grid shows in skies.

use super::palette::{self, Colour};
use crate::math::random::Rng;
use rand::{Rng as _, SeedableRng as _};

/// Entries of a mix: finer steps than 1/16 between two entries are less than a level, as the entries of a photo's palette lie
/// about 10 levels apart.
const MIX: usize = 16;

/// How many levels of error are carried from entry to entry at most. Without a limit, colours that the palette cannot mix become
/// specks of its extremes. On a photo of a brook, 64 levels make a pixel err by 4.9 levels on average, 16 by 4.2 and 8 by 3.9,
/// while the means of 4×4 pixels err by 1.3 to 1.4 with each.
const CARRIED_ERROR: i32 = 8;

/// A colour that differs by more than so many levels from every entry in some channel comes up in later frames only. It needs more
/// carried error, or it would become its nearest entry: greens that turn to reds then err by 3 levels on average, not by 29.
const FAR: i32 = 20;
const FAR_CARRIED_ERROR: i32 = 128;

/// Bits of each channel that name a cell of colours with the same mix. The bits below are dithered too.
const CELL_BITS: u32 = 6;

/// The side of the mask in pixels. It is repeated over the picture; no repeat can be seen in skies.
const MASK_SIDE: usize = 64;

/// Turns colours into palette entries.
pub(super) struct Dither {
    colours: Vec<Colour>,
    /// The mix for each cell of colours, found when the colour first comes up, darkest entry first.
    mixes: Vec<Option<[u8; MIX]>>,
    mask: Vec<u16>,
}

impl Dither {
    /// A dither to the palette `colours`.
    pub(super) fn new(colours: Vec<Colour>) -> Self {
        Self { colours, mixes: vec![None; 1 << (3 * CELL_BITS)], mask: blue_noise() }
    }

    /// The entries that stand for the pixels `rgb`, in rows of `width`.
    pub(super) fn apply(&mut self, rgb: &[u8], width: u32, indices: &mut Vec<u8>) {
        indices.clear();
        for (y, row) in rgb.chunks_exact(width as usize * 3).enumerate() {
            let start = y % MASK_SIDE * MASK_SIDE;
            for (x, pixel) in row.as_chunks::<3>().0.iter().enumerate() {
                let threshold = usize::from(self.mask[start + x % MASK_SIDE]);
                indices.push(self.entry(*pixel, threshold));
            }
        }
    }

    /// The entry for `pixel` at a place with `threshold`, 0..4096.
    fn entry(&mut self, pixel: Colour, threshold: usize) -> u8 {
        const STEPS: usize = MASK_SIDE * MASK_SIDE;
        // The high digits choose from the mix; the digits below choose between two cells, so that the two choices are independent.
        let chosen = threshold * MIX / STEPS;
        let low = (threshold * MIX % STEPS) as u32 >> (4 + CELL_BITS);
        let cell = pixel.map(|level| ((u32::from(level) + low) >> (8 - CELL_BITS)).min((1 << CELL_BITS) - 1));
        let at = cell.iter().fold(0, |at, level| at << CELL_BITS | *level as usize);
        let colours = &self.colours;
        let mix = self.mixes[at]
            .get_or_insert_with(|| mix(colours, cell.map(|level| (level << (8 - CELL_BITS)) as i32)));
        mix[chosen]
    }
}

/// The palette entries whose mean is nearest to `goal`, darkest first.
fn mix(colours: &[Colour], goal: [i32; 3]) -> [u8; MIX] {
    let missed =
        |entry: usize| -> [i32; 3] { std::array::from_fn(|c| goal[c] - i32::from(colours[entry][c])) };
    // A colour far from every entry, as only a later frame can have it, must reach entries on its other side.
    let farthest =
        missed(palette::nearest(colours, goal)).map(i32::abs).into_iter().max().unwrap_or_default();
    let limit = if farthest > FAR { FAR_CARRIED_ERROR } else { CARRIED_ERROR };
    let mut error = [0; 3];
    let mut mix = [0; MIX];
    for entry in &mut mix {
        let nearest = palette::nearest(colours, std::array::from_fn(|c| goal[c] + error[c]));
        let missed = missed(nearest);
        error = std::array::from_fn(|c| (error[c] + missed[c]).clamp(-limit, limit));
        *entry = nearest as u8;
    }
    mix.sort_by_key(|entry| luma(colours[usize::from(*entry)]));
    mix
}

/// Brightness in thousandths of a level, weighted as in BT.601.
fn luma([r, g, b]: Colour) -> u32 {
    299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b)
}

/// A mask of the ranks 0..4096, each once, such that the ranks below any limit lie evenly, without a pattern.
///
/// Ulichney 1993, "The void-and-cluster method for dither array generation", reduced to its last phase: each rank goes to the
/// largest void, the place where the sum of Gaussians around the earlier ones is least. Departs: a little noise in the sums
/// instead of a random start breaks the symmetry. 4096 searches of 4096 places: a few milliseconds.
fn blue_noise() -> Vec<u16> {
    /// Ulichney's width of the Gaussian, in pixels.
    const SIGMA: f64 = 1.5;
    /// The weight of a place itself; its square root is the noise.
    const PEAK: u32 = 1 << 24;
    let place = |x: usize, y: usize| y % MASK_SIDE * MASK_SIDE + x % MASK_SIDE;
    let reach = 3 * SIGMA.ceil() as usize;
    let gaussian = |dx: usize, dy: usize| {
        let squared = (dx.abs_diff(reach).pow(2) + dy.abs_diff(reach).pow(2)) as f64;
        (f64::from(PEAK) * (-squared / (2.0 * SIGMA * SIGMA)).exp()) as u32
    };
    let mut rng = Rng::seed_from_u64(1);
    let mut energy: Vec<u32> = (0..MASK_SIDE * MASK_SIDE).map(|_| rng.next_u32() >> 20).collect();
    let mut mask = vec![0; energy.len()];
    for rank in 0..energy.len() {
        let void = (0..energy.len()).min_by_key(|i| energy[*i]).unwrap_or_default();
        mask[void] = rank as u16;
        for (dx, dy) in (0..=2 * reach).flat_map(|dy| (0..=2 * reach).map(move |dx| (dx, dy))) {
            let (x, y) =
                (void % MASK_SIDE + MASK_SIDE + dx - reach, void / MASK_SIDE + MASK_SIDE + dy - reach);
            let around = &mut energy[place(x, y)];
            *around = around.saturating_add(gaussian(dx, dy));
        }
        energy[void] = u32::MAX;
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mask_has_each_rank_once_and_spreads_the_first_ones() {
        let mask = blue_noise();
        let mut ranks = mask.clone();
        ranks.sort_unstable();
        assert!(ranks.iter().enumerate().all(|(i, rank)| i == usize::from(*rank)));
        // 256 places, one for each square of 4 × 4: none of them touch.
        let early = |x: usize, y: usize| mask[y % MASK_SIDE * MASK_SIDE + x % MASK_SIDE] < 256;
        for (x, y) in
            (0..MASK_SIDE).flat_map(|y| (0..MASK_SIDE).map(move |x| (x, y))).filter(|(x, y)| early(*x, *y))
        {
            assert!(!early(x + 1, y) && !early(x, y + 1) && !early(x + 1, y + 1), "neighbours at {x}, {y}");
        }
    }

    #[test]
    fn an_even_area_keeps_its_colour_on_average() {
        let side = MASK_SIDE;
        // Entries about 12 levels apart, as in a photo's palette, and colours off them.
        let colours: Vec<Colour> =
            (0..216_u8).map(|i| [i % 6, i / 6 % 6, i / 36].map(|step| 90 + 12 * step)).collect();
        let mut dither = Dither::new(colours.clone());
        for colour in [[95, 100, 105], [101, 131, 143], [120, 113, 97]] {
            let mut indices = Vec::new();
            dither.apply(&colour.repeat(side * side), side as u32, &mut indices);
            for c in 0..3 {
                let sum: u32 = indices.iter().map(|i| u32::from(colours[usize::from(*i)][c])).sum();
                let mean = f64::from(sum) / (side * side) as f64;
                assert!((mean - f64::from(colour[c])).abs() < 1.0, "{colour:?}, channel {c}: {mean}");
            }
        }
    }
}
