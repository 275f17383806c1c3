//! The frame kernel: one gather a pixel.

use super::{
    Autumn,
    airborne::Sprite,
    mount::Mount,
    plates::{CELLS, Light, STAGES},
    season::Now,
    species::MOST_TWIGS,
    storage::{Planes, State, Texel},
    sway::{self, OFFSET_BITS, PITCH},
};
use crate::{
    effect::{self, RUN},
    frame::{
        Size,
        pack::{Level, Levels},
        srgb,
    },
    math::{Factor, Turns, mul_q15, random::scatter},
    noise::drive::Drive,
};
use core::ops::Range;

/// An autumn at one moment.
#[derive(Debug)]
pub struct Moment<'a> {
    planes: Planes<'a>,
    mount: Mount,
    bark: [u8; 3],
    /// Whether what is behind the leaves moves with them.
    is_photo: bool,
    sprites: &'a [Sprite],
    /// What can differ from frame to frame: columns and rows.
    moving: [Range<usize>; 2],
}

/// Fills the colour of every address, for the season of `now`: the plates of two neighbouring stages, blended in linear light.
///
/// Leaves of a photo come over it within their first two stages.
pub(super) fn colour(planes: &mut Planes<'_>, now: Now, twigs: usize, is_photo: bool) {
    for (twig, calendar) in planes.calendars[..twigs].iter().enumerate() {
        let stage = now.stage(calendar);
        let (below, share) = ((stage >> 8) as usize, stage & 0xff);
        let above = (below + 1).min(STAGES - 1);
        // The sub-tile of the plate is that of the finest tree symbols.
        let tile = twig % (CELLS / 16) * 16;
        let tile = |plate: usize| &planes.plates[plate * CELLS + tile..][..16];
        let colours = &mut planes.colours[twig * 16..][..16];
        for ((colour, from), to) in colours.iter_mut().zip(tile(below)).zip(tile(above)) {
            *colour = mixed(*from, *to, share);
        }
        let there = if is_photo { (stage / 2).min(255) as u8 } else { now.leaves(calendar) };
        planes.states[twig].there = there;
        planes.states[twig + MOST_TWIGS].there = 255 - there;
    }
}

fn mixed(from: Light, to: Light, share: u32) -> u32 {
    let [red, green, blue] = core::array::from_fn(|i| {
        let light = (u32::from(from[i]) * (256 - share) + u32::from(to[i]) * share) >> 8;
        u32::from(srgb::to_srgb(light as u16))
    });
    red | green << 8 | blue << 16
}

/// How much the leaves of a twig brighten and darken at most while they flutter, of 128.
const FLUTTER: i64 = 18;

/// Sets how bright each twig's leaves are: they turn in the wind, each with a phase of its own.
pub(super) fn flutter(states: &mut [State], twigs: usize, drive: Drive) {
    let strength = i64::from((drive.amplitude * drive.onset).to_bits()) * FLUTTER;
    let twice = Turns(drive.phase.0.wrapping_mul(2));
    for (twig, state) in states[..twigs].iter_mut().enumerate() {
        let phase = Turns((scatter(twig as u64) >> 32) as u32);
        let swing = i64::from(twice.plus(phase).sin().to_bits() >> 12);
        state.gain = (128 + ((strength * swing) >> (2 * Factor::FRAC_NBITS - 12))) as u8;
    }
}

/// A run of pixels on the way from addresses to levels. What is fetched pixel by pixel stays as it is stored; all arithmetic is on whole
/// planes, in 16-bit lanes.
struct Run {
    /// Of the leaf: red, green, blue, 0.
    colour: [u32; RUN],
    /// A texel's shade, cover, bark and wood.
    marks: [u32; RUN],
    /// A state's two parts.
    state: [u16; RUN],
    /// How bright the leaf is, Q13.
    gain: [i16; RUN],
    /// How much of the pixel it covers, Q15.
    cover: [i16; RUN],
    /// How bright the wood is, Q15.
    bark: [i16; RUN],
    /// How much of the pixel it covers, Q15.
    wood: [i16; RUN],
}

