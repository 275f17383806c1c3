//! A blur of the luma by a tent, the box of a radius twice, at a cost that does not depend on the radius.
//!
//! With D = 2·radius + 1 the tent's sum T(x) = Σ (D − |d|)·f(x + d), |d| < D, has a second difference of three terms,
//! f(x + D) − 2·f(x) + f(x − D): two running sums give it, down all columns at once and then along a row, without a plane in between
//! (Heckbert, "Filtering by repeated integration", 1986). Edges are repeated.

use super::storage::{Blocks, Words};
use crate::math::lanes::LANES;

/// A tent that runs down the columns.
pub(super) struct Tent<'a> {
    /// Of each box, D.
    side: usize,
    /// The row that comes next.
    y: usize,
    /// T(y) of each column, and T(y) − T(y − 1).
    sums: &'a mut [i32],
    slopes: &'a mut [i32],
    mean: Mean,
}

impl<'a> Tent<'a> {
    /// A tent of boxes of `radius`, 1 or more, at the first row.
    #[inline(always)]
    pub(super) fn start(radius: usize, blocks: &Blocks<'_>, [sums, slopes]: [&'a mut [i32]; 2]) -> Self {
        let side = 2 * radius + 1;
        let mean = Mean::of(side * side);
        // So far above the picture, all that the tent reaches is the first row.
        let first = blocks.row(0).iter().map(|block| block.words(Words::Luma));
        for (sum, luma) in sums.as_chunks_mut::<LANES>().0.iter_mut().zip(first) {
            for (sum, &luma) in sum.iter_mut().zip(luma) {
                *sum = ((side * side) as i32).wrapping_mul(luma.into());
            }
        }
        slopes.fill(0);
        let mut tent = Self { side, y: 0, sums, slopes, mean };
        for ahead in 1..side {
            tent.step(blocks, ahead.min(blocks.size.height as usize - 1), 0, 0, |_, _| ());
        }
        tent
    }

    /// Blurs the next row into `out`. `row` and `sums` are scratch.
    #[inline(always)]
    pub(super) fn next_row(
        &mut self,
        blocks: &Blocks<'_>,
        row: &mut [i16],
        sums: &mut [i32],
        out: &mut [i16],
    ) {
        let (side, y, last, mean) = (self.side, self.y, blocks.size.height as usize - 1, self.mean);
        // What was made of the columns begins in `row` after a margin of as much as the tent reaches.
        let inside = row[side..].as_chunks_mut::<LANES>().0;
        self.step(blocks, (y + side).min(last), y, y.saturating_sub(side), |i, sums| {
            mean.of_sums(sums, &mut inside[i]);
        });
        self.y += 1;
        let width = blocks.size.width as usize;
        let (first, end) = (row[side], row[side + width - 1]);
        row[..side].fill(first);
        row[side + width..][..side].fill(end);
        along_row(side, &row[..width + 2 * side], &mut sums[..width]);
        let blocks_of_sums = sums[..blocks.row(0).len() * LANES].as_chunks().0;
        for (out, sums) in out.as_chunks_mut().0.iter_mut().zip(blocks_of_sums) {
            mean.of_sums(sums, out);
        }
    }

    /// Hands out the sums of a row block by block, and goes on to the next: its three terms are the rows `ahead`, `at` and `behind`.
    #[inline(always)]
    fn step(
        &mut self,
        blocks: &Blocks<'_>,
        ahead: usize,
        at: usize,
        behind: usize,
        mut take: impl FnMut(usize, &[i32; LANES]),
    ) {
        let rows = blocks.row(ahead).iter().zip(blocks.row(at)).zip(blocks.row(behind));
        let running = self.sums.as_chunks_mut().0.iter_mut().zip(self.slopes.as_chunks_mut::<LANES>().0);
        for (i, ((sums, slopes), ((ahead, at), behind))) in running.zip(rows).enumerate() {
            take(i, sums);
            let (ahead, at, behind) =
                (ahead.words(Words::Luma), at.words(Words::Luma), behind.words(Words::Luma));
            // In and out as a whole: then it is a matter of vectors.
            let (mut sum, mut slope) = (*sums, *slopes);
            for lane in 0..LANES {
                slope[lane] += i32::from(ahead[lane]) - 2 * i32::from(at[lane]) + i32::from(behind[lane]);
                sum[lane] = sum[lane].wrapping_add(slope[lane]);
            }
            (*sums, *slopes) = (sum, slope);
        }
    }
}

