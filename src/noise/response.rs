//! The response of a body with inertia: a push goes on to act while it dies away.
//!
//! The paper, eq. 5 and 6: S(t) = Σ_{i=0..n} N(t−i)·P(i) with P(t) = exp(−t/τ). With r = exp(−1/τ) the same sum costs two
//! multiplications whatever n is: S(t) = r·S(t−1) + N(t) − r^(n+1)·N(t−n−1). Errors of rounding die away with r, too.
//!
//! Departs: n = 5τ, where the paper leaves n open (what is cut off is e^-5, under 1 % of the response); N is rounded to 2^-24 and
//! limited to ±128 on its way in, so that the memory is half as large.

use super::Kind;
use crate::math::Sample;
use heapless::Deque;

/// The response filter, with memory for any time constant up to [`Response::MAX_TIME_CONSTANT`].
#[derive(Clone, Debug)]
pub struct Response {
    /// r, in units of 2^-62.
    decay: i64,
    /// r^(n+1), in units of 2^-62.
    tail: i64,
    sum: Sample,
    /// N(t−n−1) to N(t−1), in units of 2^-24.
    history: Deque<i32, CAPACITY>,
}

/// n + 1 for the largest time constant.
const CAPACITY: usize = (Response::ORDER * Response::MAX_TIME_CONSTANT) as usize + 1;

/// How many fractional bits the remembered samples have.
const HISTORY_BITS: u32 = 24;

/// One, in units of 2^-62.
const ONE: i64 = 1 << 62;

impl Response {
    /// The largest time constant: 200 frames are 3.3 s at 60 frames a second.
    pub const MAX_TIME_CONSTANT: u32 = 200;

    /// n/τ: how many time constants the response lasts.
    pub const ORDER: u32 = 5;

    /// A response that dies away by 1/e in `time_constant` frames (at most [`Self::MAX_TIME_CONSTANT`]; 0 is no inertia at all),
    /// at rest.
    pub fn new(time_constant: u32) -> Self {
        let time_constant = time_constant.min(Self::MAX_TIME_CONSTANT);
        let decay = decay(time_constant);
        let lasts = (Self::ORDER * time_constant) as usize + 1;
        let tail = (1..lasts).fold(decay, |power, _| times(power, decay));
        let mut history = Deque::new();
        history.extend(core::iter::repeat_n(0, lasts));
        Self { decay, tail, sum: Sample::ZERO, history }
    }

    /// n + 1: after so many steps nothing of what was before is left.
    pub fn lasts(&self) -> usize {
        self.history.len()
    }

    /// S(t), from N(t).
    pub fn step(&mut self, sample: Sample) -> Sample {
        let rounded = crate::math::shift_rounded(sample.to_bits(), Sample::FRAC_NBITS - HISTORY_BITS);
        let new = rounded.clamp(i32::MIN.into(), i32::MAX.into()) as i32;
        let widen = |sample: i32| i64::from(sample) << (Sample::FRAC_NBITS - HISTORY_BITS);
        let old = self.history.pop_front().unwrap_or(0);
        // There is room: one was taken out.
        let _ = self.history.push_back(new);
        let kept = i128::from(self.sum.to_bits()) * i128::from(self.decay);
        let gone = i128::from(widen(old)) * i128::from(self.tail);
        let sum = ((kept - gone + i128::from(ONE / 2)) >> 62) as i64 + widen(new);
        self.sum = Sample::from_bits(sum);
        self.sum
    }

    /// G = (1 − r^(n+1))/(1 − r): what S(t) comes to when N is always 1. S/G is a weighted mean of the last n + 1 samples.
    pub fn gain(&self) -> Sample {
        let gain = (i128::from(ONE - self.tail) << Sample::FRAC_NBITS) / i128::from(ONE - self.decay);
        Sample::from_bits(gain as i64)
    }

    /// Sigma of S/G for the noise of this `kind`, as its generator makes it; 1 for the noises in 0..=1, which need none.
    ///
    /// For white noise it is √((1 − r)(1 + r^(n+1)) / (1 + r)(1 − r^(n+1))). For the others it is interpolated between computed
    /// values, within 0.3 %.
    pub fn spread(&self, kind: Kind) -> Sample {
        let time_constant = (self.lasts() - 1) as u32 / Self::ORDER;
        match kind {
            Kind::White => self.spread_of_white(),
            Kind::Filter => interpolate(&FILTER_SPREAD, time_constant),
            Kind::Hosoda => interpolate(&HOSODA_SPREAD, time_constant),
            Kind::Brown | Kind::BrownLiteral => interpolate(&BROWN_SPREAD, time_constant),
            Kind::Constant | Kind::Chaos | Kind::ChaosLiteral => Sample::ONE,
        }
    }

    fn spread_of_white(&self) -> Sample {
        let ratio = |part: i64| ((ONE - part) as u128 * (1 << 62)) / (ONE + part) as u128;
        let variance = (ratio(self.decay) << 62) / ratio(self.tail);
        Sample::from_bits((variance.isqrt() << (Sample::FRAC_NBITS - 31)) as i64)
    }
}

/// exp(−1/τ) in units of 2^-62, by its series.
fn decay(time_constant: u32) -> i64 {
    if time_constant == 0 {
        return 0;
    }
    let (mut term, mut sum) = (ONE, ONE);
    for k in 1.. {
        term /= -i64::from(k * time_constant);
        sum += term;
        if term == 0 {
            break;
        }
    }
    sum
}

/// The product of two numbers in units of 2^-62.
const fn times(a: i64, b: i64) -> i64 {
    ((a as i128 * b as i128 + (ONE / 2) as i128) >> 62) as i64
}

/// The time constants for which the spreads were computed.
const KNOTS: [u32; 16] = [0, 1, 2, 3, 5, 7, 10, 14, 20, 28, 40, 56, 80, 112, 160, 200];

