//! The maximum over a square window around every pixel, at a cost that does not depend on the window's size.
//!
//! Van Herk (1992), Gil and Werman (1993): a line is cut into blocks as long as the window; with a maximum running from each
//! block's start (prefix) and one running from its end (suffix), the maximum of any window is that of one suffix and one
//! prefix: three comparisons a pixel and direction. At the edges the window is cut off.

/// Less than any height.
const NONE: i16 = i16::MIN;

/// Replaces every pixel of `plane` by the maximum over the window of `radius` around it. Scratch: `suffix`, as long as the plane,
/// and `running`, as long as a row.
pub(super) fn maximum(radius: usize, plane: &mut [i16], suffix: &mut [i16], running: &mut [i16]) {
    for row in plane.chunks_exact_mut(running.len()) {
        along_row(radius, row, suffix);
    }
    along_columns(radius, plane, suffix, running);
}

// Positions are shifted by the radius, so that none is negative: window i covers the shifted positions i..=i + 2·radius, and
// shifted position j is pixel j − radius where there is one. A block starts where j is a multiple of the window.

fn along_row(radius: usize, row: &mut [i16], suffix: &mut [i16]) {
    let (width, window) = (row.len(), 2 * radius + 1);
    let pixel =
        |row: &[i16], j: usize| j.checked_sub(radius).and_then(|x| row.get(x)).copied().unwrap_or(NONE);
    let mut running = NONE;
    for j in (0..width + 2 * radius).rev() {
        let before = if j % window == window - 1 { NONE } else { running };
        running = before.max(pixel(row, j));
        if j < width {
            suffix[j] = running;
        }
    }
    for j in 0..width + 2 * radius {
        let before = if j % window == 0 { NONE } else { running };
        running = before.max(pixel(row, j));
        if let Some(x) = j.checked_sub(2 * radius) {
            row[x] = running.max(suffix[x]);
        }
    }
}

fn along_columns(radius: usize, plane: &mut [i16], suffix: &mut [i16], running: &mut [i16]) {
    let (width, window) = (running.len(), 2 * radius + 1);
    let height = plane.len() / width;
    let take = |running: &mut [i16], plane: &[i16], j: usize, restart: bool| {
        if restart {
            running.fill(NONE);
        }
        let row = j.checked_sub(radius).filter(|&y| y < height);
        if let Some(y) = row {
            running.iter_mut().zip(&plane[y * width..]).for_each(|(max, &h)| *max = h.max(*max));
        }
    };
    for j in (0..height + 2 * radius).rev() {
        take(running, plane, j, j % window == window - 1 || j == height + 2 * radius - 1);
        if j < height {
            suffix[j * width..][..width].copy_from_slice(running);
        }
    }
    for j in 0..height + 2 * radius {
        take(running, plane, j, j % window == 0);
        if let Some(y) = j.checked_sub(2 * radius) {
            let row = &mut plane[y * width..][..width];
            let tails = running.iter().zip(&suffix[y * width..]);
            row.iter_mut().zip(tails).for_each(|(out, (&head, &tail))| *out = head.max(tail));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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
            let (mut suffix, mut running) = (vec![0; width * height], vec![0; width]);
            maximum(radius, &mut plane, &mut suffix, &mut running);
            prop_assert_eq!(plane, naive);
        }
    }
}
