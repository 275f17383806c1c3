//! How alike two patches look: the intersection of the histograms of their words (the paper, eq. 1), over the whole patch and over its
//! quarters (Lazebnik's pyramid).
//!
//! The histograms of the database are made for a block of patches at a time and lie bin by bin, so that one bin of all patches in the
//! block is compared at once with one count of the picture's patch: bytes only, which every processor adds 16 or more at a time, and only
//! the bins that the picture's patch fills, at most 162 of 1005. Exact.

use crate::features::{PLACES, WORDS, WordMap};

/// Patches of a block: their counts of one bin are one cache line.
pub(super) const BLOCK: usize = 64;

/// Places of a patch across.
const ACROSS: usize = 9;

/// The whole patch and its quarters.
const REGIONS: usize = 5;

/// Two equal patches have this intersection: every place counts in the whole and in a quarter. It fits a byte.
pub(super) const MOST: u8 = 2 * PLACES as u8;

/// The bins that a word at a place counts in: the whole patch's, and its quarter's. The middle row and column belong to the upper left.
fn bins(place: usize, word: u8) -> [usize; 2] {
    let quarter = 2 * usize::from(place / ACROSS > ACROSS / 2) + usize::from(place % ACROSS > ACROSS / 2);
    [usize::from(word), (1 + quarter) * WORDS + usize::from(word)]
}

/// The filled bins of one patch, and their counts.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sparse(Vec<(u16, u8)>);

impl Sparse {
    pub(super) fn of(words: &WordMap) -> Self {
        let mut dense = [0u8; REGIONS * WORDS];
        for (place, &word) in words.iter().enumerate() {
            bins(place, word).into_iter().for_each(|bin| dense[bin] += 1);
        }
        Self((0u16..).zip(dense).filter(|&(_, count)| count > 0).collect())
    }
}

/// The histograms of up to [`BLOCK`] patches.
pub(super) struct Block(Vec<[u8; BLOCK]>);

impl Block {
    pub(super) fn new() -> Self {
        Self(vec![[0; BLOCK]; REGIONS * WORDS])
    }

    /// Forgets what was there and counts these patches.
    pub(super) fn fill<'a>(&mut self, patches: impl Iterator<Item = &'a WordMap>) {
        self.0.fill([0; BLOCK]);
        for (lane, words) in patches.take(BLOCK).enumerate() {
            for (place, &word) in words.iter().enumerate() {
                bins(place, word).into_iter().for_each(|bin| self.0[bin][lane] += 1);
            }
        }
    }

    /// The intersections of a patch with all of the block, 0..=[`MOST`].
    pub(super) fn intersect(&self, patch: &Sparse) -> [u8; BLOCK] {
        let mut sums = [0u8; BLOCK];
        for &(bin, count) in &patch.0 {
            let row = &self.0[usize::from(bin)];
            // Wrapping says that there is no carry to look for, as no sum exceeds MOST.
            sums.iter_mut().zip(row).for_each(|(sum, &other)| *sum = sum.wrapping_add(other.min(count)));
        }
        sums
    }
}

/// The intersection of two patches, 0..=[`MOST`].
pub(super) fn intersection(patch: &Sparse, words: &WordMap) -> u8 {
    let other = Sparse::of(words);
    let mut other = other.0.iter().peekable();
    let mut sum = 0;
    for &(bin, count) in &patch.0 {
        while other.next_if(|&&(theirs, _)| theirs < bin).is_some() {}
        if let Some(&(_, theirs)) = other.next_if(|&&(theirs, _)| theirs == bin) {
            sum += count.min(theirs);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Equation 1, word by word.
    fn literal(a: &WordMap, b: &WordMap) -> u8 {
        let inside = |region: usize, place: usize| {
            let quarter = [place / 9 > 4, place % 9 > 4];
            region == 0 || quarter == [region > 2, region.is_multiple_of(2)]
        };
        let count = |words: &WordMap, region, word| {
            words
                .iter()
                .enumerate()
                .filter(|&(place, &w)| usize::from(w) == word && inside(region, place))
                .count()
        };
        (0..REGIONS)
            .map(|r| (0..WORDS).map(|w| count(a, r, w).min(count(b, r, w))).sum::<usize>())
            .sum::<usize>() as u8
    }

    fn word_map() -> impl Strategy<Value = WordMap> {
        prop_oneof![prop::array::uniform(0u8..5), prop::array::uniform(0u8..WORDS as u8)]
    }

    proptest! {
        #[test]
        fn blocks_and_pairs_agree_with_the_equation(target in word_map(), others in prop::collection::vec(word_map(), 1..70)) {
            let sparse = Sparse::of(&target);
            let mut block = Block::new();
            block.fill(others.iter());
            let sums = block.intersect(&sparse);
            for (lane, other) in others.iter().take(BLOCK).enumerate() {
                prop_assert_eq!(sums[lane], literal(&target, other));
                prop_assert_eq!(intersection(&sparse, other), sums[lane]);
            }
            prop_assert!(sums[others.len().min(BLOCK)..].iter().all(|&sum| sum == 0));
            prop_assert_eq!(intersection(&sparse, &target), MOST);
        }
    }
}
