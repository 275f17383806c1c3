//! # Arithmetic
//!
//! The fixed-point formats of the portable core, each named once. Knows numbers; knows no pixel, noise or device.
//! Everything is integer arithmetic, so that results are identical on every machine.

pub mod lanes;
pub mod random;
mod root;
mod turns;

pub(crate) use root::{quotients, sqrt, whole_roots};
pub use turns::Turns;

/// A noise sample, and every state it is made of: of the order of one, in steps of 2^-40. A leak over 2^16 frames then errs by
/// 5e-11; with 16 fractional bits its rounding would push the noise off by several times its own size.
pub type Sample = fixed::types::I24F40;

/// A signed factor of order one: sines, amplitudes X_A in 0..=1, frequency factors X_f in 0..=2.
/// 28 fractional bits, so that a step is 3.7e-9, and room for the sum of a few.
pub type Factor = fixed::types::I4F28;

/// The product of two Q15 shares, rounded to the nearest: a·b / 2^15.
///
/// One instruction on x86-64 (`pmulhrsw`) and ARM (`sqrdmulh`), which is why the kernels are made of it. Both factors at
/// −2^15 would overflow; no caller comes near.
#[inline(always)]
pub const fn mul_q15(a: i16, b: i16) -> i16 {
    ((a as i32 * b as i32 + (1 << 14)) >> 15) as i16
}

/// 3x² − 2x³: from 0 to 1 without a jerk at either end.
pub(crate) fn smoothstep(x: Factor) -> Factor {
    x * x * (Factor::from_num(3) - 2 * x)
}

/// A factor of −1..=1 in Q15; 1 itself is one step short.
pub(crate) fn q15(factor: Factor) -> i16 {
    (factor.to_bits() >> 13).clamp(-32_767, 32_767) as i16
}

/// `x` / 2^`shift`, rounded to the nearest, halves up. A leak that rounds down instead would pull a noise below zero.
pub(crate) const fn shift_rounded(x: i64, shift: u32) -> i64 {
    (x + ((1 << shift) >> 1)) >> shift
}
