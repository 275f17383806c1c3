//! [`Range::Travelling`](super::Range::Travelling): the picture's own local phase.
//!
//! The luma is split into octave bands, each the difference of two blurs. Q = B is their sum, C = H(0) − B what is left, and
//! P = R_w B its Riesz transform along the wind w: P and Q of a wave that runs along w are its sine and cosine, so that
//! C + P·sin θ + Q·cos θ is the same wave θ further on (Felsberg and Sommer, "The monogenic signal", 2001; the look is the
//! "motion without movement" of Freeman, Adelson and Heeger, 1991). In a band that is an octave wide the Riesz transform is
//! close to −1/ω times the derivative along w, ω the band's centre frequency; so no Fourier transform is
//! needed: on a texture of all wavelengths it correlates by 0.968 with the exact transform, and has 0.93 of its amplitude.

use super::{
    relief,
    storage::{Blocks, Planes, Scratch, Words},
};
use crate::math::{Factor, Turns, lanes::LANES, whole_root};

/// Box radii of the blurs on a picture of up to 480 rows, in 1/16 pixel; each about twice the one before, so that there are two bands
/// of an octave, around wavelengths of 8 and 15 pixels.
const RADII: [i32; 3] = [16, 32, 64];

/// Fills centre and swing. Scratch: the words of the `u` slopes.
#[inline(always)]
pub(super) fn fill(planes: &mut Planes<'_>, wind: Turns) {
    let Planes { blocks, scratch, .. } = planes;
    let radii = RADII.map(|r| {
        ((r * relief::scale(blocks.size) + (8 << relief::SCALE_BITS)) >> (4 + relief::SCALE_BITS)) as usize
    });
    for (blur, radius) in BLURS.into_iter().zip(radii) {
        tent_blur(radius, blocks, blur, Words::CentreV, scratch);
    }
    let weights = [0, 1].map(|band| derivative_weights(radii[band], wind));
    swing(blocks, weights, scratch);
}

/// Where the blurs are kept, the narrowest first.
const BLURS: [Words; 3] = [Words::SineU, Words::CosineU, Words::CentreU];

/// From the blurs to P, Q and C, the heights in the words of the `v` slopes.
#[inline(always)]
fn swing(blocks: &mut Blocks<'_>, weights: [[i32; 2]; 2], scratch: &mut Scratch<'_>) {
    let ([f0, f1, f2, c0, c1, c2, in_phase, quadrature, centre], _) = scratch.rows();
    // The bands of the rows above, at and below.
    let (mut fine, mut coarse) = ([f0, f1, f2], [c0, c1, c2]);
    let height = blocks.size.height as usize;
    for row in 0..2 {
        read_bands(blocks, 0, fine[row], coarse[row]);
    }
    for y in 0..height {
        read_bands(blocks, (y + 1).min(height - 1), fine[2], coarse[2]);
        blocks.read(Words::Luma, y, centre);
        swing_of_row(
            [fine.each_ref(), coarse.each_ref()].map(|rows| rows.map(|row| &**row)),
            weights,
            [in_phase, quadrature, centre],
        );
        blocks.write(Words::SineV, y, in_phase);
        blocks.write(Words::CosineV, y, quadrature);
        blocks.write(Words::CentreV, y, centre);
        fine.rotate_left(1);
        coarse.rotate_left(1);
    }
}

/// The differences of the blurs in row `y`.
#[inline(always)]
fn read_bands(blocks: &Blocks<'_>, y: usize, fine: &mut [i16], coarse: &mut [i16]) {
    let rows = fine.chunks_mut(LANES).zip(coarse.chunks_mut(LANES));
    for ((fine, coarse), block) in rows.zip(blocks.row(y)) {
        let [narrow, middle, wide] = BLURS.map(|blur| block.words(blur));
        let differences = narrow.iter().zip(middle).zip(wide);
        for ((fine, coarse), ((&narrow, &middle), &wide)) in fine.iter_mut().zip(coarse).zip(differences) {
            (*fine, *coarse) = (narrow - middle, middle - wide);
        }
    }
}

/// From the bands above, at and below a row to its heights. The centre comes as the luma.
#[inline(always)]
fn swing_of_row(
    bands: [[&[i16]; 3]; 2],
    weights: [[i32; 2]; 2],
    [in_phase, quadrature, centre]: [&mut [i16]; 3],
) {
    let width = centre.len();
    let bands = bands.map(|rows| rows.map(|row| &row[..width]));
    let (in_phase, quadrature) = (&mut in_phase[..width], &mut quadrature[..width]);
    for x in 0..width {
        let [left, right] = [x.saturating_sub(1), (x + 1).min(width - 1)];
        let slope = |[above, at, below]: [&[i16]; 3], weights: [i32; 2]| {
            (i32::from(at[right]) - i32::from(at[left])) * weights[0]
                + (i32::from(below[x]) - i32::from(above[x])) * weights[1]
        };
        let p = (slope(bands[0], weights[0]) + slope(bands[1], weights[1])) >> 14;
        let q = i32::from(bands[0][1][x]) + i32::from(bands[1][1][x]);
        let share = evened(p, q);
        in_phase[x] = ((p * share) >> 14).clamp(-32_767, 32_767) as i16;
        quadrature[x] = ((q * share) >> 14) as i16;
        // Beyond ±256 luma levels, next to single pixels of the utmost contrast, the centre is cut.
        centre[x] = centre[x].saturating_sub(quadrature[x]);
    }
}

