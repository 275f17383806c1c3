//! 1/f noise by a digital filter: the default.
//!
//! The paper, section 3.3.3, filters white noise and leaves the filter open ([`super::hosoda`] is the one it cites). Here eight
//! leaky sums of the same white noise, their memories four times apart from 4 to 65,536 frames, are added to the last two white
//! samples. The weights are a minimax fit of the power spectrum to 1/f: within ±0.13 dB from 1e-5 to 0.49 of the frame rate (at
//! 12 frames a second, from a day to two frames).

use super::white;
use crate::math::{Sample, random::Rng, shift_rounded};

/// How many leaky sums there are. The i-th forgets by 1/4^(i+1) a frame.
pub(super) const POLES: usize = 8;

/// The weights of the white sample of this frame and of the last one: 5695 and 1628 of 4096 (the fit) over 6.879008 (the sigma
/// of the sum), so that the noise has unit sigma. In units of 2^-23.
pub(super) const DIRECT: [i64; 2] = [1_695_500, 484_684];

/// What each leaky sum takes in: 4096, 1269, 907, 302, 220, 83, 55, 40 of 4096 over 6.879008. In units of 2^-23, so that the
/// product with a white sample is exact.
pub(super) const WEIGHTS: [i64; POLES] =
    [1_219_450, 377_803, 270_030, 89_911, 65_498, 24_711, 16_374, 11_909];

/// The covariance of the leaky sums, as [`white::correlated`] takes it. Starting from zero, they would need 3·2^16 frames (at 12
/// a second, 4½ hours) to get within a thousandth of it.
#[rustfmt::skip]
pub(super) const START: [i32; POLES * (POLES + 1) / 2] = [
    3_687_271,
    1_683_492, 1_371_395,
    1_364_884, 2_181_482, 1_668_822,
    470_252, 920_224, 1_401_312, 1_056_146,
    345_569, 713_924, 1_339_997, 2_017_498, 1_514_973,
    130_660, 273_693, 543_445, 1_010_172, 1_516_667, 1_137_847,
    86_630, 182_094, 366_796, 721_649, 1_338_231, 2_007_813, 1_505_974,
    63_012, 132_565, 267_995, 534_964, 1_050_138, 1_946_229, 2_919_512, 2_189_676,
];

/// A source of 1/f noise of zero mean and unit sigma.
#[derive(Clone, Debug)]
pub struct Filter {
    sums: [i64; POLES],
    last: i64,
}

impl Filter {
    /// A source in the middle of its life.
    pub fn new(rng: &mut Rng) -> Self {
        let mut filter = Self { sums: white::correlated(&START, rng), last: 0 };
        // The last white sample is part of what the sums hold: a step makes it so.
        filter.step(rng);
        filter
    }

    /// The next frame's sample.
    pub fn step(&mut self, rng: &mut Rng) -> Sample {
        let white = white::draw(rng);
        let mut sample = DIRECT[0] * white + DIRECT[1] * self.last;
        for (i, (sum, weight)) in self.sums.iter_mut().zip(WEIGHTS).enumerate() {
            *sum += weight * white - shift_rounded(*sum, 2 * (i as u32 + 1));
            sample += *sum;
        }
        self.last = white;
        Sample::from_bits(sample)
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
    fn the_tables_are_those_of_the_fit() {
        let twin = reference::Filter::default();
        check_table(DIRECT, twin.direct, 23, 0.);
        check_table(WEIGHTS, twin.weights, 23, 0.);
        let start = reference::cholesky(reference::covariance::<reference::Filter, POLES>());
        check_table(START.map(i64::from), start, 24, 1.);
        let sigma = reference::sigma::<reference::Filter, POLES>();
        assert!((sigma - 1.).abs() < 1e-6, "sigma {sigma}");
    }

    #[test]
    fn the_power_is_one_over_f_within_the_stated_ripple() {
        use std::f64::consts::TAU;
        let twin = reference::Filter::default();
        // |H(f)|²·f in decibels, where z^-1 = (cos ω, −sin ω).
        let level = |frequency: f64| {
            let (sin, cos) = (TAU * frequency).sin_cos();
            let mut h = (twin.direct[0] + twin.direct[1] * cos, -twin.direct[1] * sin);
            for (i, weight) in twin.weights.into_iter().enumerate() {
                let a = 1. - 0.25_f64.powi(i as i32 + 1);
                let (re, im) = (1. - a * cos, a * sin);
                let scale = weight / (re * re + im * im);
                h = (h.0 + scale * re, h.1 - scale * im);
            }
            10. * ((h.0 * h.0 + h.1 * h.1) * frequency).log10()
        };
        let levels = (0..=2000).map(|i| level(1e-5 * 49_000_f64.powf(f64::from(i) / 2000.)));
        let (low, high) = levels.fold((f64::MAX, f64::MIN), |(low, high), l| (low.min(l), high.max(l)));
        assert!(high - low < 2. * 0.135, "ripple of ±{} dB", (high - low) / 2.);
    }

    #[test]
    fn the_filter_is_its_twin() {
        let (mut rng, mut words) = (stream(1, Stream::Amplitude), stream(1, Stream::Amplitude));
        let mut filter = Filter::new(&mut rng);
        for _ in 0..=POLES {
            reference::white(&mut words);
        }
        let fraction = |bits: i64, places: i32| bits as f64 / 2_f64.powi(places);
        let mut twin = reference::Filter {
            direct: DIRECT.map(|weight| fraction(weight, 23)),
            weights: WEIGHTS.map(|weight| fraction(weight, 23)),
            sums: filter.sums.map(|sum| fraction(sum, 40)),
            last: fraction(filter.last, 17),
        };
        let mut comparison = Comparison::default();
        for _ in 0..1 << 22 {
            comparison.add(filter.step(&mut rng), twin.step(reference::white(&mut words)));
        }
        comparison.check("filter");
    }

    #[test]
    fn the_first_samples_have_the_sigma_of_the_later_ones() {
        let squares = (0..4096).map(|seed| {
            let mut rng = stream(seed, Stream::Amplitude);
            Filter::new(&mut rng).step(&mut rng).to_num::<f64>().powi(2)
        });
        let variance = squares.sum::<f64>() / 4096.;
        assert!((variance - 1.).abs() < 4. * (2_f64 / 4096.).sqrt(), "variance {variance}");
    }
}
