//! What is kept of a prepared photo: blocks of 16 pixels, in lent memory.
//!
//! A frame reads one stream, block after block, instead of a stream for each of eleven planes: small processors fetch ahead for a few
//! streams only.

use super::{
    super::{
        StorageTooSmall,
        storage::{take, words},
    },
    bands::WIDEST_RADIUS,
    relief,
    spans::{self, Span},
};
use crate::{
    frame::Size,
    math::lanes::{LANES, Lanes},
};
use bytemuck::{Pod, Zeroable};

/// Sixteen pixels of a row while a photo is prepared: 14 bytes each.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Block {
    pub(super) words: [[i16; LANES]; 7],
}

/// What the words of a block come to be. A slope is in units of 2^-14.5, its u towards the light, its v across. On the way there they
/// hold other things, as the functions say.
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
    /// The luma.
    Luma,
}

impl Block {
    #[inline(always)]
    pub(super) const fn words(&self, which: Words) -> &[i16; LANES] {
        &self.words[which as usize]
    }
}

/// Sixteen pixels of a row as a frame reads them: 13 bytes each.
///
/// P and Q have 11 bits, C has 10: what P's word and Q's word have no use for. A word is taken for P as it is; P was rounded with its low bits
/// in mind, so that they are no error. All three together then err by 1/610 of a slope of 45° at worst.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Packed {
    /// Along u, along v: P, and Q.
    slopes: [[[i16; LANES]; 2]; 2],
    /// 1 − k·S̄ in Q12, S̄ the mean shade over a cycle: the gain of a pixel in the shade.
    pub(super) base: [i16; LANES],
    /// Red, green, blue.
    pub(super) colours: [[u8; LANES]; 3],
}

/// The bits of C that each of the two words keeps.
const SHARE: i32 = 5;

/// The bits that C goes without.
const DROPPED: i32 = 16 - 2 * SHARE;

impl Packed {
    /// The slopes of `block`, without base and colours.
    #[inline(always)]
    pub(super) fn new(block: &Block) -> Self {
        let pack = |axis: [Words; 3]| {
            let [p, q, c] = axis.map(|which| block.words(which));
            let mut packed = [*p, *q];
            for lane in 0..LANES {
                let centre = (c[lane] + (1 << (DROPPED - 1))) >> DROPPED;
                let low = (1 << SHARE) - 1;
                packed[0][lane] = nearest(p[lane], centre >> SHARE & low);
                packed[1][lane] = nearest(q[lane], centre & low);
            }
            packed
        };
        let slopes = [
            pack([Words::SineU, Words::CosineU, Words::CentreU]),
            pack([Words::SineV, Words::CosineV, Words::CentreV]),
        ];
        Self { slopes, ..Self::zeroed() }
    }

    /// P, Q and C along u, and along v.
    #[inline(always)]
    pub(super) fn slopes<L: Lanes>(&self) -> [[L; 3]; 2] {
        let [u, v] = &self.slopes;
        [unpacked(u), unpacked(v)]
    }
}

#[inline(always)]
fn unpacked<L: Lanes>([p, q]: &[[i16; LANES]; 2]) -> [L; 3] {
    let (p, q) = (L::load(p), L::load(q));
    [p, q, q.up::<DROPPED>().beneath::<{ SHARE + DROPPED }>(p)]
}

/// The number with these low bits that is nearest to `slope`, which is at most 54.6° and so far from the ends of 16 bits.
#[inline(always)]
const fn nearest(slope: i16, low: i16) -> i16 {
    ((slope - low + (1 << (SHARE - 1))) >> SHARE << SHARE) | low
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

impl<'a> Blocks<'a> {
    /// Replaces every block by what `pack` makes of it; it is told in which row the block is, and where its first pixel is in it.
    #[inline(always)]
    pub(super) fn pack(&mut self, mut pack: impl FnMut(Block, usize, usize) -> Packed) {
        const { assert!(size_of::<Packed>() <= size_of::<Block>()) }
        let (count, total) = (blocks_a_row(self.size.width), self.blocks.len());
        for at in 0..total {
            // It ends before the next one that is still to be read starts.
            let packed = pack(self.blocks[at], at / count, at % count * LANES);
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(self.blocks);
            bytes[at * size_of::<Packed>()..][..size_of::<Packed>()]
                .copy_from_slice(bytemuck::bytes_of(&packed));
        }
    }

    fn into_packed(self) -> &'a [Packed] {
        let bytes: &[u8] = bytemuck::cast_slice(self.blocks);
        bytemuck::cast_slice(&bytes[..self.blocks.len() * size_of::<Packed>()])
    }
}

/// A photo that is prepared.
#[derive(Debug)]
pub(super) struct Prepared<'a> {
    pub(super) size: Size,
    blocks: &'a [Packed],
    spans: &'a [Span],
}

impl<'a> Prepared<'a> {
    pub(super) fn new(Planes { blocks, spans, .. }: Planes<'a>) -> Self {
        Self { size: blocks.size, blocks: blocks.into_packed(), spans }
    }

    #[inline(always)]
    pub(super) fn row(&self, y: usize) -> &'a [Packed] {
        let count = blocks_a_row(self.size.width);
        &self.blocks[y * count..][..count]
    }

    /// The columns of row `y` that move.
    #[inline(always)]
    pub(super) fn spans(&self, y: usize) -> &'a [Span] {
        let most = spans::most(self.size.width);
        &self.spans[y * most..][..most]
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

/// Words of 64 bits that [`super::Shimmer::prepare`] needs for a photo of `size`: 14 bytes a pixel of rows that are padded to multiples of
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

    /// Finds the spans of what moves.
    pub(super) fn find_spans(&mut self, mask: &[u8]) {
        let spans = self.spans.chunks_exact_mut(spans::most(self.blocks.size.width));
        for (mask, spans) in mask.chunks_exact(self.blocks.size.width as usize).zip(spans) {
            spans::find(mask, spans);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Plain;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn packed_slopes_err_by_half_a_step_each(words: [[i16; LANES]; 7]) {
            // 54.6° in units of 2^-14.5.
            let block = Block { words: words.map(|lanes| lanes.map(|word| word % 32_587)) };
            let [u, v] = Packed::new(&block).slopes::<Plain>();
            let exact = [Words::SineU, Words::CosineU, Words::CentreU, Words::SineV, Words::CosineV, Words::CentreV];
            for ((which, got), half_a_step) in exact.into_iter().zip(u.into_iter().chain(v)).zip([16, 16, 32].into_iter().cycle()) {
                for (got, want) in got.into_iter().zip(block.words(which)) {
                    prop_assert!(got.abs_diff(*want) <= half_a_step, "{:?}: {} for {}", which, got, want);
                }
            }
        }
    }

    #[test]
    fn what_is_level_stays_level() {
        assert_eq!(Packed::new(&Block::zeroed()).slopes::<Plain>(), [[[0; LANES]; 3]; 2]);
    }
}
