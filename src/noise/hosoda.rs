//! 1/f noise by Hosoda's ladder of lag-lead filters: the digital filter in its literal form.
//!
//! T. Hosoda, "1/f雑音生成アルゴリズム" (2002): a chain of sections, each of which halves the power above one octave in two, and
//! a smoothing of the last output. All its coefficients are dyadic, so that it needs shifts and additions only.
//!
//! Its spectral slope over the three decades up to a tenth of the frame rate is 0.956, not 1: the sections bend near the frame
//! rate. [`super::filter`] is straight.
//!
//! Departs: 1) the input is Gaussian white noise, not random signs; 2) it is scaled so that the output has unit sigma; 3) it
//! starts in the middle of its life, not at rest.

use super::white;
use crate::math::{Sample, random::Rng, shift_rounded};

/// How many sections there are: enough for slopes down to 1/2^16 of the frame rate.
pub(super) const SECTIONS: usize = 8;

/// What the white noise is multiplied by: 1/0.009787203, the sigma of the ladder's output for an input of unit sigma. In units
/// of 2^-23.
pub(super) const GAIN: i64 = 857_099_656;

/// The covariance of the sections and of the output, as [`white::correlated`] takes it.
#[rustfmt::skip]
pub(super) const START: [i32; (SECTIONS + 1) * (SECTIONS + 2) / 2] = [
    6_696_142,
    8_035_485, 2_678_747,
    8_508_290, 4_727_744, 2_206_935,
    8_639_318, 5_499_472, 4_280_242, 2_108_540,
    8_673_066, 5_717_348, 5_099_420, 4_193_008, 2_097_669,
    8_681_660, 5_774_190, 5_335_362, 5_034_353, 4_222_431, 2_147_189,
    8_683_912, 5_789_174, 5_399_206, 5_285_906, 5_115_419, 4_438_311, 2_382_433,
    8_684_575, 5_793_590, 5_418_150, 5_362_580, 5_417_043, 5_539_599, 5_437_042, 3_620_006,
    8_684_619, 5_793_885, 5_419_415, 5_367_732, 5_437_791, 5_622_433, 5_748_585, 4_450_332, 517_375,
];

/// A source of nearly 1/f noise of zero mean and unit sigma.
#[derive(Clone, Debug)]
pub struct Hosoda {
    /// The low-pass outputs, slowest first.
    sections: [i64; SECTIONS],
    output: i64,
}

impl Hosoda {
    /// A source in the middle of its life.
    pub fn new(rng: &mut Rng) -> Self {
        let [sections @ .., output]: [i64; SECTIONS + 1] = white::correlated(&START, rng);
        Self { sections, output }
    }

    /// The next frame's sample.
    pub fn step(&mut self, rng: &mut Rng) -> Sample {
        let mut signal = GAIN * white::draw(rng);
        for (i, low) in self.sections.iter_mut().enumerate() {
            // The fastest section moves half of the way a frame, the one before it an eighth, and so on.
            *low += shift_rounded(signal - *low, 2 * (SECTIONS - i) as u32 - 1);
            signal = shift_rounded(signal + *low, 1);
        }
        self.output = shift_rounded(3 * signal + self.output, 2);
        Sample::from_bits(self.output)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::random::{Stream, stream},
        noise::reference::{self, Comparison, Linear as _, check_table},
    };

    #[test]
    fn the_tables_are_those_of_the_ladder() {
        let sigma = reference::sigma::<reference::Hosoda, { SECTIONS + 1 }>();
        assert!((sigma - 1.).abs() < 1e-6, "sigma {sigma}");
        check_table([GAIN], [1. / reference::Hosoda::SIGMA], 23, 0.);
        let start = reference::cholesky(reference::covariance::<reference::Hosoda, { SECTIONS + 1 }>());
        check_table(START.map(i64::from), start, 24, 1.);
    }

    #[test]
    fn the_ladder_is_its_twin() {
        let (mut rng, mut words) = (stream(1, Stream::Amplitude), stream(1, Stream::Amplitude));
        let mut ladder = Hosoda::new(&mut rng);
        for _ in 0..=SECTIONS {
            reference::white(&mut words);
        }
        let fraction = |bits: i64| bits as f64 / 2_f64.powi(40);
        let mut twin = reference::Hosoda { z: ladder.sections.map(fraction), t: fraction(ladder.output) };
        let mut comparison = Comparison::default();
        for _ in 0..1 << 22 {
            comparison.add(ladder.step(&mut rng), twin.step(reference::white(&mut words)));
        }
        comparison.check("hosoda");
    }
}
