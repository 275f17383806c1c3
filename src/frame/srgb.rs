//! The transfer curve of sRGB (IEC 61966-2-1) in integers.
//!
//! Light adds up in linear values, so photos are resampled and blended in 16-bit linear light and stored in 8-bit sRGB
//! codes. Nothing is computed by powers at run time: results are the same on every machine. A code that goes to linear
//! light and back is unchanged.

/// The linear light of every 8-bit sRGB code, 65,535 being full: the curve of the standard, rounded to nearest.
static LINEAR: [u16; 256] = [
    0, 20, 40, 60, 80, 99, 119, 139, 159, 179, 199, 219, 241, 264, 288, 313, 340, 367, 396, 427, 458, 491,
    526, 562, 599, 637, 677, 718, 761, 805, 851, 898, 947, 997, 1_048, 1_101, 1_156, 1_212, 1_270, 1_330,
    1_391, 1_453, 1_517, 1_583, 1_651, 1_720, 1_790, 1_863, 1_937, 2_013, 2_090, 2_170, 2_250, 2_333, 2_418,
    2_504, 2_592, 2_681, 2_773, 2_866, 2_961, 3_058, 3_157, 3_258, 3_360, 3_464, 3_570, 3_678, 3_788, 3_900,
    4_014, 4_129, 4_247, 4_366, 4_488, 4_611, 4_736, 4_864, 4_993, 5_124, 5_257, 5_392, 5_530, 5_669, 5_810,
    5_953, 6_099, 6_246, 6_395, 6_547, 6_700, 6_856, 7_014, 7_174, 7_335, 7_500, 7_666, 7_834, 8_004, 8_177,
    8_352, 8_528, 8_708, 8_889, 9_072, 9_258, 9_445, 9_635, 9_828, 10_022, 10_219, 10_417, 10_619, 10_822,
    11_028, 11_235, 11_446, 11_658, 11_873, 12_090, 12_309, 12_530, 12_754, 12_980, 13_209, 13_440, 13_673,
    13_909, 14_146, 14_387, 14_629, 14_874, 15_122, 15_371, 15_623, 15_878, 16_135, 16_394, 16_656, 16_920,
    17_187, 17_456, 17_727, 18_001, 18_277, 18_556, 18_837, 19_121, 19_407, 19_696, 19_987, 20_281, 20_577,
    20_876, 21_177, 21_481, 21_787, 22_096, 22_407, 22_721, 23_038, 23_357, 23_678, 24_002, 24_329, 24_658,
    24_990, 25_325, 25_662, 26_001, 26_344, 26_688, 27_036, 27_386, 27_739, 28_094, 28_452, 28_813, 29_176,
    29_542, 29_911, 30_282, 30_656, 31_033, 31_412, 31_794, 32_179, 32_567, 32_957, 33_350, 33_745, 34_143,
    34_544, 34_948, 35_355, 35_764, 36_176, 36_591, 37_008, 37_429, 37_852, 38_278, 38_706, 39_138, 39_572,
    40_009, 40_449, 40_891, 41_337, 41_785, 42_236, 42_690, 43_147, 43_606, 44_069, 44_534, 45_002, 45_473,
    45_947, 46_423, 46_903, 47_385, 47_871, 48_359, 48_850, 49_344, 49_841, 50_341, 50_844, 51_349, 51_858,
    52_369, 52_884, 53_401, 53_921, 54_445, 54_971, 55_500, 56_032, 56_567, 57_105, 57_646, 58_190, 58_737,
    59_287, 59_840, 60_396, 60_955, 61_517, 62_082, 62_650, 63_221, 63_795, 64_372, 64_952, 65_535,
];

/// Bits of linear light below the index of [`FLOOR`]. Neighbouring codes are at least 2^4 apart, so that a bin of that
/// width holds one rounding threshold at the most.
const FLOOR_SHIFT: u32 = 4;

