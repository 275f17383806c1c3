//! Planes of changes as bytes, each frame on its own.
//!
//! A pixel is predicted by its neighbours to the left, above, and above left (the median edge detector of LOCO-I, Weinberger et al. 1996):
//! min(a, b), max(a, b) or a + b − c. What is left of it, modulo 256, is coded by a `huffman` code of the
//! frame's own:
//!
//! ```text
//!   0  lengths of the codes   128   4 bits a byte, the lower half first
//! 128  bytes of the streams 1, 2 and 3, each   4   little-endian
//! 140  streams 1 to 4: bits, the most significant first, filled up with zeros to a byte
//! ```
//!
//! Each stream has a quarter of the pixels, rounded up, the last one what is left: four chains of look-ups are on their way at a
//! time. Only what lies in the [`Extent`] of its row is coded; beyond it everything is 0.

use super::huffman::{LENGTHS_BYTES, LONGEST, Lengths, Table};

/// Bytes before the streams.
const HEAD: usize = LENGTHS_BYTES + 3 * 4;

/// The columns of a row that can change, from `start` to before `end`; none if they are equal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Extent {
    /// The first.
    pub start: u16,
    /// Behind the last.
    pub end: u16,
}

impl Extent {
    /// The columns of a row that are not 0.
    pub fn of(row: &[u8]) -> Self {
        let moves = |&value: &u8| value > 0;
        let start = row.iter().position(moves).unwrap_or(0) as u16;
        Self { start, end: row.iter().rposition(moves).map_or(0, |last| last as u16 + 1) }
    }

    const fn len(self) -> usize {
        (self.end - self.start) as usize
    }
}

/// A picture of one or more planes, one after the other, all with the same extents.
#[derive(Clone, Copy, Debug)]
pub struct Planes<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// One for each row; none reaches beyond the width.
    pub extents: &'a [Extent],
    /// How many planes.
    pub count: usize,
}

impl Planes<'_> {
    /// Values that are coded.
    pub fn coded(&self) -> usize {
        self.count * self.extents.iter().map(|extent| extent.len()).sum::<usize>()
    }

    /// The row number, from 0 over all planes, and the extent of each row.
    fn rows(&self) -> impl Iterator<Item = (usize, Extent)> {
        (0..).zip((0..self.count).flat_map(|_| self.extents.iter().copied()))
    }
}

/// The most bytes of a frame of which so many values are coded.
pub const fn most_bytes(coded: usize) -> usize {
    HEAD + (coded * LONGEST as usize).div_ceil(8) + 4
}

/// The prediction from the left, from above, and from above left.
#[inline(always)]
fn median(left: i8, above: i8, corner: i8) -> i8 {
    let (a, b, c) = (i16::from(left), i16::from(above), i16::from(corner));
    (a + b - c).max(a.min(b)).min(a.max(b)) as i8
}

/// Calls `each` with the values of a row within its extent, the prediction of each from those before it, and where it stands.
#[inline(always)]
fn predict(planes: &Planes<'_>, values: &mut [i8], mut each: impl FnMut(&mut i8, i8)) {
    let height = planes.extents.len();
    for (row, extent) in planes.rows() {
        if extent.len() == 0 {
            continue;
        }
        let columns = extent.start.into()..usize::from(extent.end);
        let (before, from) = values.split_at_mut(row * planes.width);
        let own = &mut from[columns.clone()];
        let (mut left, mut corner) = (0, 0);
        if row.is_multiple_of(height) {
            for value in own {
                each(value, left);
                left = *value;
            }
            continue;
        }
        let above = &before[before.len() - planes.width..];
        if let Some(column) = columns.start.checked_sub(1) {
            corner = above[column];
        }
        for (value, &above) in own.iter_mut().zip(&above[columns]) {
            each(value, median(left, above, corner));
            (left, corner) = (*value, above);
        }
    }
}

