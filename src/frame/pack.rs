//! From colours to the bytes of a pixel format.

use super::{PixelFormat, dither};
use crate::math::{
    lanes::{LANES, Lanes, Task, on_widest},
    mul_q15,
};

/// A colour channel with 4 fractional bits: 8-bit levels × 16, so 0..=4080.
pub type Level = u16;

/// The full level.
pub const WHITE: Level = 255 << 4;

/// The colours of sixteen pixels side by side, a row of levels a channel: red, green, blue. Where levels are not said to be within 0..=4080, they may go up to 2^15 − 256,
/// and are brought within when they are packed.
pub type Block = [[i16; LANES]; 3];

/// Levels that may lie beyond 0..=4080, brought within.
#[inline(always)]
pub fn clipped<L: Lanes>(levels: L) -> L {
    levels.at_least(L::splat(0)).at_most(L::splat(WHITE as i16))
}

/// Writes the pixels of `blocks` into `out`, of row `y`, without the first `skip` of them (fewer than 16), until it is full.
///
/// Levels are brought to the format's own steps by ordered dithering with the fixed tile of [`dither`]: what the format can
/// show exactly stays exact, and the mean over a tile is within 1/256 of a step of the level asked for.
pub fn pack(format: PixelFormat, blocks: &[Block], skip: usize, y: u32, out: &mut [u8]) {
    on_widest(Packing { format, blocks, skip, y, out });
}

struct Packing<'a> {
    format: PixelFormat,
    blocks: &'a [Block],
    skip: usize,
    y: u32,
    out: &'a mut [u8],
}

impl Task for Packing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        // A loop for each of the formats that panels commonly have.
        match self.format {
            PixelFormat::Xrgb8888 => self.blocks::<L>(PixelFormat::Xrgb8888),
            PixelFormat::Rgb565 => self.blocks::<L>(PixelFormat::Rgb565),
            format => self.blocks::<L>(format),
        }
    }
}

impl Packing<'_> {
    #[inline(always)]
    fn blocks<L: Lanes>(self, format: PixelFormat) {
        let (bytes, thresholds) = (format.bytes_per_pixel(), thresholds::<L>(self.y));
        let (mut skip, mut out) = (self.skip, self.out);
        for [red, green, blue] in self.blocks {
            let colours = [L::load(red), L::load(green), L::load(blue)];
            let length = out.len().min((LANES - skip) * bytes);
            let (pixels, rest) = out.split_at_mut(length);
            if length == LANES * bytes {
                pack_block(format, colours, thresholds, pixels);
            } else {
                let mut whole = [0; LANES * 4];
                pack_block(format, colours, thresholds, &mut whole[..LANES * bytes]);
                pixels.copy_from_slice(&whole[skip * bytes..][..length]);
            }
            (skip, out) = (0, rest);
        }
    }
}

/// Writes the pixels of a block into `out`, which has room for just them. `thresholds` are those of the row.
#[inline(always)]
pub(crate) fn pack_block<L: Lanes>(format: PixelFormat, colours: [L; 3], thresholds: L, out: &mut [u8]) {
    let bgr = [colours[2], colours[1], colours[0]];
    match format {
        PixelFormat::Xrgb8888 => pack_8888(bgr, thresholds, out),
        PixelFormat::Xbgr8888 => pack_8888(colours, thresholds, out),
        PixelFormat::Rgb565 => pack_565(colours, thresholds, out),
        PixelFormat::Bgr565 => pack_565(bgr, thresholds, out),
        PixelFormat::Rgb888 | PixelFormat::Bgr888 | PixelFormat::Xrgb2101010 => {
            let (mut block, mut own) = ([[0; LANES]; 3], [0; LANES]);
            let [red, green, blue] = &mut block;
            colours[0].store(red);
            colours[1].store(green);
            colours[2].store(blue);
            thresholds.store(&mut own);
            pack_plainly(format, &block, &own, out);
        }
    }
}

/// The thresholds of row `y` for [`pack_block`].
#[inline(always)]
pub(crate) fn thresholds<L: Lanes>(y: u32) -> L {
    L::load_q7(dither::thresholds(y)).down::<7>()
}

