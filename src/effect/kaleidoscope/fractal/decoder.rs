//! From leaves back to a picture.

use super::{Code, Leaf, block::brightness_q10};

/// Shrinks the plane `levels` of `width` by 2:1; a pixel is the rounded mean of four.
///
/// About an instruction a pixel where there are lanes.
pub fn contract(levels: &[u8], width: usize, contracted: &mut [u8]) {
    let rows = levels.chunks_exact(2 * width).zip(contracted.chunks_exact_mut(width / 2));
    for (pair, out) in rows {
        let (above, below) = pair.split_at(width);
        contract_row(above, below, out);
    }
}

#[inline(always)]
fn contract_row(above: &[u8], below: &[u8], out: &mut [u8]) {
    let pairs = above.as_chunks::<2>().0.iter().zip(below.as_chunks::<2>().0);
    for (out, (&[a, b], &[c, d])) in out.iter_mut().zip(pairs) {
        *out = ((u16::from(a) + u16::from(b) + u16::from(c) + u16::from(d) + 2) >> 2) as u8;
    }
}

/// Decodes `code` into `levels`, from whatever they hold, by `iterations` [sweeps](sweep). From anything at all, 6 sweeps are within a
/// level of the end on photos; from the picture before, 1 follows what moves slowly.
///
/// # Panics
/// If `levels` is not as long as the plane, or `contracted` not a quarter of that.
pub fn decode(code: &Code<'_>, iterations: u32, levels: &mut [u8], contracted: &mut [u8]) {
    assert_eq!(levels.len(), code.plane.pixels(), "the plane does not have the code's size");
    assert_eq!(contracted.len() * 4, levels.len(), "the contracted plane is not a quarter of the plane");
    contract(levels, code.plane.width as usize, contracted);
    for _ in 0..iterations {
        sweep(code, levels, contracted);
    }
}

/// Draws every range once, in place: `contracted` is the contraction of `levels`, and stays so range by range, so that later ranges see
/// what earlier ones have become.
pub fn sweep(code: &Code<'_>, levels: &mut [u8], contracted: &mut [u8]) {
    let width = code.plane.width as usize;
    for &leaf in code.leaves {
        draw(leaf, contracted, width, levels);
        shrink(leaf, levels, width, contracted);
    }
}

/// z' = s·D + o for the pixels of a leaf.
fn draw(leaf: Leaf, contracted: &[u8], width: usize, levels: &mut [u8]) {
    let (x, y, side) = leaf.range();
    let strides = leaf.strides(width / 2);
    let (s, o) = (i32::from(leaf.contrast) * 64, brightness_q10(leaf.contrast, leaf.brightness) + 512);
    for v in 0..side {
        let row = &mut levels[(y + v) * width + x..][..side];
        let mut at = strides.start + v as isize * strides.down;
        for level in row {
            *level = ((s * i32::from(contracted[at as usize]) + o) >> 10).clamp(0, 255) as u8;
            at += strides.right;
        }
    }
}

/// Brings the contraction of a leaf's range up to date.
fn shrink(leaf: Leaf, levels: &[u8], width: usize, contracted: &mut [u8]) {
    let (x, y, side) = leaf.range();
    for v in (0..side).step_by(2) {
        let [above, below] = [v, v + 1].map(|v| &levels[(y + v) * width + x..][..side]);
        contract_row(above, below, &mut contracted[(y + v) / 2 * (width / 2) + x / 2..][..side / 2]);
    }
}