/// Codes `values` into `out`, which holds [`most_bytes`], and tells how many bytes it takes. `residuals` is scratch memory for as many
/// values as are coded. What lies beyond the extents must be 0.
///
/// # Panics
/// If one of the slices is too short.
pub fn encode(planes: &Planes<'_>, values: &mut [i8], residuals: &mut [u8], out: &mut [u8]) -> usize {
    let mut at = 0;
    let mut counts = [0_u32; 256];
    predict(planes, values, |value, prediction| {
        let residual = value.wrapping_sub(prediction) as u8;
        residuals[at] = residual;
        counts[usize::from(residual)] += 1;
        at += 1;
    });
    let lengths = Lengths::of(counts);
    let codes = lengths.codes();
    let (head, body) = out.split_at_mut(HEAD);
    let (lengths_bytes, sizes) = head.split_at_mut(LENGTHS_BYTES);
    if let Some(bytes) = lengths_bytes.first_chunk_mut() {
        lengths.write(bytes);
    }
    let mut end = 0;
    let streams = quarters(&residuals[..at]);
    for (i, stream) in streams.into_iter().enumerate() {
        let start = end;
        end += write_stream(stream, &codes, &mut body[start..]);
        if let Some(size) = sizes.chunks_exact_mut(4).nth(i) {
            size.copy_from_slice(&((end - start) as u32).to_le_bytes());
        }
    }
    HEAD + end
}

fn quarters(values: &[u8]) -> [&[u8]; 4] {
    let quarter = values.len().div_ceil(4);
    let mut rest = values;
    core::array::from_fn(|_| {
        let (own, others) = rest.split_at(quarter.min(rest.len()));
        rest = others;
        own
    })
}

fn quarters_mut(values: &mut [u8]) -> [&mut [u8]; 4] {
    let quarter = values.len().div_ceil(4);
    let mut rest = values;
    core::array::from_fn(|_| {
        let length = quarter.min(rest.len());
        rest.split_off_mut(..length).unwrap_or_default()
    })
}

fn write_stream(symbols: &[u8], codes: &[(u32, u32); 256], out: &mut [u8]) -> usize {
    let (mut held, mut count, mut at) = (0_u64, 0, 0);
    for &symbol in symbols {
        let (code, length) = codes[usize::from(symbol)];
        held = held << length | u64::from(code);
        count += length;
        while count >= 8 {
            count -= 8;
            out[at] = (held >> count) as u8;
            at += 1;
        }
    }
    if count > 0 {
        out[at] = (held << (8 - count)) as u8;
        at += 1;
    }
    at
}

/// Decodes `bytes` into `values`, whose pixels beyond the extents it leaves alone; `residuals` is scratch memory for as many values as are coded.
/// `None`, and values as they were, if the bytes are no such frame.
///
/// # Panics
/// If one of the slices is too short.
pub fn decode(planes: &Planes<'_>, bytes: &[u8], residuals: &mut [u8], values: &mut [i8]) -> Option<()> {
    let residuals = &mut residuals[..planes.coded()];
    read_residuals(bytes, residuals)?;
    let mut residuals = residuals.iter();
    predict(planes, values, |value, prediction| {
        if let Some(&residual) = residuals.next() {
            *value = prediction.wrapping_add(residual as i8);
        }
    });
    Some(())
}

fn read_residuals(bytes: &[u8], residuals: &mut [u8]) -> Option<()> {
    let (lengths, rest) = bytes.split_first_chunk::<LENGTHS_BYTES>()?;
    let (sizes, mut body) = rest.split_first_chunk::<12>()?;
    let table = Lengths::read(lengths)?.table();
    let mut streams = [Bits::default(); 4];
    for (stream, size) in streams.iter_mut().zip(sizes.as_chunks::<4>().0) {
        *stream = Bits::of(body.split_off(..u32::from_le_bytes(*size) as usize)?);
    }
    streams[3] = Bits::of(body);
    let mut outs = quarters_mut(residuals);
    // All four together as far as the shortest, the last, goes.
    let together = outs[3].len() / 4;
    {
        let [a, b, c, d] = outs.each_mut().map(|out| out.as_chunks_mut::<4>().0[..together].iter_mut());
        for (((a, b), c), d) in a.zip(b).zip(c).zip(d) {
            for stream in &mut streams {
                stream.refill();
            }
            for i in 0..4 {
                a[i] = streams[0].take(&table);
                b[i] = streams[1].take(&table);
                c[i] = streams[2].take(&table);
                d[i] = streams[3].take(&table);
            }
        }
    }
    for (stream, out) in streams.iter_mut().zip(&mut outs) {
        for symbol in &mut out[together * 4..] {
            stream.refill();
            *symbol = stream.take(&table);
        }
    }
    streams.iter().all(Bits::ends).then_some(())
}

/// A stream that is read. Beyond its end are zeros.
#[derive(Clone, Copy, Default)]
struct Bits<'a> {
    bytes: &'a [u8],
    /// Bytes taken from it, those beyond its end counted.
    at: usize,
    /// The next bits, the first on top. Below the `count` that are held may lie some that come again.
    held: u64,
    count: u32,
}