/// The code at the lower end of every bin of linear light.
static FLOOR: [u8; 1 << (16 - FLOOR_SHIFT)] = {
    let mut floor = [0; 1 << (16 - FLOOR_SHIFT)];
    let (mut bin, mut code) = (0, 0);
    while bin < floor.len() {
        while code < 255 && (bin << FLOOR_SHIFT) as u16 >= threshold(code) {
            code += 1;
        }
        floor[bin] = code as u8;
        bin += 1;
    }
    floor
};

/// The least linear light that is nearer to the code after `code` than to `code`; `code` is less than 255.
const fn threshold(code: usize) -> u16 {
    LINEAR[code].midpoint(LINEAR[code + 1]) + 1
}

/// The linear light of an 8-bit sRGB code.
#[inline]
pub fn to_linear(code: u8) -> u16 {
    LINEAR[usize::from(code)]
}

/// The linear light of a 16-bit sRGB value, within two steps of the curve: 8-bit codes with straight lines
/// between them.
#[inline]
pub fn to_linear_16(value: u16) -> u16 {
    // 65,535 = 255 × 257, so the 8-bit codes lie at the multiples of 257.
    let (code, rest) = (usize::from(value / 257), u32::from(value % 257));
    let low = u32::from(LINEAR[code]);
    let high = u32::from(LINEAR[(code + 1).min(255)]);
    (low + ((high - low) * rest + 128) / 257) as u16
}

/// The 8-bit sRGB code nearest to a linear light.
#[inline]
pub fn to_srgb(linear: u16) -> u8 {
    let code = FLOOR[usize::from(linear >> FLOOR_SHIFT)];
    if code < 255 && linear >= threshold(usize::from(code)) { code + 1 } else { code }
}

/// The 8-bit sRGB code of a linear light for a pixel whose dither threshold is `dither`: the code below or above, so that
/// over pixels with evenly spread thresholds the mean is the linear light itself.
#[inline]
pub fn to_srgb_dithered(linear: u16, dither: u8) -> u8 {
    let near = to_srgb(linear);
    let below = if to_linear(near) > linear { near - 1 } else { near };
    let Some(above) = below.checked_add(1) else { return below };
    let step = u32::from(to_linear(above) - to_linear(below));
    let rest = u32::from(linear - to_linear(below));
    if rest * 256 > step * u32::from(dither) + step / 2 { above } else { below }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curve as the standard writes it.
    fn curve(value: f64) -> f64 {
        if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
    }

    #[test]
    fn the_table_is_the_curve_of_the_standard() {
        for code in 0..=255_u8 {
            let exact = curve(f64::from(code) / 255.0) * 65_535.0;
            assert!((exact - f64::from(to_linear(code))).abs() <= 0.5, "code {code}: {exact}");
        }
    }

    #[test]
    fn a_code_survives_the_way_to_linear_light_and_back() {
        for code in 0..=255_u8 {
            assert_eq!(to_srgb(to_linear(code)), code);
            for dither in [0, 100, 255] {
                assert_eq!(to_srgb_dithered(to_linear(code), dither), code);
            }
        }
    }

    #[test]
    fn every_light_gets_the_nearest_code() {
        for linear in 0..=u16::MAX {
            let error = |code: u8| i32::from(to_linear(code)).abs_diff(i32::from(linear));
            let best = (0..=255).map(error).min();
            assert_eq!(Some(error(to_srgb(linear))), best, "light {linear}");
        }
    }

    #[test]
    fn sixteen_bit_values_are_within_two_steps_of_the_curve() {
        for value in 0..=u16::MAX {
            let exact = curve(f64::from(value) / 65_535.0) * 65_535.0;
            assert!((exact - f64::from(to_linear_16(value))).abs() < 2.0, "value {value}: {exact}");
        }
    }

    #[test]
    fn the_mean_of_dithered_codes_is_the_light() {
        for linear in (0..=65_535_u16).step_by(97) {
            let sum: u32 =
                (0..=255).map(|dither| u32::from(to_linear(to_srgb_dithered(linear, dither)))).sum();
            let step = 600.0 / 256.0; // The widest step of the table, shared by 256 thresholds.
            assert!((f64::from(sum) / 256.0 - f64::from(linear)).abs() <= step, "light {linear}");
        }
    }
}
