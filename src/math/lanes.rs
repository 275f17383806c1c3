//! Sixteen pixels at a time: 16-bit lanes, and the choice of the instruction set at run time.
//!
//! A kernel is written once, over [`Lanes`], and runs on whatever the machine has: AVX2, SSE4.1, NEON, or plain Rust, which is
//! the definition that the others equal to the bit. `on_widest` chooses.
//!
//! # Why intrinsics, and why this file may be unsafe
//! Loops over `[i16; 16]` that the compiler vectorises by itself were tried first. LLVM 21 widens the chains of rounding products to
//! 32 bits and never finds `pmulhrsw` or `sqrdmulh`: 272 instructions instead of 83 for a block of 16 pixels with AVX2, 4.6 times a
//! plain copy instead of 1.4. Portable vectors (`core::simd`) are not stable, and the crates that give safe ones choose the instruction set when they
//! are compiled. So each operation is one intrinsic. What is unsafe is to run one where the processor does not have it: the
//! vector types are private, and only `on_widest` and, in tests, `on_each` name them, after `cpufeatures` has asked the processor.

/// Pixels in a block.
pub const LANES: usize = 16;

/// One 16-bit number for each pixel of a block. Sums wrap around.
pub trait Lanes: Copy {
    /// The same number in every lane.
    fn splat(value: i16) -> Self;
    /// The numbers of `from`.
    fn load(from: &[i16; LANES]) -> Self;
    /// Bytes in Q7: times 128.
    fn load_q7(from: &[u8; LANES]) -> Self;
    /// Writes the numbers to `to`.
    fn store(self, to: &mut [i16; LANES]);
    /// Writes the numbers as words of 16 bits, least significant byte first.
    fn store_words(self, to: &mut [u8; 2 * LANES]);
    /// Writes pixels of four bytes: a sixteenth of the three channels, cut to 0..=255, and 255.
    fn store_pixels(channels: [Self; 3], to: &mut [u8; 4 * LANES]);
    /// The sum.
    fn plus(self, other: Self) -> Self;
    /// The difference.
    fn minus(self, other: Self) -> Self;
    /// [`super::mul_q15`].
    fn times(self, other: Self) -> Self;
    /// The larger one.
    fn at_least(self, other: Self) -> Self;
    /// The smaller one.
    fn at_most(self, other: Self) -> Self;
    /// The bits that both have.
    fn and(self, other: Self) -> Self;
    /// The bits that either has.
    fn or(self, other: Self) -> Self;
    /// Shifted to the left.
    fn up<const BITS: i32>(self) -> Self;
    /// Shifted to the right, with the sign.
    fn down<const BITS: i32>(self) -> Self;
    /// The low `BITS` bits, beneath `upper` shifted to the left by as many.
    fn beneath<const BITS: i32>(self, upper: Self) -> Self;
}

/// Something that is done with lanes.
///
/// `run`, and all that it calls for each block, must be `#[inline(always)]`: a function that stays on its own is compiled without the
/// instruction set. So is a closure, where `array::map` and the like stand between: arrays of lanes are written out.
pub(crate) trait Task {
    /// What comes of it.
    type Output;

    /// Does it.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Plain Rust.
pub(crate) type Plain = [i16; LANES];

impl Lanes for Plain {
    #[inline(always)]
    fn splat(value: i16) -> Self {
        [value; LANES]
    }

    #[inline(always)]
    fn load(from: &[i16; LANES]) -> Self {
        *from
    }

    #[inline(always)]
    fn load_q7(from: &[u8; LANES]) -> Self {
        from.map(|byte| i16::from(byte) << 7)
    }

    #[inline(always)]
    fn store(self, to: &mut [i16; LANES]) {
        *to = self;
    }

    #[inline(always)]
    fn store_words(self, to: &mut [u8; 2 * LANES]) {
        for (to, word) in to.as_chunks_mut().0.iter_mut().zip(self) {
            *to = word.to_le_bytes();
        }
    }

