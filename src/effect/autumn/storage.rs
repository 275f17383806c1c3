//! What is kept of a prepared tree, carved out of lent memory.

use super::{
    super::{
        StorageTooSmall,
        storage::{take, words},
    },
    leaf,
    plates::{self, Light},
    season::Calendar,
    species::MOST_TWIGS,
    sway::{self, Node},
};
use crate::frame::Size;
use bytemuck::{Pod, Zeroable};

/// Addresses of leaves: 12 bits of the twig, 4 of the leaf.
pub(super) const ADDRESSES: usize = 1 << 16;

/// A pixel of the tree, of its leaves on the ground, or of neither.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C, align(8))]
pub(super) struct Texel {
    /// The RIFS address: the twig's tree symbols, then two leaf symbols.
    pub(super) address: u16,
    /// While the tree is painted, how near it is, 0 being far; afterwards, where it stands in [`Planes::states`].
    pub(super) depth: u16,
    /// How bright the leaf is here, 128 being its plate's own brightness.
    pub(super) shade: u8,
    /// How much of the pixel the leaf covers.
    pub(super) cover: u8,
    /// How bright the wood behind the leaf is.
    pub(super) bark: u8,
    /// How much of the pixel the wood covers.
    pub(super) wood: u8,
}

/// What the season and the wind make of a twig's leaves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub(super) struct State {
    /// How much of the leaves is there.
    pub(super) there: u8,
    /// How bright they are, 128 being usual.
    pub(super) gain: u8,
}

/// The columns `start..end` of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub(super) struct Span {
    pub(super) start: u16,
    pub(super) end: u16,
}

/// What is kept of a tree.
#[derive(Debug)]
pub(super) struct Planes<'a> {
    pub(super) size: Size,
    pub(super) texels: &'a mut [Texel],
    /// What is behind the tree, sRGB: red, green, blue.
    pub(super) background: [&'a mut [u8]; 3],
    /// Where a row's texels are not empty.
    pub(super) spans: &'a mut [Span],
    /// The colour of every address, sRGB: red, green, blue, 0. Holds the leaves between the sun and each place while the tree is prepared.
    pub(super) colours: &'a mut [u32],
    /// Of each twig: on the tree, then on the ground.
    pub(super) states: &'a mut [State],
    pub(super) plates: &'a mut [Light],
    pub(super) calendars: &'a mut [Calendar],
    /// L of each twig.
    pub(super) sunlight: &'a mut [u8],
    /// Where in the picture each twig is, in pixels.
    pub(super) spots: &'a mut [[i16; 2]],
    pub(super) nodes: &'a mut [Node],
    pub(super) stencil: &'a mut [leaf::Cell],
}

/// Words of 64 bits that an autumn of `size` needs: 11 bytes a pixel, and 0.5 MB for the tree.
pub const fn storage_len(size: Size) -> usize {
    let picture =
        words::<Texel>(size.pixels()) + 3 * words::<u8>(size.pixels()) + words::<Span>(size.height as usize);
    let colours = words::<u32>(ADDRESSES) + words::<Light>(plates::STAGES * plates::CELLS);
    let twig = words::<Calendar>(MOST_TWIGS) + words::<u8>(MOST_TWIGS) + words::<[i16; 2]>(MOST_TWIGS);
    let stencil = words::<leaf::Cell>(leaf::SIDE * leaf::SIDE);
    picture + colours + twig + words::<State>(2 * MOST_TWIGS) + words::<Node>(sway::nodes(size)) + stencil
}

impl<'a> Planes<'a> {
    pub(super) fn carve(size: Size, storage: &'a mut [u64]) -> Result<Self, StorageTooSmall> {
        let error = StorageTooSmall { needed: storage_len(size), got: storage.len() };
        Self::try_carve(size, storage).ok_or(error)
    }

    fn try_carve(size: Size, mut memory: &'a mut [u64]) -> Option<Self> {
        let memory = &mut memory;
        Some(Self {
            size,
            texels: take(memory, size.pixels())?,
            background: [
                take(memory, size.pixels())?,
                take(memory, size.pixels())?,
                take(memory, size.pixels())?,
            ],
            spans: take(memory, size.height as usize)?,
            colours: take(memory, ADDRESSES)?,
            states: take(memory, 2 * MOST_TWIGS)?,
            plates: take(memory, plates::STAGES * plates::CELLS)?,
            calendars: take(memory, MOST_TWIGS)?,
            sunlight: take(memory, MOST_TWIGS)?,
            spots: take(memory, MOST_TWIGS)?,
            nodes: take(memory, sway::nodes(size))?,
            stencil: take(memory, leaf::SIDE * leaf::SIDE)?,
        })
    }
}
