//! From heights to slopes: what the light sees.

use super::{
    super::Photo,
    Range, Settings,
    shade::{Light, ONE, SLOPE_ONE},
    storage::{Block, Blocks, Packed, Planes, Words},
};
use crate::{
    frame::Size,
    math::{
        Turns,
        lanes::{LANES, Lanes},
        quotients, whole_roots,
    },
};

/// Fractional bits of [`scale`].
pub(super) const SCALE_BITS: u32 = 8;

/// How many times a picture of `size` is larger than one whose shorter side has 480 pixels, at least 1, in Q8: with it the relief and
/// its waves keep their look on every panel.
pub(super) const fn scale(size: Size) -> i32 {
    let side = if size.width < size.height { size.width } else { size.height };
    let scale = (side << SCALE_BITS) as i32 / 480;
    if scale < 1 << SCALE_BITS { 1 << SCALE_BITS } else { scale }
}

/// A radius on a picture of up to 480 rows as one on a picture of `size`.
pub(super) const fn scaled(radius: usize, size: Size) -> usize {
    (radius * scale(size) as usize + (1 << (SCALE_BITS - 1))) >> SCALE_BITS
}

/// Turns the heights (in the words of the v slopes) into slopes, finds the gain in the mean shade, and packs it all for the frames.
#[inline(always)]
pub(super) fn fill<L: Lanes>(planes: &mut Planes<'_>, photo: Photo<'_>, settings: &Settings, light: Light) {
    let axes = Axes::new(settings, planes.blocks.size);
    let Planes { blocks, scratch, .. } = planes;
    let (_, [p0, p1, p2, q0, q1, q2, c0, c1, c2, along_u, along_v]) = scratch.rows::<0, 11>();
    // The heights of the rows above, at and below.
    let mut heights = [[p0, p1, p2], [q0, q1, q2], [c0, c1, c2]];
    let (width, height) = (blocks.size.width as usize, blocks.size.height as usize);
    for ((_, v), [above, at, _]) in SLOPES.into_iter().zip(&mut heights) {
        blocks.read(v, 0, above);
        blocks.read(v, 0, at);
    }
    for y in 0..height {
        // Row y is replaced only after row y + 1 was read; the last one is repeated.
        for ((u, v), rows) in SLOPES.into_iter().zip(&mut heights) {
            let [above, at, below] = rows.each_mut().map(|row| &mut **row);
            match y + 1 < height {
                true => blocks.read(v, y + 1, below),
                false => below.copy_from_slice(at),
            }
            slopes_of_row([above, at, below].map(|row| &row[..width]), along_u, along_v, axes);
            blocks.write(u, y, along_u);
            blocks.write(v, y, along_v);
            rows.rotate_left(1);
        }
    }
    finish::<L>(blocks, photo, light, settings.range == Range::Full);
}

/// The words of P's, Q's and C's slopes.
const SLOPES: [(Words, Words); 3] =
    [(Words::SineU, Words::SineV), (Words::CosineU, Words::CosineV), (Words::CentreU, Words::CentreV)];

/// The last step, block by block.
#[inline(always)]
fn finish<L: Lanes>(blocks: &mut Blocks<'_>, photo: Photo<'_>, light: Light, level_centre: bool) {
    let width = photo.size.width as usize;
    blocks.pack(
        #[inline(always)]
        |mut block, y, x| {
            let pixels = y * width + x..y * width + width.min(x + LANES);
            if level_centre {
                block.words[Words::CentreU as usize] = [0; LANES];
                block.words[Words::CentreV as usize] = [0; LANES];
            }
            flatten(&mut block);
            mask(&mut block, &photo.mask[pixels.clone()]);
            let mut packed = Packed::new(&block);
            let base = L::splat(ONE).minus(mean_shade::<L>(&packed, light));
            base.store(&mut packed.base);
            let rgb = photo.rgb[3 * pixels.start..3 * pixels.end].as_chunks().0;
            let [red, green, blue] = &mut packed.colours;
            for (i, &[r, g, b]) in rgb.iter().enumerate() {
                (red[i], green[i], blue[i]) = (r, g, b);
            }
            packed
        },
    );
}

/// The swing of every pixel times its mask. Where that is 0 the relief is level, too, so that nothing of what is packed strays into the swing.
#[inline(always)]
fn mask(block: &mut Block, mask: &[u8]) {
    let mut whole = [0; LANES];
    whole[..mask.len()].copy_from_slice(mask);
    // 1/255 in units of 2^-16, so that 255 is exactly 1.
    let masked = |word: i16, mask: u8| ((i32::from(word) * i32::from(mask) * 257 + (1 << 15)) >> 16) as i16;
    for which in [Words::SineU, Words::SineV, Words::CosineU, Words::CosineV] {
        for (word, mask) in block.words[which as usize].iter_mut().zip(whole) {
            *word = masked(*word, mask);
        }
    }
    for which in [Words::CentreU, Words::CentreV] {
        for (word, mask) in block.words[which as usize].iter_mut().zip(whole) {
            *word = if mask == 0 { 0 } else { *word };
        }
    }
}

/// Slopes per height difference: a unit vector towards the light and one across, times the relief, Q15.
#[derive(Clone, Copy)]
struct Axes {
    u: [i32; 2],
    v: [i32; 2],
}

impl Axes {
    fn new(settings: &Settings, size: Size) -> Self {
        // relief · scale / luma_for_45_degrees, at most 1/2 so that products stay within 32 bits.
        let steepness =
            (settings.relief.to_bits().max(0) as i64 * i64::from(scale(size))) >> (28 + SCALE_BITS - 15);
        let steepness = (steepness / i64::from(settings.range.luma_for_45_degrees())).min(1 << 14);
        let axis = |direction: Turns| {
            [direction.sin(), -direction.cos()].map(|c| ((i64::from(c.to_bits()) * steepness) >> 28) as i32)
        };
        Self { u: axis(settings.light.azimuth), v: axis(settings.light.azimuth.plus(Turns::QUARTER)) }
    }

