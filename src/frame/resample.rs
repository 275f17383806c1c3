//! Resampling of photos in linear light.
//!
//! A separable cubic convolution (Keys 1981, eq. 4 with a = −1/2, also known as Catmull-Rom), stretched by the factor of
//! shrinking so that it averages what it leaves out (antialiasing), edges repeated. At the same size it is the identity.
//!
//! Rows come in and go out one at a time, each source row is asked for once, in order, and first shrunk along its width:
//! memory is a few rows ([`storage_len`]), never the photo. Departs from the textbook in two ways: 1) weights are integers
//! of 14 fractional bits and sum exactly to one (rounded as a running sum, so that the error never adds up), so a flat
//! colour stays that very colour; 2) rows between the two passes are clipped to what 16 bits hold.
//!
//! Cost: about 4 multiplications a sample for each pass when shrinking, independent of the factor.

use core::fmt;

/// The longest side of a source or a result, in pixels: the longest that a JPEG can have.
pub const MAX_SIDE: u32 = u16::MAX as u32;

/// Fractional bits of positions along an axis.
const POSITION_BITS: u32 = 24;

/// Fractional bits of the weights. One more would not leave room for the weight one in 16 bits.
const WEIGHT_BITS: u32 = 14;

/// Fractional bits of the kernel's argument and value.
const KERNEL_BITS: u32 = 16;

/// Weights of a column are padded with zeros to a multiple of this, for the sake of vector instructions.
const LANES: usize = 8;

/// How pixels along one axis of a source become pixels of the result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axis {
    source: u32,
    /// Where the part to be shown starts, and how long it is; pixels with [`POSITION_BITS`].
    start: u64,
    length: u64,
    out: u32,
}

impl Axis {
    /// All of `source` pixels stretched over `out` pixels.
    ///
    /// # Panics
    /// If either is zero or exceeds [`MAX_SIDE`].
    pub const fn whole(source: u32, out: u32) -> Self {
        Self::centred(source, (1, 1), out)
    }

    /// The middle `share.0 / share.1` of `source` pixels, stretched over `out` pixels; more than all is as all.
    ///
    /// # Panics
    /// If a side is zero or exceeds [`MAX_SIDE`], or the share is zero or not a number.
    pub const fn centred(source: u32, share: (u64, u64), out: u32) -> Self {
        assert!(source > 0 && source <= MAX_SIDE && out > 0 && out <= MAX_SIDE);
        assert!(share.0 > 0 && share.1 > 0);
        let all = (source as u64) << POSITION_BITS;
        let share = if share.0 < share.1 { share } else { (1, 1) };
        // Even, so that what is left over is the same on both sides; at least 1/256 pixel, so that there is a part at all.
        let part = (all as u128 * share.0 as u128 / share.1 as u128) as u64 & !1;
        let least = 1 << (POSITION_BITS - 8);
        let length = if part < least { least } else { part };
        Self { source, start: (all - length) / 2, length, out }
    }

    /// Source pixels that one pixel of the result is made from.
    const fn taps(&self, multiple: usize) -> usize {
        let stretch = if self.length > (self.out as u64) << POSITION_BITS { self.length } else { 0 };
        let support = stretch.div_ceil((self.out as u64) << (POSITION_BITS - 2)) as usize;
        let taps = (if support < 4 { 4 } else { support }).next_multiple_of(multiple);
        if taps < self.source as usize { taps } else { self.source as usize }
    }

    /// The weights of the source pixels that make pixel `x` of the result, and the first of these.
    fn weigh(&self, x: u32, weights: &mut [u16]) -> u16 {
        let kernel = Kernel::new(self, x);
        let count = weights.len() as i64;
        let first = kernel.first.clamp(0, i64::from(self.source) - count);
        // What lies beyond an edge counts for the pixel at the edge.
        let at = |tap: i64| -> i64 {
            let i = first + tap;
            let mut sum = kernel.at(i);
            if i == 0 {
                sum += (kernel.first..0).map(|beyond| kernel.at(beyond)).sum::<i64>();
            }
            if i == i64::from(self.source) - 1 {
                sum += (i + 1..=kernel.last).map(|beyond| kernel.at(beyond)).sum::<i64>();
            }
            sum
        };
        let total: i64 = (0..count).map(at).sum();
        let (mut running, mut given) = (0, 0);
        for (tap, weight) in weights.iter_mut().enumerate() {
            running += at(tap as i64);
            let share = ((running << (WEIGHT_BITS + 1)) + total).div_euclid(2 * total);
            *weight = (share - given) as u16;
            given = share;
        }
        first as u16
    }
}

