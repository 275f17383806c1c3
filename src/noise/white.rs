//! White Gaussian noise, and correlated starts drawn from it.
//!
//! The paper, section 3.3.1: the sum of n uniform random numbers less its mean. Here n = 12 numbers of 16 bits, from three words
//! of the generator; twice the sum less 12·65535 has a sigma of 2^17 (short by 1 part in 2^33), so that no division is needed.
//! The sum never exceeds ±6 sigma. No departure from the paper.

use crate::math::{Sample, random::Rng};
use rand::Rng as _;

/// How many fractional bits [`draw`] has.
pub(super) const FRACTION_BITS: u32 = 17;

/// A white Gaussian number of zero mean, in units of 2^-17 sigma.
pub(super) fn draw(rng: &mut Rng) -> i64 {
    // Two lanes of 32 bits, each of which sums six uniforms.
    const LANES: u64 = 0x0000_ffff_0000_ffff;
    let mut lanes = 0;
    for _ in 0..3 {
        let word = rng.next_u64();
        lanes += (word & LANES) + (word >> 16 & LANES);
    }
    let sum = (lanes & 0xffff_ffff) + (lanes >> 32);
    2 * sum as i64 - 12 * 65_535
}

/// A white Gaussian sample of zero mean and unit sigma.
pub fn step(rng: &mut Rng) -> Sample {
    Sample::from_bits(draw(rng) << (Sample::FRAC_NBITS - FRACTION_BITS))
}

/// Zero-mean Gaussian numbers, correlated as the filters' states are once they have run for ever.
///
/// `factor` holds the rows of the lower Cholesky factor of their covariance, diagonal included, one after the other, in units of
/// 2^-24. A filter that starts like this is stationary at once; one that starts from zero would have to run for minutes of frames.
pub(super) fn correlated<const N: usize>(factor: &[i32], rng: &mut Rng) -> [i64; N] {
    let white: [i64; N] = core::array::from_fn(|_| draw(rng));
    core::array::from_fn(|row| {
        let start = row * (row + 1) / 2;
        let weights = &factor[start..=start + row];
        let sum: i64 = weights.iter().zip(white).map(|(&weight, white)| i64::from(weight) * white).sum();
        sum >> (FRACTION_BITS + 24 - Sample::FRAC_NBITS)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::random::{Stream, stream};

    #[test]
    fn white_has_no_mean_unit_sigma_and_a_gaussian_tail() {
        let mut rng = stream(3, Stream::Amplitude);
        let frames = 1 << 22;
        let (mut sum, mut squares, mut beyond) = (0., 0., 0);
        for _ in 0..frames {
            let sample = step(&mut rng).to_num::<f64>();
            sum += sample;
            squares += sample * sample;
            beyond += u32::from(sample.abs() > 2.);
        }
        let n = f64::from(frames);
        assert!((sum / n).abs() < 4. / n.sqrt(), "mean {}", sum / n);
        assert!((squares / n - 1.).abs() < 4. * (2. / n).sqrt(), "variance {}", squares / n);
        // Of a Gaussian, 4.550 % lies beyond two sigma; of the sum of twelve uniforms, 4.455 %.
        let share = f64::from(beyond) / n;
        assert!((share - 0.04455).abs() < 0.0005, "beyond two sigma {share}");
    }

    #[test]
    fn the_sum_of_twelve_words_is_exact() {
        use crate::noise::reference;
        let (mut rng, mut twin) = (stream(5, Stream::Frequency), stream(5, Stream::Frequency));
        for _ in 0..10_000 {
            assert_eq!(step(&mut rng).to_num::<f64>(), reference::white(&mut twin));
        }
    }
}
