//! What is kept of a clip that plays: in lent memory.

use super::{Header, code::Extent, view::Place};
use crate::{
    effect::{
        StorageTooSmall,
        storage::{take, words},
    },
    frame::Size,
    math::lanes::LANES,
};
use bytemuck::{Pod, Zeroable};

/// Sixteen pixels of a row: what stands still of them.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Block {
    /// Red, green and blue of the base.
    pub(super) base: [[u8; LANES]; 3],
    /// What of a change they take, in 64ths.
    pub(super) gain: [[u8; LANES]; 3],
}

/// A change of sixteen pixels, in 64ths of a level.
pub(super) type Change = [i16; LANES];

/// The columns of a row of the panel that move.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Span {
    pub(super) start: u16,
    pub(super) end: u16,
}

/// The measures that memory depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures {
    pub(super) panel: Size,
    pub(super) planes: usize,
    pub(super) grid: Size,
    /// Whether the panel is mounted turned.
    pub(super) turned: bool,
    /// Bytes of the longest part that is read at a time.
    packed: usize,
}

impl Measures {
    pub(super) const fn new(header: &Header, panel: Size, turned: bool) -> Self {
        let (longest, matte) = (header.longest as usize, header.matte as usize);
        Self {
            panel,
            planes: header.shape.kind.planes(),
            grid: header.shape.grid,
            turned,
            packed: if longest > matte { longest } else { matte },
        }
    }

    pub(super) const fn blocks_a_row(&self) -> usize {
        (self.panel.width as usize).div_ceil(LANES)
    }

    /// Blocks of a plane.
    pub(super) const fn blocks(&self) -> usize {
        self.blocks_a_row() * self.panel.height as usize
    }

    const fn values(&self) -> usize {
        self.grid.pixels() * self.planes
    }

    /// The longer side of the grid, which is a row of it when it is turned, and one pixel more.
    const fn longest_row(&self) -> usize {
        let Size { width, height } = self.grid;
        let longer = if width > height { width } else { height };
        longer as usize + 1
    }

    pub(super) const fn storage_len(&self) -> usize {
        words::<Block>(self.blocks())
            + words::<Change>(self.blocks() * self.planes)
            + words::<Span>(self.panel.height as usize)
            + words::<Place>(self.panel.width as usize)
            + words::<Extent>(self.grid.height as usize)
            + 2 * words::<i8>(self.values())
            + words::<u8>(self.values())
            + words::<i16>(self.values())
            + words::<i16>(if self.turned { self.values() } else { 0 })
            + words::<i16>(self.longest_row())
            + words::<u8>(self.packed)
    }
}

/// The parts of the memory.
#[derive(Debug)]
pub(super) struct Memory<'a> {
    /// Row by row; the last one of a row reaches beyond it.
    pub(super) blocks: &'a mut [Block],
    /// Plane by plane, as the blocks.
    pub(super) changes: &'a mut [Change],
    /// One for each row of the panel.
    pub(super) spans: &'a mut [Span],
    /// One for each column of the panel.
    pub(super) columns: &'a mut [Place],
    /// One for each row of the grid.
    pub(super) extents: &'a mut [Extent],
    /// Two frames, decoded.
    pub(super) frames: [&'a mut [i8]; 2],
    /// Scratch memory of the decoder.
    pub(super) residuals: &'a mut [u8],
    /// What the two frames make together, in 64ths of a level.
    pub(super) mixed: &'a mut [i16],
    /// The same as the panel is mounted, if it is mounted turned.
    pub(super) turned: &'a mut [i16],
    /// A row between two rows of that.
    pub(super) row: &'a mut [i16],
    /// What is read from the file.
    pub(super) packed: &'a mut [u8],
}

impl<'a> Memory<'a> {
    pub(super) fn carve(measures: &Measures, mut memory: &'a mut [u64]) -> Result<Self, StorageTooSmall> {
        let too_small = StorageTooSmall { needed: measures.storage_len(), got: memory.len() };
        Self::parts(measures, &mut memory).ok_or(too_small)
    }

    fn parts(measures: &Measures, memory: &mut &'a mut [u64]) -> Option<Self> {
        let values = measures.values();
        Some(Self {
            blocks: take(memory, measures.blocks())?,
            changes: take(memory, measures.blocks() * measures.planes)?,
            spans: take(memory, measures.panel.height as usize)?,
            columns: take(memory, measures.panel.width as usize)?,
            extents: take(memory, measures.grid.height as usize)?,
            frames: [take(memory, values)?, take(memory, values)?],
            residuals: take(memory, values)?,
            mixed: take(memory, values)?,
            turned: take(memory, if measures.turned { values } else { 0 })?,
            row: take(memory, measures.longest_row())?,
            packed: take(memory, measures.packed)?,
        })
    }
}
