//! 1/f noise by intermittent chaos.
//!
//! The paper, eq. 9: N grows by u·N^z while it is below 1/2 and is doubled and folded above. Close to 0 it creeps for minutes,
//! then bursts: that alternation has a 1/f spectrum. [`Literal`] is the map as printed; it dies, because a value above 1 is followed
//! by 0 for ever. [`Chaos`] lives.
//!
//! Departs (`Chaos`): 1) u = 2^(z−1), so that the map fills 0..1 exactly and never exceeds it; 2) below 2^-14 the value is put
//! back to 2^-14 and a random part, which bounds the creep to 8,192 frames; 3) 24 random low bits are added, because a map on a finite
//! number of values ends in a short cycle (with 16 bits one block of 256 frames among 2^32 frames stood twice); 4) the sample is √N: N itself spends so little of its power on the creep that its
//! spectral slope is 0.81, that of its root, along the same orbit, is 1.

use crate::math::{Sample, random::Rng, sqrt};
use rand::Rng as _;

/// 1/2, where the map folds, as a fraction of 64 bits.
const FOLD: u64 = 1 << 63;

/// 2^-14, the least value, as a fraction of 64 bits. The creep from there to 1/2 takes 7,600 frames (at 12 a second, ten minutes).
const LEAST_BITS: u32 = 14;

/// 2^(k/100) for each k, in units of 2^-31: what x^-0.01 gains with each halving of x.
#[rustfmt::skip]
pub(super) const HALVINGS: [u32; 33] = [
    2_147_483_648, 2_162_420_578, 2_177_461_403, 2_192_606_844, 2_207_857_631, 2_223_214_495,
    2_238_678_175, 2_254_249_413, 2_269_928_958, 2_285_717_562, 2_301_615_985, 2_317_624_990,
    2_333_745_347, 2_349_977_830, 2_366_323_218, 2_382_782_298, 2_399_355_859, 2_416_044_699,
    2_432_849_619, 2_449_771_426, 2_466_810_934, 2_483_968_961, 2_501_246_331, 2_518_643_875,
    2_536_162_429, 2_553_802_834, 2_571_565_937, 2_589_452_593, 2_607_463_660, 2_625_600_004,
    2_643_862_496, 2_662_252_014, 2_680_769_441,
];

/// 1 − (1 + j/128)^-0.01 for each j, in units of 2^-38: what x^-0.01 loses within an octave.
#[rustfmt::skip]
pub(super) const WITHIN_OCTAVE: [u32; 129] = [
    0, 21_390_552, 42_614_280, 63_673_752, 84_571_479, 105_309_914, 125_891_456, 146_318_450,
    166_593_188, 186_717_912, 206_694_815, 226_526_041, 246_213_691, 265_759_818, 285_166_432,
    304_435_501, 323_568_951, 342_568_670, 361_436_504, 380_174_263, 398_783_719, 417_266_609,
    435_624_635, 453_859_464, 471_972_730, 489_966_036, 507_840_953, 525_599_021, 543_241_749,
    560_770_621, 578_187_087, 595_492_575, 612_688_482, 629_776_180, 646_757_017, 663_632_314,
    680_403_369, 697_071_455, 713_637_823, 730_103_700, 746_470_293, 762_738_786, 778_910_342,
    794_986_105, 810_967_195, 826_854_718, 842_649_756, 858_353_375, 873_966_622, 889_490_527,
    904_926_100, 920_274_336, 935_536_214, 950_712_696, 965_804_725, 980_813_234, 995_739_136,
    1_010_583_332, 1_025_346_707, 1_040_030_132, 1_054_634_464, 1_069_160_546, 1_083_609_209,
    1_097_981_269, 1_112_277_530, 1_126_498_784, 1_140_645_809, 1_154_719_374, 1_168_720_232,
    1_182_649_129, 1_196_506_795, 1_210_293_953, 1_224_011_313, 1_237_659_574, 1_251_239_426,
    1_264_751_548, 1_278_196_609, 1_291_575_267, 1_304_888_173, 1_318_135_966, 1_331_319_277,
    1_344_438_728, 1_357_494_932, 1_370_488_491, 1_383_420_002, 1_396_290_052, 1_409_099_219,
    1_421_848_073, 1_434_537_178, 1_447_167_088, 1_459_738_349, 1_472_251_502, 1_484_707_078,
    1_497_105_603, 1_509_447_594, 1_521_733_561, 1_533_964_009, 1_546_139_435, 1_558_260_329,
    1_570_327_174, 1_582_340_450, 1_594_300_626, 1_606_208_168, 1_618_063_534, 1_629_867_179,
    1_641_619_548, 1_653_321_083, 1_664_972_221, 1_676_573_390, 1_688_125_017, 1_699_627_519,
    1_711_081_312, 1_722_486_803, 1_733_844_397, 1_745_154_492, 1_756_417_482, 1_767_633_756,
    1_778_803_698, 1_789_927_686, 1_801_006_096, 1_812_039_299, 1_823_027_659, 1_833_971_537,
    1_844_871_292, 1_855_727_274, 1_866_539_834, 1_877_309_315, 1_888_036_057, 1_898_720_396,
];