impl<'a> Bits<'a> {
    fn of(bytes: &'a [u8]) -> Self {
        Self { bytes, ..Self::default() }
    }

    /// Holds at least 56 bits.
    #[inline(always)]
    fn refill(&mut self) {
        if let Some(&eight) = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk::<8>) {
            self.held |= u64::from_be_bytes(eight) >> self.count;
            let whole = (63 - self.count) / 8;
            self.at += whole as usize;
            self.count += whole * 8;
        } else {
            while self.count < 56 {
                let byte = self.bytes.get(self.at).copied().unwrap_or(0);
                self.held |= u64::from(byte) << (56 - self.count);
                self.at += 1;
                self.count += 8;
            }
        }
    }

    #[inline(always)]
    fn take(&mut self, table: &Table) -> u8 {
        let entry = table[(self.held >> (64 - LONGEST)) as usize];
        self.held <<= entry.length;
        self.count -= u32::from(entry.length);
        entry.byte
    }

    /// Whether just its bits were taken, but for those that fill up the last byte.
    fn ends(&self) -> bool {
        (self.at * 8 - self.count as usize).div_ceil(8) == self.bytes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Codes planes and gives the bytes.
    fn coded(planes: &Planes<'_>, values: &[i8]) -> Vec<u8> {
        let count = planes.coded();
        let mut out = vec![0; most_bytes(count)];
        let length = encode(planes, &mut values.to_vec(), &mut vec![0; count], &mut out);
        out.truncate(length);
        out
    }

    /// Rows with random extents, and values in them that go to both ends.
    fn pictures() -> impl Strategy<Value = (usize, usize, Vec<Extent>, Vec<i8>)> {
        (
            1_usize..40,
            1_usize..3,
            prop::collection::vec((0_u16..40, 0_u16..40), 1..12),
            any::<u64>(),
            0_u32..8,
        )
            .prop_map(|(width, count, ends, seed, coarse)| {
                let within = |at: u16| at.min(width as u16);
                let extents: Vec<Extent> = ends
                    .iter()
                    .map(|&(a, b)| Extent { start: within(a.min(b)), end: within(a.max(b)) })
                    .collect();
                let mut state = seed | 1;
                let mut values = vec![0; width * extents.len() * count];
                for (row, extent) in extents.iter().cycle().take(extents.len() * count).enumerate() {
                    for x in extent.start..extent.end {
                        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                        values[row * width + usize::from(x)] = (state >> 56) as i8 >> coarse;
                    }
                }
                (width, count, extents, values)
            })
    }

    proptest! {
        #[test]
        fn what_is_coded_comes_back_to_the_bit((width, count, extents, values) in pictures()) {
            let planes = Planes { width, extents: &extents, count };
            let bytes = coded(&planes, &values);
            let mut back = vec![0; values.len()];
            prop_assert_eq!(decode(&planes, &bytes, &mut vec![0; planes.coded()], &mut back), Some(()));
            prop_assert_eq!(back, values);
        }

        #[test]
        fn any_bytes_are_a_frame_or_are_refused_and_change_nothing(
            (width, count, extents, values) in pictures(), flips in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..8), 0..4), cut: prop::sample::Index
        ) {
            let planes = Planes { width, extents: &extents, count };
            let mut bytes = coded(&planes, &values);
            for (at, bit) in flips {
                let at = at.index(bytes.len());
                bytes[at] ^= 1_u8 << bit;
            }
            bytes.truncate(cut.index(bytes.len() + 1));
            let mut back = vec![7; values.len()];
            if decode(&planes, &bytes, &mut vec![0; planes.coded()], &mut back).is_none() {
                prop_assert!(back.iter().all(|&value| value == 7));
            }
        }
    }

    #[test]
    fn an_extent_holds_all_that_moves() {
        assert_eq!(Extent::of(&[0, 0, 3, 0, 9, 0]), Extent { start: 2, end: 5 });
        assert_eq!(Extent::of(&[0, 0]), Extent { start: 0, end: 0 });
    }

    #[test]
    fn a_still_frame_takes_an_eighth_of_a_byte_a_pixel() {
        let extents = [Extent { start: 0, end: 640 }; 360];
        let planes = Planes { width: 640, extents: &extents, count: 1 };
        assert!(coded(&planes, &vec![0; 640 * 360]).len() <= 640 * 360 / 8 + HEAD + 4);
    }
}