    #[inline(always)]
    fn store_pixels([a, b, c]: [Self; 3], to: &mut [u8; 4 * LANES]) {
        let byte = |level: i16| (level >> 4).clamp(0, 255) as u8;
        for (i, to) in to.as_chunks_mut().0.iter_mut().enumerate() {
            *to = [byte(a[i]), byte(b[i]), byte(c[i]), 255];
        }
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i].wrapping_add(other[i]))
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i].wrapping_sub(other[i]))
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        core::array::from_fn(|i| super::mul_q15(self[i], other[i]))
    }

    #[inline(always)]
    fn at_least(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i].max(other[i]))
    }

    #[inline(always)]
    fn at_most(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i].min(other[i]))
    }

    #[inline(always)]
    fn and(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i] & other[i])
    }

    #[inline(always)]
    fn or(self, other: Self) -> Self {
        core::array::from_fn(|i| self[i] | other[i])
    }

    #[inline(always)]
    fn up<const BITS: i32>(self) -> Self {
        self.map(|x| x << BITS)
    }

    #[inline(always)]
    fn down<const BITS: i32>(self) -> Self {
        self.map(|x| x >> BITS)
    }

    #[inline(always)]
    fn beneath<const BITS: i32>(self, upper: Self) -> Self {
        core::array::from_fn(|i| upper[i] << BITS | self[i] & low_bits(BITS))
    }
}

/// A number with only its low `bits` bits set, fewer than 16.
const fn low_bits(bits: i32) -> i16 {
    (1 << bits) - 1
}

/// Runs `task` with the widest lanes of this machine.
#[inline]
pub(crate) fn on_widest<T: Task>(task: T) -> T::Output {
    #[cfg(target_arch = "x86_64")]
    return x86_64::on_widest(task);
    #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
    return task.run::<neon::Neon>();
    #[cfg(not(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon"))))]
    task.run::<Plain>()
}

/// Starts to fetch the memory `bytes` after the start of `at`, `size_of::<T>()` of it, into the cache, if it is any; on ARM, which fetches ahead by
/// itself, it does nothing.
#[inline(always)]
pub(crate) fn fetch<T>(at: &T, bytes: usize) {
    #[cfg(target_arch = "x86_64")]
    x86_64::fetch(at, bytes);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (at, bytes);
}

/// What comes of the task with each kind of lanes of this machine, [`Plain`] first.
#[cfg(test)]
pub(crate) fn on_each<T: Task>(task: impl Fn() -> T) -> Vec<(&'static str, T::Output)> {
    let mut outputs = vec![("plain", task().run::<Plain>())];
    #[cfg(target_arch = "x86_64")]
    outputs.extend(x86_64::on_each(task));
    #[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
    outputs.push(("NEON", task().run::<neon::Neon>()));
    outputs
}

/// Methods that are one intrinsic each: `name(arguments) = intrinsic;`, on one vector of 16 lanes.
#[cfg(target_arch = "x86_64")]
macro_rules! on_one {
    ($($name:ident = $intrinsic:ident;)*) => {
        $(#[inline(always)]
        fn $name(self, other: Self) -> Self {
            // SAFETY: see the head of this file: values of this type exist only where the processor has the instruction.
            Self(unsafe { $intrinsic(self.0, other.0) })
        })*
    };
}

/// The same on two vectors of 8 lanes.
#[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
macro_rules! on_two {
    ($($name:ident = $intrinsic:ident;)*) => {
        $(#[inline(always)]
        fn $name(self, other: Self) -> Self {
            // SAFETY: see the head of this file: values of this type exist only where the processor has the instruction.
            Self(unsafe { [$intrinsic(self.0[0], other.0[0]), $intrinsic(self.0[1], other.0[1])] })
        })*
    };
}

#[cfg(target_arch = "x86_64")]
mod x86_64 {
    use super::{LANES, Lanes, Plain, Task};
    use core::arch::x86_64::*;

    cpufeatures::new!(has_avx2, "avx2");
    cpufeatures::new!(has_sse41, "sse4.1", "ssse3");

    #[inline]
    pub(super) fn on_widest<T: Task>(task: T) -> T::Output {
        if has_avx2::get() {
            // SAFETY: the processor has AVX2.
            unsafe { with_avx2(task) }
        } else if has_sse41::get() {
            // SAFETY: the processor has SSE4.1 and SSSE3.
            unsafe { with_sse41(task) }
        } else {
            task.run::<Plain>()
        }
    }

    #[cfg(test)]
    pub(super) fn on_each<T: Task>(task: impl Fn() -> T) -> Vec<(&'static str, T::Output)> {
        let mut outputs = Vec::new();
        if has_avx2::get() {
            // SAFETY: the processor has AVX2.
            outputs.push(("AVX2", unsafe { with_avx2(task()) }));
        }
        if has_sse41::get() {
            // SAFETY: the processor has SSE4.1 and SSSE3.
            outputs.push(("SSE4.1", unsafe { with_sse41(task()) }));
        }
        outputs
    }

