//! What is done once a frame: two frames of changes become one, as large as the panel, and the colours that it makes.

use super::{
    clip::{Clip, Source},
    code::{Planes, decode},
    storage::{Block, Change, Measures, Memory, Span},
    view::Axis,
};
use crate::{
    effect,
    frame::{Rotation, Size, pack, rotate},
    math::{
        Factor,
        lanes::{LANES, Lanes, Task, on_widest},
        mul_q15, sqrt,
    },
};
use core::ops::Range;

/// A clip at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    size: Size,
    blocks_a_row: usize,
    blocks: &'a [Block],
    /// Those of red, green and blue, which may be the same.
    changes: [&'a [Change]; 3],
    spans: &'a [Span],
}

impl<'a> Moment<'a> {
    pub(super) fn new(memory: Memory<'a>, measures: &Measures) -> Self {
        let blocks: &[Block] = memory.blocks;
        let changes: &[Change] = memory.changes;
        let plane = |i: usize| &changes[i % measures.planes * blocks.len()..][..blocks.len()];
        Self {
            size: measures.panel,
            blocks_a_row: measures.blocks_a_row(),
            blocks,
            changes: [0, 1, 2].map(plane),
            spans: memory.spans,
        }
    }
}

impl effect::Moment for Moment<'_> {
    #[inline(always)]
    fn size(&self) -> Size {
        self.size
    }

    #[inline(always)]
    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let Span { start, end } = self.spans[y as usize];
        (start < end).then(|| start.into()..end.into()).into_iter()
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [pack::Block]) {
        let row = y as usize * self.blocks_a_row;
        let place = row + x / LANES..row + self.blocks_a_row;
        let changes = self.changes.map(|plane| &plane[place.clone()]);
        on_widest(Run { from: &self.blocks[place], changes, to: blocks });
    }
}

/// Fills `to` with the colours of blocks.
struct Run<'a> {
    from: &'a [Block],
    /// Those of red, green and blue.
    changes: [&'a [Change]; 3],
    to: &'a mut [pack::Block],
}

impl Task for Run<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for (channel, changes) in self.changes.into_iter().enumerate() {
            for ((to, from), change) in self.to.iter_mut().zip(self.from).zip(changes) {
                colour::<L>(from, channel, change).store(&mut to[channel]);
            }
        }
    }
}

/// A channel with 4 fractional bits, unclipped: the base, and as much of the change in 64ths as a gain in 64ths says.
#[inline(always)]
fn colour<L: Lanes>(block: &Block, channel: usize, change: &Change) -> L {
    let base = L::load_q7(&block.base[channel]).down::<3>();
    base.plus(L::load(change).times(L::load_q7(&block.gain[channel])))
}

/// The most that a pixel changes, in 64ths of a level: all of them.
const MOST: i32 = 255 * 64;

/// Decodes frame number `number` into one of the two of the memory. In the place of one that is damaged comes
/// what the other of the two holds.
pub(super) fn fetch<C: Source>(clip: &Clip<C>, number: u32, memory: &mut Memory<'_>, slot: usize) {
    let shape = &clip.header().shape;
    let planes =
        Planes { width: shape.grid.width as usize, extents: memory.extents, count: shape.kind.planes() };
    let decoded = clip
        .read_frame(number, memory.packed)
        .and_then(|bytes| decode(&planes, bytes, memory.residuals, memory.frames[slot]));
    if decoded.is_none() {
        let [first, second] = &mut memory.frames;
        match slot {
            0 => first.copy_from_slice(second),
            _ => second.copy_from_slice(first),
        }
        clip.source().damaged(number);
    }
}

/// How much of each of two frames is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Shares {
    /// In units of 2^-10, from units of change to 64ths of a level.
    pub(super) of: [i32; 2],
}

impl Shares {
    /// The shares at `between`, Q16, of the way from one frame to the next, at a `strength` of up to 7.
    ///
    /// A plain mean of two frames whose changes correlate by ρ has the contrast √((1−f)² + f² + 2f(1−f)ρ): the picture would go dull and sharp
    /// again from frame to frame. The shares are divided by it.
    pub(super) fn new(between: u32, correlation: u16, strength: Factor, step: u8) -> Self {
        let (b, a) = (u64::from(between), u64::from((1 << 16) - between));
        let square = a * a + b * b + ((2 * a * b * u64::from(correlation)) >> 15);
        // In units of 2^-32, below 1; the root in units of 2^-16.
        let contrast = (sqrt(square.min((1 << 32) - 1) << 32) >> 47).max(1);
        let scale = i64::from(strength.to_bits()) * i64::from(step) * 64;
        let share = |part: u64| (scale * part as i64 / contrast as i64) >> (Factor::FRAC_NBITS - 10);
        Self { of: [share(a) as i32, share(b) as i32] }
    }
}

/// Makes one change of the two frames, turned as the panel is mounted.
pub(super) fn mix(
    memory: &mut Memory<'_>,
    slots: [usize; 2],
    shares: Shares,
    measures: &Measures,
    rotation: Rotation,
) {
    let [from, to] = slots.map(|slot| &*memory.frames[slot]);
    let [a, b] = shares.of;
    for ((mixed, &from), &to) in memory.mixed.iter_mut().zip(from).zip(to) {
        let sum = i32::from(from) * a + i32::from(to) * b;
        *mixed = ((sum + (1 << 9)) >> 10).clamp(-MOST, MOST) as i16;
    }
    if measures.turned {
        let pixels = measures.grid.pixels();
        for (mixed, turned) in memory.mixed.chunks_exact(pixels).zip(memory.turned.chunks_exact_mut(pixels)) {
            rotate(rotation, mixed, measures.grid, turned);
        }
    }
}

/// Spreads the change over the pixels of the panel that move.
pub(super) fn spread(memory: &mut Memory<'_>, measures: &Measures, rotation: Rotation, rows: &Axis) {
    let grid = rotation.turned(measures.grid);
    let (width, pixels) = (grid.width as usize, grid.pixels());
    let source: &[i16] = if measures.turned { memory.turned } else { memory.mixed };
    let blocks_a_row = measures.blocks_a_row();
    for (y, span) in memory.spans.iter().enumerate() {
        let Some(place) = rows.place(y as u32).filter(|_| span.start < span.end) else { continue };
        let columns = &memory.columns[span.start.into()..span.end.into()];
        for (plane, changes) in
            source.chunks_exact(pixels).zip(memory.changes.chunks_exact_mut(measures.blocks()))
        {
            let upper = usize::from(place.index) * width;
            let lower = (upper + width).min(pixels - width);
            let (upper, lower) = (&plane[upper..upper + width], &plane[lower..lower + width]);
            for ((between, &upper), &lower) in memory.row.iter_mut().zip(upper).zip(lower) {
                *between = upper + mul_q15(lower - upper, place.weight);
            }
            // Looked at beside the last pixel, with no weight.
            memory.row[width] = 0;
            let out = changes[y * blocks_a_row..][..blocks_a_row].as_flattened_mut();
            for (out, place) in out[span.start.into()..].iter_mut().zip(columns) {
                let index = usize::from(place.index);
                let (left, right) = (memory.row[index], memory.row[index + 1]);
                *out = left + mul_q15(right - left, place.weight);
            }
        }
    }
}
