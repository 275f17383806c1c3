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
        Self((self.0 * (16 - share) + other.0 * share) >> 4 & LANES)
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
