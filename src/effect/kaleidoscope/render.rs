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

pub(super) fn one(addresses: &[u16], table: &[Texel; ADDRESSES], levels: &mut Levels<'_>) {
    let channels = levels.red.iter_mut().zip(&mut *levels.green).zip(&mut *levels.blue);
    for (((red, green), blue), &address) in channels.zip(addresses) {
        [*red, *green, *blue] = colour(table, address).channels();
    }
}

fn four([a, b, c, d]: [&[u16]; 4], table: &[Texel; ADDRESSES], levels: &mut Levels<'_>) {
    let channels = levels.red.iter_mut().zip(&mut *levels.green).zip(&mut *levels.blue);
    let addresses = a.iter().zip(b).zip(c).zip(d);
    for (((red, green), blue), (((&a, &b), &c), &d)) in channels.zip(addresses) {
        [*red, *green, *blue] = Texel::mean([a, b, c, d].map(|address| colour(table, address))).channels();
    }
}