/// The kernel that makes one pixel of the result.
struct Kernel {
    /// Its middle in the source; pixels with [`POSITION_BITS`], the middle of the first pixel being 0.
    centre: i64,
    /// How much it is stretched, as the reciprocal with 32 fractional bits.
    shrink: u64,
    /// The first and the last source pixel that it reaches.
    first: i64,
    last: i64,
}

impl Kernel {
    fn new(axis: &Axis, x: u32) -> Self {
        let out = u64::from(axis.out);
        let middle = axis.start + (2 * u64::from(x) + 1) * axis.length / (2 * out);
        let centre = middle as i64 - (1 << (POSITION_BITS - 1));
        let unstretched = out << POSITION_BITS;
        let (shrink, reach) = if axis.length > unstretched {
            (
                ((u128::from(unstretched) << 32) / u128::from(axis.length)) as u64,
                (2 * axis.length / out) as i64,
            )
        } else {
            (1 << 32, 2 << POSITION_BITS)
        };
        let (first, last) = ((centre - reach) >> POSITION_BITS, (centre + reach) >> POSITION_BITS);
        Self { centre, shrink, first: first + 1, last }
    }

    /// Twice the kernel's value at source pixel `i`, with [`KERNEL_BITS`].
    fn at(&self, i: i64) -> i64 {
        let distance = ((i << POSITION_BITS) - self.centre).unsigned_abs();
        let t = ((distance * self.shrink) >> (POSITION_BITS + 32 - KERNEL_BITS)) as i64;
        let square = (t * t) >> KERNEL_BITS;
        let cube = (square * t) >> KERNEL_BITS;
        match t >> KERNEL_BITS {
            0 => 3 * cube - 5 * square + (2 << KERNEL_BITS),
            1 => -cube + 5 * square - 8 * t + (4 << KERNEL_BITS),
            _ => 0,
        }
    }
}

/// The memory that [`resample`] needs, in 16-bit words: with the taps 4 × max(source / out, 1) of each axis about
/// `columns.out × (1 + taps) + channels × (columns.source + columns.out × (row taps + 1)) + row taps`.
pub const fn storage_len(columns: Axis, rows: Axis, channels: usize) -> usize {
    let (width, taps, row_taps) = (columns.out as usize, columns.taps(LANES), rows.taps(1));
    width * (1 + taps) + channels * (columns.source as usize + width * (row_taps + 1)) + row_taps
}

/// Lent memory that is too short for [`resample`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StorageTooSmall {
    /// 16-bit words that it takes.
    pub needed: usize,
    /// 16-bit words there are.
    pub got: usize,
}

impl fmt::Display for StorageTooSmall {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a resampling storage of {} words: it takes {}", self.got, self.needed)
    }
}

impl core::error::Error for StorageTooSmall {}

/// Resamples a picture of `channels` planes.
///
/// `source` is asked for source rows in ascending order, each at the most once and only those that are needed: it fills a
/// row, which is plane after plane of `columns`' source pixels. `sink` is handed every row of the result from top to
/// bottom, plane after plane of `columns`' result pixels. Values are linear light (or anything else that averages) of the
/// full 16 bits.
///
/// # Errors
/// If `storage` is shorter than [`storage_len`].
pub fn resample(
    columns: Axis,
    rows: Axis,
    channels: usize,
    storage: &mut [u16],
    mut source: impl FnMut(u32, &mut [u16]),
    mut sink: impl FnMut(u32, &[u16]),
) -> Result<(), StorageTooSmall> {
    let (needed, got) = (storage_len(columns, rows, channels), storage.len());
    if got < needed {
        return Err(StorageTooSmall { needed, got });
    }
    let (width, taps, row_taps) = (columns.out as usize, columns.taps(LANES), rows.taps(1));
    let (starts, storage) = storage.split_at_mut(width);
    let (weights, storage) = storage.split_at_mut(width * taps);
    let (row_weights, storage) = storage.split_at_mut(row_taps);
    let (source_row, storage) = storage.split_at_mut(channels * columns.source as usize);
    let (out_row, storage) = storage.split_at_mut(channels * width);
    let ring = &mut storage[..row_taps * channels * width];

    for ((x, start), weights) in (0..).zip(&mut *starts).zip(weights.chunks_exact_mut(taps)) {
        *start = columns.weigh(x, weights);
    }
    let mut next = 0;
    for y in 0..rows.out {
        let first = usize::from(rows.weigh(y, row_weights));
        next = next.max(first);
        while next < first + row_taps {
            source(next as u32, source_row);
            source_row.iter_mut().for_each(|value| *value ^= SIGN);
            let slot = &mut ring[next % row_taps * out_row.len()..][..out_row.len()];
            for (plane, out) in
                source_row.chunks_exact(columns.source as usize).zip(slot.chunks_exact_mut(width))
            {
                shrink_row(plane, starts, weights, out);
            }
            next += 1;
        }
        join_rows(ring, first, row_weights, out_row);
        sink(y, out_row);
    }
    Ok(())
}

