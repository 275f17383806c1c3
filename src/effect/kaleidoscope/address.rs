//! Addresses: the itinerary of every pixel through the domains of its ranges.
//!
//! A pixel x of range i is drawn from δ(x) = 2·(d_i + iso_i(x − r_i)), that one from δ(δ(x)), and so on. With a symbol σ(x) of 0..16 a pixel,
//! the address of x is σ(x), σ(δ(x)), σ(δ(δ(x))): the paper's extended IFS address (its section 7), truncated to [`DEPTH`] symbols. One pass
//! A(x) ← σ(x)·A(δ(x)) makes one more symbol right, from any start.

use super::fractal::{Code, Leaf};

/// Symbols.
pub(super) const SYMBOLS: usize = 16;

/// Symbols of an address, the first in the highest bits.
pub(super) const DEPTH: u32 = 3;

/// The number of addresses.
pub(super) const ADDRESSES: usize = SYMBOLS.pow(DEPTH);

/// The symbol of a pixel.
pub(super) enum Symbols<'a> {
    /// That of its range, which `literal` sorts by contrast and brightness.
    Literal(&'a Literal),
    /// That of its level.
    Tonal(&'a Tones),
}

/// Fills `addresses`, as long as the plane of `code`, from the decoded `levels`.
pub(super) fn fill(code: &Code<'_>, symbols: &Symbols<'_>, levels: &[u8], addresses: &mut [u16]) {
    let width = code.plane_size().width as usize;
    addresses.fill(0);
    for _ in 0..DEPTH {
        for &leaf in code.leaves() {
            match symbols {
                Symbols::Literal(literal) => {
                    let symbol = literal.symbol(leaf.contrast(), leaf.brightness());
                    pass(leaf, width, addresses, |_| symbol);
                }
                Symbols::Tonal(tones) => {
                    pass(leaf, width, addresses, |i| tones.symbols[usize::from(levels[i])]);
                }
            }
        }
    }
}

/// A(x) ← σ(x)·A(δ(x)) for the pixels x of a leaf of a plane of `width`.
#[inline(always)]
pub(super) fn pass(leaf: Leaf, width: usize, addresses: &mut [u16], symbol: impl Fn(usize) -> u8) {
    let (x, y, side) = leaf.range();
    // A pixel of the contracted plane at (c, r) begins at 2(c + r·width) in the plane.
    let strides = leaf.strides(width);
    for v in 0..side {
        let mut at = strides.start + v as isize * strides.down;
        let start = (y + v) * width + x;
        for i in start..start + side {
            addresses[i] = u16::from(symbol(i)) << 8 | addresses[2 * at as usize] >> 4;
            at += strides.right;
        }
    }
}

/// The symbol of every level, and what a symbol looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tones {
    pub(super) symbols: [u8; 256],
    /// The mean level of a symbol's pixels.
    pub(super) levels: [u8; SYMBOLS],
}

impl Tones {
    /// Of a picture of these levels. A symbol is halfway between how many pixels are darker (a level's rank is that of the middle of its pixels)
    /// and how much darker the darkest is. By rank alone the haze of a sky, which is half of a picture, would be torn into eight
    /// tones that nobody sees in it.
    pub(super) fn new(levels: &[u8]) -> Self {
        let mut counts = [0_u64; 256];
        levels.iter().for_each(|&z| counts[usize::from(z)] += 1);
        let darkest = counts.iter().position(|&count| count > 0).unwrap_or(0) as u64;
        let lightest = counts.iter().rposition(|&count| count > 0).unwrap_or(255) as u64;
        let (total, span) = ((levels.len() as u64).max(1), lightest - darkest + 1);
        let mut darker = 0;
        let mut z = 0;
        let symbols = counts.map(|count| {
            let rank = ((2 * darker + count) << 16) / (2 * total);
            let tone = ((2 * z.clamp(darkest, lightest) + 1 - 2 * darkest) << 16) / (2 * span);
            darker += count;
            z += 1;
            ((SYMBOLS as u64 * (rank + tone)) >> 17).min(SYMBOLS as u64 - 1) as u8
        });
        let mut sums = [(0_u64, 0_u64); SYMBOLS];
        for (z, (&symbol, &count)) in (0_u64..).zip(symbols.iter().zip(&counts)) {
            let (sum, pixels) = &mut sums[usize::from(symbol)];
            (*sum, *pixels) = (*sum + z * count, *pixels + count);
        }
        let mut last = darkest as u8;
        let levels = sums.map(|(sum, pixels)| {
            last = (sum + pixels / 2).checked_div(pixels).map_or(last, |mean| mean as u8);
            last
        });
        Self { symbols, levels }
    }
}

/// The paper's symbols: four classes of the contrast times four of the brightness, each of about as many ranges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Literal {
    contrasts: [i32; 3],
    brightnesses: [i32; 3],
}

impl Literal {
    pub(super) fn new(code: &Code<'_>) -> Self {
        let leaves = code.leaves().iter();
        Self {
            contrasts: quartiles(leaves.clone().map(|leaf| leaf.contrast().into())),
            brightnesses: quartiles(leaves.map(|leaf| leaf.brightness().into())),
        }
    }

    pub(super) fn symbol(&self, contrast: i8, brightness: u8) -> u8 {
        let class =
            |value: i32, limits: &[i32; 3]| limits.iter().filter(|&&limit| value >= limit).count() as u8;
        class(contrast.into(), &self.contrasts) << 2 | class(brightness.into(), &self.brightnesses)
    }
}

/// The least values above a quarter, a half and three quarters of all, which are −128..=127.
fn quartiles(values: impl Iterator<Item = i32>) -> [i32; 3] {
    let mut counts = [0_usize; 256];
    values.for_each(|value| counts[(value + 128) as usize] += 1);
    let total: usize = counts.iter().sum();
    [1, 2, 3].map(|quarter| {
        let mut below = 0;
        let found = counts.iter().position(|&count| {
            below += count;
            below * 4 > total * quarter
        });
        found.map_or(128, |at| at as i32 - 128)
    })
}
