//! What is kept of a prepared photo: blocks of 16 pixels, in lent memory.
//!
//! A frame reads one stream, block after block, instead of a stream for each of eleven planes: small processors fetch ahead for a few
//! streams only.

use super::{
    super::{
        Photo, StorageTooSmall,
        storage::{take, words},
    },
    bands::WIDEST_RADIUS,
    relief,
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

    /// Copies words of row `y` to the start of `row`, whole blocks: [`Scratch::rows`] are long enough.
    #[inline(always)]
    pub(super) fn read(&self, which: Words, y: usize, row: &mut [i16]) {
        for (to, block) in row.as_chunks_mut::<LANES>().0.iter_mut().zip(self.row(y)) {
            *to = *block.words(which);
        }
    }

    /// Copies the start of `row` into words of row `y`.
    #[inline(always)]
    pub(super) fn write(&mut self, which: Words, y: usize, row: &[i16]) {
        for (from, block) in row.as_chunks::<LANES>().0.iter().zip(self.row_mut(y)) {
            block.words[which as usize] = *from;
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

/// Rows for preparation.
#[derive(Debug)]
pub(super) struct Scratch<'a> {
    /// Of a row.
    len: usize,
    words: &'a mut [i32],
}

/// Rows of i32 that preparation needs besides the blocks.
const SCRATCH_ROWS: usize = 12;

impl Scratch<'_> {
    /// Rows of 32 bits and of 16 bits, each as long as the blocks of a row with [`margin`] on both sides.
    #[inline(always)]
    pub(super) fn rows<const WIDE: usize, const NARROW: usize>(
        &mut self,
    ) -> ([&mut [i32]; WIDE], [&mut [i16]; NARROW]) {
        const { assert!(WIDE + NARROW.div_ceil(2) <= SCRATCH_ROWS) }
        let (wide, narrow) = self.words.split_at_mut(WIDE * self.len);
        let mut wide = wide.chunks_exact_mut(self.len);
        let mut narrow = bytemuck::cast_slice_mut(narrow).chunks_exact_mut(self.len);
        (
            core::array::from_fn(|_| wide.next().unwrap_or_default()),
            core::array::from_fn(|_| narrow.next().unwrap_or_default()),
        )
    }
}

/// Columns beyond each end of a row that the widest window of preparation reaches: a tent of twice the radius of its boxes, and one more
/// for its differences.
pub(super) const fn margin(size: Size) -> usize {
    2 * relief::scaled(WIDEST_RADIUS, size) + 2
}

/// Words of 64 bits that [`super::Shimmer::prepare`] needs for a photo of `size`: 18 bytes a pixel of rows that are padded to multiples of
/// 16, 1/8 byte a pixel for the spans of what moves, and 48 bytes a column of scratch, whose rows reach a little beyond the picture.
pub const fn storage_len(size: Size) -> usize {
    let blocks = words::<Block>(blocks_a_row(size.width) * size.height as usize);
    let spans = words::<Span>(spans::most(size.width) * size.height as usize);
    blocks + spans + words::<i32>(scratch_len(size))
}

const fn blocks_a_row(width: u32) -> usize {
    (width as usize).div_ceil(LANES)
}

const fn scratch_len(size: Size) -> usize {
    SCRATCH_ROWS * scratch_row(size)
}

const fn scratch_row(size: Size) -> usize {
    blocks_a_row(size.width) * LANES + 2 * margin(size)
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
            scratch: Scratch { len: scratch_row(size), words: take(memory, scratch_len(size))? },
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
                let [_, red, green, blue] = &mut block.bytes;
                let colours = red.iter_mut().zip(green).zip(blue).zip(rgb.as_chunks().0);
                for (((red, green), blue), &[r, g, b]) in colours {
                    (*red, *green, *blue) = (r, g, b);
                }
            }
            spans::find(mask, spans);
        }
    }
}
