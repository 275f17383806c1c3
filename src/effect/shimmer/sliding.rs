//! The maximum over a square window around every pixel. At the edges the window is cut off.
//!
//! Along a row by doubling: the maxima of 2, 4, 8 … pixels, then of two such runs that overlap. That takes the logarithm of the window in
//! comparisons, 16 pixels in each. Down the columns, where whole rows are compared anyway, by van Herk (1992), Gil and Werman (1993): the
//! rows are cut into bands as high as the window; with a maximum running from each band's start (prefix) and one running from its
//! end (suffix), the maximum of any window is that of one suffix and one prefix.

use super::storage::{Blocks, Scratch, Words};
use crate::math::lanes::LANES;

/// Less than any height.
const NONE: i16 = i16::MIN;

/// Replaces every pixel of `plane` by the maximum over the window of `radius`, at most [`super::storage::margin`], around it. `suffix` is
/// scratch.
#[inline(always)]
pub(super) fn maximum(
    radius: usize,
    blocks: &mut Blocks<'_>,
    plane: Words,
    suffix: Words,
    scratch: &mut Scratch<'_>,
) {
    let (_, [row, mut here, mut there]) = scratch.rows::<0, 3>();
    let width = blocks.size.width as usize;
    for y in 0..blocks.size.height as usize {
        blocks.read(plane, y, row);
        along_row(radius, &mut row[..width], &mut here, &mut there);
        blocks.write(plane, y, row);
    }
    along_columns(radius, blocks, plane, suffix, row);
}

/// `here` and `there` are scratch, `radius` longer than `row` at both ends.
#[inline(always)]
fn along_row<'a>(radius: usize, row: &mut [i16], here: &mut &'a mut [i16], there: &mut &'a mut [i16]) {
    let (width, window) = (row.len(), 2 * radius + 1);
    here[..radius].fill(NONE);
    here[radius..][..width].copy_from_slice(row);
    here[radius + width..][..radius].fill(NONE);
    let mut run = 1;
    while 2 * run <= window {
        // Where two runs still fit.
        let count = width + window - 2 * run;
        larger(&here[..count], &here[run..][..count], &mut there[..count]);
        core::mem::swap(here, there);
        run *= 2;
    }
    larger(&here[..width], &here[window - run..][..width], row);
}

#[inline(always)]
fn larger(a: &[i16], b: &[i16], out: &mut [i16]) {
    out.iter_mut().zip(a).zip(b).for_each(|((out, &a), &b)| *out = a.max(b));
}

// Positions are shifted by the radius, so that none is negative: window i covers the shifted positions i..=i + 2·radius, and
// shifted position j is row j − radius where there is one. A band starts where j is a multiple of the window.

#[inline(always)]
fn along_columns(radius: usize, blocks: &mut Blocks<'_>, plane: Words, suffix: Words, running: &mut [i16]) {
    let (height, window) = (blocks.size.height as usize, 2 * radius + 1);
    let end = height + 2 * radius;
    for start in (0..end).step_by(window) {
        let band = start..(start + window).min(end);
        running.fill(NONE);
        for j in band.clone().rev() {
            take(radius, blocks, plane, j, running);
            if j < height {
                blocks.write(suffix, j, running);
            }
        }
        running.fill(NONE);
        for j in band {
            take(radius, blocks, plane, j, running);
            // Row j − 2·radius was taken long before.
            if let Some(y) = j.checked_sub(2 * radius) {
                let heads = running.as_chunks::<LANES>().0;
                for (head, block) in heads.iter().zip(blocks.row_mut(y)) {
                    let tail = block.words[suffix as usize];
                    larger(head, &tail, &mut block.words[plane as usize]);
                }
            }
        }
    }
}

/// Takes shifted position `j` into the running maximum.
#[inline(always)]
fn take(radius: usize, blocks: &Blocks<'_>, plane: Words, j: usize, running: &mut [i16]) {
    if let Some(y) = j.checked_sub(radius).filter(|&y| y < blocks.size.height as usize) {
        for (running, block) in running.as_chunks_mut::<LANES>().0.iter_mut().zip(blocks.row(y)) {
            let highest = *running;
            larger(&highest, block.words(plane), running);
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

    proptest! {
        #[test]
        fn every_window_is_that_of_the_definition(
            width in 1_usize..40, height in 1_usize..30, radius in 0_usize..10, seed: u64
        ) {
            let mut plane: Vec<i16> = (0..width * height)
                .map(|i| (seed.wrapping_mul(i as u64 * 2 + 1) >> 40) as i16)
                .collect();
            let naive: Vec<i16> = (0..width * height).map(|i| {
                let (x, y) = (i % width, i / width);
                let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
                let columns = x.saturating_sub(radius)..(x + radius + 1).min(width);
                rows.flat_map(|y| columns.clone().map(move |x| (x, y))).map(|(x, y)| plane[y * width + x]).max().unwrap()
            }).collect();
            let size = Size::new(width as u32, height as u32);
            let mut storage = vec![0; storage_len(size)];
            let Planes { mut blocks, mut scratch, .. } = Planes::carve(size, &mut storage).unwrap();
            let mut padded = vec![0; width.next_multiple_of(LANES)];
            for (y, row) in plane.chunks(width).enumerate() {
                padded[..width].copy_from_slice(row);
                blocks.write(Words::Luma, y, &padded);
            }
            maximum(radius, &mut blocks, Words::Luma, Words::SineU, &mut scratch);
            for (y, row) in plane.chunks_mut(width).enumerate() {
                blocks.read(Words::Luma, y, &mut padded);
                row.copy_from_slice(&padded[..width]);
            }
            prop_assert_eq!(plane, naive);
        }
    }
}
