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
