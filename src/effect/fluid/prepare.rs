//! What is done once a clip: the base and how far each of its pixels moves.

use super::{
    Tint,
    code::Extent,
    storage::{Block, Measures, Memory, Span},
    view::{Axis, Place},
};
use crate::{
    effect::kaleidoscope::luma,
    frame::{Rotation, rotate},
    math::lanes::LANES,
};
use bytemuck::Zeroable;

/// Fills what stands still: blocks, spans, columns and extents. The first frame holds the matte as it comes, upright; both are
/// empty afterwards.
pub(super) fn fill(
    memory: &mut Memory<'_>,
    measures: &Measures,
    rgb: &[[u8; 3]],
    tint: &Tint,
    rotation: Rotation,
    axes: &[Axis; 2],
) {
    let [columns, rows] = axes;
    let grid = measures.grid;
    let [upright, matte] = memory.frames.each_mut().map(|frame| bytemuck::cast_slice_mut::<i8, u8>(frame));
    for (extent, row) in memory.extents.iter_mut().zip(upright.chunks_exact(grid.width as usize)) {
        *extent = Extent::of(row);
    }
    rotate(rotation, upright, grid, matte);
    let width = rotation.turned(grid).width as usize;
    let matte = Matte { values: &matte[..grid.pixels()], width };

    let panel_width = measures.panel.width as usize;
    for (x, place) in (0..).zip(&mut *memory.columns) {
        // What lies beyond the grid takes nothing of it, wherever it is told to look.
        *place = columns.place(x).unwrap_or_default();
    }
    let blocks = memory.blocks.chunks_exact_mut(measures.blocks_a_row());
    for (((y, blocks), rgb), span) in
        (0..).zip(blocks).zip(rgb.chunks_exact(panel_width)).zip(&mut *memory.spans)
    {
        blocks.fill(Block::zeroed());
        *span = Span::default();
        let row = rows.place(y);
        for (x, &pixel) in rgb.iter().enumerate() {
            let (block, lane) = (&mut blocks[x / LANES], x % LANES);
            let place = columns.place(x as u32);
            let share = place.zip(row).map_or(0, |(column, row)| matte.at(column, row));
            for (channel, &level) in pixel.iter().enumerate() {
                let gain = share * u32::from(tint.0[usize::from(luma(pixel))][channel]);
                let gain = (gain + 127) / 255;
                block.base[channel][lane] = level;
                block.gain[channel][lane] = gain as u8;
                if gain > 0 {
                    *span =
                        Span { start: if span.end == 0 { x as u16 } else { span.start }, end: x as u16 + 1 };
                }
            }
        }
    }
    memory.changes.fill([0; LANES]);
    memory.frames.iter_mut().for_each(|frame| frame.fill(0));
    memory.row.fill(0);
}

/// The matte as the panel is mounted.
struct Matte<'a> {
    values: &'a [u8],
    width: usize,
}

impl Matte<'_> {
    /// The matte between four pixels, 0..=255.
    fn at(&self, column: Place, row: Place) -> u32 {
        let height = self.values.len() / self.width;
        let value = |x: usize, y: usize| {
            i64::from(self.values[y.min(height - 1) * self.width + x.min(self.width - 1)])
        };
        let (x, y) = (usize::from(column.index), usize::from(row.index));
        let [across, down] = [column, row].map(|place| i64::from(place.weight));
        let line = |y| value(x, y) * (32_768 - across) + value(x + 1, y) * across;
        ((line(y) * (32_768 - down) + line(y + 1) * down + (1 << 29)) >> 30) as u32
    }
}
