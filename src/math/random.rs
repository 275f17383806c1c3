//! Seeded random streams with a documented, portable algorithm.
//!
//! Every consumer of chance has a stream of its own, so that drawing more numbers in one place changes nothing elsewhere.

/// The generator of every random stream: Xoshiro256++ (Blackman and Vigna, 2019). Never `SmallRng` or `StdRng`, whose
/// algorithm depends on the machine or on the version of the crate.
pub type Rng = rand::rngs::Xoshiro256PlusPlus;

/// Names a random stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// The noise that scales the swing.
    Amplitude = 1,
    /// The noise that bends the oscillation's frequency.
    Frequency = 2,
    /// The order in which photos are shown.
    Playlist = 3,
}

/// The generator of one `stream` of `seed`, from its start.
///
/// The streams of neighbouring seeds are as unrelated as those of any two: the seed is spread by the finaliser of
/// SplitMix64 before the stream's number is added, and `seed_from_u64` spreads the sum again.
pub fn stream(seed: u64, stream: Stream) -> Rng {
    rand::SeedableRng::seed_from_u64(scatter(seed).wrapping_add(stream as u64))
}

/// A number as unrelated to those of neighbouring keys as any: a step of SplitMix64 (Steele, Lea and Flood, 2014). For chance that
/// belongs to a thing, like a leaf, and must not depend on the order in which things are looked at.
pub(crate) const fn scatter(key: u64) -> u64 {
    let mut z = key.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng as _;

    #[test]
    fn streams_and_seeds_differ_and_repeat() {
        let first = |seed, name| stream(seed, name).next_u64();
        assert_eq!(first(7, Stream::Amplitude), first(7, Stream::Amplitude));
        assert_ne!(first(7, Stream::Amplitude), first(7, Stream::Frequency));
        assert_ne!(first(7, Stream::Frequency), first(8, Stream::Amplitude));
    }

    #[test]
    fn the_generator_is_the_same_on_every_machine() {
        assert_eq!(stream(1, Stream::Amplitude).next_u64(), 2_419_095_151_734_221_764);
    }
}