    #[target_feature(enable = "avx2")]
    fn with_avx2<T: Task>(task: T) -> T::Output {
        task.run::<Avx2>()
    }

    #[target_feature(enable = "sse4.1,ssse3")]
    fn with_sse41<T: Task>(task: T) -> T::Output {
        task.run::<Sse41>()
    }

    /// The line of the cache.
    const LINE: usize = 64;

    #[inline(always)]
    pub(super) fn fetch<T>(at: &T, bytes: usize) {
        let start = core::ptr::from_ref(at).cast::<i8>().wrapping_add(bytes);
        for line in 0..size_of::<T>().div_ceil(LINE) {
            // SAFETY: a prefetch reads nothing and never faults, whatever the address; SSE is part of x86-64.
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(line * LINE)) }
        }
    }

    /// One vector of 256 bits. Two of its parts of 128 bits each are packed and interleaved on their own.
    #[derive(Clone, Copy)]
    struct Avx2(__m256i);

    // SAFETY of all blocks: see the head of the file: this code runs under `with_avx2` alone. Loads and stores go through references to arrays
    // of just their size, and need no alignment.
    #[expect(clippy::undocumented_unsafe_blocks, reason = "all for the one reason above")]
    impl Lanes for Avx2 {
        #[inline(always)]
        fn splat(value: i16) -> Self {
            Self(unsafe { _mm256_set1_epi16(value) })
        }

        #[inline(always)]
        fn load(from: &[i16; LANES]) -> Self {
            Self(unsafe { _mm256_loadu_si256(from.as_ptr().cast()) })
        }

        #[inline(always)]
        fn load_q7(from: &[u8; LANES]) -> Self {
            Self(unsafe {
                let bytes = _mm_loadu_si128(from.as_ptr().cast());
                _mm256_slli_epi16::<7>(_mm256_cvtepu8_epi16(bytes))
            })
        }

        #[inline(always)]
        fn store(self, to: &mut [i16; LANES]) {
            unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), self.0) }
        }

        #[inline(always)]
        fn store_words(self, to: &mut [u8; 2 * LANES]) {
            unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), self.0) }
        }

        #[inline(always)]
        fn store_pixels(channels: [Self; 3], to: &mut [u8; 4 * LANES]) {
            let [Self(a), Self(b), Self(c)] =
                [channels[0].down::<4>(), channels[1].down::<4>(), channels[2].down::<4>()];
            unsafe {
                let ac = _mm256_packus_epi16(a, c);
                let bx = _mm256_packus_epi16(b, _mm256_set1_epi16(255));
                let (ab, cx) = (_mm256_unpacklo_epi8(ac, bx), _mm256_unpackhi_epi8(ac, bx));
                // Pixels 0–3 and 8–11, and 4–7 and 12–15.
                let (even, odd) = (_mm256_unpacklo_epi16(ab, cx), _mm256_unpackhi_epi16(ab, cx));
                let (first, second) = to.split_at_mut(2 * LANES);
                let low = _mm256_permute2x128_si256::<0x20>(even, odd);
                let high = _mm256_permute2x128_si256::<0x31>(even, odd);
                _mm256_storeu_si256(first.as_mut_ptr().cast(), low);
                _mm256_storeu_si256(second.as_mut_ptr().cast(), high);
            }
        }

        on_one! {
            plus = _mm256_add_epi16;
            minus = _mm256_sub_epi16;
            times = _mm256_mulhrs_epi16;
            at_least = _mm256_max_epi16;
            at_most = _mm256_min_epi16;
            and = _mm256_and_si256;
            or = _mm256_or_si256;
        }

        #[inline(always)]
        fn up<const BITS: i32>(self) -> Self {
            Self(unsafe { _mm256_slli_epi16::<BITS>(self.0) })
        }

        #[inline(always)]
        fn down<const BITS: i32>(self) -> Self {
            Self(unsafe { _mm256_srai_epi16::<BITS>(self.0) })
        }

        #[inline(always)]
        fn beneath<const BITS: i32>(self, upper: Self) -> Self {
            upper.up::<BITS>().or(self.and(Self::splat(super::low_bits(BITS))))
        }
    }

    /// Two vectors of 128 bits.
    #[derive(Clone, Copy)]
    struct Sse41([__m128i; 2]);

    // SAFETY of all blocks: as above, under `with_sse41`.
    #[expect(clippy::undocumented_unsafe_blocks, reason = "all for the one reason above")]
    impl Lanes for Sse41 {
        #[inline(always)]
        fn splat(value: i16) -> Self {
            Self(unsafe { [_mm_set1_epi16(value); 2] })
        }

        #[inline(always)]
        fn load(from: &[i16; LANES]) -> Self {
            let (low, high) = from.split_at(LANES / 2);
            Self(unsafe { [_mm_loadu_si128(low.as_ptr().cast()), _mm_loadu_si128(high.as_ptr().cast())] })
        }

        #[inline(always)]
        fn load_q7(from: &[u8; LANES]) -> Self {
            let (low, high) = from.split_at(LANES / 2);
            Self(unsafe {
                let low = _mm_cvtepu8_epi16(_mm_loadl_epi64(low.as_ptr().cast()));
                let high = _mm_cvtepu8_epi16(_mm_loadl_epi64(high.as_ptr().cast()));
                [_mm_slli_epi16::<7>(low), _mm_slli_epi16::<7>(high)]
            })
        }

        #[inline(always)]
        fn store(self, to: &mut [i16; LANES]) {
            for (to, half) in to.as_chunks_mut::<{ LANES / 2 }>().0.iter_mut().zip(self.0) {
                unsafe { _mm_storeu_si128(to.as_mut_ptr().cast(), half) }
            }
        }

        #[inline(always)]
        fn store_words(self, to: &mut [u8; 2 * LANES]) {
            for (to, half) in to.as_chunks_mut::<LANES>().0.iter_mut().zip(self.0) {
                unsafe { _mm_storeu_si128(to.as_mut_ptr().cast(), half) }
            }
        }

        #[inline(always)]
        fn store_pixels(channels: [Self; 3], to: &mut [u8; 4 * LANES]) {
            let [Self(a), Self(b), Self(c)] =
                [channels[0].down::<4>(), channels[1].down::<4>(), channels[2].down::<4>()];
            for (i, to) in to.as_chunks_mut::<{ 2 * LANES }>().0.iter_mut().enumerate() {
                let (first, second) = to.split_at_mut(LANES);
                unsafe {
                    let ac = _mm_packus_epi16(a[i], c[i]);
                    let bx = _mm_packus_epi16(b[i], _mm_set1_epi16(255));
                    let (ab, cx) = (_mm_unpacklo_epi8(ac, bx), _mm_unpackhi_epi8(ac, bx));
                    _mm_storeu_si128(first.as_mut_ptr().cast(), _mm_unpacklo_epi16(ab, cx));
                    _mm_storeu_si128(second.as_mut_ptr().cast(), _mm_unpackhi_epi16(ab, cx));
                }
            }
        }

        on_two! {
            plus = _mm_add_epi16;
            minus = _mm_sub_epi16;
            times = _mm_mulhrs_epi16;
            at_least = _mm_max_epi16;
            at_most = _mm_min_epi16;
            and = _mm_and_si128;
            or = _mm_or_si128;
        }

        #[inline(always)]
        fn up<const BITS: i32>(self) -> Self {
            Self(unsafe { [_mm_slli_epi16::<BITS>(self.0[0]), _mm_slli_epi16::<BITS>(self.0[1])] })
        }

        #[inline(always)]
        fn down<const BITS: i32>(self) -> Self {
            Self(unsafe { [_mm_srai_epi16::<BITS>(self.0[0]), _mm_srai_epi16::<BITS>(self.0[1])] })
        }

        #[inline(always)]
        fn beneath<const BITS: i32>(self, upper: Self) -> Self {
            upper.up::<BITS>().or(self.and(Self::splat(super::low_bits(BITS))))
        }
    }
}

