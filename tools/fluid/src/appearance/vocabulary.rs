//! The vocabulary: 200 words that stand for all descriptors.
//!
//! Repeated bisection (the paper's choice, as in Steinbach, Karypis and Kumar 2000): the cluster with the largest squared error is cut in
//! two until there are enough. Nothing is drawn by lot: the first cut is across the direction in which a cluster is longest, so that the
//! same descriptors give the same words.

use super::descriptor::Descriptor;
use crate::features::WORDS;
use rayon::prelude::*;

/// The word of places that show nothing: the last one.
pub const FLAT_WORD: u8 = (WORDS - 1) as u8;

/// Steps towards the longest direction of a cluster. It need not be exact, as the cut moves afterwards.
const POWER_STEPS: usize = 4;

/// Times the two halves are improved. A tenth round moved under 1 % of the descriptors of the clips that this was tuned with.
const ROUNDS: usize = 8;

/// Mean descriptors of clusters, nearest to which a descriptor is given its word.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Vocabulary {
    words: Vec<[i16; 128]>,
    /// Half of the squared length of every word.
    halves: Vec<i32>,
}

impl Vocabulary {
    /// Words for such descriptors: 200, or fewer where there are not as many different ones. Flat ones are left out.
    ///
    /// About 1.5 s of one core for 40,000 descriptors.
    pub fn train(samples: &[Descriptor]) -> Self {
        let samples: Vec<[f32; 128]> = samples
            .iter()
            .filter(|sample| **sample != [0; 128])
            .map(|sample| sample.map(f32::from))
            .collect();
        let mut clusters = Vec::with_capacity(WORDS);
        if !samples.is_empty() {
            clusters.push(Cluster::of(&samples, (0..samples.len()).collect()));
        }
        while clusters.len() < WORDS - 1 {
            let Some(worst) = (0..clusters.len())
                .filter(|index| clusters[*index].error > 0.0)
                .max_by(|a, b| clusters[*a].error.total_cmp(&clusters[*b].error))
            else {
                break;
            };
            match clusters[worst].bisected(&samples) {
                Some([one, two]) => {
                    clusters[worst] = one;
                    clusters.push(two);
                }
                None => clusters[worst].error = 0.0,
            }
        }
        Self::from_words(
            clusters.iter().map(|cluster| cluster.mean.map(|entry| (entry + 0.5) as i16)).collect(),
        )
    }

    fn from_words(words: Vec<[i16; 128]>) -> Self {
        let halves = words.iter().map(|word| product(word, word) / 2).collect();
        Self { words, halves }
    }

    /// The words as bytes, 128 each.
    pub fn to_bytes(&self) -> Vec<u8> {
        // A mean of bytes is a byte.
        self.words.iter().flatten().map(|entry| *entry as u8).collect()
    }

    /// The vocabulary that [`Self::to_bytes`] wrote, if these are such bytes.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, rest) = bytes.as_chunks::<128>();
        (rest.is_empty() && words.len() < WORDS)
            .then(|| Self::from_words(words.iter().map(|word| word.map(i16::from)).collect()))
    }

    /// How many words there are, the flat one not counted.
    pub fn len(&self) -> usize {
        self.words.len()
    }

    /// Whether there are none: then every place is flat.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// The nearest word; [`FLAT_WORD`] for a flat descriptor. The first counts where two are as near.
    pub fn word(&self, descriptor: &Descriptor) -> u8 {
        if *descriptor == [0; 128] {
            return FLAT_WORD;
        }
        let descriptor = descriptor.map(i16::from);
        let (mut best, mut best_score) = (FLAT_WORD, i32::MIN);
        for (index, (word, half)) in self.words.iter().zip(&self.halves).enumerate() {
            // |d − w|² = |d|² − 2 (d·w − |w|²/2)
            let score = product(&descriptor, word) - half;
            if score > best_score {
                (best, best_score) = (index as u8, score);
            }
        }
        best
    }
}

/// At most 128 · 255²: far from the limits of i32.
fn product(a: &[i16; 128], b: &[i16; 128]) -> i32 {
    a.iter().zip(b).map(|(a, b)| i32::from(*a) * i32::from(*b)).sum()
}

/// Some of the samples.
struct Cluster {
    members: Vec<usize>,
    mean: [f32; 128],
    /// Sum of the squared distances from the mean.
    error: f32,
}

impl Cluster {
    fn of(samples: &[[f32; 128]], members: Vec<usize>) -> Self {
        let mut sum = [0.0f64; 128];
        for member in &members {
            for (sum, entry) in sum.iter_mut().zip(&samples[*member]) {
                *sum += f64::from(*entry);
            }
        }
        let mean = sum.map(|sum| (sum / members.len() as f64) as f32);
        let error =
            members.iter().map(|member| f64::from(distance(&samples[*member], &mean))).sum::<f64>() as f32;
        Self { members, mean, error }
    }

    /// Its two halves; none if all its members are the same.
    fn bisected(&self, samples: &[[f32; 128]]) -> Option<[Self; 2]> {
        let direction = self.longest_direction(samples);
        let middle = dot(&self.mean, &direction);
        let mut right: Vec<bool> =
            self.members.par_iter().map(|member| dot(&samples[*member], &direction) > middle).collect();
        let mut halves = self.split(samples, &right)?;
        for _ in 0..ROUNDS {
            let next: Vec<bool> = self
                .members
                .par_iter()
                .map(|member| {
                    let sample = &samples[*member];
                    distance(sample, &halves[1].mean) < distance(sample, &halves[0].mean)
                })
                .collect();
            if next == right {
                break;
            }
            right = next;
            halves = self.split(samples, &right)?;
        }
        Some(halves)
    }