/// Rows inside are kept as signed numbers, 0 in the middle of the range: products of 16-bit signed numbers are what vector
/// units are good at. As weights sum to one, the offset passes through unchanged.
const SIGN: u16 = 0x8000;

/// Half a weight of one, for rounding.
const HALF: i32 = 1 << (WEIGHT_BITS - 1);

/// A sum of products as a signed 16-bit number.
#[inline]
fn settle(sum: i32) -> u16 {
    (sum.wrapping_add(HALF) >> WEIGHT_BITS).clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as u16
}

/// The product of two signed 16-bit numbers.
#[inline]
fn product(a: u16, b: u16) -> i32 {
    i32::from(a as i16) * i32::from(b as i16)
}

/// The pass along a row.
fn shrink_row(plane: &[u16], starts: &[u16], weights: &[u16], out: &mut [u16]) {
    let taps = weights.len() / starts.len();
    for ((out, &start), weights) in out.iter_mut().zip(starts).zip(weights.chunks_exact(taps)) {
        let samples = &plane[usize::from(start)..][..taps];
        // Wrapping only for speed: the absolute weights sum to less than two, so the sum stays below 2^30.
        let sum = weights.iter().zip(samples).fold(0_i32, |sum, (&w, &v)| sum.wrapping_add(product(w, v)));
        *out = settle(sum);
    }
}

