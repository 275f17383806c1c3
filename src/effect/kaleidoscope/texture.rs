//! The reference photo, blurred to the size of the boxes that its colours are taken from.
//!
//! T[s1 … sM] is the mean colour over a square of 1/4^M of the photo's sides. All those squares are of one size, so the means around
//! every place are found once: a colour is then one look-up, and there are no point samples that could sparkle.

use crate::effect::storage::{take, words};
use crate::{
    effect::StorageTooSmall,
    frame::{Size, pack::Level, srgb},
};
use bytemuck::{Pod, Zeroable};

/// Pixels of a side; the photo is stretched to a square.
pub(super) const SIDE: usize = 256;

/// Texels: those of the square, and room for the neighbours, of no weight, of the last ones.
pub(super) const TEXELS: usize = SIDE * SIDE + SIDE + 1;

/// A colour: red, green and blue in the lower 16-bit lanes of a word, so that sums and weighted means take one step for all three.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(transparent)]
pub(super) struct Texel(u64);

/// 12 bits of each lane.
const LANES: u64 = 0x0fff_0fff_0fff;

impl Texel {
    pub(super) const fn new([r, g, b]: [Level; 3]) -> Self {
        Self(r as u64 | (g as u64) << 16 | (b as u64) << 32)
    }

    #[inline(always)]
    pub(super) const fn channels(self) -> [Level; 3] {
        [self.0 as u16, (self.0 >> 16) as u16, (self.0 >> 32) as u16]
    }

    /// The colour `share` sixteenths of the way to `other`, rounded down: 12 bits and 4 are a lane.
    #[inline(always)]
    pub(super) const fn towards(self, other: Self, share: u64) -> Self {
        // What a lane of the difference borrows from the next, the sum gives back.
        Self((self.0 << 4).wrapping_add(other.0.wrapping_sub(self.0).wrapping_mul(share)) >> 4 & LANES)
    }

    /// The mean of colours, rounded down.
    pub(super) fn mean_of(colours: &[Self]) -> Self {
        // Red and blue in the halves of one sum, which are wide enough for what a window has.
        let (mut red_and_blue, mut green) = (0_u64, 0_u64);
        for colour in colours {
            red_and_blue += colour.0 & 0x0000_ffff_0000_ffff;
            green += colour.0 >> 16 & 0xffff;
        }
        let sums = [red_and_blue & 0xffff_ffff, green, red_and_blue >> 32];
        Self::new(sums.map(|sum| (sum / colours.len().max(1) as u64) as Level))
    }

    /// The mean of four colours, rounded down.
    #[inline(always)]
    pub(super) const fn mean([a, b, c, d]: [Self; 4]) -> Self {
        Self((a.0 + b.0 + c.0 + d.0) >> 2 & LANES)
    }

    /// The luma, in levels.
    pub(super) const fn luma(self) -> Level {
        let [r, g, b] = self.channels();
        ((r as u32 * 218 + g as u32 * 732 + b as u32 * 74 + 512) >> 10) as Level
    }
}

/// How colours are made darker or lighter, all channels alike; Q12.
#[derive(Clone, Copy, Debug)]
pub(super) struct Toning {
    /// They are scaled by this, and cut at white.
    pub(super) scale: u16,
    /// Then they are brought so far to white.
    pub(super) white: u16,
}

impl Toning {
    /// What changes nothing.
    pub(super) const NONE: Self = Self { scale: 1 << 12, white: 0 };

    #[inline(always)]
    fn of(self, level: Level) -> Level {
        const WHITE: Level = 255 << 4;
        // Products of 16 bits of which the upper half is taken: there are lanes for that.
        let part = |level: Level, factor: u16| ((u32::from(level << 4) * u32::from(factor)) >> 16) as u16;
        let scaled = part(level, self.scale).min(WHITE);
        scaled + part(WHITE - scaled, self.white)
    }
}