    fn split(&self, samples: &[[f32; 128]], right: &[bool]) -> Option<[Self; 2]> {
        let side = |wanted: bool| {
            let members: Vec<usize> = self
                .members
                .iter()
                .zip(right)
                .filter(|(_, right)| **right == wanted)
                .map(|(member, _)| *member)
                .collect();
            (!members.is_empty()).then(|| Self::of(samples, members))
        };
        Some([side(false)?, side(true)?])
    }

    /// The first principal direction, by the power method from the member that is farthest from the mean.
    fn longest_direction(&self, samples: &[[f32; 128]]) -> [f32; 128] {
        // A part of a large cluster tells its direction as well.
        let members: Vec<usize> =
            self.members.iter().step_by(self.members.len() / 2000 + 1).copied().collect();
        let from_mean = |member: usize| {
            let mut difference = samples[member];
            difference.iter_mut().zip(&self.mean).for_each(|(entry, mean)| *entry -= mean);
            difference
        };
        let far = |member: &usize| distance(&samples[*member], &self.mean);
        let farthest = members.iter().copied().max_by(|a, b| far(a).total_cmp(&far(b)));
        let mut direction = farthest.map_or([0.0; 128], from_mean);
        for _ in 0..POWER_STEPS {
            let mut next = [0.0; 128];
            for member in &members {
                let difference = from_mean(*member);
                let weight = dot(&difference, &direction);
                next.iter_mut().zip(&difference).for_each(|(next, entry)| *next += weight * entry);
            }
            let length = dot(&next, &next).sqrt();
            if length == 0.0 {
                break;
            }
            direction = next.map(|entry| entry / length);
        }
        direction
    }
}

/// A sum in 8 lanes, so that the compiler can use the vector unit.
fn lanes(a: &[f32; 128], b: &[f32; 128], term: impl Fn(f32, f32) -> f32) -> f32 {
    let mut sums = [0.0; 8];
    for (a, b) in a.as_chunks::<8>().0.iter().zip(b.as_chunks::<8>().0) {
        for lane in 0..8 {
            sums[lane] += term(a[lane], b[lane]);
        }
    }
    sums.iter().sum()
}

fn dot(a: &[f32; 128], b: &[f32; 128]) -> f32 {
    lanes(a, b, |a, b| a * b)
}

fn distance(a: &[f32; 128], b: &[f32; 128]) -> f32 {
    lanes(a, b, |a, b| (a - b) * (a - b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Descriptors near one of `kinds` ones.
    fn samples(kinds: usize, each: usize) -> Vec<Descriptor> {
        (0..kinds * each)
            .map(|index| {
                let (kind, member) = (index % kinds, index / kinds);
                core::array::from_fn(|entry| {
                    let lit = (entry * 7 + kind * 13) % kinds == 0;
                    (if lit { 150 } else { 10 }) + ((entry + member * 31) % 8) as u8
                })
            })
            .collect()
    }

    #[test]
    fn kinds_of_descriptors_get_words_of_their_own() {
        let samples = samples(5, 20);
        let vocabulary = Vocabulary::train(&samples);
        for (index, sample) in samples.iter().enumerate() {
            for (kind, other) in samples[..5].iter().enumerate().filter(|(kind, _)| *kind != index % 5) {
                assert_ne!(vocabulary.word(sample), vocabulary.word(other), "kinds {kind} and {}", index % 5);
            }
        }
    }

    #[test]
    fn there_are_no_more_words_than_different_descriptors() {
        let mut samples = vec![[9; 128]; 50];
        samples.push([0; 128]);
        samples.push(core::array::from_fn(|entry| entry as u8));
        let vocabulary = Vocabulary::train(&samples);
        assert_eq!(vocabulary.len(), 2);
        assert_eq!(vocabulary.word(&[0; 128]), FLAT_WORD);
        assert!(Vocabulary::train(&[[0; 128]; 3]).is_empty());
    }

    #[test]
    fn bytes_keep_a_vocabulary() {
        let vocabulary = Vocabulary::train(&samples(9, 40));
        let bytes = vocabulary.to_bytes();
        assert_eq!(Vocabulary::from_bytes(&bytes), Some(vocabulary));
        assert_eq!(Vocabulary::from_bytes(&bytes[1..]), None);
        assert_eq!(Vocabulary::from_bytes(&vec![1; 128 * WORDS]), None);
    }

    proptest! {
        #[test]
        fn the_word_is_the_nearest(seed: [u8; 32]) {
            let vocabulary = Vocabulary::train(&samples(17, 12));
            let descriptor: Descriptor = core::array::from_fn(|entry| seed[entry % 32].wrapping_add(entry as u8));
            let squared = |word: usize| vocabulary.words[word]
                .iter()
                .zip(descriptor)
                .map(|(a, b)| (i64::from(*a) - i64::from(b)).pow(2))
                .sum::<i64>();
            let nearest = (0..vocabulary.len()).map(squared).min();
            let given = squared(usize::from(vocabulary.word(&descriptor)));
            // Half of an odd square is rounded.
            prop_assert!(given <= nearest.unwrap_or(0) + 1);
        }
    }
}
