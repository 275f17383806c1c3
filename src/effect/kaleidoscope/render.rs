//! The frame kernel: one look-up a pixel.

use super::{Kaleidoscope, address::ADDRESSES, prepare::Planes, texture::Texel};
use crate::{
    effect,
    frame::{
        Size,
        pack::{Block, Level},
    },
    math::{Factor, lanes::LANES, mul_q15, q15},
    noise::drive::Drive,
};
use core::{iter, ops::Range};

/// A kaleidoscope at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    size: Size,
    planes: Planes<'a>,
    /// How far the photo has given way to the kaleidoscope, Q15; nothing is left of it where there is no such number.
    onset: Option<i16>,
}

impl<'a> Moment<'a> {
    pub(super) fn new<S: AsMut<[u64]>>(kaleidoscope: &'a mut Kaleidoscope<S>, drive: Drive) -> Self {
        let Kaleidoscope { size, mode, depth, mirrors, storage } = kaleidoscope;
        let Some(planes) = Planes::carve(*size, *mode, storage.as_mut()) else {
            unreachable!("the storage was long enough when the photo was prepared")
        };
        mirrors.follow(drive);
        mirrors.colours(planes.texels, *depth, planes.table);
        let onset = (drive.onset < Factor::ONE).then(|| q15(drive.onset));
        Self { size: *size, planes, onset }
    }
}

impl effect::Moment for Moment<'_> {
    fn size(&self) -> Size {
        self.size
    }

    fn moving(&self, _: u32) -> impl Iterator<Item = Range<usize>> {
        iter::once(0..self.size.width as usize)
    }

    fn colours(&self, x: usize, y: u32, blocks: &mut [Block]) {
        let row = y as usize * self.size.width as usize;
        let place = row + x..row + self.size.width as usize;
        let Planes { addresses, table, rgb, .. } = &self.planes;
        let Some((table, _)) = table.split_first_chunk::<ADDRESSES>() else { return };
        let pixels = self.size.pixels();
        let layer = |i: usize| &addresses[i * pixels..][place.clone()];
        if addresses.len() == pixels {
            one(layer(0), table, blocks);
        } else {
            four([0, 1, 2, 3].map(layer), table, blocks);
        }
        if let Some(onset) = self.onset {
            for (block, photo) in blocks.iter_mut().zip(rgb[place].chunks(LANES)) {
                for (i, old) in photo.iter().enumerate() {
                    for (plane, &old) in block.iter_mut().zip(old) {
                        let old = i16::from(old) << 4;
                        plane[i] = old + mul_q15(plane[i] - old, onset);
                    }
                }
            }
        }
    }
}

/// The colour of an address. One beyond the table, which there is none of, would be folded into it.
#[inline(always)]
fn colour(table: &[Texel; ADDRESSES], address: u16) -> Texel {
    table[usize::from(address) % ADDRESSES]
}

/// Colours of addresses.
pub(super) fn one(addresses: &[u16], table: &[Texel; ADDRESSES], blocks: &mut [Block]) {
    for (i, block) in blocks.iter_mut().enumerate() {
        let addresses = block_at(addresses, i);
        *block = take_apart(|i| colour(table, addresses[i]));
    }
}

/// Means of the colours of four layers of addresses.
fn four(layers: [&[u16]; 4], table: &[Texel; ADDRESSES], blocks: &mut [Block]) {
    for (i, block) in blocks.iter_mut().enumerate() {
        let layers = layers.map(|layer| block_at(layer, i));
        *block = take_apart(|i| Texel::mean(layers.map(|layer| colour(table, layer[i]))));
    }
}

/// Block `i` of a row of addresses; what is beyond its end is 0.
#[inline(always)]
fn block_at(row: &[u16], i: usize) -> [u16; LANES] {
    let rest = row.get(i * LANES..).unwrap_or_default();
    rest.first_chunk()
        .copied()
        .unwrap_or_else(|| core::array::from_fn(|i| rest.get(i).copied().unwrap_or_default()))
}

#[inline(always)]
fn take_apart(texel: impl Fn(usize) -> Texel) -> Block {
    let mut block = [[0; LANES]; 3];
    // Half a block at a time: the compiler makes lanes of it, and has registers for no more.
    for start in [0, LANES / 2] {
        let channels: [[Level; 3]; LANES / 2] = core::array::from_fn(|i| texel(start + i).channels());
        for (channel, plane) in block.iter_mut().enumerate() {
            for (level, channels) in plane[start..].iter_mut().zip(&channels) {
                *level = channels[channel] as i16;
            }
        }
    }
    block
}
