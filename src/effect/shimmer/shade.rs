//! Lambert's shade of a slope: S = max(0, n·L), in units of the gain.

use crate::math::{Factor, lanes::Lanes, q15};

/// Slopes are in units of 2^-14.5, so that the rounding product of two is in units of 2^-14: 1 is 23170.
pub(super) const SLOPE_ONE: i32 = 23_170;

/// A gain or a shade of 1.
pub(super) const ONE: i16 = 1 << 12;

/// The light and the strength, in the frame in which `u` points towards the light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// k·L_z in Q12, L_z the sine of the elevation; k = m/L_z, m the strength.
    up: i16,
    /// k times the cosine of the elevation, in units of 2^-12.5.
    along: i16,
}

/// A light below 5° would make black of every slope that turns away, and its share of the plane, by which the shade is divided, nothing.
const LEAST_UP: i16 = 2856;

/// k is at most 3.98: a shade, up to 2·k where a slope of 54.6° faces the light, then fits 16 bits.
const LARGEST_STRENGTH: i64 = 3_980;

impl Light {
    pub(super) fn new(light: super::Light, strength: Factor) -> Self {
        let up = q15(light.elevation.sin()).max(LEAST_UP);
        let along = q15(light.elevation.cos()).max(0);
        // k in Q15.
        let k = (i64::from(strength.to_bits().max(0)) << 2) / i64::from(up);
        let k = k.min(LARGEST_STRENGTH * (1 << 15) / 1_000);
        let scaled = |share: i16, one: i64| ((k * i64::from(share) * one + (1 << 29)) >> 30) as i16;
        Self { up: scaled(up, ONE.into()), along: scaled(along, 5_793) }
    }

    /// k·S of slopes of at most 54.6°, Q12.
    ///
    /// n = (−u, −v, 1)/sqrt(1 + u² + v²), so n·L = (L_z − |L_xy|·u)/sqrt(1 + u² + v²). Within 0.0008·k·S + 0.0006 of the exact value.
    #[inline(always)]
    pub(super) fn shade<L: Lanes>(self, u: L, v: L) -> L {
        let facing = L::splat(self.up).minus(L::splat(self.along).times(u));
        facing.times(reciprocal_root(u.times(u).plus(v.times(v)))).at_least(L::splat(0))
    }
}

/// 1/sqrt(1 + s) in Q15, for s of 0..2 in Q14. Within 0.00073 of it, relative to it.
///
/// The polynomial of degree 4 in y = (s − 1)/2 whose largest relative error is least, but for rounding: at |y| ≤ 1/2 all its coefficients are
/// below 1, so that Horner's scheme needs no shifts. With degree 5 (0.00017) the frame's error against float64 would be no smaller, since
/// dithering has most of it; up to 60°, s of 0..3, degree 5 would have 0.0006.
#[inline(always)]
fn reciprocal_root<L: Lanes>(square: L) -> L {
    const COEFFICIENTS: [i16; 4] = [-9_532, 8_435, -11_430, 23_174];
    let y = square.minus(L::splat(1 << 14));
    let mut sum = L::splat(8_889);
    for c in COEFFICIENTS {
        sum = y.times(sum).plus(L::splat(c));
    }
    sum
}

/// The slope a·p + b·q + c, a and b in Q15.
#[inline(always)]
pub(super) fn slope<L: Lanes>(a: L, p: L, b: L, q: L, c: L) -> L {
    a.times(p).plus(b.times(q)).plus(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Turns, lanes::Plain};

    #[test]
    fn the_reciprocal_root_is_within_the_stated_error() {
        for square in 0..=32_767_i16 {
            let exact = 1.0 / (1.0 + f64::from(square) / 16_384.0).sqrt();
            let got = f64::from(reciprocal_root(Plain::splat(square))[0]) / 32_768.0;
            assert!((got / exact - 1.0).abs() < 0.00073, "s = {square}: {got} for {exact}");
        }
    }

    #[test]
    fn the_shade_is_that_of_lambert() {
        let elevation = Turns::from_degrees(35);
        let light = super::super::Light { azimuth: Turns::default(), elevation };
        for strength in [1, 2] {
            let light = Light::new(light, Factor::from_num(strength));
            let (sine, cosine) = 35_f64.to_radians().sin_cos();
            let k = f64::from(strength) / sine;
            for u in (-32_600..32_600_i16).step_by(97) {
                for v in (-32_600..32_600_i16).step_by(103) {
                    let one = 2_f64.powf(14.5);
                    let (uf, vf) = (f64::from(u) / one, f64::from(v) / one);
                    let square = uf * uf + vf * vf;
                    if square > 1.41 * 1.41 {
                        continue;
                    }
                    let exact = k * ((sine - cosine * uf) / (1.0 + square).sqrt()).max(0.0);
                    let got = f64::from(light.shade(Plain::splat(u), Plain::splat(v))[0]) / f64::from(ONE);
                    let bound = 0.0008 * exact + 0.0006;
                    assert!((got - exact).abs() < bound, "u {uf} v {vf}: {got} for {exact}");
                }
            }
        }
    }
}
