//! Which parts of the reference photo the symbols stand for.
//!
//! Symbol k stands for a window g_k of a quarter of the reference's sides. In the literal mode they tile it; in the tonal modes they are chosen so that
//! their mean lumas are evenly spread, from the darkest place of the reference to its lightest, and so a picture's tones are kept.

use super::{
    address::SYMBOLS,
    texture::{SIDE, Texel},
};
use crate::frame::pack::Level;

/// A place in the reference: both coordinates in parts of 2^16 of its sides. What lies beyond an edge is its mirror image.
pub(super) type Place = [i32; 2];

/// One side of the reference.
pub(super) const UNIT: i32 = 1 << 16;

/// The middles of the windows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Windows(pub(super) [Place; SYMBOLS]);

impl Windows {
    /// Four by four tiles.
    pub(super) fn tiles() -> Self {
        let middle = |i: usize| UNIT / 8 + UNIT / 4 * i as i32;
        Self(core::array::from_fn(|k| [middle(k % 4), middle(k / 4)]))
    }

    /// Those whose lumas are evenly spread once they are moved by `shifts`; of the windows `before` those are kept that are nearly as good.
    pub(super) fn tonal(summary: &Summary, shifts: &Self, before: Option<&Self>) -> Self {
        let lumas = || (0..CANDIDATES * CANDIDATES).map(|i| i32::from(summary.at(candidate(i)).luma));
        let (darkest, lightest) = (lumas().min().unwrap_or(0), lumas().max().unwrap_or(0));
        let mut windows = Self::tiles();
        let mut overlaps = [0; CANDIDATES * CANDIDATES];
        // From both ends to the middle: the darkest and the lightest are the rarest.
        for step in 0..SYMBOLS {
            let k = if step % 2 == 0 { step / 2 } else { SYMBOLS - 1 - step / 2 };
            let wanted = darkest + (lightest - darkest) * (2 * k as i32 + 1) / (2 * SYMBOLS as i32);
            let cost = |i: usize| {
                let place = candidate(i);
                let found = summary.at([place[0] + shifts.0[k][0], place[1] + shifts.0[k][1]]);
                let kept = before.is_some_and(|before| before.0[k] == place);
                TONE * (i32::from(found.luma) - wanted).abs() - i32::from(found.saturation) * SATURATION / 2
                    + overlaps[i] * OVERLAP
                    - if kept { KEPT } else { 0 }
            };
            let best = (0..CANDIDATES * CANDIDATES).min_by_key(|&i| cost(i)).map(candidate);
            windows.0[k] = best.unwrap_or(windows.0[k]);
            for (i, sum) in overlaps.iter_mut().enumerate() {
                *sum += overlap(candidate(i), windows.0[k]);
            }
        }
        windows
    }
}

/// Candidates along a side.
const CANDIDATES: usize = 11;

/// The middle of candidate `i`: from edge to edge, a window lies within the reference.
const fn candidate(i: usize) -> Place {
    const fn along(i: usize) -> i32 {
        UNIT / 8 + (UNIT * 3 / 4) * i as i32 / (CANDIDATES as i32 - 1)
    }
    [along(i % CANDIDATES), along(i / CANDIDATES)]
}

// Weights of a window's faults, in 1/64 level of luma: a level of wrong tone, of saturation, a sixteenth of overlap, and what a change costs. A
// window that covers another is worth 12 levels of wrong tone, a colourful one in place of a grey one about as much.
const TONE: i32 = 4;
const SATURATION: i32 = 1;
const OVERLAP: i32 = 160;
const KEPT: i32 = 256;

/// How much of a window another covers, in sixteenths.
fn overlap(a: Place, b: Place) -> i32 {
    let along = |i: usize| (UNIT / 4 - (a[i] - b[i]).abs()).max(0) >> 12;
    along(0) * along(1) / 16
}

/// The mean over a window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Mean {
    /// In levels.
    pub(super) luma: Level,
    /// The largest channel less the smallest, in levels.
    pub(super) saturation: Level,
}

/// Means of windows whose middles lie on a grid of [`GRID`] places a side.
#[derive(Clone, Debug)]
pub(super) struct Summary([[Mean; GRID]; GRID]);

const GRID: usize = 32;

impl Summary {
    pub(super) fn new(texels: &[Texel]) -> Self {
        let mut grid = [[Mean::default(); GRID]; GRID];
        for (y, row) in grid.iter_mut().enumerate() {
            for (x, mean) in row.iter_mut().enumerate() {
                *mean = window_mean(texels, (2 * x + 1) as i32 * UNIT / 64, (2 * y + 1) as i32 * UNIT / 64);
            }
        }
        Self(grid)
    }

    /// The mean of the window around the nearest place of the grid.
    pub(super) fn at(&self, place: Place) -> Mean {
        let [x, y] = place.map(|at| folded(at) as usize * GRID / UNIT as usize);
        self.0[y][x]
    }
}

/// Where a coordinate is found once the mirror images are folded in: 0..2^16.
#[inline(always)]
pub(super) const fn folded(at: i32) -> u16 {
    // The bit of the mirror images turns all those below it over.
    (at ^ (at << 15 >> 31)) as u16
}

/// Every fourth texel of a window.
fn window_mean(texels: &[Texel], x: i32, y: i32) -> Mean {
    const SAMPLES: i32 = 16;
    let (mut luma, mut saturation) = (0, 0);
    for v in 0..SAMPLES {
        for u in 0..SAMPLES {
            let at = |middle: i32, i: i32| {
                folded(middle + (2 * i + 1 - SAMPLES) * UNIT / 8 / SAMPLES) as usize * SIDE / UNIT as usize
            };
            let texel = texels[at(y, v) * SIDE + at(x, u)];
            let [r, g, b] = texel.channels();
            luma += u32::from(texel.luma());
            saturation += u32::from(r.max(g).max(b) - r.min(g).min(b));
        }
    }
    let mean = |sum: u32| (sum / (SAMPLES * SAMPLES) as u32) as Level;
    Mean { luma: mean(luma), saturation: mean(saturation) }
}