impl Run {
    const EMPTY: Self = Self {
        colour: [0; RUN],
        marks: [0; RUN],
        state: [0; RUN],
        gain: [0; RUN],
        cover: [0; RUN],
        bark: [0; RUN],
        wood: [0; RUN],
    };

    /// Makes shares and gains of the first `count` marks and states.
    #[inline(always)]
    fn weigh(&mut self, count: usize) {
        for i in 0..count {
            let [shade, cover, bark, wood] = self.marks[i].to_le_bytes().map(i16::from);
            let [there, gain] = self.state[i].to_le_bytes().map(i16::from);
            // 128 of either is 1.
            self.gain[i] = mul_q15(shade << 7, gain << 7);
            self.cover[i] = mul_q15(whole(cover), whole(there));
            self.bark[i] = bark << 7;
            self.wood[i] = whole(wood);
        }
    }

    /// A channel of the first pixels: leaf over wood over what is behind.
    #[inline(always)]
    fn layer(&self, channel: usize, bark: u8, behind: impl Iterator<Item = u8>, levels: &mut [Level]) {
        let bark = i16::from(bark) << 4;
        for (i, (level, behind)) in levels.iter_mut().zip(behind).enumerate() {
            let behind = i16::from(behind) << 4;
            let wood = mul_q15(bark, self.bark[i]);
            let leaf = ((self.colour[i] >> (8 * channel)) & 0xff) as i16;
            let leaf = mul_q15(leaf << 6, self.gain[i]).min(255 << 4);
            let behind = behind + mul_q15(wood - behind, self.wood[i]);
            *level = (behind + mul_q15(leaf - behind, self.cover[i])) as Level;
        }
    }
}

/// 0..=255 to 0..=1 in Q15, both ends exact to a step.
#[inline(always)]
const fn whole(share: i16) -> i16 {
    (share << 7) | (share >> 1)
}

impl<'a> Moment<'a> {
    pub(super) fn new<S: AsMut<[u64]>>(autumn: &'a mut Autumn<S>) -> Self {
        let Autumn { mount, bark, is_photo, moving, storage, sprites, .. } = autumn;
        let Ok(planes) = Planes::carve(mount.panel, storage.as_mut()) else {
            unreachable!("the storage was long enough when the tree was prepared")
        };
        Self { planes, mount: *mount, bark: *bark, is_photo: *is_photo, sprites, moving: moving.clone() }
    }

    /// Where the pixels from (x, y) on are fetched from.
    pub(super) fn sources(&self, x: usize, y: usize, sources: &mut [u32]) {
        let (columns, _) = sway::grid(self.planes.size);
        let width = self.planes.size.width as i32;
        let (row, down) = (y / PITCH, (y % PITCH) as i32);
        let node = |column: usize, axis: usize| {
            let at = |row: usize| i32::from(self.planes.nodes[row * columns + column].offset[axis]);
            at(row) * PITCH as i32 + (at(row + 1) - at(row)) * down
        };
        let mut done = 0;
        while done < sources.len() {
            let column = (x + done) / PITCH;
            let right = (x + done) % PITCH;
            let count = (PITCH - right).min(sources.len() - done);
            let from = [0, 1].map(|axis| node(column, axis));
            let slope = [0, 1].map(|axis| (node(column + 1, axis) - from[axis]) / PITCH as i32);
            const ONE: u32 = OFFSET_BITS + PITCH.trailing_zeros();
            let half = 1 << (ONE - 1);
            let mut at = [0, 1].map(|axis| from[axis] + slope[axis] * right as i32 + half);
            let start = (y as i32) * width + (x + done) as i32;
            for (i, source) in sources[done..done + count].iter_mut().enumerate() {
                *source = (start + i as i32 + (at[0] >> ONE) + (at[1] >> ONE) * width) as u32;
                at = [at[0] + slope[0], at[1] + slope[1]];
            }
            done += count;
        }
    }

