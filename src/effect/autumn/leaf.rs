//! The leaf: the attractor of the DIFS, with the address of every point of it.
//!
//! Fractal top function (the paper, eq. 3 to 6): where pieces of the attractor overlap, that of the smallest word is on top. Pieces are
//! painted in descending order of their words.

use super::space::{ONE, PlaneMap};
use bytemuck::{Pod, Zeroable};

/// Cells of a side of a stencil: a leaf on a panel of 4K is about as large.
pub(super) const SIDE: usize = 32;

/// Places of a side of the drawing that a stencil is made from.
const FINE: usize = 4 * SIDE;

/// Words this long end, however large their piece still is.
const LONGEST_WORD: u32 = 10;

/// Symbols of a leaf that are part of an address.
const SYMBOLS: u32 = 2;

/// Nothing of the leaf.
const EMPTY: u8 = 0xff;

/// A cell of a leaf.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub(super) struct Cell {
    /// Its two leaf symbols, 0..16.
    pub(super) address: u8,
    /// How much of it the leaf covers.
    pub(super) cover: u8,
}

/// A leaf in a square, row by row, its tip up.
pub(super) type Stencil = [Cell; SIDE * SIDE];

/// Draws the attractor of `maps` into `stencil`, as large as fits.
pub(super) fn draw(maps: &[PlaneMap], stencil: &mut Stencil) {
    let mut bounds = Bounds { low: [i32::MAX; 2], high: [i32::MIN; 2] };
    // The attractor's extent is known from its points to a hundredth after six symbols.
    pieces(maps, PlaneMap::IDENTITY, 0, 0, 6, &|_| false, &mut |map, _| bounds.include(map.e, map.f));
    let (centre, half) = bounds.square();
    let mut fine = [EMPTY; FINE * FINE];
    let cell = (half / (FINE as i32 / 2)).max(1);
    let is_small = |map: &PlaneMap| {
        let reach = i64::from(map.a.abs().max(map.b.abs()).max(map.c.abs()).max(map.d.abs()));
        reach * i64::from(half) / i64::from(ONE) < i64::from(cell)
    };
    pieces(maps, PlaneMap::IDENTITY, 0, 0, LONGEST_WORD, &is_small, &mut |map, address| {
        let column = (map.e - centre[0] + half) / cell;
        let row = (centre[1] + half - map.f) / cell;
        // Two by two: a piece is about as large as its distance to the next.
        for (x, y) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (column, row) = (column + x, row + y);
            if (0..FINE as i32).contains(&column) && (0..FINE as i32).contains(&row) {
                fine[row as usize * FINE + column as usize] = address;
            }
        }
    });
    shrink(&fine, stencil);
}

/// What the attractor fills.
struct Bounds {
    low: [i32; 2],
    high: [i32; 2],
}

impl Bounds {
    fn include(&mut self, x: i32, y: i32) {
        for (i, at) in [x, y].into_iter().enumerate() {
            self.low[i] = self.low[i].min(at);
            self.high[i] = self.high[i].max(at);
        }
    }

    /// The centre and half the side of the square around it.
    fn square(&self) -> ([i32; 2], i32) {
        let centre = core::array::from_fn(|i| self.low[i].midpoint(self.high[i]));
        let half = (0..2).map(|i| self.high[i] / 2 - self.low[i] / 2).max().unwrap_or(0);
        (centre, half.max(FINE as i32))
    }
}

/// Visits the pieces of the attractor in descending order of their words, with the two leading symbols of each.
fn pieces(
    maps: &[PlaneMap],
    map: PlaneMap,
    length: u32,
    address: u8,
    longest: u32,
    is_small: &impl Fn(&PlaneMap) -> bool,
    visit: &mut impl FnMut(&PlaneMap, u8),
) {
    if length >= longest || (length >= SYMBOLS && is_small(&map)) {
        return visit(&map, address);
    }
    for (symbol, inner) in maps.iter().enumerate().rev() {
        let address = if length < SYMBOLS { address << 2 | symbol as u8 } else { address };
        pieces(maps, map.after(inner), length + 1, address, longest, is_small, visit);
    }
}

/// Each cell is what most of its 16 places are.
fn shrink(fine: &[u8; FINE * FINE], stencil: &mut Stencil) {
    for (at, cell) in stencil.iter_mut().enumerate() {
        let corner = at / SIDE * 4 * FINE + at % SIDE * 4;
        let mut votes = [0_u8; 16];
        for place in (0..16).map(|i| fine[corner + i / 4 * FINE + i % 4]).filter(|&place| place != EMPTY) {
            votes[usize::from(place)] += 1;
        }
        let covered: u8 = votes.iter().sum();
        let address = (0..16).rev().max_by_key(|&address: &u8| votes[usize::from(address)]).unwrap_or(0);
        *cell = Cell { address, cover: (u32::from(covered) * 255 / 16) as u8 };
    }
}

#[cfg(test)]
mod tests {
    use super::{super::species::Species, *};

    /// The address of the smallest word whose piece holds the point, in f64, by asking all pieces.
    fn top(maps: &[PlaneMap], x: f64, y: f64, reach: f64) -> Option<u8> {
        let mut best = None;
        pieces(maps, PlaneMap::IDENTITY, 0, 0, 8, &|_| false, &mut |map, address| {
            let (px, py) = (f64::from(map.e) / f64::from(ONE), f64::from(map.f) / f64::from(ONE));
            if (px - x).abs() < reach && (py - y).abs() < reach {
                best = best.map_or(Some(address), |best: u8| Some(best.min(address)));
            }
        });
        best
    }

    #[test]
    fn every_leaf_fills_a_good_part_of_its_square() {
        for (name, _) in super::super::species::KNOWN {
            let species = Species::known(name).unwrap();
            let mut stencil = [Cell::default(); SIDE * SIDE];
            draw(&species.leaf, &mut stencil);
            let covered = stencil.iter().filter(|cell| cell.cover >= 128).count();
            assert!((60..900).contains(&covered), "{name}: {covered} of {} cells", SIDE * SIDE);
        }
    }

    #[test]
    fn the_smallest_word_is_on_top() {
        let maple = Species::known("maple").unwrap();
        let mut stencil = [Cell::default(); SIDE * SIDE];
        draw(&maple.leaf, &mut stencil);
        let mut bounds = Bounds { low: [i32::MAX; 2], high: [i32::MIN; 2] };
        pieces(&maple.leaf, PlaneMap::IDENTITY, 0, 0, 6, &|_| false, &mut |map, _| {
            bounds.include(map.e, map.f)
        });
        let (centre, half) = bounds.square();
        let [cx, cy, half] = [centre[0], centre[1], half].map(|length| f64::from(length) / f64::from(ONE));
        let (mut same, mut all) = (0, 0);
        for (at, cell) in stencil.iter().enumerate().filter(|(_, cell)| cell.cover == 255) {
            let step = 2. * half / SIDE as f64;
            let x = cx - half + (at % SIDE) as f64 * step + step / 2.;
            let y = cy + half - (at / SIDE) as f64 * step - step / 2.;
            if let Some(want) = top(&maple.leaf, x, y, step / 2.) {
                (same, all) = (same + u32::from(want >> 2 == cell.address >> 2), all + 1);
            }
        }
        assert!(all > 100 && same * 100 >= all * 85, "{same} of {all} cells");
    }
}
