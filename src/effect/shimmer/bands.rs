//! [`Range::Travelling`](super::Range::Travelling): the picture's own local phase.
//!
//! The luma is split into octave bands, each the difference of two blurs. Q = B is their sum, C = H(0) − B what is left, and
//! P = R_w B its Riesz transform along the wind w: P and Q of a wave that runs along w are its sine and cosine, so that
//! C + P·sin θ + Q·cos θ is the same wave θ further on (Felsberg and Sommer, "The monogenic signal", 2001; the look is the
//! "motion without movement" of Freeman, Adelson and Heeger, 1991). In a band that is an octave wide the Riesz transform is
//! close to −1/ω times the derivative along w, ω the band's centre frequency; so no Fourier transform is
//! needed: on a texture of all wavelengths it correlates by 0.968 with the exact transform, and has 0.93 of its amplitude.

use super::{relief, storage::Planes};
use crate::math::{Factor, Turns};

/// Box radii of the blurs on a picture of up to 480 rows, in 1/16 pixel; each about twice the one before, so that there are two bands
/// of an octave, around wavelengths of 8 and 15 pixels.
const RADII: [i32; 3] = [16, 32, 64];

/// Fills centre and swing. Scratch: the `u` planes.
pub(super) fn fill(planes: &mut Planes<'_>, wind: Turns) {
    let size = planes.size;
    let radii = RADII.map(|r| {
        ((r * relief::scale(size) + (8 << relief::SCALE_BITS)) >> (4 + relief::SCALE_BITS)) as usize
    });
    let width = size.width as usize;
    {
        let blurs = [&mut *planes.sine.u, &mut *planes.cosine.u, &mut *planes.centre.u];
        for (blur, radius) in blurs.into_iter().zip(radii) {
            blur.copy_from_slice(planes.mean_shade);
            tent_blur(radius, width, blur, planes.centre.v, planes.scratch);
        }
    }
    let weights = [0, 1].map(|band| derivative_weights(radii[band], wind));
    let (fine, middle, coarse) = (&*planes.sine.u, &*planes.cosine.u, &*planes.centre.u);
    for y in 0..size.height as usize {
        let rows = Rows::around(y, width, size.height as usize);
        for x in 0..width {
            let columns = [x.saturating_sub(1), (x + 1).min(width - 1)];
            let riesz = slope(fine, middle, &rows, columns, x, weights[0])
                + slope(middle, coarse, &rows, columns, x, weights[1]);
            let i = y * width + x;
            let (in_phase, quadrature) = (riesz >> 14, i32::from(fine[i]) - i32::from(coarse[i]));
            let share = evened(in_phase, quadrature);
            planes.sine.v[i] = ((in_phase * share) >> 14).clamp(-32_767, 32_767) as i16;
            planes.cosine.v[i] = ((quadrature * share) >> 14) as i16;
            // Beyond ±256 luma levels, next to single pixels of the utmost contrast, the centre is cut.
            planes.centre.v[i] = planes.mean_shade[i].saturating_sub(planes.cosine.v[i]);
        }
    }
}

/// The amplitude s at which a swing is neither enlarged nor reduced, in luma levels, Q7.
///
/// A = sqrt(P² + Q²) becomes 2·A·s/(A + s): up to twice as large where there is little of it, and never more than 2·s. The phase stays, and
/// so does H(0), but the outline of a mountain no longer swings twenty times as far as leaves in the shade, as its contrast would
/// have it.
const EVEN_AMPLITUDE: i32 = 12 << 7;

/// 2·s/(A + s) in Q14.
fn evened(in_phase: i32, quadrature: i32) -> i32 {
    let square = |x: i32| i64::from(x) * i64::from(x);
    let amplitude = (square(in_phase) + square(quadrature)).isqrt() as i32;
    (EVEN_AMPLITUDE << 15) / (amplitude + EVEN_AMPLITUDE)
}

/// Starts of the rows above, at and below `y`, repeated at the picture's edges.
struct Rows([usize; 3]);