/// The amplitude s at which a swing is neither enlarged nor reduced, in luma levels, Q7.
///
/// A = sqrt(P² + Q²) becomes 2·A·s/(A + s): up to twice as large where there is little of it, and never more than 2·s. The phase stays, and
/// so does H(0), but the outline of a mountain no longer swings twenty times as far as leaves in the shade, as its contrast would
/// have it.
const EVEN_AMPLITUDE: u32 = 12 << 7;

/// 2·s/(A + s) in Q14.
#[inline(always)]
fn evened(in_phase: i32, quadrature: i32) -> i32 {
    let square = |x: i32| (i64::from(x) * i64::from(x)) as u64;
    let amplitude = whole_root(square(in_phase) + square(quadrature));
    ((EVEN_AMPLITUDE << 15) / (amplitude + EVEN_AMPLITUDE)) as i32
}

/// −1/ω times the wind's direction, halved for the central difference, Q14.
///
/// The difference of two blurs with deviations σ and 2σ is greatest at ω = 0.961/σ; a box of radius r, twice, has
/// σ² = ((2r + 1)² − 1)/6 = (2/3)·r·(r + 1).
#[inline(always)]
fn derivative_weights(radius: usize, wind: Turns) -> [i32; 2] {
    const PER_DEVIATION_Q14: i64 = 17_049; // 1/0.961
    let deviation_q8 = (((radius as u64 * (radius as u64 + 1) * 2) << 16) / 3).isqrt() as i64;
    let along = |direction: Factor| {
        ((-i64::from(direction.to_bits()) * PER_DEVIATION_Q14 * deviation_q8) >> (28 + 8 + 1)) as i32
    };
    [along(wind.sin()), along(-wind.cos())]
}

/// Blurs the luma by a box of `radius`, twice in each direction: a tent. `other` is scratch. The cost does not depend on the radius.
#[inline(always)]
fn tent_blur(radius: usize, blocks: &mut Blocks<'_>, blur: Words, other: Words, scratch: &mut Scratch<'_>) {
    let ([row], sums) = scratch.rows();
    for y in 0..blocks.size.height as usize {
        blocks.read(Words::Luma, y, row);
        blur_row(radius, row, sums);
        blur_row(radius, row, sums);
        blocks.write(blur, y, row);
    }
    blur_columns(radius, blocks, blur, other, row, sums);
    blur_columns(radius, blocks, other, blur, row, sums);
}

#[inline(always)]
fn blur_row(radius: usize, row: &mut [i16], sums: &mut [i32]) {
    let last = row.len() - 1;
    let pixel = |x: usize| i32::from(row[x.min(last)]);
    let mut sum = radius as i32 * pixel(0) + (0..radius).map(pixel).sum::<i32>();
    for (x, to) in sums.iter_mut().enumerate() {
        sum += pixel(x + radius);
        *to = sum;
        sum -= pixel(x.saturating_sub(radius));
    }
    let reciprocal = Reciprocal::of(2 * radius + 1);
    row.iter_mut().zip(sums).for_each(|(out, &mut sum)| *out = reciprocal.times(sum));
}

#[inline(always)]
fn blur_columns(
    radius: usize,
    blocks: &mut Blocks<'_>,
    from: Words,
    to: Words,
    row: &mut [i16],
    sums: &mut [i32],
) {
    let (last, radius, reciprocal) =
        (blocks.size.height as isize - 1, radius as isize, Reciprocal::of(2 * radius + 1));
    sums.fill(0);
    // Row y is written when the rows up to y + radius have come in.
    for y in -2 * radius..=last {
        blocks.read(from, (y + radius).clamp(0, last) as usize, row);
        sums.iter_mut().zip(&*row).for_each(|(sum, &h)| *sum += i32::from(h));
        if y < 0 {
            continue;
        }
        for (sums, block) in sums.chunks(LANES).zip(blocks.row_mut(y as usize)) {
            let out = &mut block.words[to as usize];
            out.iter_mut().zip(sums).for_each(|(out, &sum)| *out = reciprocal.times(sum));
        }
        blocks.read(from, (y - radius).max(0) as usize, row);
        sums.iter_mut().zip(&*row).for_each(|(sum, &h)| *sum -= i32::from(h));
    }
}

/// Division of a sum of heights by the width of a box, 3 or more.
#[derive(Clone, Copy)]
struct Reciprocal(u32);

impl Reciprocal {
    fn of(divisor: usize) -> Self {
        Self(((1_u64 << 32) / divisor.max(3) as u64) as u32 + 1)
    }

    /// The quotient rounded to nearest, for sums of heights that are not negative. 32 bits times 32: one instruction in vectors.
    #[inline(always)]
    fn times(self, sum: i32) -> i16 {
        ((u64::from(sum as u32) * u64::from(self.0) + (1 << 31)) >> 32) as i16
    }
}