/// u·x^1.99 with u = 2^(0.99 + `hundredths`/100), for x below 1/2, both as fractions of 64 bits.
///
/// x^1.99 is x²·x^-0.01, and the second factor is so flat that it may be interpolated linearly, within 8e-8.
pub(super) fn growth(x: u64, hundredths: usize) -> u64 {
    let square = (u128::from(x) * u128::from(x)) >> 64;
    if square == 0 {
        return 0;
    }
    let octave = x.leading_zeros();
    let mantissa = x << octave << 1;
    let (entry, between) = ((mantissa >> 57) as usize, mantissa >> 33 & 0xff_ffff);
    let (low, high) = (u64::from(WITHIN_OCTAVE[entry]), u64::from(WITHIN_OCTAVE[entry + 1]));
    let lost = low + (((high - low) * between) >> 24);
    let gained = u64::from(HALVINGS[octave as usize + hundredths]);
    let factor = (gained << 31) - ((gained * lost) >> 7); // in units of 2^-62
    ((square * u128::from(factor)) >> 61) as u64
}

/// A source of 1/f noise in 0..=1 that never dies and never repeats.
#[derive(Clone, Debug)]
pub struct Chaos {
    /// N, as a fraction of 64 bits.
    pub(super) state: u64,
}

impl Chaos {
    /// The mean of the samples, over 16 seeds of 2^26 frames; single seeds lie within 0.0015.
    pub(super) const MEAN: Sample = Sample::lit("0.2944");
    /// One over the standard deviation of the samples, 0.2981; single seeds lie within 0.0003.
    pub(super) const PER_SIGMA: Sample = Sample::lit("3.3546");

    /// A source in the middle of its life: the creep makes small values likely, about as 1/N.
    pub fn new(rng: &mut Rng) -> Self {
        let octave = rng.next_u64() % u64::from(LEAST_BITS);
        Self { state: (rng.next_u64() | FOLD) >> octave }
    }

    /// The next frame's sample.
    pub fn step(&mut self, rng: &mut Rng) -> Sample {
        let random = rng.next_u64();
        let next = if self.state < FOLD {
            self.state.saturating_add(growth(self.state, 0)).saturating_add(random >> 40)
        } else {
            self.state << 1 | random >> 63
        };
        const LEAST: u64 = 1 << (64 - LEAST_BITS);
        self.state = if next < LEAST { LEAST + (random << 1 >> LEAST_BITS) } else { next };
        Sample::from_bits((sqrt(self.state) >> (63 - Sample::FRAC_NBITS)) as i64)
    }
}

/// Eq. 9 as printed, with u = 2 and z = 1.99: N just below 1/2 is followed by a value above 1, and that by 0 for ever. When that
/// happens, a line in the log says so. The samples are N, at most 1.
#[derive(Clone, Debug)]
pub struct Literal {
    /// N, in units of 2^-63.
    state: u64,
}

impl Literal {
    const ONE: u64 = 1 << 63;

    /// A source that starts anywhere in 0..1.
    pub fn new(rng: &mut Rng) -> Self {
        Self { state: rng.next_u64() >> 1 }
    }

    /// The next frame's sample.
    pub fn step(&mut self) -> Sample {
        let next = Self::after(self.state);
        if next == 0 && self.state != 0 {
            log::warn!(
                "the literal intermittent chaos has died: its value is 0 from now on (choose `chaos`, which lives)"
            );
        }
        self.state = next;
        Sample::from_bits((next.min(Self::ONE) >> (63 - Sample::FRAC_NBITS)) as i64)
    }

