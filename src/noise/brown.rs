//! Brown noise: 1/f² noise, the integral of white noise.
//!
//! The paper, eq. 10: N(t) = Σ N_w(s). That sum strays ever farther (clamped to where it can be used, it would soon rest on a
//! limit nearly always), so [`Brown`] forgets slowly; [`Literal`] is the sum as printed.

use super::white;
use crate::math::{Sample, random::Rng, shift_rounded};

/// A source of brown noise of zero mean and unit sigma: y += g·w − y/2^LEAK, with g² = 2^(1−LEAK).
///
/// Its spectrum is 1/f² above 1/(2π·2^LEAK) of the frame rate and flat below. Sigma is 1/√(1 − 2^−(LEAK+1)): 1.0005 for the
/// default. LEAK is odd, so that g is a power of two.
///
/// Departs from eq. 10 by the leak, and by starting from a white sample: stationary at once.
#[derive(Clone, Debug)]
pub struct Brown<const LEAK: u32 = USUAL_LEAK> {
    sum: i64,
}

/// The usual leak: at 12 frames a second the noise forgets in 43 s, so that a viewer sees the whole range within minutes.
pub const USUAL_LEAK: u32 = 9;

/// By how much a white sample is shifted on its way into a sum that leaks by 2^-`leak`.
const fn white_shift(leak: u32) -> u32 {
    Sample::FRAC_NBITS - white::FRACTION_BITS - (leak - 1) / 2
}

impl<const LEAK: u32> Brown<LEAK> {
    /// A source in the middle of its life.
    pub fn new(rng: &mut Rng) -> Self {
        const { assert!(LEAK % 2 == 1 && LEAK < 40, "the gain must be a power of two, and exact") };
        Self { sum: white::step(rng).to_bits() }
    }

    /// The next frame's sample.
    pub fn step(&mut self, rng: &mut Rng) -> Sample {
        self.sum += (white::draw(rng) << white_shift(LEAK)) - shift_rounded(self.sum, LEAK);
        Sample::from_bits(self.sum)
    }
}

/// The sum of eq. 10 as printed, from N_w(0) on. It is scaled like [`Brown`] with the usual leak (a white sample moves it by 1/16),
/// so that both look the same in their first seconds; the paper leaves the scale open.
#[derive(Clone, Debug, Default)]
pub struct Literal {
    sum: i64,
}

impl Literal {
    /// The next frame's sample.
    pub fn step(&mut self, rng: &mut Rng) -> Sample {
        self.sum = self.sum.saturating_add(white::draw(rng) << white_shift(USUAL_LEAK));
        Sample::from_bits(self.sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        math::random::{Stream, stream},
        noise::reference::{self, Comparison, Linear as _},
    };

    fn is_its_twin<const LEAK: u32, const TWIN: i32>() {
        let (mut rng, mut words) = (stream(1, Stream::Amplitude), stream(1, Stream::Amplitude));
        let mut brown = Brown::<LEAK>::new(&mut rng);
        let mut twin = reference::Brown::<TWIN> { sum: reference::white(&mut words) };
        let mut comparison = Comparison::default();
        for _ in 0..1 << 22 {
            comparison.add(brown.step(&mut rng), twin.step(reference::white(&mut words)));
        }
        comparison.check("brown");
    }

    #[test]
    fn brown_noise_is_its_twin() {
        is_its_twin::<USUAL_LEAK, 9>();
        is_its_twin::<15, 15>();
    }

    #[test]
    fn sigma_is_as_stated() {
        let sigma = reference::sigma::<reference::Brown<9>, 1>();
        assert!((sigma - 1.000_5).abs() < 5e-5, "{sigma}");
    }

    #[test]
    fn the_literal_sum_is_exact() {
        let (mut rng, mut words) = (stream(1, Stream::Amplitude), stream(1, Stream::Amplitude));
        let (mut brown, mut sum) = (Literal::default(), 0.);
        for _ in 0..100_000 {
            sum += reference::white(&mut words) / 16.;
            assert_eq!(brown.step(&mut rng).to_num::<f64>(), sum);
        }
    }
}
