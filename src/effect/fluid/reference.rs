//! The slow twin: what a clip shows, in f64, literal to the formulas of the module's head; and clips to try it with.

use super::{
    Base, Clip, Fluid, Header, Kind, Shape, Tint, View,
    clip::{self, Entry},
    code::{Extent, Planes, encode, most_bytes},
    storage_len,
};
use crate::{
    effect::{Effect, Moment as _},
    frame::{Rect, Rotation, Size},
    math::{Factor, Turns, lanes::LANES},
    noise::drive::Drive,
};
use proptest::prelude::*;

/// What a clip is made of.
#[derive(Clone, Debug)]
pub(super) struct Film {
    pub(super) shape: Shape,
    pub(super) matte: Vec<u8>,
    pub(super) tint: Tint,
    pub(super) correlation: u16,
    pub(super) frames: Vec<Vec<i8>>,
}

impl Film {
    /// A film of noise that is as coarse as `coarse` says, beside a still edge.
    pub(super) fn drawn(kind: Kind, grid: Size, seed: u64, coarse: u32) -> Self {
        let base = Size::new(grid.width * 3, grid.height * 2);
        let rect = Rect { x: 1, y: 1, size: Size::new(base.width - 1, base.height - 1) };
        let shape = Shape { kind, millihertz: 25_000, step: 1 + (seed % 3) as u8, base, grid, rect };
        let mut state = seed | 1;
        let mut noise = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 56) as u8
        };
        let matte: Vec<u8> = (0..grid.pixels())
            .map(|i| if (i as u32).is_multiple_of(grid.width) { 0 } else { noise().saturating_mul(2) })
            .collect();
        let extents: Vec<Extent> = matte.chunks(grid.width as usize).map(Extent::of).collect();
        let inside = |i: usize| {
            let extent = extents[i % grid.pixels() / grid.width as usize];
            (extent.start..extent.end).contains(&((i % grid.width as usize) as u16))
        };
        let mut value = |i| if inside(i) { (noise() as i8).max(-127) >> coarse } else { 0 };
        let frames = (0..4).map(|_| (0..shape.values()).map(&mut value).collect()).collect();
        let tint = Tint(core::array::from_fn(|i| [64, 20 + i as u8 / 2, 255 - i as u8]));
        Self { shape, matte, tint, correlation: (seed >> 40) as u16 & 0x7fff, frames }
    }

    /// The bytes of its file, with nine bytes that are no photo for a base.
    pub(super) fn file(&self) -> Vec<u8> {
        let (width, values) = (self.shape.grid.width as usize, self.shape.values());
        let (mut residuals, mut packed) = (vec![0; values], vec![0; most_bytes(values)]);
        let mut pack = |extents: &[Extent], count, values: &mut Vec<i8>| {
            let length = encode(&Planes { width, extents, count }, values, &mut residuals, &mut packed);
            packed[..length].to_vec()
        };
        let all = vec![Extent { start: 0, end: width as u16 }; self.shape.grid.height as usize];
        let matte = pack(&all, 1, &mut bytemuck::cast_slice(&self.matte).to_vec());
        let tint = self.tint.0.as_flattened();
        let mut file = [&[0; clip::HEADER], tint, &matte, b"no photo."].concat();
        let extents: Vec<Extent> = self.matte.chunks(width).map(Extent::of).collect();
        let (mut index, mut longest) = (Vec::new(), 0);
        for frame in &self.frames {
            let bytes = pack(&extents, self.shape.kind.planes(), &mut frame.clone());
            index.extend(Entry::of(file.len() as u64, &bytes).write());
            longest = longest.max(bytes.len() as u32);
            file.extend(bytes);
        }
        let checksums = [tint, &matte, b"no photo.", &index].map(clip::part_checksum);
        file.extend(index);
        let header = Header {
            shape: self.shape,
            correlation: self.correlation,
            frames: self.frames.len() as u32,
            matte: matte.len() as u32,
            picture: 9,
            longest,
            length: file.len() as u64,
            checksums,
        };
        file[..clip::HEADER].copy_from_slice(&header.write());
        file
    }

    /// A value between the pixels of a plane of the grid; `None` beyond what the grid covers.
    fn between(&self, plane: impl Fn(usize) -> f64, panel: Size, (x, y): (u32, u32)) -> Option<f64> {
        let Shape { base, grid, rect, .. } = self.shape;
        let place = |at: u32, panel: u32, base: u32, start: u32, part: u32, grid: u32| {
            let on_base = (f64::from(at) + 0.5) * f64::from(base) / f64::from(panel);
            let on_part = (on_base - f64::from(start)) / f64::from(part);
            let on_grid = (on_part * f64::from(grid) - 0.5).clamp(0.0, f64::from(grid - 1));
            (0.0..1.0).contains(&on_part).then_some(on_grid)
        };
        let x = place(x, panel.width, base.width, rect.x, rect.size.width, grid.width)?;
        let y = place(y, panel.height, base.height, rect.y, rect.size.height, grid.height)?;
        let (width, height) = (grid.width as usize, grid.height as usize);
        let at = |x: usize, y: usize| plane(y.min(height - 1) * width + x.min(width - 1));
        let (left, top) = (x as usize, y as usize);
        let (across, down) = (x.fract(), y.fract());
        let line = |y| at(left, y) * (1.0 - across) + at(left + 1, y) * across;
        Some(line(top) * (1.0 - down) + line(top + 1) * down)
    }

    /// The colour of a pixel whose base is `rgb`, `share` of the way from one of the `frames` to the other, at a strength.
    fn shown(
        &self,
        rgb: [u8; 3],
        frames: [usize; 2],
        share: f64,
        strength: f64,
        panel: Size,
        at: (u32, u32),
    ) -> [f64; 3] {
        let correlation = f64::from(self.correlation) / 32_768.0;
        let contrast =
            ((1.0 - share).powi(2) + share.powi(2) + 2.0 * share * (1.0 - share) * correlation).sqrt();
        let luma = crate::effect::kaleidoscope::luma(rgb);
        core::array::from_fn(|channel| {
            let plane = if self.shape.kind == Kind::Colour { channel * self.shape.grid.pixels() } else { 0 };
            let change = |i: usize| {
                let [from, to] = frames.map(|frame| f64::from(self.frames[frame][plane + i]));
                let units = (from * (1.0 - share) + to * share) / contrast * strength;
                (units * f64::from(self.shape.step)).clamp(-255.0, 255.0)
            };
            let tint = match self.shape.kind {
                Kind::Luma => f64::from(self.tint.0[usize::from(luma)][channel]) / 64.0,
                Kind::Colour => 1.0,
            };
            let matte = self.between(|i| f64::from(self.matte[i]) / 255.0, panel, at).unwrap_or(0.0);
            let change = self.between(change, panel, at).unwrap_or(0.0);
            (f64::from(rgb[channel]) + matte * tint * change).clamp(0.0, 255.0)
        })
    }
}

