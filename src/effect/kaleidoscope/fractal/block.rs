//! One range and one domain: the best contrast and brightness, and the error that is left.

use super::{LARGEST, isometry::Strides};

/// The pixels of a square of up to [`LARGEST`] pixels a side, row by row without a gap.
#[derive(Clone, Copy, Debug)]
pub(super) struct Block {
    levels: [u8; LARGEST * LARGEST],
    side: usize,
    pub(super) sum: u32,
    pub(super) square_sum: u32,
}

impl Block {
    /// The pixels that `strides` reads of `plane`.
    pub(super) fn read(plane: &[u8], strides: Strides, side: usize) -> Self {
        let mut levels = [0; LARGEST * LARGEST];
        for (v, row) in levels.chunks_exact_mut(side).take(side).enumerate() {
            let start = strides.start + v as isize * strides.down;
            if strides.right == 1 {
                row.copy_from_slice(&plane[start as usize..][..side]);
            } else {
                for (u, level) in row.iter_mut().enumerate() {
                    *level = plane[(start + u as isize * strides.right) as usize];
                }
            }
        }
        let mut block = Self { levels, side, sum: 0, square_sum: 0 };
        block.sum = block.levels().iter().map(|&z| u32::from(z)).sum();
        block.square_sum = block.levels().iter().map(|&z| u32::from(z) * u32::from(z)).sum();
        block
    }

    /// The square at (x, y) of `plane`.
    pub(super) fn at(plane: &[u8], width: usize, x: usize, y: usize, side: usize) -> Self {
        Self::read(plane, Strides { start: (y * width + x) as isize, right: 1, down: width as isize }, side)
    }

    pub(super) fn levels(&self) -> &[u8] {
        &self.levels[..self.pixels()]
    }

    pub(super) const fn side(&self) -> usize {
        self.side
    }

    const fn pixels(&self) -> usize {
        self.side * self.side
    }

    /// The variance times the square of the number of pixels.
    pub(super) const fn spread(&self) -> u64 {
        self.pixels() as u64 * self.square_sum as u64 - self.sum as u64 * self.sum as u64
    }

    /// The block turned about: pixel (u, v) is what `strides` (of its side, from 0) reads.
    #[cfg(test)]
    pub(super) fn turned(&self, strides: Strides) -> Self {
        Self::read(self.levels(), strides, self.side)
    }
}

/// What describes a range by a domain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Fit {
    /// k, −15..=15.
    pub(super) contrast: i8,
    /// 0..=127.
    pub(super) brightness: u8,
    /// The sum of the squared errors, Q20.
    pub(super) error: u64,
}

/// The largest |k|: below 16 the map contracts.
pub(super) const STEEPEST: i64 = 15;

/// The largest step of the brightness.
const BRIGHTEST: i64 = 127;

/// The brightness of a step, Q10: evenly spread over what k levels of a domain leave possible, −255·s..=255 for s > 0 and
/// 0..=255·(1 + |s|) else (Fisher's).
pub(super) const fn brightness_q10(contrast: i8, step: u8) -> i32 {
    let k = contrast as i32;
    let span = 255 * 64 * (16 + k.abs());
    let least = if k > 0 { -255 * 64 * k } else { 0 };
    (span * step as i32 + BRIGHTEST as i32 / 2) / BRIGHTEST as i32 + least
}

impl Fit {
    /// The contrast that is nearest to the best one, and the brightness with which `domain` is nearest to `range` then.
    pub(super) fn new(range: &Block, domain: &Block) -> Self {
        let sums = Sums::new(range, domain);
        sums.fit(sums.contrast())
    }

    /// As [`Fit::new`], but of the contrasts next to that the one whose steps of brightness, up to four levels apart, suit best. A domain that is of use
    /// stays so.
    pub(super) fn finest(range: &Block, domain: &Block) -> Self {
        let sums = Sums::new(range, domain);
        let k = sums.contrast();
        let others = [k - 1, k + 1].into_iter().filter(|other| other.abs() <= STEEPEST && *other != 0);
        others
            .map(|k| sums.fit(k))
            .fold(sums.fit(k), |best, fit| if fit.error < best.error { fit } else { best })
    }
}

/// What is summed up of a range and a domain: the pixels, and the levels of each, their squares and their products.
struct Sums {
    n: i64,
    r: i64,
    rr: i64,
    d: i64,
    dd: i64,
    rd: i64,
}

impl Sums {
    fn new(range: &Block, domain: &Block) -> Self {
        let n = range.pixels() as i64;
        let product: u32 =
            range.levels().iter().zip(domain.levels()).map(|(&r, &d)| u32::from(r) * u32::from(d)).sum();
        let [r, rr, d, dd, rd] =
            [range.sum, range.square_sum, domain.sum, domain.square_sum, product].map(i64::from);
        Self { n, r, rr, d, dd, rd }
    }

    /// k of the least error, rounded.
    const fn contrast(&self) -> i64 {
        let Self { n, r, d, dd, rd, .. } = *self;
        let (covariance, variance) = (n * rd - r * d, n * dd - d * d);
        if variance == 0 {
            return 0;
        }
        let k = div_rounded(16 * covariance, variance);
        if k > STEEPEST {
            STEEPEST
        } else if k < -STEEPEST {
            -STEEPEST
        } else {
            k
        }
    }

    /// With the best brightness for k.
    fn fit(&self, k: i64) -> Fit {
        let Self { n, r, rr, d, dd, rd } = *self;
        // n times the best brightness in Q4, and the step next to it.
        let ideal = 16 * r - k * d;
        let span = 255 * (16 + k.abs());
        let least = if k > 0 { -255 * k } else { 0 };
        let step = div_rounded((ideal - least * n) * BRIGHTEST, span * n).clamp(0, BRIGHTEST);
        let (contrast, brightness) = (k as i8, step as u8);
        let (s, o) = (k * 64, i64::from(brightness_q10(contrast, brightness)));
        let error = (rr << 20) - ((s * rd + o * r) << 11) + s * s * dd + 2 * s * o * d + n * o * o;
        Fit { contrast, brightness, error: error as u64 }
    }
}

/// The quotient rounded to nearest, halves up.
const fn div_rounded(dividend: i64, divisor: i64) -> i64 {
    (2 * dividend + divisor).div_euclid(2 * divisor)
}
