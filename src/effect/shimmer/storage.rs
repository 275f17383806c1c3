//! What is kept of a prepared photo: blocks of 16 pixels, in lent memory.
//!
//! A frame reads one stream, block after block, instead of a stream for each of eleven planes: small processors fetch ahead for a few
//! streams only.

use super::{
    super::{
        Photo, StorageTooSmall,
        storage::{take, words},
    },
    spans::{self, Span},
};
use crate::{frame::Size, math::lanes::LANES};
use bytemuck::{Pod, Zeroable};

/// Sixteen pixels of a row: 18 bytes each.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Block {
    pub(super) words: [[i16; LANES]; 7],
    pub(super) bytes: [[u8; LANES]; 4],
}

/// What the words of a block are. A slope is in units of 2^-14.5, its u towards the light, its v across. While a photo is
/// prepared they hold other things, as the functions say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Words {
    /// ∇P, what sin θ multiplies.
    SineU,
    SineV,
    /// ∇Q, what cos θ multiplies.
    CosineU,
    CosineV,
    /// ∇C.
    CentreU,
    CentreV,
    /// 1 − M·k·S̄ in Q12, S̄ the mean shade over a cycle: the gain of a pixel in the shade. Holds the luma while the photo is prepared.
    Base,
}

/// What the bytes of a block are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bytes {
    Mask,
    Red,
    Green,
    Blue,
}

impl Block {
    #[inline(always)]
    pub(super) const fn words(&self, which: Words) -> &[i16; LANES] {
        &self.words[which as usize]
    }

    #[inline(always)]
    pub(super) const fn bytes(&self, which: Bytes) -> &[u8; LANES] {
        &self.bytes[which as usize]
    }
}

/// The blocks of a photo, row by row; the last one of a row reaches beyond it.
#[derive(Debug)]
pub(super) struct Blocks<'a> {
    pub(super) size: Size,
    blocks: &'a mut [Block],
}

impl Blocks<'_> {
    #[inline(always)]
    pub(super) fn row(&self, y: usize) -> &[Block] {
        let count = blocks_a_row(self.size.width);
        &self.blocks[y * count..][..count]
    }

    #[inline(always)]
    pub(super) fn row_mut(&mut self, y: usize) -> &mut [Block] {
        let count = blocks_a_row(self.size.width);
        &mut self.blocks[y * count..][..count]
    }

    /// Copies words of row `y` into `row`, which is as long as the picture is wide.
    #[inline(always)]
    pub(super) fn read(&self, which: Words, y: usize, row: &mut [i16]) {
        for (to, block) in row.chunks_mut(LANES).zip(self.row(y)) {
            to.copy_from_slice(&block.words(which)[..to.len()]);
        }
    }

    /// Copies `row` into words of row `y`.
    #[inline(always)]
    pub(super) fn write(&mut self, which: Words, y: usize, row: &[i16]) {
        for (from, block) in row.chunks(LANES).zip(self.row_mut(y)) {
            block.words[which as usize][..from.len()].copy_from_slice(from);
        }
    }
}

/// The memory of a photo.
#[derive(Debug)]
pub(super) struct Planes<'a> {
    pub(super) blocks: Blocks<'a>,
    /// The spans of row y, of which there are at most `spans::most(width)`.
    pub(super) spans: &'a mut [Span],
    /// Scratch of preparation.
    pub(super) scratch: Scratch<'a>,
}

/// Rows for preparation, each as long as the picture is wide.
#[derive(Debug)]
pub(super) struct Scratch<'a> {
    width: usize,
    words: &'a mut [i32],
}

/// Rows of i32 that preparation needs besides the blocks.
const SCRATCH_ROWS: usize = 7;

impl Scratch<'_> {
    /// Rows of 16 bits, and one of 32.
    pub(super) fn rows<const N: usize>(&mut self) -> ([&mut [i16]; N], &mut [i32]) {
        const { assert!(N <= 2 * (SCRATCH_ROWS - 1)) }
        let (sums, words) = self.words.split_at_mut(self.width);
        let mut rows = bytemuck::cast_slice_mut(words).chunks_exact_mut(self.width);
        (core::array::from_fn(|_| rows.next().unwrap_or_default()), sums)
    }
}

/// Words of 64 bits that [`super::Shimmer::prepare`] needs for a photo of `size`: 18 bytes a pixel of rows that are padded to multiples of
/// 16, 1/8 byte a pixel for the spans of what moves, and 28 bytes a column of scratch.
pub const fn storage_len(size: Size) -> usize {
    let blocks = words::<Block>(blocks_a_row(size.width) * size.height as usize);
    let spans = words::<Span>(spans::most(size.width) * size.height as usize);
    blocks + spans + words::<i32>(scratch_len(size))
}

const fn blocks_a_row(width: u32) -> usize {
    (width as usize).div_ceil(LANES)
}

const fn scratch_len(size: Size) -> usize {
    SCRATCH_ROWS * size.width as usize
}

impl<'a> Planes<'a> {
    pub(super) fn carve(size: Size, storage: &'a mut [u64]) -> Result<Self, StorageTooSmall> {
        let error = StorageTooSmall { needed: storage_len(size), got: storage.len() };
        Self::try_carve(size, storage).ok_or(error)
    }

    fn try_carve(size: Size, mut memory: &'a mut [u64]) -> Option<Self> {
        let memory = &mut memory;
        let height = size.height as usize;
        Some(Self {
            blocks: Blocks { size, blocks: take(memory, blocks_a_row(size.width) * height)? },
            spans: take(memory, spans::most(size.width) * height)?,
            scratch: Scratch { width: size.width as usize, words: take(memory, scratch_len(size))? },
        })
    }

    /// Takes over the photo's colours and mask, and finds the spans of what moves.
    pub(super) fn fill_photo(&mut self, photo: Photo<'_>) {
        assert_eq!(photo.rgb.len(), photo.size.pixels() * 3, "the photo's colours do not have its size");
        assert_eq!(photo.mask.len(), photo.size.pixels(), "the photo's mask does not have its size");
        let width = photo.size.width as usize;
        let rows = photo.rgb.chunks_exact(width * 3).zip(photo.mask.chunks_exact(width));
        let spans = self.spans.chunks_exact_mut(spans::most(photo.size.width));
        for (y, ((rgb, mask), spans)) in rows.zip(spans).enumerate() {
            let parts = rgb.chunks(3 * LANES).zip(mask.chunks(LANES));
            for (block, (rgb, mask)) in self.blocks.row_mut(y).iter_mut().zip(parts) {
                *block = Block::zeroed();
                block.bytes[Bytes::Mask as usize][..mask.len()].copy_from_slice(mask);
                for (i, &[r, g, b]) in rgb.as_chunks().0.iter().enumerate() {
                    let [_, red, green, blue] = &mut block.bytes;
                    (red[i], green[i], blue[i]) = (r, g, b);
                }
            }
            spans::find(mask, spans);
        }
    }
}
