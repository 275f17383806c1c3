//! From colours to the bytes of a pixel format.

use super::{PixelFormat, dither};
use crate::math::{
    lanes::{LANES, Lanes},
    mul_q15,
};

/// A colour channel with 4 fractional bits: 8-bit levels × 16, so 0..=4080.
pub type Level = u16;

/// The full level.
pub const WHITE: Level = 255 << 4;

/// Colours of a run of pixels, a plane a channel, all of one length.
#[derive(Debug)]
pub struct Levels<'a> {
    /// Red.
    pub red: &'a mut [Level],
    /// Green.
    pub green: &'a mut [Level],
    /// Blue.
    pub blue: &'a mut [Level],
}

impl Levels<'_> {
    /// The three planes, to be treated alike.
    pub fn planes(&mut self) -> [&mut [Level]; 3] {
        [self.red, self.green, self.blue]
    }
}

/// Levels that may lie beyond 0..=4080, brought within.
#[inline(always)]
pub fn clipped<L: Lanes>(levels: L) -> L {
    levels.at_least(L::splat(0)).at_most(L::splat(WHITE as i16))
}

/// Writes the pixels of a block into `out`, which has room for just them: those of [`pack`] on the [`clipped`] levels. `thresholds` are those
/// of the row.
#[inline(always)]
pub fn pack_block<L: Lanes>(format: PixelFormat, colours: [L; 3], thresholds: L, out: &mut [u8]) {
    let bgr = [colours[2], colours[1], colours[0]];
    match format {
        PixelFormat::Xrgb8888 => pack_8888(bgr, thresholds, out),
        PixelFormat::Xbgr8888 => pack_8888(colours, thresholds, out),
        PixelFormat::Rgb565 => pack_565(colours, thresholds, out),
        PixelFormat::Bgr565 => pack_565(bgr, thresholds, out),
        PixelFormat::Rgb888 | PixelFormat::Bgr888 | PixelFormat::Xrgb2101010 => {
            let mut planes = [[0; LANES]; 3];
            for (plane, levels) in planes.iter_mut().zip(colours) {
                clipped(levels).store(bytemuck::cast_mut(plane));
            }
            let mut own = [0; LANES];
            thresholds.store(&mut own);
            let [red, green, blue] = planes.each_mut().map(|plane| &mut plane[..]);
            pack_with(format, &Levels { red, green, blue }, &own.map(|t| t as u8), 0, out);
        }
    }
}

/// The thresholds of row `y` for [`pack_block`].
#[inline(always)]
pub fn thresholds<L: Lanes>(y: u32) -> L {
    L::load_q7(dither::thresholds(y)).down::<7>()
}

