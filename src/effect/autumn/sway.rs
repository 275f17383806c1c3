//! How the wind bends the tree: a smooth field of offsets.
//!
//! Every bough of second order has a sway of its own phase. The pixels of the tree are fetched from places that the field names; between
//! the nodes of a grid the offsets are interpolated, so that the picture is bent like a cloth, and nothing can tear or open.

use super::{mount::Mount, storage::Texel};
use crate::{
    frame::Size,
    math::{Factor, Turns, random::scatter},
    noise::drive::Drive,
};
use bytemuck::{Pod, Zeroable};

/// Pixels between nodes, each way.
pub(super) const PITCH: usize = 32;

/// Boughs with a sway of their own.
pub(super) const BOUGHS: usize = 16;

/// Fractional bits of an offset.
pub(super) const OFFSET_BITS: u32 = 8;

/// A node of the grid.
#[derive(Clone, Copy, Debug, Zeroable, Pod)]
#[repr(C)]
pub(super) struct Node {
    /// The share that each bough has in it, of 2^12.
    shares: [u16; BOUGHS],
    /// Right and down, in steps of 2^-8 pixel.
    pub(super) offset: [i16; 2],
}

/// Nodes of a row, and rows of them.
pub(super) const fn grid(size: Size) -> (usize, usize) {
    (size.width as usize / PITCH + 2, size.height as usize / PITCH + 2)
}

/// Nodes of a picture.
pub(super) const fn nodes(size: Size) -> usize {
    let (columns, rows) = grid(size);
    columns * rows
}

/// Finds the boughs' shares from the leaves around each node. `bough` names the bough of an address.
pub(super) fn fill(
    nodes: &mut [Node],
    mount: Mount,
    texels: &[Texel],
    root_y: i32,
    bough: impl Fn(&Texel) -> Option<usize>,
) {
    let size = mount.panel;
    let (columns, rows) = grid(size);
    nodes.fill(Node::zeroed());
    for (at, texel) in texels.iter().enumerate() {
        let (x, y) = (at % size.width as usize, at / size.width as usize);
        if let Some(bough) = bough(texel) {
            nodes[(y + PITCH / 2) / PITCH * columns + (x + PITCH / 2) / PITCH].shares[bough] += 1;
        }
    }
    for row in 0..rows {
        smooth(nodes, row * columns, 1, columns);
    }
    for column in 0..columns {
        smooth(nodes, column, columns, rows);
    }
    for (at, node) in nodes.iter_mut().enumerate() {
        let (column, row) = (at % columns, at / columns);
        // What is near the edge of the picture stays, so that nothing is fetched from beyond it; and so does the foot of the tree.
        let last = |count: usize| count - 3;
        let is_edge = column < 1 || row < 1 || column > last(columns) || row > last(rows);
        let [_, y] = mount.pixel((column * PITCH) as i32, (row * PITCH) as i32);
        let height = i64::from((root_y - y).clamp(0, root_y)) * 4_096 / i64::from(root_y.max(1));
        let sum: u32 = node.shares.iter().map(|&share| u32::from(share)).sum();
        for share in &mut node.shares {
            let part = u64::from(*share) * height as u64 / u64::from(sum + FIRM);
            *share = if is_edge { 0 } else { part as u16 };
        }
    }
}

/// Where fewer leaves than these are around, it is the trunk, which hardly moves.
const FIRM: u32 = 60;

/// Smooths a line of nodes, there and back.
fn smooth(nodes: &mut [Node], start: usize, step: usize, count: usize) {
    let mut carry = [0_u32; BOUGHS];
    let forth = (0..count).map(|i| start + i * step);
    for at in forth.clone().chain(forth.rev()) {
        for (share, carry) in nodes[at].shares.iter_mut().zip(&mut carry) {
            *carry = (u32::from(*share) + *carry).div_ceil(2);
            *share = *carry as u16;
        }
    }
}

/// The farthest that anything is moved, of the picture's height: 1/80. And never farther than a node's pitch, see [`fill`].
fn reach(size: Size) -> i32 {
    (((size.height as i32) << OFFSET_BITS) / 80).min((PITCH as i32 - 2) << OFFSET_BITS)
}

/// Sets the offsets for the moment of `drive`.
pub(super) fn bend(nodes: &mut [Node], mount: Mount, drive: Drive) {
    let strength = drive.amplitude * drive.onset;
    let most = i64::from(reach(mount.upright()));
    let sways: [[i32; 2]; BOUGHS] = core::array::from_fn(|bough| {
        // Neighbours sway nearly together: a third of a turn apart at most.
        let phase = Turns((scatter(bough as u64 ^ 0x3a7e) >> 32) as u32 / 3);
        let swing = drive.phase.plus(phase);
        let third = Factor::from_num(1) / 3;
        let along = strength * (third + 2 * third * swing.sin());
        let down = strength * swing.plus(phase).cos() * third;
        let sway =
            [along, down].map(|share| ((i64::from(share.to_bits()) * most) >> Factor::FRAC_NBITS) as i32);
        mount.direction(sway)
    });
    for node in nodes {
        for (axis, offset) in node.offset.iter_mut().enumerate() {
            let shares = node.shares.iter().zip(&sways);
            let sum: i32 = shares.map(|(&share, sway)| i32::from(share) * sway[axis]).sum();
            // Fetched from where it comes from.
            *offset = -(sum >> 12) as i16;
        }
    }
}