    /// Eq. 9. Where it leaves the value open (N = 1/2, N = 1), the second line is taken.
    fn after(state: u64) -> u64 {
        const HALF: u64 = Literal::ONE / 2;
        match state {
            0..HALF => state + growth(state << 1, 1) / 2,
            HALF..=Self::ONE => (state - HALF) * 2,
            _ => 0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::random::{Stream, stream},
        noise::reference::{self, Comparison, check_table},
    };

    fn fraction(bits: u64) -> f64 {
        bits as f64 / 2_f64.powi(64)
    }

    #[test]
    fn the_tables_are_powers() {
        let halvings = (0..33).map(|k| 2_f64.powf(f64::from(k) / 100.));
        check_table(HALVINGS.map(i64::from), halvings, 31, 1e-4);
        // 1 − m^-0.01 by expm1, for m^-0.01 is close to 1.
        let within_octave = (0..129).map(|j| -f64::exp_m1(-0.01 * (f64::from(j) / 128.).ln_1p()));
        check_table(WITHIN_OCTAVE.map(i64::from), within_octave, 38, 1e-4);
    }

    #[test]
    fn growth_is_within_the_stated_error() {
        let mut rng = stream(1, Stream::Amplitude);
        for _ in 0..1_000_000 {
            let x = (rng.next_u64() | FOLD) >> (1 + rng.next_u64() % 14);
            for (hundredths, u) in [(0, 2_f64.powf(0.99)), (1, 2.)] {
                let exact = reference::growth(fraction(x), u);
                let error = fraction(growth(x, hundredths)) / exact - 1.;
                assert!(error.abs() < 8e-8, "{x:#x}: {error:e}");
            }
        }
        assert_eq!(growth(1, 0), 0);
    }

    /// Chaos makes any two orbits part: the twin follows frame by frame, from where the integers are.
    #[test]
    fn chaos_is_its_twin() {
        let mut rng = stream(1, Stream::Amplitude);
        let mut words = rng.clone();
        let mut chaos = Chaos::new(&mut rng);
        let _ = [words.next_u64(), words.next_u64()];
        let mut comparison = Comparison::default();
        for _ in 0..1 << 22 {
            let (before, random) = (fraction(chaos.state), words.next_u64());
            let next = if before < 0.5 {
                before + reference::growth(before, 2_f64.powf(0.99)) + fraction(random >> 40)
            } else {
                2. * before - 1. + fraction(random >> 63)
            };
            let least = 2_f64.powi(-14);
            let next = if next < least { least + fraction(random << 1) * least } else { next };
            comparison.add(chaos.step(&mut rng), next.sqrt());
        }
        comparison.check("chaos");
    }

    #[test]
    fn chaos_leaves_even_the_ends_of_its_range() {
        for state in [0, 1, FOLD - 1, FOLD, u64::MAX] {
            let mut rng = stream(1, Stream::Amplitude);
            let mut chaos = Chaos { state };
            let samples: Vec<_> = (0..20_000).map(|_| chaos.step(&mut rng)).collect();
            assert!(samples.iter().any(|&sample| sample < Sample::FRAC_1_SQRT_2), "from {state:#x}");
            assert!(samples.iter().any(|&sample| sample > Sample::FRAC_1_SQRT_2), "from {state:#x}");
        }
    }

    #[test]
    fn the_mean_and_sigma_are_as_stated() {
        let mut rng = stream(1, Stream::Amplitude);
        let mut chaos = Chaos::new(&mut rng);
        let (mut sum, mut squares, n) = (0., 0., f64::from(1 << 24));
        for _ in 0..1 << 24 {
            let sample = chaos.step(&mut rng).to_num::<f64>();
            sum += sample;
            squares += sample * sample;
        }
        let mean = sum / n;
        let sigma = (squares / n - mean * mean).sqrt();
        assert!((mean - Chaos::MEAN.to_num::<f64>()).abs() < 0.005, "{mean}");
        assert!((sigma * Chaos::PER_SIGMA.to_num::<f64>() - 1.).abs() < 0.005, "{sigma}");
    }

    #[test]
    fn the_literal_map_is_eq_9() {
        let value = |state: u64| state as f64 / Literal::ONE as f64;
        let mut rng = stream(1, Stream::Amplitude);
        for _ in 0..100_000 {
            let state = rng.next_u64() >> 1;
            let n = value(state);
            let exact = if n < 0.5 { n + reference::growth(n, 2.) } else { 2. * n - 1. };
            assert!((value(Literal::after(state)) - exact).abs() < 1e-7, "{n}");
        }
        assert_eq!(Literal::after(Literal::ONE / 2), 0);
        assert_eq!(Literal::after(Literal::ONE), Literal::ONE);
        assert_eq!(Literal::after(Literal::ONE + 1), 0);
        assert!(Literal::after(Literal::ONE / 2 - 1) > Literal::ONE);
    }
}
