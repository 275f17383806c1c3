use super::Factor;

/// An angle as a share of a full turn, in steps of 2^-32 turn. Sums wrap, so that a phase stays exact for ever.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Turns(pub u32);

impl Turns {
    /// A quarter of a turn: 90°.
    pub const QUARTER: Self = Self(1 << 30);

    /// The angle of `degrees`, rounded to the nearest step of 2^-32 turn.
    pub const fn from_degrees(degrees: i32) -> Self {
        let wrapped = degrees.rem_euclid(360) as u64;
        Self((((wrapped << 32) + 180) / 360) as u32)
    }

    /// This angle turned further by `step`.
    #[must_use]
    pub const fn plus(self, step: Self) -> Self {
        Self(self.0.wrapping_add(step.0))
    }

    /// The sine, within 1e-8.
    ///
    /// The quarter turn around zero is an odd polynomial, the minimax fit of sin(πx/2) over 0..=1; the other three quarters
    /// are its mirror images.
    pub fn sin(self) -> Factor {
        // Fold to -1..=1 quarters: the second and third quarter run backwards.
        let quarters = self.0 as i32; // −2^31..2^31 is −2..2 quarters in Q30.
        let folded = match quarters {
            q if q > 1 << 30 => (1_i64 << 31) - i64::from(q),
            q if q < -(1 << 30) => -(1_i64 << 31) - i64::from(q),
            q => i64::from(q),
        };
        // Q30 coefficients of x, x³, x⁵, x⁷, x⁹.
        const ODD: [i64; 5] = [1_686_629_674, -693_597_876, 85_564_854, -5_016_766, 161_942];
        let square = (folded * folded) >> 30;
        let sum = ODD.iter().rev().fold(0_i64, |sum, c| ((sum * square) >> 30) + c);
        let q30 = (folded * sum + (1 << 29)) >> 30;
        Factor::from_bits((q30.clamp(-(1 << 30), 1 << 30) >> 2) as i32)
    }

    /// The cosine, within 1e-8.
    pub fn cos(self) -> Factor {
        self.plus(Self::QUARTER).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_within_the_stated_error() {
        let worst = (0..1_000_000_u32).fold(0_f64, |worst, i| {
            let angle = Turns(i.wrapping_mul(4_294_967));
            let radians = f64::from(angle.0) / 2_f64.powi(32) * core::f64::consts::TAU;
            let sine = (angle.sin().to_num::<f64>() - radians.sin()).abs();
            let cosine = (angle.cos().to_num::<f64>() - radians.cos()).abs();
            worst.max(sine).max(cosine)
        });
        assert!(worst < 1e-8, "worst error {worst:e}");
    }

    #[test]
    fn quarters_are_exact() {
        assert_eq!(
            [0, 90, 180, 270].map(|d| Turns::from_degrees(d).sin().to_bits() >> 4),
            [0, 1 << 24, 0, -(1 << 24)]
        );
        assert_eq!(Turns::from_degrees(-90), Turns::from_degrees(270));
    }
}
