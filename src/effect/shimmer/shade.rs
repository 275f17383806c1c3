//! Lambert's shade of a slope: S = max(0, n·L).

use crate::math::mul_q15;

/// The direction of the light, in the frame in which `u` points towards it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// L_z, the sine of the elevation, Q14; at least [`LEAST_UP`].
    pub(super) up: i16,
    /// The cosine of the elevation, Q15.
    along: i16,
}

/// A light below 5° would make black of every slope that turns away, and its share of the plane, by which the shade is divided, nothing.
const LEAST_UP: i16 = 1428;

impl Light {
    pub(super) fn new(light: super::Light) -> Self {
        let q15 = |factor: crate::math::Factor| (factor.to_bits() >> 13).min(i32::from(i16::MAX)) as i16;
        Self { up: (q15(light.elevation.sin()) / 2).max(LEAST_UP), along: q15(light.elevation.cos()).max(0) }
    }

    /// The shade of a slope of at most 60°, u and v in Q14: 0..=1 in Q14.
    ///
    /// n = (−u, −v, 1)/sqrt(1 + u² + v²), so n·L = (L_z − |L_xy|·u)/sqrt(1 + u² + v²). Within 0.0015 of the exact value.
    #[inline(always)]
    pub(super) const fn shade(self, u: i16, v: i16) -> i16 {
        let square = mul_q15(u, u) + mul_q15(v, v); // Q13
        let shade = mul_q15(self.up - mul_q15(self.along, u), reciprocal_root(square));
        if shade < 0 { 0 } else { shade }
    }
}

/// 1/sqrt(1 + s) in Q15, for s of 0..=3 in Q13. Within 0.0006.
///
/// The minimax polynomial of degree 5 in y = (s − 3/2)/4, whose error is 0.00048; in steps of y the coefficients are 0.63285, −0.51019,
/// 0.55966, −0.63499, 1.91971, −3.39707. With degree 4 (0.0016) a strength of 1.25 would be wrong by up to 1.8 levels.
#[inline(always)]
const fn reciprocal_root(square: i16) -> i16 {
    let y = square - 12_288; // (s − 3/2)/4 in Q15
    let quartic = mul_q15(y, -27_829) + 15_726; // Q13
    let cubic = (mul_q15(y, quartic) << 1) - 10_404; // Q14
    let quadratic = mul_q15(y, cubic) + 9_169; // Q14
    let linear = (mul_q15(y, quadratic) << 1) - 16_718; // Q15
    mul_q15(y, linear) + 20_737
}

/// The slope a·p + b·q + c in Q14, a and b in Q15.
#[inline(always)]
pub(super) const fn slope(a: i16, p: i16, b: i16, q: i16, c: i16) -> i16 {
    mul_q15(a, p) + mul_q15(b, q) + c
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Turns;

    #[test]
    fn the_reciprocal_root_is_within_the_stated_error() {
        for square in 0..=24_576_i16 {
            let exact = 1.0 / (1.0 + f64::from(square) / 8192.0).sqrt();
            let error = f64::from(reciprocal_root(square)) / 32_768.0 - exact;
            assert!(error.abs() < 0.0006, "s = {square}: {error}");
        }
    }

    #[test]
    fn the_shade_is_that_of_lambert() {
        let elevation = Turns::from_degrees(35);
        let light = Light::new(super::super::Light { azimuth: Turns::default(), elevation });
        for u in (-28_000..28_000_i16).step_by(97) {
            for v in (-28_000..28_000_i16).step_by(103) {
                let (uf, vf) = (f64::from(u) / 16_384.0, f64::from(v) / 16_384.0);
                let square = uf * uf + vf * vf;
                if square <= 3.0 {
                    let angle = 35_f64.to_radians();
                    let exact = ((angle.sin() - angle.cos() * uf) / (1.0 + square).sqrt()).max(0.0);
                    let got = f64::from(light.shade(u, v)) / 16_384.0;
                    assert!((got - exact).abs() < 0.0015, "u {uf} v {vf}: {got} for {exact}");
                }
            }
        }
    }
}