/// The pass across rows: row `first` and the following of `ring`, weighed.
fn join_rows(ring: &[u16], first: usize, weights: &[u16], out: &mut [u16]) {
    const BLOCK: usize = 32;
    let row_len = out.len();
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        let mut sums = [0_i32; BLOCK];
        for (tap, &weight) in weights.iter().enumerate() {
            let row = &ring[(first + tap) % weights.len() * row_len..][..row_len];
            let samples = &row[block * BLOCK..][..out.len()];
            if let Ok(samples) = <&[u16; BLOCK]>::try_from(samples) {
                for (sum, &value) in sums.iter_mut().zip(samples) {
                    *sum = sum.wrapping_add(product(weight, value));
                }
            } else {
                for (sum, &value) in sums.iter_mut().zip(samples) {
                    *sum = sum.wrapping_add(product(weight, value));
                }
            }
        }
        for (out, sum) in out.iter_mut().zip(sums) {
            *out = settle(sum) ^ SIGN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    extern crate std;
    use std::{vec, vec::Vec};

    fn run(columns: Axis, rows: Axis, channels: usize, picture: &[u16]) -> Vec<u16> {
        let mut storage = vec![0; storage_len(columns, rows, channels)];
        let (source_len, out_len) = (columns.source as usize * channels, columns.out as usize * channels);
        let mut out = Vec::with_capacity(rows.out as usize * out_len);
        let mut last = None;
        resample(
            columns,
            rows,
            channels,
            &mut storage,
            |y, row| {
                assert!(last < Some(y), "row {y} after {last:?}");
                last = Some(y);
                row.copy_from_slice(&picture[y as usize * source_len..][..source_len]);
            },
            |_, row| out.extend_from_slice(row),
        )
        .unwrap();
        out
    }

    /// The slow twin of one axis: the textbook's sum in f64, normalised, edges repeated.
    fn reference_row(axis: Axis, row: &[f64]) -> Vec<f64> {
        let one = f64::from(1_u32 << POSITION_BITS);
        let (start, length) = (axis.start as f64 / one, axis.length as f64 / one);
        let scale = length / f64::from(axis.out);
        let stretch = scale.max(1.0);
        let kernel = |t: f64| match t.abs() {
            t if t < 1.0 => 1.5 * t.powi(3) - 2.5 * t.powi(2) + 1.0,
            t if t < 2.0 => -0.5 * t.powi(3) + 2.5 * t.powi(2) - 4.0 * t + 2.0,
            _ => 0.0,
        };
        let pixel = |x: u32| {
            let centre = start + (f64::from(x) + 0.5) * scale - 0.5;
            let (mut sum, mut total) = (0.0, 0.0);
            for i in (centre - 2.0 * stretch).floor() as i64..=(centre + 2.0 * stretch).ceil() as i64 {
                let weight = kernel((i as f64 - centre) / stretch);
                sum += weight * row[i.clamp(0, row.len() as i64 - 1) as usize];
                total += weight;
            }
            (sum / total).clamp(0.0, 65_535.0)
        };
        (0..axis.out).map(pixel).collect()
    }

    fn reference(columns: Axis, rows: Axis, picture: &[u16]) -> Vec<f64> {
        let wide: Vec<f64> = picture.iter().map(|&v| f64::from(v)).collect();
        let (source, width) = (columns.source as usize, columns.out as usize);
        let narrow: Vec<f64> = wide.chunks(source).flat_map(|row| reference_row(columns, row)).collect();
        let mut out = vec![0.0; width * rows.out as usize];
        for x in 0..width {
            let column: Vec<f64> = narrow.iter().skip(x).step_by(width).copied().collect();
            for (y, value) in reference_row(rows, &column).into_iter().enumerate() {
                out[y * width + x] = value;
            }
        }
        out
    }

    fn noise(len: usize, seed: u64) -> Vec<u16> {
        use rand::Rng as _;
        let mut rng = crate::math::random::stream(seed, crate::math::random::Stream::Playlist);
        (0..len).map(|_| rng.next_u64() as u16).collect()
    }

    fn axis() -> impl Strategy<Value = Axis> {
        (1_u32..70, 1_u32..70, 1_u64..=100)
            .prop_map(|(source, out, percent)| Axis::centred(source, (percent, 100), out))
    }

    proptest! {
        #[test]
        fn it_is_within_a_thousandth_of_the_twin(columns in axis(), rows in axis(), seed: u64) {
            let picture = noise((columns.source * rows.source) as usize, seed);
            let want = reference(columns, rows, &picture);
            for (got, want) in run(columns, rows, 1, &picture).into_iter().zip(want) {
                prop_assert!((f64::from(got) - want).abs() < 65.0, "{} for {}", got, want);
            }
        }

        #[test]
        fn a_flat_colour_stays_that_very_colour(columns in axis(), rows in axis(), colour: u16) {
            let picture = vec![colour; (columns.source * rows.source) as usize];
            prop_assert!(run(columns, rows, 1, &picture).iter().all(|&v| v == colour));
        }

        #[test]
        fn the_same_size_is_the_identity(width in 1_u32..70, height in 1_u32..70, channels in 1_usize..=4) {
            let picture = noise((width * height) as usize * channels, 1);
            let got = run(Axis::whole(width, width), Axis::whole(height, height), channels, &picture);
            prop_assert_eq!(got, picture);
        }
    }

    #[test]
    fn weights_sum_to_one_at_every_scale() {
        for (source, out) in [(65_535, 1), (65_535, 2), (1, 65_535), (10_000, 1_080), (3, 7), (6_000, 1_920)]
        {
            let axis = Axis::whole(source, out);
            let mut weights = vec![0; axis.taps(LANES)];
            for x in (0..out).step_by(97) {
                axis.weigh(x, &mut weights);
                assert_eq!(weights.iter().map(|&w| i32::from(w as i16)).sum::<i32>(), 1 << WEIGHT_BITS);
            }
        }
    }

    #[test]
    fn too_little_memory_is_told_with_both_numbers() {
        let axis = Axis::whole(8, 4);
        let needed = storage_len(axis, axis, 1);
        let error = resample(axis, axis, 1, &mut vec![0; needed - 1], |_, _| {}, |_, _| {}).unwrap_err();
        assert_eq!(error, StorageTooSmall { needed, got: needed - 1 });
    }
}
