//! The foliage of a photo in place of a tree: the owner's own goes through the season by the same colour stealing.
//!
//! A photo has no words of symbols, so that its foliage is given some: the cells of a quadtree over the picture, with the symbols of
//! every cell shuffled, so that no order of the quarters can be seen. Six symbols make a twig. The cells follow the picture: each pixel
//! is moved by how bright its surroundings are, so that a leaf in the light and its neighbour in the shade lie far apart, and the
//! border between two boughs runs along the outline of a leaf. Where it crosses one, it is scattered pixel by pixel, and looks soft.
//! Of a leaf's two symbols one is the twig's next quarter, the other how the pixel differs from its surroundings: veins and
//! rims have colours of their own. The light on a leaf is that of the photo.

use super::{mount::Mount, noise::fbm, species::Species, storage::Texel, view::TREE_DEPTHS};
use crate::{effect::Photo, frame::Size, math::random::scatter};

/// Levels of the quadtree for a twig, and for the first symbol of the leaf within it.
const TWIG_LEVELS: u32 = 6;
const LEAF_LEVELS: u32 = 1;

/// The luma of a green leaf in full light: the mean of the green plate.
const GREEN_LUMA: u32 = 140;

/// Greener than this, by 2g − r − b, is foliage for sure; what is less green by 24 is none.
const GREEN: i32 = 28;

/// Fills the texels from the photo's foliage: what its mask holds and is green.
pub(super) fn fill(texels: &mut [Texel], photo: Photo<'_>, mount: Mount, species: &Species, seed: u64) {
    let (width, height) = (photo.size.width as usize, mount.upright().height);
    let colours = photo.rgb.as_chunks::<3>().0;
    for (at, ((texel, &colour), &mask)) in texels.iter_mut().zip(colours).zip(photo.mask).enumerate() {
        // What hardly moves, the middle of a broad leaf, turns all the same.
        let mut cover = (u32::from(mask) * 3).min(255) * greenness(colour) / 255;
        if cover > 0 {
            cover = cover * deciduousness(colours, photo.size, at) / 255;
        }
        *texel = Texel::default();
        if cover > 0 {
            let [x, y] = mount.pixel((at % width) as i32, (at / width) as i32);
            let around = surroundings(colours, photo.size, at);
            let cell = cell(x as u32, y as u32, height, around, seed);
            let twig = ((cell >> (2 * LEAF_LEVELS)) as usize * species.twigs()) >> (2 * TWIG_LEVELS);
            texel.address = (twig as u16) << 4 | ((cell & 3) << 2 | detail(luma(colour), around)) as u16;
            texel.depth = *TREE_DEPTHS.start();
            texel.cover = cover as u8;
            texel.shade = (luma(colour) * 128 / GREEN_LUMA).min(255) as u8;
        }
    }
}

fn luma([r, g, b]: [u8; 3]) -> u32 {
    (u32::from(r) * 54 + u32::from(g) * 183 + u32::from(b) * 19) >> 8
}

/// How green a pixel is, 0..=255: the excess green of vegetation indices (Woebbecke et al., 1995), with a soft edge. Dark leaves are
/// as green as bright ones.
fn greenness(colour: [u8; 3]) -> u32 {
    let [r, g, b] = colour.map(i32::from);
    // Turquoise water has as much blue as green, and what is brown more red.
    let excess = (2 * g - r - b).min(2 * (g - b)).min(4 * (g - r) + 40) * 110 / (luma(colour) as i32 + 40);
    ((excess - GREEN + 24) * 255 / 24).clamp(0, 255) as u32
}

/// How far from each other the pixels are of which the surroundings are the median, of the picture's shorter side.
const SURROUNDINGS: u32 = 160;

/// How far the foliage around a pixel is that of a tree that turns, 0..=255. The needles of conifers are dark and bluish; leaves
/// have more red than blue.
fn deciduousness(colours: &[[u8; 3]], size: Size, at: usize) -> u32 {
    let green = around(colours, size, at).into_iter().filter(|&colour| greenness(colour) > 0);
    let [r, g, b] = green.fold([0; 3], |sum, colour| core::array::from_fn(|i| sum[i] + i32::from(colour[i])));
    // Of 256 of the green.
    let warmth = (r - b) * 256 / g.max(1);
    ((warmth - EVERGREEN) * 255 / 24).clamp(0, 255) as u32
}