#[inline(always)]
fn pack_8888<L: Lanes>(channels: [L; 3], thresholds: L, out: &mut [u8]) {
    if let Some(out) = out.first_chunk_mut() {
        let thresholds = thresholds.down::<4>();
        let [a, b, c] = channels;
        L::store_pixels([a.plus(thresholds), b.plus(thresholds), c.plus(thresholds)], out);
    }
}

#[inline(always)]
fn pack_565<L: Lanes>([high, green, low]: [L; 3], thresholds: L, out: &mut [u8]) {
    if let Some(out) = out.first_chunk_mut() {
        let steps = |levels: L, steps: i16| clipped(levels).up::<3>().times(L::splat(steps)).plus(thresholds);
        let high = steps(high, STEPS_5).and(L::splat(0x1f00)).up::<3>();
        let green = steps(green, STEPS_6).and(L::splat(0x3f00)).down::<3>();
        high.or(green).or(steps(low, STEPS_5).down::<8>()).store_words(out);
    }
}

/// [`pack_block`] a pixel at a time, which the others equal to the bit.
#[inline(never)]
fn pack_plainly(format: PixelFormat, block: &Block, thresholds: &[i16; LANES], out: &mut [u8]) {
    let level = |channel: usize, i: usize| block[channel][i].clamp(0, WHITE as i16) as Level;
    for (i, out) in out.chunks_exact_mut(format.bytes_per_pixel()).enumerate() {
        let ([r, g, b], t) = ([level(0, i), level(1, i), level(2, i)], thresholds[i] as u32);
        let pixel = match format {
            PixelFormat::Xrgb8888 => 0xff00_0000 | to_8(r, t) << 16 | to_8(g, t) << 8 | to_8(b, t),
            PixelFormat::Xbgr8888 => 0xff00_0000 | to_8(b, t) << 16 | to_8(g, t) << 8 | to_8(r, t),
            PixelFormat::Rgb888 => to_8(r, t) << 16 | to_8(g, t) << 8 | to_8(b, t),
            PixelFormat::Bgr888 => to_8(b, t) << 16 | to_8(g, t) << 8 | to_8(r, t),
            PixelFormat::Rgb565 => to_5(r, t) << 11 | to_6(g, t) << 5 | to_5(b, t),
            PixelFormat::Bgr565 => to_5(b, t) << 11 | to_6(g, t) << 5 | to_5(r, t),
            PixelFormat::Xrgb2101010 => 0xc000_0000 | to_10(r, t) << 20 | to_10(g, t) << 10 | to_10(b, t),
        };
        out.copy_from_slice(&pixel.to_le_bytes()[..out.len()]);
    }
}

/// 16 thresholds suffice for the 4 fractional bits.
#[inline(always)]
const fn to_8(level: Level, threshold: u32) -> u32 {
    (level as u32 + (threshold >> 4)) >> 4
}

/// 31 steps of 256 for the full level times 8, in Q15, rounded down: with the topmost threshold that still is step 31.
const STEPS_5: i16 = 7_967;

/// 63 steps of 256 for the full level times 8, in Q15.
const STEPS_6: i16 = 16_191;

#[inline(always)]
const fn to_5(level: Level, threshold: u32) -> u32 {
    (mul_q15((level << 3) as i16, STEPS_5) as u32 + threshold) >> 8
}

#[inline(always)]
const fn to_6(level: Level, threshold: u32) -> u32 {
    (mul_q15((level << 3) as i16, STEPS_6) as u32 + threshold) >> 8
}

