//! A canonical prefix code of limited length for bytes.
//!
//! Huffman's code (1952) of the counts; where it is longer than [`LONGEST`] bits, the counts are halved and it is built anew, which
//! costs under 0.1 % here. Canonical: codes of a length are consecutive numbers in the order of their bytes, so the lengths alone tell the code.

/// The most bits of a code: four codes fit what one refill of a register brings, and the table stays in the first-level cache.
pub(super) const LONGEST: u32 = 12;

/// Bytes that the lengths take in a file: four bits each.
pub(super) const LENGTHS_BYTES: usize = 128;

/// How many bits each byte takes; 0 for one that does not occur. A code is always complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Lengths([u8; 256]);

impl Lengths {
    /// The best lengths for bytes that occur so often.
    pub(super) fn of(mut counts: [u32; 256]) -> Self {
        // A code has two words at least.
        for spare in [0, 1] {
            if counts.iter().filter(|&&count| count > 0).count() < 2 {
                counts[spare] = counts[spare].max(1);
            }
        }
        loop {
            let lengths = unlimited(&counts);
            if lengths.iter().all(|&length| u32::from(length) <= LONGEST) {
                return Self(lengths);
            }
            counts = counts.map(|count| count.div_ceil(2));
        }
    }

    pub(super) fn read(bytes: &[u8; LENGTHS_BYTES]) -> Option<Self> {
        let lengths: [u8; 256] = core::array::from_fn(|i| bytes[i / 2] >> (i % 2 * 4) & 15);
        let mut sum = 0_u32;
        for length in lengths.iter().map(|&length| u32::from(length)).filter(|&length| length > 0) {
            sum += (1_u32 << LONGEST).checked_shr(length).filter(|_| length <= LONGEST)?;
        }
        // Every sequence of bits means something, and one thing (Kraft).
        (sum == 1 << LONGEST).then_some(Self(lengths))
    }

    pub(super) fn write(&self, bytes: &mut [u8; LENGTHS_BYTES]) {
        for (byte, pair) in bytes.iter_mut().zip(self.0.as_chunks::<2>().0) {
            *byte = pair[0] | pair[1] << 4;
        }
    }

    /// The bytes that occur, by the length of their codes.
    fn canonical(&self) -> impl Iterator<Item = (u8, u32)> {
        (1..=LONGEST).flat_map(|length| {
            let of_length = (0..=255).zip(&self.0).filter(move |&(_, &own)| u32::from(own) == length);
            of_length.map(move |(byte, _)| (byte, length))
        })
    }

    /// The code of each byte and its length.
    pub(super) fn codes(&self) -> [(u32, u32); 256] {
        let mut codes = [(0, 0); 256];
        let mut next = 0;
        for (byte, length) in self.canonical() {
            codes[usize::from(byte)] = (next >> (LONGEST - length), length);
            next += 1 << (LONGEST - length);
        }
        codes
    }

    /// What any [`LONGEST`] bits begin with.
    pub(super) fn table(&self) -> Table {
        let mut table = [Entry::default(); 1 << LONGEST];
        let mut next = 0;
        for (byte, length) in self.canonical() {
            let count = 1 << (LONGEST - length);
            table[next..next + count].fill(Entry { byte, length: length as u8 });
            next += count;
        }
        table
    }
}

/// A byte and the bits that it takes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    pub(super) byte: u8,
    pub(super) length: u8,
}

pub(super) type Table = [Entry; 1 << LONGEST];

/// The lengths of Huffman's code, which at least two bytes share.
fn unlimited(counts: &[u32; 256]) -> [u8; 256] {
    let mut order: [u8; 256] = core::array::from_fn(|i| i as u8);
    order.sort_unstable_by_key(|&byte| (counts[usize::from(byte)], byte));
    let first = order.iter().take_while(|&&byte| counts[usize::from(byte)] == 0).count();
    let leaves = 256 - first;
    // Leaves by their weight, then the inner nodes as they are joined, which have a rising weight too.
    let mut weights = [0_u64; 511];
    for (weight, &byte) in weights.iter_mut().zip(&order[first..]) {
        *weight = counts[usize::from(byte)].into();
    }
    let mut parents = [0_usize; 511];
    let (mut leaf, mut inner) = (0, leaves);
    for node in leaves..2 * leaves - 1 {
        for _ in 0..2 {
            let take_leaf = leaf < leaves && (inner == node || weights[leaf] <= weights[inner]);
            let child = if take_leaf { &mut leaf } else { &mut inner };
            weights[node] += weights[*child];
            parents[*child] = node;
            *child += 1;
        }
    }
    let mut depths = [0_u8; 511];
    for node in (0..2 * leaves - 2).rev() {
        depths[node] = depths[parents[node]] + 1;
    }
    let mut lengths = [0; 256];
    for (&byte, &depth) in order[first..].iter().zip(&depths) {
        lengths[usize::from(byte)] = depth;
    }
    lengths
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_code_of_a_known_example_is_huffmans() {
        let mut counts = [0; 256];
        for (byte, count) in [(b'a', 45), (b'b', 13), (b'c', 12), (b'd', 16), (b'e', 9), (b'f', 5)] {
            counts[usize::from(byte)] = count;
        }
        let lengths = Lengths::of(counts).0;
        assert_eq!(
            [b'a', b'b', b'c', b'd', b'e', b'f'].map(|byte| lengths[usize::from(byte)]),
            [1, 3, 3, 3, 4, 4]
        );
    }

    #[test]
    fn lengths_that_are_no_code_are_refused() {
        let mut bytes = [0; LENGTHS_BYTES];
        assert_eq!(Lengths::read(&bytes), None, "empty");
        bytes[0] = 0x01;
        assert_eq!(Lengths::read(&bytes), None, "incomplete");
        bytes[0] = 0x11;
        assert!(Lengths::read(&bytes).is_some());
        bytes[1] = 0x01;
        assert_eq!(Lengths::read(&bytes), None, "too many");
        bytes[1] = 0x0f;
        assert_eq!(Lengths::read(&bytes), None, "too long");
    }

    proptest! {
        #[test]
        fn any_counts_give_a_complete_code_that_is_read_back(
            counts in prop::collection::vec(prop_oneof![Just(0_u32), 0_u32..9, 0_u32..1 << 24], 256)
        ) {
            let lengths = Lengths::of(counts.clone().try_into().unwrap());
            let mut bytes = [0; LENGTHS_BYTES];
            lengths.write(&mut bytes);
            prop_assert_eq!(Lengths::read(&bytes), Some(lengths));
            let (codes, table) = (lengths.codes(), lengths.table());
            for byte in 0..256 {
                let (code, length) = codes[byte];
                prop_assert!(counts[byte] == 0 || length > 0);
                if length > 0 {
                    let entry = table[(code << (LONGEST - length)) as usize];
                    prop_assert_eq!((usize::from(entry.byte), u32::from(entry.length)), (byte, length));
                }
            }
        }
    }
}
