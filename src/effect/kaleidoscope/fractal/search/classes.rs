//! Fisher's 72 classes: blocks of the same class look alike, and are compared one by one.
//!
//! A block is turned until its brightest quarter is the upper left one and of its neighbours the right one is the brighter: what remains are three orders of
//! brightness, times 24 orders of the quarters' variances (Fisher 1995, section 3.2).

use super::{
    super::{block::Block, isometry::Isometry},
    Planes, Pool,
};
use crate::effect::storage::{take, words};

const CLASSES: usize = 72;

/// Words of 64 bits that the classes of `count` domains take.
pub(super) const fn len(count: usize) -> usize {
    2 * words::<u8>(count) + words::<u32>(count)
}

/// The domains of one side, sorted by class.
pub(in super::super) struct Classes<'a> {
    pub(super) pool: Pool,
    /// How every domain was turned.
    turns: &'a [u8],
    /// Domains, class by class; in a class in their order.
    members: &'a [u32],
    /// Where in `members` each class ends.
    ends: [u32; CLASSES],
}

impl<'a> Classes<'a> {
    pub(super) fn new(planes: &Planes<'_>, pool: Pool, mut memory: &'a mut [u64]) -> Self {
        let (memory, count) = (&mut memory, pool.len());
        let bytes = take::<u8>(memory, count).zip(take::<u8>(memory, count));
        let Some(((classes, turns), members)) = bytes.zip(take::<u32>(memory, count)) else {
            unreachable!("the memory was as long as the formula asks for")
        };
        let mut counts = [0_u32; CLASSES];
        for (i, (class, turn)) in classes.iter_mut().zip(&mut *turns).enumerate() {
            let quarters = Quarters::of(&pool.block(planes, i));
            let (found, isometry) = quarters.class();
            (*class, *turn) = (found, isometry.index());
            counts[usize::from(found)] += 1;
        }
        let mut next = 0;
        let mut ends = counts.map(|count| {
            let start = next;
            next += count;
            start
        });
        for (i, &class) in classes.iter().enumerate() {
            let end = &mut ends[usize::from(class)];
            members[*end as usize] = i as u32;
            *end += 1;
        }
        Self { pool, turns, members, ends }
    }

    /// Tells `found` the domains of the range's class, and those of the class of its negative.
    pub(super) fn candidates(&self, range: &Block, mut found: impl FnMut(usize, Isometry)) {
        let quarters = Quarters::of(range);
        for quarters in [quarters, quarters.negative()] {
            let (class, turn) = quarters.class();
            let class = usize::from(class);
            let start = class.checked_sub(1).map_or(0, |before| self.ends[before] as usize);
            for &member in &self.members[start..self.ends[class] as usize] {
                let domain = Isometry::from_index(self.turns[member as usize]);
                found(member as usize, domain.then(turn.inverse()));
            }
        }
    }
}

/// Brightness and variance of the quarters: upper left and right, lower left and right.
#[derive(Clone, Copy, Debug)]
struct Quarters {
    brightness: [i64; 4],
    variance: [i64; 4],
}

impl Quarters {
    fn of(block: &Block) -> Self {
        let half = block.side() / 2;
        let (mut sums, mut squares) = ([0_i64; 4], [0_i64; 4]);
        for (i, row) in block.levels().chunks_exact(half).enumerate() {
            let quarter = i % 2 + 2 * usize::from(i / 2 >= half);
            for &level in row {
                let z = i64::from(level);
                sums[quarter] += z;
                squares[quarter] += z * z;
            }
        }
        let pixels = (half * half) as i64;
        let variance = core::array::from_fn(|i| pixels * squares[i] - sums[i] * sums[i]);
        Self { brightness: sums, variance }
    }

    const fn negative(self) -> Self {
        let [a, b, c, d] = self.brightness;
        Self { brightness: [-a, -b, -c, -d], variance: self.variance }
    }

    /// The class, and the isometry that turns the block as its class demands: of several the first.
    fn class(self) -> (u8, Isometry) {
        let turned = |values: [i64; 4], j: u8| {
            // A block of 2 × 2 reads its quarters.
            let strides = Isometry::from_index(j).strides(0, 2, 2);
            let at =
                |u: isize, v: isize| values[(strides.start + u * strides.right + v * strides.down) as usize];
            [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
        };
        let is_canonical = |&j: &u8| {
            let [a, b, c, d] = turned(self.brightness, j);
            a >= b && a >= d && b >= c
        };
        let j = (0..Isometry::COUNT)
            .find(is_canonical)
            .unwrap_or_else(|| unreachable!("one corner is the brightest"));
        let [_, b, c, d] = turned(self.brightness, j);
        let major = u8::from(d > c) + u8::from(d > b);
        (24 * major + order(turned(self.variance, j)), Isometry::from_index(j))
    }
}

/// The number of the order of four values, 0..24.
fn order(values: [i64; 4]) -> u8 {
    let larger = |i: usize| (i + 1..4).filter(|&j| values[j] > values[i]).count() as u8;
    larger(0) * 6 + larger(1) * 2 + larger(2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_turned_block_stays_in_its_class(levels in proptest::collection::vec(any::<u8>(), 64), j in 0_u8..8) {
            let block = Block::at(&levels, 8, 0, 0, 8);
            let turned = block.turned(Isometry::from_index(j).strides(0, 8, 8));
            let [a, b] = [block, turned].map(|block| Quarters::of(&block));
            let mut brightness = a.brightness;
            brightness.sort_unstable();
            prop_assume!(brightness.windows(2).all(|pair| pair[0] != pair[1]));
            prop_assert_eq!(a.class().0, b.class().0);
        }
    }

    #[test]
    fn there_are_24_orders() {
        let mut seen = [false; 24];
        for i in 0..256_i64 {
            seen[usize::from(order([i & 3, i >> 2 & 3, i >> 4 & 3, i >> 6]))] = true;
        }
        assert!(seen.iter().all(|&seen| seen));
    }
}
