//! The maximum over a square window around every pixel, at a cost that does not depend on the window's size.
//!
//! Van Herk (1992), Gil and Werman (1993): a line is cut into blocks as long as the window; with a maximum running from each
//! block's start (prefix) and one running from its end (suffix), the maximum of any window is that of one suffix and one
//! prefix: three comparisons a pixel and direction. At the edges the window is cut off.

use super::storage::{Block, Blocks, Scratch, Words};
use crate::math::lanes::LANES;

/// Less than any height.
const NONE: i16 = i16::MIN;

/// Replaces every pixel of `plane` by the maximum over the window of `radius` around it. `suffix` is scratch.
#[inline(always)]
pub(super) fn maximum(
    radius: usize,
    blocks: &mut Blocks<'_>,
    plane: Words,
    suffix: Words,
    scratch: &mut Scratch<'_>,
) {
    let ([row, prefixes, suffixes], _) = scratch.rows();
    for y in 0..blocks.size.height as usize {
        blocks.read(plane, y, row);
        along_row(radius, row, prefixes, suffixes);
        blocks.write(plane, y, row);
    }
    along_columns(radius, blocks, plane, suffix, row, prefixes);
}

#[inline(always)]
fn along_row(radius: usize, row: &mut [i16], prefixes: &mut [i16], suffixes: &mut [i16]) {
    let (width, window) = (row.len(), 2 * radius + 1);
    for ((row, prefixes), suffixes) in
        row.chunks(window).zip(prefixes.chunks_mut(window)).zip(suffixes.chunks_mut(window))
    {
        let mut running = NONE;
        for (prefix, &h) in prefixes.iter_mut().zip(row) {
            running = running.max(h);
            *prefix = running;
        }
        running = NONE;
        for (suffix, &h) in suffixes.iter_mut().zip(row).rev() {
            running = running.max(h);
            *suffix = running;
        }
    }
    // The window of x starts in the first block for x < 2·radius + 1, and is cut off at its start for x < radius.
    for x in 0..radius.min(width) {
        row[x] = prefixes[(x + radius).min(width - 1)];
    }
    for (row, (&suffix, &prefix)) in
        row.iter_mut().skip(radius).zip(suffixes.iter().zip(prefixes.iter().skip(2 * radius)))
    {
        *row = suffix.max(prefix);
    }
    // Where it is cut off at its end: the last block, which the window may start in, has no more than what remains.
    let last = (width - 1) / window * window;
    for x in width.saturating_sub(radius).max(radius)..width {
        let suffix = suffixes[x - radius];
        row[x] = if x - radius < last { suffix.max(prefixes[width - 1]) } else { suffix };
    }
}

// Positions are shifted by the radius, so that none is negative: window i covers the shifted positions i..=i + 2·radius, and
// shifted position j is row j − radius where there is one. A block starts where j is a multiple of the window.

#[inline(always)]
fn along_columns(
    radius: usize,
    blocks: &mut Blocks<'_>,
    plane: Words,
    suffix: Words,
    row: &mut [i16],
    running: &mut [i16],
) {
    let (height, window) = (blocks.size.height as usize, 2 * radius + 1);
    let mut take = |running: &mut [i16], blocks: &Blocks<'_>, j: usize, restart: bool| {
        if restart {
            running.fill(NONE);
        }
        if let Some(y) = j.checked_sub(radius).filter(|&y| y < height) {
            blocks.read(plane, y, row);
            running.iter_mut().zip(&*row).for_each(|(max, &h)| *max = h.max(*max));
        }
    };
    for j in (0..height + 2 * radius).rev() {
        take(running, blocks, j, j % window == window - 1 || j == height + 2 * radius - 1);
        if j < height {
            blocks.write(suffix, j, running);
        }
    }
    for j in 0..height + 2 * radius {
        take(running, blocks, j, j % window == 0);
        if let Some(y) = j.checked_sub(2 * radius) {
            let blocks = blocks.row_mut(y).iter_mut();
            for (head, Block { words, .. }) in running.chunks(LANES).zip(blocks) {
                let tail = words[suffix as usize];
                let out = &mut words[plane as usize];
                out.iter_mut().zip(head).zip(tail).for_each(|((out, &head), tail)| *out = head.max(tail));
            }
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
            width in 1_usize..40, height in 1_usize..30, radius in 0_usize..12, seed: u64
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
            for (y, row) in plane.chunks(width).enumerate() {
                blocks.write(Words::Luma, y, row);
            }
            maximum(radius, &mut blocks, Words::Luma, Words::SineU, &mut scratch);
            for (y, row) in plane.chunks_mut(width).enumerate() {
                blocks.read(Words::Luma, y, row);
            }
            prop_assert_eq!(plane, naive);
        }
    }
}