impl Rows {
    fn around(y: usize, width: usize, height: usize) -> Self {
        Self([y.saturating_sub(1), y, (y + 1).min(height - 1)].map(|y| y * width))
    }
}

/// The weighted derivative of the band `narrow − wide` at column x.
fn slope(narrow: &[i16], wide: &[i16], rows: &Rows, columns: [usize; 2], x: usize, weights: [i32; 2]) -> i32 {
    let band = |i: usize| i32::from(narrow[i]) - i32::from(wide[i]);
    let [above, at, below] = rows.0;
    (band(at + columns[1]) - band(at + columns[0])) * weights[0]
        + (band(below + x) - band(above + x)) * weights[1]
}

/// −1/ω times the wind's direction, halved for the central difference, Q14.
///
/// The difference of two blurs with deviations σ and 2σ is greatest at ω = 0.961/σ; a box of radius r, twice, has
/// σ² = ((2r + 1)² − 1)/6 = (2/3)·r·(r + 1).
fn derivative_weights(radius: usize, wind: Turns) -> [i32; 2] {
    const PER_DEVIATION_Q14: i64 = 17_049; // 1/0.961
    let deviation_q8 = (((radius as u64 * (radius as u64 + 1) * 2) << 16) / 3).isqrt() as i64;
    let along = |direction: Factor| {
        ((-i64::from(direction.to_bits()) * PER_DEVIATION_Q14 * deviation_q8) >> (28 + 8 + 1)) as i32
    };
    [along(wind.sin()), along(-wind.cos())]
}

/// Blurs `plane` by a box of `radius`, twice in each direction: a tent. `other` (a plane) and `sums` (a row or column) are
/// scratch. The cost does not depend on the radius.
fn tent_blur(radius: usize, width: usize, plane: &mut [i16], other: &mut [i16], sums: &mut [i32]) {
    box_blur(radius, width, plane, other, sums);
    box_blur(radius, width, other, plane, sums);
}

fn box_blur(radius: usize, width: usize, from: &mut [i16], to: &mut [i16], sums: &mut [i32]) {
    let reciprocal = Reciprocal::of(2 * radius + 1);
    for (from, to) in from.chunks_exact(width).zip(to.chunks_exact_mut(width)) {
        let pixel = |x: isize| i32::from(from[x.clamp(0, width as isize - 1) as usize]);
        let mut sum: i32 = (-(radius as isize)..radius as isize).map(pixel).sum();
        for (x, to) in to.iter_mut().enumerate() {
            sum += pixel(x as isize + radius as isize);
            *to = reciprocal.times(sum);
            sum -= pixel(x as isize - radius as isize);
        }
    }
    // Down the columns, a row at a time: back into `from`, then over to `to`.
    let height = to.len() / width;
    let sums = &mut sums[..width];
    let row = |y: isize| y.clamp(0, height as isize - 1) as usize * width;
    sums.fill(0);
    for y in -(radius as isize)..radius as isize {
        sums.iter_mut().zip(&to[row(y)..]).for_each(|(sum, &h)| *sum += i32::from(h));
    }
    for y in 0..height as isize {
        let (enters, leaves) = (row(y + radius as isize), row(y - radius as isize));
        for x in 0..width {
            sums[x] += i32::from(to[enters + x]);
            from[y as usize * width + x] = reciprocal.times(sums[x]);
            sums[x] -= i32::from(to[leaves + x]);
        }
    }
    to.copy_from_slice(from);
}

/// Division of a sum of heights by the width of a box.
#[derive(Clone, Copy)]
struct Reciprocal(u64);

impl Reciprocal {
    fn of(divisor: usize) -> Self {
        Self((1_u64 << 32) / divisor as u64 + 1)
    }

    /// The quotient rounded to nearest, for sums of heights that are not negative.
    fn times(self, sum: i32) -> i16 {
        ((sum as u64 * self.0 + (1 << 31)) >> 32) as i16
    }
}
