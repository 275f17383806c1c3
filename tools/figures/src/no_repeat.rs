//! `no-repeat`: that a noise never shows the same 256 frames again.
//!
//! Frames are cut into blocks of 256, every block is condensed to a hash of 64 bits, and the hashes are sorted: two alike are a
//! repeat. It takes 2^(N−5) bytes for 2^N frames (128 MB for 2^32, a decade at 12 frames a second). Two different blocks of 2^24
//! share a hash by chance once in 131,072 checks.

use crate::Failure;
use indicatif::{ProgressBar, ProgressStyle};
use yurameki::{
    math::random::{Stream, stream},
    noise::{Generator, Kind},
    os::interrupt::Interrupt,
};

/// Arguments of `no-repeat`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// constant, white, chaos, filter, hosoda, brown, chaos-literal or brown-literal.
    #[arg(long, value_name = "K")]
    kind: Kind,
    /// Look at 2^N frames, 9 to 36; it takes 2^(N-5) bytes of memory.
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(9..=36))]
    log2_steps: u32,
    /// The seed of the noise.
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
}

const LOG2_BLOCK: u32 = 8;

/// Blocks between two looks at the clock and at Ctrl-C.
const BLOCKS_A_STEP: usize = 1 << 12;

/// Checks one noise.
pub(crate) fn check(args: &Args) -> Result<(), Failure> {
    let interrupt = Interrupt::install()?;
    let Args { kind, log2_steps, seed } = *args;
    let blocks = 1_usize << (log2_steps - LOG2_BLOCK);
    let bar = ProgressBar::new(blocks as u64);
    bar.set_style(ProgressStyle::with_template("{wide_bar} {percent} % of the blocks, {eta} left")?);
    let mut hashes = Vec::new();
    hashes.try_reserve_exact(blocks).map_err(|_| {
        format!("{} MB of memory are needed and not there; ask for fewer steps", (blocks * 8) >> 20)
    })?;
    let mut generator = Generator::new(kind, stream(seed, Stream::Amplitude));
    while hashes.len() < blocks {
        if interrupt.requested() {
            return Err("stopped".into());
        }
        let count = BLOCKS_A_STEP.min(blocks - hashes.len());
        hashes.extend((0..count).map(|_| block(&mut generator)));
        bar.inc(count as u64);
    }
    bar.finish_and_clear();
    let repeats = repeats(&mut hashes);
    let of = format!("{blocks} blocks of {} frames, seed {seed}", 1 << LOG2_BLOCK);
    if repeats > 0 {
        return Err(format!("{kind} repeats itself: {repeats} of {of} were there before").into());
    }
    println!("{kind} does not repeat itself: {of}, all different");
    Ok(())
}

/// The hash of the next block: each sample is mixed in by a multiplication and a shift; the end is the finaliser of SplitMix64.
fn block(generator: &mut Generator) -> u64 {
    let hash = (0..1 << LOG2_BLOCK).fold(0xcbf2_9ce4_8422_2325_u64, |hash, _| {
        let sample = generator.step().to_bits() as u64;
        let mixed = (hash ^ sample).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        mixed ^ (mixed >> 32)
    });
    let hash = (hash ^ (hash >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    hash ^ (hash >> 31)
}

/// How many hashes are equal to an earlier one. Sorts them.
fn repeats(hashes: &mut [u64]) -> usize {
    hashes.sort_unstable();
    hashes.windows(2).filter(|pair| pair[0] == pair[1]).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_kind(kind: Kind, log2_steps: u32) -> Result<(), String> {
        check(&Args { kind, log2_steps, seed: 1 }).map_err(|failure| failure.to_string())
    }

    #[test]
    fn every_noise_but_the_dead_ones_goes_on() {
        for kind in Kind::ALL {
            let found = check_kind(kind, 16);
            assert_eq!(found.is_ok(), !matches!(kind, Kind::Constant | Kind::ChaosLiteral), "{found:?}");
        }
    }

    #[test]
    fn a_repeat_is_counted() {
        assert_eq!(
            check_kind(Kind::Constant, 10).unwrap_err(),
            "constant repeats itself: 3 of 4 blocks of 256 frames, seed 1 were there before"
        );
        assert_eq!(repeats(&mut [5, 1, 5, 2, 5, 1]), 3);
    }
}