/// Sigma of S/G at each knot for [`super::filter`], in units of 2^-16.
const FILTER_SPREAD: [u32; KNOTS.len()] = [
    65536, 62875, 61024, 59924, 58526, 57596, 56601, 55651, 54626, 53641, 52571, 51538, 50418, 49341, 48178,
    47438,
];

/// Sigma of S/G at each knot for [`super::hosoda`], in units of 2^-16.
const HOSODA_SPREAD: [u32; KNOTS.len()] = [
    65536, 61806, 59246, 57782, 56004, 54870, 53692, 52597, 51445, 50359, 49202, 48100, 46915, 45776, 44544,
    43759,
];

/// Sigma of S/G at each knot for [`super::brown::Brown`] with the usual leak, in units of 2^-16.
const BROWN_SPREAD: [u32; KNOTS.len()] = [
    65568, 65515, 65450, 65388, 65267, 65147, 64968, 64733, 64384, 63927, 63258, 62396, 61162, 59618, 57497,
    55885,
];

/// The straight line between the two knots around `time_constant`.
fn interpolate(spread: &[u32; KNOTS.len()], time_constant: u32) -> Sample {
    let above = KNOTS.iter().position(|&knot| knot >= time_constant).unwrap_or(KNOTS.len() - 1).max(1);
    let (low, high) = (KNOTS[above - 1], KNOTS[above]);
    let line = spread[above - 1] * (high - time_constant) + spread[above] * (time_constant - low);
    Sample::from_num(line) / Sample::from_num((high - low) << 16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::random::{Stream, stream},
        noise::{Generator, reference},
    };
    use proptest::prelude::*;

    #[test]
    fn the_spreads_are_those_of_the_f64_twins() {
        let twins = [
            (FILTER_SPREAD, reference::spread::<reference::Filter, 8>(&KNOTS)),
            (HOSODA_SPREAD, reference::spread::<reference::Hosoda, 9>(&KNOTS)),
            (BROWN_SPREAD, reference::spread::<reference::Brown<9>, 1>(&KNOTS)),
        ];
        for (table, twin) in twins {
            reference::check_table(table.map(i64::from), twin, 16, 0.1);
        }
    }

    #[test]
    fn spreads_between_the_knots_are_within_the_stated_error() {
        let between = [4, 6, 12, 17, 24, 34, 48, 68, 96, 136, 180];
        let white = [1, 5, 10, 20, 40, 200];
        check_spread(Kind::Filter, &between, &reference::spread::<reference::Filter, 8>(&between), 3e-3);
        check_spread(Kind::Hosoda, &between, &reference::spread::<reference::Hosoda, 9>(&between), 3e-3);
        check_spread(Kind::Brown, &between, &reference::spread::<reference::Brown<9>, 1>(&between), 3e-3);
        check_spread(Kind::White, &white, &reference::spread::<reference::White, 1>(&white), 1e-8);
    }

    fn check_spread(kind: Kind, time_constants: &[u32], twin: &[f64], error: f64) {
        for (&time_constant, exact) in time_constants.iter().zip(twin) {
            let spread = Response::new(time_constant).spread(kind).to_num::<f64>();
            assert!((spread / exact - 1.).abs() < error, "{kind}, {time_constant}: {spread} for {exact}");
        }
    }

    #[test]
    fn the_spreads_at_the_presets_are_known() {
        let presets = [
            (Kind::White, [0.3174, 0.2249, 0.1591, 0.1125]),
            (Kind::Filter, [0.8930, 0.8637, 0.8335, 0.8022]),
            // Of a noise whose own sigma is 1.0005.
            (Kind::Brown, [0.9954 * 1.0005, 0.9909 * 1.0005, 0.9819 * 1.0005, 0.9648 * 1.0005]),
        ];
        for (kind, spreads) in presets {
            check_spread(kind, &[5, 10, 20, 40], &spreads, 5e-4);
        }
    }

    /// The recursion against the sum of eq. 5, in steps of 2^-24: what remains is the rounding of the samples on their way in.
    #[test]
    fn the_recursion_is_the_sum() {
        for (time_constant, steps) in [(1, 2.), (20, 4.), (40, 6.), (200, 12.)] {
            let mut response = Response::new(time_constant);
            let lasts = response.lasts();
            let mut noise = Generator::new(Kind::Brown, stream(1, Stream::Amplitude));
            let mut samples = vec![0.; lasts];
            let mut worst = 0_f64;
            for _ in 0..20_000 {
                let sample = noise.step();
                samples.push(sample.to_num());
                let exact = reference::response(&samples[samples.len() - lasts..], f64::from(time_constant));
                worst = worst.max((response.step(sample).to_num::<f64>() - exact).abs());
            }
            println!("τ = {time_constant}: within {:.1} steps of 2^-24", worst * 2_f64.powi(24));
            assert!(worst <= steps * 2_f64.powi(-24), "τ = {time_constant}: {worst:e}");
        }
    }

    proptest! {
        #[test]
        fn a_constant_comes_to_the_gain(time_constant in 0..250_u32) {
            let mut response = Response::new(time_constant);
            let mut last = Sample::ZERO;
            for _ in 0..response.lasts() {
                last = response.step(Sample::ONE);
            }
            prop_assert!((last - response.gain()).abs() <= Sample::from_bits(1 << 9));
        }
    }

    #[test]
    fn no_inertia_changes_nothing() {
        let mut response = Response::new(0);
        assert_eq!((response.lasts(), response.gain()), (1, Sample::ONE));
        for bits in [1_i64 << 40, -3 << 35, 0] {
            assert_eq!(response.step(Sample::from_bits(bits)), Sample::from_bits(bits));
        }
    }
}
