//! Square roots.

/// 1/√((j + 32½)/128) for each j, in units of 2^-15: where the search for the reciprocal root begins.
#[rustfmt::skip]
const SEEDS: [u16; 96] = [
    65_030, 64_052, 63_117, 62_222, 61_363, 60_540, 59_748, 58_987, 58_254, 57_548, 56_867, 56_210, 55_574, 54_960,
    54_366, 53_791, 53_233, 52_693, 52_169, 51_660, 51_165, 50_685, 50_218, 49_763, 49_321, 48_890, 48_470, 48_061,
    47_663, 47_273, 46_894, 46_523, 46_161, 45_807, 45_462, 45_124, 44_793, 44_470, 44_153, 43_843, 43_540, 43_243,
    42_951, 42_666, 42_386, 42_112, 41_843, 41_579, 41_320, 41_065, 40_816, 40_571, 40_330, 40_093, 39_861, 39_632,
    39_408, 39_187, 38_970, 38_756, 38_546, 38_340, 38_136, 37_936, 37_739, 37_545, 37_354, 37_166, 36_980, 36_798,
    36_618, 36_441, 36_266, 36_093, 35_924, 35_756, 35_591, 35_428, 35_267, 35_109, 34_953, 34_798, 34_646, 34_496,
    34_347, 34_201, 34_056, 33_913, 33_772, 33_633, 33_496, 33_360, 33_225, 33_093, 32_962, 32_832,
];

/// One as [`sqrt`] gives it.
const ONE: u64 = 1 << 63;

/// The square root, in units of 2^-63, of `x` in units of 2^-64; within 2^-26 of the root, and at most 1.
///
/// The reciprocal root comes from a table of the seven leading bits and two of Newton's steps, y ← y·(3 − x·y²)/2, each of
/// which squares the error. That takes multiplications only; `u64::isqrt` divides, and a step of chaos took 175 instructions
/// with it instead of 122.
pub(crate) fn sqrt(x: u64) -> u64 {
    if x == 0 {
        return 0;
    }
    // The fraction is brought into 1/4..1, its reciprocal root into 1..2.
    let pairs = x.leading_zeros() / 2;
    let x = x << (2 * pairs);
    let seed = u64::from(SEEDS[(x >> 57) as usize - 32]);
    let x = x >> 32;
    // 3 − x·y², in units of 2^-32, from y² in units of 2^-30.
    let left = |square: u64| (3 << 32) - ((x * square) >> 30);
    let once = (seed * left(seed * seed)) >> 17; // in units of 2^-31
    let twice = (once * (left((once * once) >> 32) >> 2)) >> 31; // in units of 2^-31
    (x * twice).min(ONE) >> pairs
}

/// The square root of each number, to the nearest, digit by digit: it needs no table and no product, and so suits lanes of 32 bits of any
/// kind. One by one, with the table above, it was most of the time that a photo took to prepare.
#[inline(always)]
pub(crate) fn whole_roots<const N: usize>(squares: [u32; N]) -> [u32; N] {
    let (mut rest, mut root) = (squares, [0_u32; N]);
    for digit in (0..16).rev() {
        let place = 1 << (2 * digit);
        for (rest, root) in rest.iter_mut().zip(&mut root) {
            // What does not fit wraps around, and is larger than before.
            let left = (*rest).min(rest.wrapping_sub(*root + place));
            *root = (*root >> 1) + if left == *rest { 0 } else { place };
            *rest = left;
        }
    }
    root.iter_mut().zip(rest).for_each(|(root, rest)| *root += u32::from(rest > *root));
    root
}

/// `dividend` / each divisor, rounded down; quotients must be below 2^16, and divisors from 1 to 2^17 − 1. As above, digit by digit.
#[inline(always)]
pub(crate) fn quotients<const N: usize>(dividend: u32, divisors: [u32; N]) -> [u32; N] {
    let (mut rest, mut quotient) = ([dividend; N], [0_u32; N]);
    for digit in (0..16).rev() {
        let place = 1 << digit;
        for ((rest, quotient), divisor) in rest.iter_mut().zip(&mut quotient).zip(divisors) {
            let left = (*rest).min(rest.wrapping_sub(divisor << digit));
            *quotient += if left == *rest { 0 } else { place };
            *rest = left;
        }
    }
    quotient
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_seeds_are_reciprocal_roots() {
        for (j, seed) in SEEDS.into_iter().enumerate() {
            let exact = 2_f64.powi(15) / ((j as f64 + 32.5) / 128.).sqrt();
            assert!((f64::from(seed) - exact).abs() <= 0.5, "seed {j} is {seed}, exactly {exact}");
        }
    }

    fn error(x: u64) -> f64 {
        let exact = (x as f64 / 2_f64.powi(64)).sqrt();
        (sqrt(x) as f64 / ONE as f64 / exact - 1.).abs()
    }

    #[test]
    fn the_ends_of_every_seed_are_within_the_stated_error() {
        assert_eq!(sqrt(0), 0);
        assert!(sqrt(u64::MAX) <= ONE);
        for j in 32..128_u64 {
            for x in [j << 57, (j << 57) | ((1 << 57) - 1), (j << 57) + (1 << 56)] {
                for pairs in 0..32 {
                    let x = (x >> (2 * pairs)).max(1);
                    assert!(error(x) < 2_f64.powi(-26), "{x:#x}: {:e}", error(x));
                }
            }
        }
    }

    proptest! {
        #[test]
        fn whole_roots_are_the_nearest(squares: [u32; 16], shift in 0..32_u32) {
            let squares = squares.map(|square| square >> shift);
            prop_assert_eq!(whole_roots(squares), squares.map(|square| f64::from(square).sqrt().round() as u32));
        }

        #[test]
        fn quotients_by_digits_are_those_of_division(
            quotient in 0..1_u32 << 16, divisors: [u32; 16], shift in 0..16_u32
        ) {
            let divisors = divisors.map(|divisor| ((divisor >> 15) >> shift).max(1));
            let least = divisors.into_iter().min().unwrap_or(1);
            let dividend = (u64::from(quotient) * u64::from(least)).min(u32::MAX.into()) as u32;
            prop_assert_eq!(quotients(dividend, divisors), divisors.map(|divisor| dividend / divisor));
        }

        #[test]
        fn roots_are_within_the_stated_error(x in 1_u64.., shift in 0..64_u32) {
            let x = (x >> shift).max(1);
            prop_assert!(error(x) < 2_f64.powi(-26), "{:e}", error(x));
        }
    }
}