    /// The slopes at column x, in Q10, from the heights above, at and below it, of which left and right are the neighbours.
    #[inline(always)]
    fn slopes(self, [above, at, below]: [&[i16]; 3], x: usize, left: usize, right: usize) -> (i16, i16) {
        let column = |x: usize| i32::from(above[x]) + 2 * i32::from(at[x]) + i32::from(below[x]);
        let row = |row: &[i16]| i32::from(row[left]) + 2 * i32::from(row[x]) + i32::from(row[right]);
        // Eight times the gradient in Q7, to Q8.
        let (dx, dy) = ((column(right) - column(left)) >> 2, (row(below) - row(above)) >> 2);
        let along = |axis: [i32; 2]| {
            let slope = (dx * axis[0] + dy * axis[1]) >> (8 + 15 - STEEP_BITS);
            slope.clamp(i16::MIN.into(), i16::MAX.into()) as i16
        };
        (along(self.u), along(self.v))
    }
}

/// Fractional bits of a slope before [`flatten`]: room for ±32.
const STEEP_BITS: u32 = 10;

/// From the heights (Q7) above, at and below a row to its slopes along the axes, Q10, saturated. The gradient is Sobel's, which
/// smooths across the direction that it differentiates; edges are repeated.
#[inline(always)]
fn slopes_of_row(rows: [&[i16]; 3], along_u: &mut [i16], along_v: &mut [i16], axes: Axes) {
    let width = rows[0].len();
    let (along_u, along_v) = (&mut along_u[..width], &mut along_v[..width]);
    let last = width - 1;
    (along_u[0], along_v[0]) = axes.slopes(rows, 0, 0, 1.min(last));
    for x in 1..last {
        (along_u[x], along_v[x]) = axes.slopes(rows, x, x - 1, x + 1);
    }
    (along_u[last], along_v[last]) = axes.slopes(rows, last, last.saturating_sub(1), last);
}

/// tan 54.6° in Q10: the steepest that the shade's polynomial is made for is √2, less some steps for rounding.
const STEEPEST: u32 = 1440;

/// Brings the slopes of a block from Q10 to units of 2^-14.5, flattened where centre and swing together could pass 54.6°.
///
/// |c + a·p + b·q| ≤ |c| + sqrt(|p|² + |q|²) for a² + b² ≤ 1; all three are scaled by the same factor, so that the swing keeps
/// its shape.
#[inline(always)]
fn flatten(block: &mut Block) {
    let Some(slopes) = block.words.first_chunk_mut::<6>() else { return };
    let mut rough = [0; LANES];
    for words in &*slopes {
        rough.iter_mut().zip(words).for_each(|(sum, word)| *sum += u32::from(word.unsigned_abs()));
    }
    let steep = rough.iter().fold(0, |steepest: u32, &rough| steepest.max(rough)) > STEEPEST;
    let factors = if steep { flattening(slopes) } else { [SLOPE_ONE as u32; LANES] };
    for words in slopes {
        for (word, factor) in words.iter_mut().zip(factors) {
            *word = ((i32::from(*word) * factor as i32) >> STEEP_BITS) as i16;
        }
    }
}

/// The factors that flatten the pixels' slopes, in units of 2^-14.5.
#[inline(always)]
fn flattening([pu, pv, qu, qv, cu, cv]: &[[i16; LANES]; 6]) -> [u32; LANES] {
    let (mut swings, mut centres) = ([0; LANES], [0; LANES]);
    for i in 0..LANES {
        // At most 2^15 each, so that four squares would be 2^32 at the most: one less, where they are.
        let square = |slope: i16| (i32::from(slope) * i32::from(slope)) as u32;
        swings[i] = (square(pu[i]) + square(pv[i]) + square(qu[i])).saturating_add(square(qv[i]));
        centres[i] = square(cu[i]) + square(cv[i]);
    }
    let (swings, mut steepest) = (whole_roots(swings), whole_roots(centres));
    steepest.iter_mut().zip(swings).for_each(|(sum, swing)| *sum = (*sum + swing).max(STEEPEST));
    quotients(STEEPEST * SLOPE_ONE as u32, steepest)
}

/// The swing at which the mean shade is taken: the root mean square of X_A, which has mean 1/2 and deviation 1/6
/// ([`crate::noise::drive`]): sqrt(1/4 + 1/36) = 0.527, Q15.
const TYPICAL_SWING: i16 = 17_270;

/// The mean of the shade over the phases 0°, 90°, 180°, 270°: exact to the third order of the slopes. k·S̄ in Q12.
#[inline(always)]
fn mean_shade<L: Lanes>(packed: &Packed, light: Light) -> L {
    let [[pu, qu, cu], [pv, qv, cv]] = packed.slopes::<L>();
    let centre = [cu, cv];
    mean(mean_of_opposites([pu, pv], centre, light), mean_of_opposites([qu, qv], centre, light))
}

/// The mean of the shades where the swing is on one side and on the other.
#[inline(always)]
fn mean_of_opposites<L: Lanes>(swing: [L; 2], centre: [L; 2], light: Light) -> L {
    let typical = L::splat(TYPICAL_SWING);
    let (u, v) = (swing[0].times(typical), swing[1].times(typical));
    let ahead = light.shade(centre[0].plus(u), centre[1].plus(v));
    mean(ahead, light.shade(centre[0].minus(u), centre[1].minus(v)))
}

#[inline(always)]
fn mean<L: Lanes>(a: L, b: L) -> L {
    a.plus(b).times(L::splat(1 << 14))
}