/// A drive at a phase.
pub(super) fn drive(phase: u32, amplitude: f64) -> Drive {
    Drive {
        amplitude: Factor::from_num(amplitude),
        frequency: Factor::ONE,
        phase: Turns(phase),
        onset: Factor::ONE,
    }
}

/// All colours of a moment, with 4 fractional bits.
pub(super) fn colours(moment: &super::Moment<'_>) -> Vec<[u16; 3]> {
    let Size { width, height } = moment.size();
    let mut all = Vec::new();
    for y in 0..height {
        let mut blocks = vec![[[0; LANES]; 3]; (width as usize).div_ceil(LANES)];
        moment.colours(0, y, &mut blocks);
        let level = |x: usize, channel: usize| blocks[x / LANES][channel][x % LANES].clamp(0, 4080) as u16;
        all.extend((0..width as usize).map(|x| [0, 1, 2].map(|channel| level(x, channel))));
    }
    all
}

/// A base of noise.
pub(super) fn base(size: Size) -> Vec<u8> {
    (0..size.pixels() * 3).map(|i| (i * i / 7 % 251) as u8).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn a_frame_is_that_of_the_twin(
        colour: bool, width in 1_u32..24, height in 1_u32..12, panel in (1_u32..50, 1_u32..30),
        seed: u64, coarse in 0_u32..4, amplitude in 0.0..=1.0_f64, turned in 0.001..0.499_f64,
    ) {
        let kind = if colour { Kind::Colour } else { Kind::Luma };
        let film = Film::drawn(kind, Size::new(width, height), seed, coarse);
        let (file, panel) = (film.file(), Size::new(panel.0, panel.1));
        let clip = Clip::open(&file[..]).unwrap();
        let rgb = base(panel);
        let mut storage = vec![0; storage_len(clip.header(), panel, Rotation::None)];
        let base = Base { size: panel, rgb: &rgb, view: View::whole(panel) };
        let mut fluid = Fluid::prepare(clip, base, Factor::ONE, &mut storage).unwrap();

        fluid.at(drive(0, amplitude));
        let got = colours(&fluid.at(drive((turned * 4_294_967_296.0) as u32, amplitude)));
        let position = turned * 25.0 * 5.0 / 3.0;
        let first = position.floor() as usize % 4;
        let haste = (4.0 * position - 1.0).clamp(1.0, 63.0);
        let share = ((position.fract() - 0.5) * haste + 0.5).clamp(0.0, 1.0);
        let range = if colour { 0.5 } else { 1.0 };
        let strength = 1.0 + range * (amplitude - 0.5);
        for (i, (got, &rgb)) in got.iter().zip(rgb.as_chunks::<3>().0).enumerate() {
            let at = (i as u32 % panel.width, i as u32 / panel.width);
            let want = film.shown(rgb, [first, (first + 1) % 4], share, strength, panel, at);
            for channel in 0..3 {
                let error = (f64::from(got[channel]) / 16.0 - want[channel]).abs();
                // A gain of 64ths is off by 1/128 of a change of up to 255, and a little for each of the roundings.
                prop_assert!(error < 2.5, "{:?}, channel {}: {} instead of {}", at, channel, f64::from(got[channel]) / 16.0, want[channel]);
            }
        }
    }
}