/// The tent's sums along a row that has margins of `side` pixels.
#[inline(always)]
fn along_row(side: usize, row: &[i16], sums: &mut [i32]) {
    let width = sums.len();
    let (behind, here, ahead) = (&row[..width], &row[side..][..width], &row[2 * side..][..width]);
    for (sum, ((&behind, &here), &ahead)) in sums.iter_mut().zip(behind.iter().zip(here).zip(ahead)) {
        *sum = i32::from(ahead) - 2 * i32::from(here) + i32::from(behind);
    }
    // T(0) and T(0) − T(−1).
    let (mut total, mut slope) = (0_i32, 0);
    for d in 0..side {
        let [left, right] = [row[1 + d], row[2 * side - 1 - d]].map(i32::from);
        let both = if d + 1 < side { left + right } else { left };
        total = total.wrapping_add((d as i32 + 1).wrapping_mul(both));
        slope += i32::from(row[side + d]) - i32::from(row[d]);
    }
    for sum in sums {
        slope += core::mem::replace(sum, total);
        total = total.wrapping_add(slope);
    }
}

/// Division of a tent's sums by its weight.
#[derive(Clone, Copy)]
struct Mean {
    reciprocal: u32,
    shift: u32,
}

impl Mean {
    /// The weight is odd, and 9 or more.
    fn of(weight: usize) -> Self {
        let shift = 32 + weight.ilog2();
        Self { reciprocal: ((1_u64 << shift) / weight as u64) as u32 + 1, shift }
    }

    /// The quotients, rounded to nearest. Sums of the largest tents take all of 32 bits.
    #[inline(always)]
    fn of_sums(self, sums: &[i32; LANES], out: &mut [i16; LANES]) {
        for (out, &sum) in out.iter_mut().zip(sums) {
            let product = u64::from(sum as u32) * u64::from(self.reciprocal);
            *out = ((product + (1 << (self.shift - 1))) >> self.shift) as i16;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::storage::{Planes, storage_len},
        *,
    };
    use crate::frame::Size;
    use proptest::prelude::*;

    /// The twin: the tent by its definition, edges repeated, the columns first.
    fn by_definition(luma: &[i16], width: usize, radius: usize) -> Vec<f64> {
        let side = 2 * radius as isize + 1;
        let along = |plane: &[f64], step: usize, count: usize, at: usize, i: usize| -> f64 {
            let terms = (1 - side..side).map(|d| {
                let place = (at as isize + d).clamp(0, count as isize - 1);
                (side - d.abs()) as f64 * plane[(i as isize + (place - at as isize) * step as isize) as usize]
            });
            terms.sum::<f64>() / (side * side) as f64
        };
        let plane: Vec<f64> = luma.iter().map(|&luma| luma.into()).collect();
        let down: Vec<f64> = (0..plane.len())
            .map(|i| along(&plane, width, plane.len() / width, i / width, i).round())
            .collect();
        (0..plane.len()).map(|i| along(&down, 1, width, i % width, i)).collect()
    }

    proptest! {
        #[test]
        fn every_tent_is_that_of_the_definition(
            width in 1_usize..40, height in 1_usize..30, radius in 1_usize..=4, seed: u64
        ) {
            let luma: Vec<i16> = (0..width * height)
                .map(|i| ((seed.wrapping_mul(i as u64 * 2 + 1) >> 40) % 32_641) as i16)
                .collect();
            let size = Size::new(width as u32, height as u32);
            let mut storage = vec![0; storage_len(size)];
            let Planes { mut blocks, mut scratch, .. } = Planes::carve(size, &mut storage).unwrap();
            let ([down, slopes, sums], [row, out]) = scratch.rows();
            for (y, luma) in luma.chunks(width).enumerate() {
                row[..width].copy_from_slice(luma);
                blocks.write(Words::Luma, y, row);
            }
            let mut tent = Tent::start(radius, &blocks, [down, slopes]);
            for want in by_definition(&luma, width, radius).chunks(width) {
                tent.next_row(&blocks, row, sums, out);
                for (&got, &want) in out.iter().zip(want) {
                    prop_assert!((f64::from(got) - want).abs() < 0.51, "{} for {}", got, want);
                }
            }
        }
    }
}