#[cfg(all(target_arch = "aarch64", target_feature = "neon"))]
mod neon {
    use super::{LANES, Lanes};
    use core::arch::aarch64::*;

    /// Two vectors of 128 bits.
    #[derive(Clone, Copy)]
    pub(super) struct Neon([int16x8_t; 2]);

    // SAFETY of all blocks: this module is compiled only for processors that all have NEON. Loads and stores go through references to arrays of
    // just their size, and need no alignment.
    #[expect(clippy::undocumented_unsafe_blocks, reason = "all for the one reason above")]
    impl Lanes for Neon {
        #[inline(always)]
        fn splat(value: i16) -> Self {
            Self(unsafe { [vdupq_n_s16(value); 2] })
        }

        #[inline(always)]
        fn load(from: &[i16; LANES]) -> Self {
            let (low, high) = from.split_at(LANES / 2);
            Self([low, high].map(|half| unsafe { vld1q_s16(half.as_ptr()) }))
        }

        #[inline(always)]
        fn load_q7(from: &[u8; LANES]) -> Self {
            Self(unsafe {
                let bytes = vld1q_u8(from.as_ptr());
                [vshll_n_u8::<7>(vget_low_u8(bytes)), vshll_high_n_u8::<7>(bytes)]
                    .map(|half| vreinterpretq_s16_u16(half))
            })
        }