    /// Fetches what the run shows: of each pixel its texel, and by its address a colour and a state.
    fn fetch(&self, sources: &[u32], run: &mut Run) {
        let (texels, colours, states) = (&*self.planes.texels, &*self.planes.colours, &*self.planes.states);
        let last = texels.len() - 1;
        let out = run.colour.iter_mut().zip(&mut run.marks).zip(&mut run.state);
        for (((colour, marks), state), &source) in out.zip(sources) {
            let texel: Texel = texels[(source as usize).min(last)];
            *colour = colours[usize::from(texel.address)];
            *marks = u32::from_le_bytes([texel.shade, texel.cover, texel.bark, texel.wood]);
            let State { there, gain } = states[usize::from(texel.depth) % (2 * MOST_TWIGS)];
            *state = u16::from_le_bytes([there, gain]);
        }
        run.weigh(sources.len());
    }

    /// Paints the leaves in the air over the run.
    fn sprites(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        let (x, y, length) = (x as i32, y as i32, levels.red.len() as i32);
        let touches = |sprite: &&Sprite| {
            (sprite.rows.0..sprite.rows.1).contains(&y)
                && sprite.columns.0 < x + length
                && sprite.columns.1 > x
        };
        for sprite in self.sprites.iter().filter(touches) {
            for column in sprite.columns.0.max(x)..sprite.columns.1.min(x + length) {
                let [across, down] = self.mount.pixel(column, y);
                let cell = sprite.lens.cell(self.planes.stencil, across, down);
                if cell.cover == 0 {
                    continue;
                }
                let colour = self.planes.colours[usize::from(sprite.twig) << 4 | usize::from(cell.address)];
                let cover = i32::from(cell.cover) + i32::from(cell.cover >> 7);
                for (channel, plane) in levels.planes().into_iter().enumerate() {
                    let level = &mut plane[(column - x) as usize];
                    let leaf =
                        (((colour >> (8 * channel) & 0xff) * u32::from(sprite.gain)) >> 3).min(4_080) as i32;
                    *level = (i32::from(*level) + (((leaf - i32::from(*level)) * cover) >> 8)) as u16;
                }
            }
        }
    }
}

impl effect::Moment for Moment<'_> {
    fn size(&self) -> Size {
        self.planes.size
    }

    fn moving(&self, y: u32) -> impl Iterator<Item = Range<usize>> {
        let [columns, rows] = &self.moving;
        rows.contains(&(y as usize)).then(|| columns.clone()).into_iter()
    }

    fn levels(&self, x: usize, y: u32, levels: &mut Levels<'_>) {
        let count = levels.red.len();
        let start = y as usize * self.planes.size.width as usize + x;
        let behind = &self.planes.background[start..start + count];
        let span = self.planes.spans[y as usize];
        if x + count <= usize::from(span.start) || x >= usize::from(span.end) {
            for (channel, plane) in levels.planes().into_iter().enumerate() {
                plane
                    .iter_mut()
                    .zip(behind)
                    .for_each(|(level, pixel)| *level = u16::from(pixel[channel]) << 4);
            }
        } else {
            let mut sources = [0; RUN];
            self.sources(x, y as usize, &mut sources[..count]);
            let mut run = Run::EMPTY;
            self.fetch(&sources[..count], &mut run);
            for (channel, plane) in levels.planes().into_iter().enumerate() {
                let bark = self.bark[channel];
                if self.is_photo {
                    let all = &*self.planes.background;
                    let moved =
                        sources[..count].iter().map(|&at| all[(at as usize).min(all.len() - 1)][channel]);
                    run.layer(channel, bark, moved, plane);
                } else {
                    run.layer(channel, bark, behind.iter().map(|pixel| pixel[channel]), plane);
                }
            }
        }
        self.sprites(x, y, levels);
    }
}