/// What is no warmer than this is evergreen.
const EVERGREEN: i32 = 24;

/// The luma around the pixel numbered `at`: the median of nine, which keeps the edges of leaves.
fn surroundings(colours: &[[u8; 3]], size: Size, at: usize) -> u32 {
    let mut lumas = around(colours, size, at).map(luma);
    *lumas.select_nth_unstable(4).1
}

/// Nine pixels, the one numbered `at` in their middle.
fn around(colours: &[[u8; 3]], size: Size, at: usize) -> [[u8; 3]; 9] {
    let step = (size.width.min(size.height) / SURROUNDINGS).max(1) as i32;
    let (x, y) = ((at % size.width as usize) as i32, (at / size.width as usize) as i32);
    core::array::from_fn(|i| {
        let (across, down) = ((i % 3) as i32 - 1, (i / 3) as i32 - 1);
        let column = (x + across * step).clamp(0, size.width as i32 - 1);
        let row = (y + down * step).clamp(0, size.height as i32 - 1);
        colours[(row * size.width as i32 + column) as usize]
    })
}

/// The last symbol of a leaf's address: darker or brighter than what is `around`, a little or much.
fn detail(luma: u32, around: u32) -> u32 {
    let difference = (luma as i32 - around as i32) * 128 / (around as i32 + 32);
    ((difference + 24) / 12).clamp(0, 3) as u32
}

/// The symbols of the quadtree's cell at a pixel with a luma of `around` about it, that of the leaf last.
fn cell(x: u32, y: u32, height: u32, around: u32, seed: u64) -> u32 {
    let levels = TWIG_LEVELS + LEAF_LEVELS;
    // The picture's height is a side of the tree; what is to its right begins again. In steps of 2^-16 of it.
    let place = |at: u32| ((u64::from(at) << 16) / u64::from(height)) as i32;
    let grain = scatter(seed ^ u64::from(x) << 32 ^ u64::from(y));
    let (x, y) = (place(x), place(y));
    let bent = |at: i32, bits: u32, seed| {
        // An eighth of the height in waves of a sixth.
        let coarse = fbm(x * 6, y * 6, 3, seed) / 4;
        // By a luma of 64, a tenth of the height.
        let lit = around as i32 * 100;
        // A four hundredth of the height, most often less: the sum of two even spreads.
        let byte = |shift: u32| (grain >> (bits + shift)) as i32 & 0xff;
        let scattered = byte(0) - byte(8);
        (at + coarse + lit + scattered) as u32 & 0xffff
    };
    let (x, y) = (bent(x, 0, seed ^ 21), bent(y, 32, seed ^ 22));
    (0..levels).fold(0, |cell, level| {
        let bit = 15 - level;
        let quarter = (x >> bit & 1) | (y >> bit & 1) << 1;
        // One of the four rotations of the symbols, with or without exchange of two, by chance.
        let chance = scatter(seed ^ u64::from(cell) << 8 ^ u64::from(level)) as u32;
        cell << 2 | ((quarter + chance) & 3 ^ (chance >> 2 & 1))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_are_green_and_sky_bark_and_stone_are_not() {
        for green in [[80, 120, 50], [30, 48, 20], [150, 180, 90], [60, 90, 50]] {
            assert!(greenness(green) > 200, "{green:?}: {}", greenness(green));
        }
        for other in
            [[120, 160, 220], [240, 240, 240], [110, 90, 70], [128, 128, 128], [0, 0, 0], [180, 40, 30]]
        {
            assert_eq!(greenness(other), 0, "{other:?}");
        }
    }

    #[test]
    fn neighbours_share_leading_symbols_and_all_symbols_are_used() {
        let mut seen = [0_u32; 4];
        let (mut same, mut all) = (0, 0);
        for y in (0..480).step_by(7) {
            for x in (0..640).step_by(7) {
                let (here, beside) = (cell(x, y, 480, 90, 1), cell(x + 2, y, 480, 90, 1));
                same += u32::from(here >> 10 == beside >> 10);
                all += 1;
                seen[(here >> 12) as usize] += 1;
            }
        }
        assert!(same * 100 > all * 85, "{same} of {all} neighbours are in one bough");
        assert!(seen.iter().all(|&count| count * 10 > all), "{seen:?}");
    }
}