        #[inline(always)]
        fn store(self, to: &mut [i16; LANES]) {
            for (to, half) in to.as_chunks_mut::<{ LANES / 2 }>().0.iter_mut().zip(self.0) {
                unsafe { vst1q_s16(to.as_mut_ptr(), half) }
            }
        }

        #[inline(always)]
        fn store_words(self, to: &mut [u8; 2 * LANES]) {
            for (to, half) in to.as_chunks_mut::<LANES>().0.iter_mut().zip(self.0) {
                unsafe { vst1q_u8(to.as_mut_ptr(), vreinterpretq_u8_s16(half)) }
            }
        }

        #[inline(always)]
        fn store_pixels(channels: [Self; 3], to: &mut [u8; 4 * LANES]) {
            unsafe {
                let [a, b, c] =
                    channels.map(|Self([low, high])| vqshrun_high_n_s16::<4>(vqshrun_n_s16::<4>(low), high));
                vst4q_u8(to.as_mut_ptr(), uint8x16x4_t(a, b, c, vdupq_n_u8(255)));
            }
        }

        on_two! {
            plus = vaddq_s16;
            minus = vsubq_s16;
            times = vqrdmulhq_s16;
            at_least = vmaxq_s16;
            at_most = vminq_s16;
            and = vandq_s16;
            or = vorrq_s16;
        }

        #[inline(always)]
        fn up<const BITS: i32>(self) -> Self {
            Self(self.0.map(|half| unsafe { vshlq_n_s16::<BITS>(half) }))
        }

        #[inline(always)]
        fn down<const BITS: i32>(self) -> Self {
            Self(self.0.map(|half| unsafe { vshrq_n_s16::<BITS>(half) }))
        }

        #[inline(always)]
        fn beneath<const BITS: i32>(self, upper: Self) -> Self {
            Self(unsafe {
                [vsliq_n_s16::<BITS>(self.0[0], upper.0[0]), vsliq_n_s16::<BITS>(self.0[1], upper.0[1])]
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every operation, once.
    #[derive(Clone, Copy)]
    struct Everything<'a> {
        blocks: &'a [[i16; LANES]; 3],
        bytes: &'a [u8; LANES],
    }

    impl Task for Everything<'_> {
        type Output = (Vec<[i16; LANES]>, Vec<u8>);

        #[inline(always)]
        fn run<L: Lanes>(self) -> Self::Output {
            let [a, b, c] = self.blocks.each_ref().map(L::load);
            let made = [L::splat(self.blocks[0][0]), L::load_q7(self.bytes), a.up::<3>(), a.down::<8>()];
            let of_two = [
                a.plus(b),
                a.minus(b),
                a.times(b),
                a.at_least(b),
                a.at_most(b),
                a.and(b),
                a.or(b),
                a.beneath::<11>(b),
            ];
            let words = made.into_iter().chain(of_two).map(|lanes| {
                let mut words = [0; LANES];
                lanes.store(&mut words);
                words
            });
            let (mut pixels, mut bytes) = ([0; 4 * LANES], [0; 2 * LANES]);
            L::store_pixels([a, b, c], &mut pixels);
            a.store_words(&mut bytes);
            fetch(self.blocks, 100_000);
            (words.collect(), pixels.into_iter().chain(bytes).collect())
        }
    }

    proptest! {
        #[test]
        fn every_instruction_set_computes_as_plain_rust_does(blocks: [[i16; LANES]; 3], bytes: [u8; LANES]) {
            // −2^15 times itself is the one product that differs; the kernels never make it.
            let blocks = blocks.map(|block| block.map(|x| x.max(-i16::MAX)));
            let results = on_each(|| Everything { blocks: &blocks, bytes: &bytes });
            for (name, result) in &results {
                prop_assert_eq!(result, &results[0].1, "{}", name);
            }
        }
    }
}