#[inline(always)]
fn pack_8888<L: Lanes>(channels: [L; 3], thresholds: L, out: &mut [u8]) {
    if let Some(out) = out.first_chunk_mut() {
        let thresholds = thresholds.down::<4>();
        L::store_pixels(channels.map(|levels| levels.plus(thresholds)), out);
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

/// Writes pixels `x`.. of row `y` into `out`, whose length is that of the run in `format`.
///
/// Levels are brought to the format's own steps by ordered dithering with the fixed tile of [`dither`]: what the format can
/// show exactly stays exact, and the mean over a tile is within 1/256 of a step of the level asked for.
pub fn pack(format: PixelFormat, colours: &Levels<'_>, x: u32, y: u32, out: &mut [u8]) {
    pack_with(format, colours, dither::thresholds(y), x, out);
}

/// [`pack`] with the thresholds of a row.
#[inline(always)]
fn pack_with(format: PixelFormat, colours: &Levels<'_>, row: &[u8; dither::SIDE], x: u32, out: &mut [u8]) {
    match format {
        PixelFormat::Xrgb8888 => pack_as::<4>(colours, x, row, out, |[r, g, b], t| {
            (0xff00_0000 | to_8(r, t) << 16 | to_8(g, t) << 8 | to_8(b, t)).to_le_bytes()
        }),
        PixelFormat::Xbgr8888 => pack_as::<4>(colours, x, row, out, |[r, g, b], t| {
            (0xff00_0000 | to_8(b, t) << 16 | to_8(g, t) << 8 | to_8(r, t)).to_le_bytes()
        }),
        PixelFormat::Rgb888 => {
            pack_as::<3>(colours, x, row, out, |[r, g, b], t| [b, g, r].map(|level| to_8(level, t) as u8));
        }
        PixelFormat::Bgr888 => {
            pack_as::<3>(colours, x, row, out, |[r, g, b], t| [r, g, b].map(|level| to_8(level, t) as u8));
        }
        PixelFormat::Rgb565 => pack_as::<2>(colours, x, row, out, |[r, g, b], t| {
            ((to_5(r, t) << 11 | to_6(g, t) << 5 | to_5(b, t)) as u16).to_le_bytes()
        }),
        PixelFormat::Bgr565 => pack_as::<2>(colours, x, row, out, |[r, g, b], t| {
            ((to_5(b, t) << 11 | to_6(g, t) << 5 | to_5(r, t)) as u16).to_le_bytes()
        }),
        PixelFormat::Xrgb2101010 => pack_as::<4>(colours, x, row, out, |[r, g, b], t| {
            (0xc000_0000 | to_10(r, t) << 20 | to_10(g, t) << 10 | to_10(b, t)).to_le_bytes()
        }),
    }
}

#[inline(always)]
fn pack_as<const BYTES: usize>(
    colours: &Levels<'_>,
    x: u32,
    row: &[u8; dither::SIDE],
    out: &mut [u8],
    pixel: impl Fn([Level; 3], u32) -> [u8; BYTES],
) {
    let (pixels, _) = out.as_chunks_mut::<BYTES>();
    let channels = colours.red.iter().zip(&*colours.green).zip(&*colours.blue);
    for (i, (out, ((&r, &g), &b))) in pixels.iter_mut().zip(channels).enumerate() {
        *out = pixel([r, g, b], u32::from(row[(x as usize + i) % dither::SIDE]));
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
    use crate::math::lanes::{Task, on_each};
    use proptest::prelude::*;

    fn packed(format: PixelFormat, level: Level, threshold_x: u32, y: u32) -> [u8; 3] {
        let mut out = [0; 4];
        let mut planes = [[level]; 3];
        let [red, green, blue] = planes.each_mut();
        let colours = &Levels { red, green, blue };
        let bytes = format.bytes_per_pixel();
        pack(format, colours, threshold_x, y, &mut out[..bytes]);
        format.unpack(&out)
    }

    /// Packs a block, whose levels may lie beyond the scale.
    struct Block {
        format: PixelFormat,
        colours: [[i16; LANES]; 3],
        y: u32,
    }

    impl Task for Block {
        type Output = Vec<u8>;

        #[inline(always)]
        fn run<L: Lanes>(self) -> Vec<u8> {
            let mut out = vec![0; LANES * self.format.bytes_per_pixel()];
            pack_block(self.format, self.colours.each_ref().map(L::load), thresholds(self.y), &mut out);
            out
        }
    }

    proptest! {
        #[test]
        fn blocks_are_packed_like_their_clipped_pixels(colours: [[i16; LANES]; 3], y in 0_u32..40) {
            // The room that dithering needs above.
            let colours = colours.map(|plane| plane.map(|level| level.min(i16::MAX - 255)));
            let mut planes = colours.map(|plane| plane.map(|level| level.clamp(0, 4080) as Level));
            let [red, green, blue] = planes.each_mut().map(|plane| &mut plane[..]);
            let levels = &Levels { red, green, blue };
            for format in PixelFormat::ALL {
                let mut plain = vec![0; LANES * format.bytes_per_pixel()];
                pack(format, levels, 0, y, &mut plain);
                for (name, packed) in on_each(|| Block { format, colours, y }) {
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
                    assert_eq!(packed(format, level * 16, x, x / 3), [level as u8; 3], "{format} {level}");
                }
            }
        }
    }

    #[test]
    fn black_and_white_stay_pure_in_every_format() {
        for format in PixelFormat::ALL {
            for at in 0..256 {
                assert_eq!(packed(format, 0, at % 16, at / 16), [0; 3], "{format}");
                assert_eq!(packed(format, 4080, at % 16, at / 16), [255; 3], "{format}");
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
                let sums = (0..256).map(|at| packed(format, level, at % 16, at / 16).map(f64::from));
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
        let colours = &Levels { red: &mut [255 * 16], green: &mut [128 * 16], blue: &mut [0] };
        for format in PixelFormat::ALL {
            let mut out = [0; 4];
            pack(format, colours, 0, 0, &mut out[..format.bytes_per_pixel()]);
            let [r, g, b] = format.unpack(&out);
            assert!(r == 255 && g.abs_diff(128) < 5 && b == 0, "{format}: {r} {g} {b}");
        }
    }
}