/// 262916/2^20 is 1023/4080, high by 0.004 of a step at full level.
#[inline(always)]
const fn to_10(level: Level, threshold: u32) -> u32 {
    (level as u32 * 262_916 + threshold * 4096) >> 20
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::on_each;
    use proptest::prelude::*;

    fn packed(format: PixelFormat, level: Level, x: usize, y: u32) -> [u8; 3] {
        let mut out = [0; 4];
        let block = [[level as i16; LANES]; 3];
        pack(format, &[block], x, y, &mut out[..format.bytes_per_pixel()]);
        format.unpack(&out)
    }

    /// The pixels from `skip` on, a pixel at a time.
    fn plainly(format: PixelFormat, blocks: &[Block], skip: usize, y: u32, count: usize) -> Vec<u8> {
        let thresholds = dither::thresholds(y).map(i16::from);
        let bytes = format.bytes_per_pixel();
        let mut whole = vec![0; blocks.len() * LANES * bytes];
        for (block, out) in blocks.iter().zip(whole.chunks_exact_mut(LANES * bytes)) {
            pack_plainly(format, block, &thresholds, out);
        }
        whole[skip * bytes..][..count * bytes].to_vec()
    }

    /// [`Packing`] into memory of its own.
    struct Packed<'a> {
        format: PixelFormat,
        blocks: &'a [Block],
        skip: usize,
        y: u32,
        bytes: usize,
    }

    impl Task for Packed<'_> {
        type Output = Vec<u8>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u8> {
            let Self { format, blocks, skip, y, bytes } = self;
            let mut out = vec![0; bytes];
            Packing { format, blocks, skip, y, out: &mut out }.run::<L>();
            out
        }
    }

    proptest! {
        #[test]
        fn blocks_are_packed_like_their_pixels(
            blocks: [Block; 3], y in 0_u32..40, skip in 0..LANES, count in 0..=2 * LANES
        ) {
            // The room that dithering needs above.
            let blocks = blocks.map(|block| block.map(|plane| plane.map(|level| level.min(i16::MAX - 255))));
            for format in PixelFormat::ALL {
                let plain = plainly(format, &blocks, skip, y, count);
                let bytes = count * format.bytes_per_pixel();
                for (name, packed) in on_each(|| Packed { format, blocks: &blocks, skip, y, bytes }) {
                    prop_assert_eq!(&packed, &plain, "{} {}", name, format);
                }
            }
        }
    }

    #[test]
    fn levels_of_8_bits_pass_unchanged_through_the_formats_that_hold_them() {
        for format in PixelFormat::ALL.into_iter().filter(|f| f.bytes_per_pixel() > 2) {
            for level in 0..=255_u16 {
                for x in 0..16 {
                    assert_eq!(
                        packed(format, level * 16, x, x as u32 / 3),
                        [level as u8; 3],
                        "{format} {level}"
                    );
                }
            }
        }
    }

    #[test]
    fn black_and_white_stay_pure_in_every_format() {
        for format in PixelFormat::ALL {
            for at in 0..256 {
                assert_eq!(packed(format, 0, at as usize % 16, at / 16), [0; 3], "{format}");
                assert_eq!(packed(format, 4080, at as usize % 16, at / 16), [255; 3], "{format}");
            }
        }
    }

    #[test]
    fn the_mean_over_a_tile_is_the_level_asked_for() {
        for format in PixelFormat::ALL {
            // `unpack` rounds to 8 bits: by up to half a level from 10 bits, and nearly one from 5.
            let bound = match format {
                PixelFormat::Rgb565 | PixelFormat::Bgr565 => 1.3,
                PixelFormat::Xrgb2101010 => 0.57,
                _ => 0.07,
            };
            for level in (0..=4080).step_by(17) {
                let sums = (0..256).map(|at| packed(format, level, at as usize % 16, at / 16).map(f64::from));
                let mean = sums.fold([0.0; 3], |sum, rgb| core::array::from_fn(|i| sum[i] + rgb[i] / 256.0));
                for channel in mean {
                    let error = (channel - f64::from(level) / 16.0).abs();
                    assert!(error < bound, "{format}: level {level}/16 shows as {channel}");
                }
            }
        }
    }

    #[test]
    fn channels_land_where_the_format_says() {
        let block = [255, 128, 0].map(|level| [level * 16; LANES]);
        for format in PixelFormat::ALL {
            let mut out = [0; 4];
            pack(format, &[block], 0, 0, &mut out[..format.bytes_per_pixel()]);
            let [r, g, b] = format.unpack(&out);
            assert!(r == 255 && g.abs_diff(128) < 5 && b == 0, "{format}: {r} {g} {b}");
        }
    }
}
