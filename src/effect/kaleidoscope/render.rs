//! The frame kernel: one look-up a pixel.

use super::{Kaleidoscope, address::ADDRESSES, prepare::Planes, texture::Texel};
use crate::{
    effect::{self, RUN},
    frame::{
        Size,
        pack::{Level, Levels},
    },
    math::{Factor, mul_q15, q15},
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

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        let start = y as usize * self.size.width as usize + x;
        let place = start..start + levels.red.len();
        let Planes { addresses, table, rgb, .. } = &self.planes;
        let Some((table, _)) = table.split_first_chunk::<ADDRESSES>() else { return };
        let pixels = self.size.pixels();
        let layer = |i: usize| &addresses[i * pixels..][place.clone()];
        if addresses.len() == pixels {
            one(layer(0), table, levels);
        } else {
            four([0, 1, 2, 3].map(layer), table, levels);
        }
        if let Some(onset) = self.onset {
            let photo = rgb[place.clone()].iter();
            let mut old = [[0; 3]; RUN];
            old.iter_mut().zip(photo).for_each(|(old, &photo)| *old = photo);
            for (channel, plane) in levels.planes().into_iter().enumerate() {
                for (level, old) in plane.iter_mut().zip(&old) {
                    let old = i16::from(old[channel]) << 4;
                    *level = (old + mul_q15(*level as i16 - old, onset)) as Level;
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

/// Pixels that are taken apart together: the compiler makes lanes of them.
const BLOCK: usize = 8;

pub(super) fn one(addresses: &[u16], table: &[Texel; ADDRESSES], levels: &mut Levels<'_>) {
    let (blocks, rest) = addresses.as_chunks::<BLOCK>();
    let blocks = blocks.iter().map(|block| take_apart(block.map(|address| colour(table, address))));
    let rest = rest.iter().map(|&address| colour(table, address));
    fill(blocks, rest, levels);
}

fn four(layers: [&[u16]; 4], table: &[Texel; ADDRESSES], levels: &mut Levels<'_>) {
    let [a, b, c, d] = layers.map(|layer| layer.as_chunks::<BLOCK>().0.iter());
    let mean = |addresses: [u16; 4]| Texel::mean(addresses.map(|address| colour(table, address)));
    let texels = a
        .zip(b)
        .zip(c)
        .zip(d)
        .map(|(((a, b), c), d)| take_apart(core::array::from_fn(|i| mean([a[i], b[i], c[i], d[i]]))));
    let start = levels.red.len() / BLOCK * BLOCK;
    let rest = (start..levels.red.len()).map(|i| mean(layers.map(|layer| layer[i])));
    fill(texels, rest, levels);
}

#[inline(always)]
fn take_apart(texels: [Texel; BLOCK]) -> [[Level; BLOCK]; 3] {
    let channels = texels.map(Texel::channels);
    [channels.map(|[red, _, _]| red), channels.map(|[_, green, _]| green), channels.map(|[_, _, blue]| blue)]
}

/// Fills `levels` with the channels of whole blocks, and with those of the `rest`.
#[inline(always)]
fn fill(
    blocks: impl Iterator<Item = [[Level; BLOCK]; 3]>,
    rest: impl Iterator<Item = Texel>,
    levels: &mut Levels<'_>,
) {
    let (red, red_rest) = levels.red.as_chunks_mut::<BLOCK>();
    let (green, green_rest) = levels.green.as_chunks_mut::<BLOCK>();
    let (blue, blue_rest) = levels.blue.as_chunks_mut::<BLOCK>();
    for (((red, green), blue), channels) in red.iter_mut().zip(green).zip(blue).zip(blocks) {
        [*red, *green, *blue] = channels;
    }
    for (((red, green), blue), texel) in red_rest.iter_mut().zip(green_rest).zip(blue_rest).zip(rest) {
        [*red, *green, *blue] = texel.channels();
    }
}
