//! A palette for a film, and a dither that stands still.

use color_quant::NeuQuant;
use std::collections::BTreeSet;

/// The most colours of a palette: one of the 256 of a GIF is transparent.
const COLOURS: usize = 255;

/// The corners of the colour cube. They are in every palette, so that any colour that comes up later in the film can be mixed.
const CORNERS: [[u8; 3]; 8] = [
    [0, 0, 0],
    [255, 0, 0],
    [0, 255, 0],
    [255, 255, 0],
    [0, 0, 255],
    [255, 0, 255],
    [0, 255, 255],
    [255, 255, 255],
];

/// Palette entries that are mixed for a colour: steps of 1/16 between two entries are finer than a level of brightness, as the
/// entries of a photo's palette lie about 10 levels apart.
const MIX: usize = 16;

/// Bits of each channel that name the cell of a colour in the table of mixes.
const CELL_BITS: u32 = 6;

/// Colours, and for each cell of the colour cube the mix of them that looks like it.
pub(super) struct Palette {
    colours: Vec<[u8; 3]>,
    mixes: Vec<Option<Box<[u8; MIX]>>>,
}

impl Palette {
    /// The entry that stands for no colour. The palette never has it.
    pub(super) const TRANSPARENT: u8 = 255;

    /// The palette for a film whose first frame is `rgb`: its own colours if they are few, else the best for it.
    pub(super) fn of(rgb: &[u8]) -> Self {
        let (pixels, _) = rgb.as_chunks::<3>();
        let mut colours: BTreeSet<[u8; 3]> = CORNERS.into();
        for pixel in pixels {
            if colours.insert(*pixel) && colours.len() > COLOURS {
                break;
            }
        }
        if colours.len() > COLOURS {
            let rgba: Vec<u8> = pixels.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
            let quantized = NeuQuant::new(10, COLOURS - CORNERS.len(), &rgba).color_map_rgb();
            colours = CORNERS.into_iter().chain(quantized.as_chunks::<3>().0.iter().copied()).collect();
        }
        Self { colours: colours.into_iter().collect(), mixes: vec![None; 1 << (3 * CELL_BITS)] }
    }

    pub(super) fn colours(&self) -> &[[u8; 3]] {
        &self.colours
    }

    /// The entries that stand for the pixels `rgb`, in rows of `width`.
    pub(super) fn dither(&mut self, rgb: &[u8], width: u32, indices: &mut Vec<u8>) {
        indices.clear();
        for (y, row) in rgb.chunks_exact(width as usize * 3).enumerate() {
            for (x, pixel) in row.as_chunks::<3>().0.iter().enumerate() {
                let threshold = threshold(x as u32, y as u32);
                indices.push(self.index(*pixel, threshold));
            }
        }
    }

    fn index(&mut self, pixel: [u8; 3], threshold: u32) -> u8 {
        let cell = pixel.map(|v| u32::from(v) >> (8 - CELL_BITS));
        let at = cell.into_iter().fold(0, |at, v| at << CELL_BITS | v as usize);
        let colours = &self.colours;
        let mix = self.mixes[at].get_or_insert_with(|| Box::new(mix(colours, pixel)));
        mix[(threshold >> 28) as usize]
    }
}

/// A value for each place that is spread evenly over any neighbourhood.
fn threshold(x: u32, y: u32) -> u32 {
    x.wrapping_mul(3_242_174_889).wrapping_add(y.wrapping_mul(2_447_445_414))
}

fn mix(colours: &[[u8; 3]], goal: [u8; 3]) -> [u8; MIX] {
    let mut error = [0_i32; 3];
    let mut mix = [0_u8; MIX];
    for entry in &mut mix {
        let wanted: [i32; 3] = std::array::from_fn(|c| i32::from(goal[c]) + error[c]);
        let distance =
            |colour: &[u8; 3]| -> i32 { (0..3).map(|c| (i32::from(colour[c]) - wanted[c]).pow(2)).sum() };
        let nearest = (0..colours.len()).min_by_key(|i| distance(&colours[*i])).unwrap_or_default();
        for c in 0..3 {
            error[c] += i32::from(goal[c]) - i32::from(colours[nearest][c]);
        }
        *entry = nearest as u8;
    }
    mix.sort_by_key(|i| luma(colours[usize::from(*i)]));
    mix
}

fn luma([r, g, b]: [u8; 3]) -> u32 {
    299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b)
}