/// Brings the colours of `table` `share` sixteenths of the way to the toned `fresh` ones, rounded to nearest.
pub(super) fn approach(table: &mut [Texel], fresh: &[Texel], toning: Toning, share: u16) {
    // Lane by lane. What becomes of the uppermost, which is no colour, is the same for all, and nobody looks at it.
    let fresh: &[Level] = bytemuck::cast_slice(fresh);
    for (old, &new) in bytemuck::cast_slice_mut::<Texel, Level>(table).iter_mut().zip(fresh) {
        *old = (*old * (16 - share) + toning.of(new) * share + 8) >> 4;
    }
}

/// A picture whose colours are taken: sRGB, 3 bytes a pixel, row by row.
#[derive(Clone, Copy, Debug)]
pub struct Reference<'a> {
    /// Width and height in pixels.
    pub size: Size,
    /// Red, green, blue of every pixel.
    pub rgb: &'a [u8],
}

/// Words of 64 bits that preparing a texture takes besides the texture.
pub(super) const fn scratch_len() -> usize {
    2 * words::<u16>(SIDE * SIDE)
}

/// Fills `texels` with the means over squares of `1/4^depth` of the sides, in linear light, mirrored at the edges.
pub(super) fn fill(
    reference: Reference<'_>,
    depth: u32,
    texels: &mut [Texel],
    mut scratch: &mut [u64],
) -> Result<(), StorageTooSmall> {
    let too_small = StorageTooSmall { needed: scratch_len(), got: scratch.len() };
    let memory = &mut scratch;
    let planes = take::<u16>(memory, SIDE * SIDE).zip(take::<u16>(memory, SIDE * SIDE));
    let (plane, other) = planes.ok_or(too_small)?;
    let radius = SIDE >> (2 * depth + 1);
    for channel in 0..3 {
        shrink(reference, channel, plane);
        blur_rows_transposed(plane, radius, other);
        blur_rows_transposed(other, radius, plane);
        for (texel, &light) in texels.iter_mut().zip(&*plane) {
            let mut channels = texel.channels();
            channels[channel] = level(light);
            *texel = Texel::new(channels);
        }
    }
    Ok(())
}

/// The mean light of the pixels of `reference` that lie in each of the plane's.
fn shrink(reference: Reference<'_>, channel: usize, plane: &mut [u16]) {
    let Size { width, height } = reference.size;
    let span = |i: usize, length: u32| {
        let at = |i: usize| i * length as usize / SIDE;
        at(i)..at(i + 1).max(at(i) + 1)
    };
    for (y, row) in plane.chunks_exact_mut(SIDE).enumerate() {
        for (x, out) in row.iter_mut().enumerate() {
            let (mut sum, mut count) = (0_u64, 0_u64);
            for v in span(y, height) {
                for u in span(x, width) {
                    sum += u64::from(srgb::to_linear(reference.rgb[3 * (v * width as usize + u) + channel]));
                    count += 1;
                }
            }
            *out = ((sum + count / 2) / count) as u16;
        }
    }
}

/// The means over `radius` pixels to each side along the rows of `from`, into the columns of `to`.
fn blur_rows_transposed(from: &[u16], radius: usize, to: &mut [u16]) {
    let mirrored = |at: isize| {
        let at = if at < 0 { -1 - at } else { at };
        if at < SIDE as isize { at as usize } else { 2 * SIDE - 1 - at as usize }
    };
    let (reach, count) = (radius as isize, 2 * radius as u32 + 1);
    for (y, row) in from.chunks_exact(SIDE).enumerate() {
        let light = |at: isize| u32::from(row[mirrored(at)]);
        let mut sum: u32 = (-reach..reach).map(light).sum();
        for x in 0..SIDE {
            sum += light(x as isize + reach);
            to[x * SIDE + y] = ((sum + count / 2) / count) as u16;
            sum -= light(x as isize - reach);
        }
    }
}

/// The coded level, with its four fractional bits, of a linear light.
fn level(light: u16) -> Level {
    let near = srgb::to_srgb(light);
    let below = if srgb::to_linear(near) > light { near - 1 } else { near };
    let start = srgb::to_linear(below);
    let step = srgb::to_linear(below.saturating_add(1)) - start;
    let rest = u32::from(light - start) * 16;
    u16::from(below) * 16 + (rest.checked_div(u32::from(step))).unwrap_or(0) as u16
}
