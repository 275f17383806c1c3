//! Noise over the plane: bark, clouds, grass and the spots of leaves.

use crate::math::random::scatter;

/// Fractional bits of a place: one is the distance between lattice points.
pub(super) const BITS: u32 = 16;

const ONE: i64 = 1 << BITS;

/// −2^15..2^15, for the lattice point (x, y).
fn lattice(x: i64, y: i64, seed: u64) -> i64 {
    let key = (x as u32 as u64) << 32 | y as u32 as u64;
    (scatter(key ^ seed.wrapping_mul(0xd134_2543_de82_ef95)) >> 48) as i64 - (1 << 15)
}

/// Smooth noise of −2^15..2^15 at a place: lattice values, joined by 3t² − 2t³.
pub(super) fn smooth(x: i32, y: i32, seed: u64) -> i32 {
    let (x, y) = (i64::from(x), i64::from(y));
    let (column, row) = (x >> BITS, y >> BITS);
    let ease = |t: i64| (((t * t) >> BITS) * (3 * ONE - 2 * t)) >> BITS;
    let (right, down) = (ease(x & (ONE - 1)), ease(y & (ONE - 1)));
    let along = |row| {
        let (from, to) = (lattice(column, row, seed), lattice(column + 1, row, seed));
        from + (((to - from) * right) >> BITS)
    };
    let (above, below) = (along(row), along(row + 1));
    (above + (((below - above) * down) >> BITS)) as i32
}

/// Fractional Brownian motion of −2^15..2^15: `octaves` of [`smooth`], each twice as fine and half as strong.
pub(super) fn fbm(x: i32, y: i32, octaves: u32, seed: u64) -> i32 {
    let octave =
        |k: u32| smooth(x.wrapping_shl(k), y.wrapping_shl(k), seed.wrapping_add(k.into())) >> (k + 1);
    (0..octaves).map(octave).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_no_steps_and_no_bias() {
        let (mut sum, mut last) = (0_i64, smooth(0, 0, 3));
        for x in (0..1 << 24).step_by(256) {
            let here = smooth(x, x / 3, 3);
            assert!((here - last).abs() < 1_500, "a step of {} at {x}", here - last);
            (sum, last) = (sum + i64::from(here), here);
        }
        assert!((sum >> 16).abs() < 3_000, "the mean is {}", sum >> 16);
    }
}
