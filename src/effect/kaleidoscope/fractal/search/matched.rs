//! The matched filter: a block as a unit vector of 16 numbers, and blocks compared by dot products.
//!
//! A block is shrunk to 4 × 4 means, freed of its mean and normalised; |dot| = 1 is a perfect match but for contrast and brightness.
//! A range is compared with a domain in all eight orientations. Done one by one that takes 128 products. But the 16 numbers can be
//! written in a basis in which an isometry does next to nothing (the irreducible representations of the square's group D4): eight of them
//! keep their place and at the most change sign, together, in four sorts (A1 of three, A2 and B1 of one, B2 of three), and eight are four
//! pairs (p, q) that turn like a point of the plane (E). So with the sums of products
//!
//! ```text
//! a1, a2, b1, b2 of each sort, and Epp, Epq, Eqp, Eqq of the pairs
//! ```
//!
//! the eight dot products are ±P + ±E of just four P (a1 ± a2 ± b1 ± b2) and four E (Epp ± Eqq, Epq ± Eqp), and the largest of each
//! pair is |P| + |E|: 24 products and a few sums for all eight. This is exact, and what makes an exhaustive search fit for portable code.
//!
//! A domain of little contrast cannot be steepened to a range of much, as |s| < 1: with t = |dot| and c = s·|D|/|R|, the
//! error is |R|²·(1 − 2ct + c²), least at c = t if s allows that. So domains are compared by c·(2t − c); by t alone, camera lost
//! 0.9 dB.

use super::{
    super::{block::Block, isometry::Isometry},
    Planes, Pool,
};
use crate::{
    effect::storage::{take, words},
    math::lanes::{self, Task, on_widest},
};

/// Domains that are compared at a time, one a lane; each lane keeps its best. So many that the compiler makes vectors of them.
const LANES: usize = 32;

/// How many lanes' best are compared exactly.
const BEST: usize = 8;

/// 32 domains: of each its 16 numbers, Q15: A1 (3), A2, B1, B2 (3), and p, q of four pairs; and |D|.
type Group = [Lanes; 17];

/// A number of each of 32 domains.
type Lanes = [i16; LANES];

/// Where the |D| are: those of the 4 × 4 means, Q6. The largest is 510 levels.
const NORMS: usize = 16;

/// More groups than this are searched in parts, as their numbers are 16 bits.
const MOST_GROUPS: usize = 1 << 15;

/// Words of 64 bits that the numbers and the orientations of `count` domains take.
pub(super) const fn len(count: usize) -> usize {
    words::<Group>(count.div_ceil(LANES)) + words::<u8>(count)
}

/// The domains of one side.
pub(in super::super) struct Matched<'a> {
    pub(super) pool: Pool,
    groups: &'a [Group],
    /// How domains were turned; none is if all orientations are compared.
    turns: Option<&'a [u8]>,
}

impl<'a> Matched<'a> {
    pub(super) fn new(planes: &Planes<'_>, pool: Pool, canonical: bool, mut memory: &'a mut [u64]) -> Self {
        let memory = &mut memory;
        let carved = take::<Group>(memory, pool.len().div_ceil(LANES)).zip(take::<u8>(memory, pool.len()));
        let Some((groups, turns)) = carved else {
            unreachable!("the memory was as long as the formula asks for")
        };
        groups.fill([[0; LANES]; 17]);
        for (i, turn) in turns.iter_mut().enumerate() {
            let mut vector = Vector::of(&pool.block(planes, i));
            if canonical {
                let isometry = vector.canonical();
                vector = vector.turned(isometry);
                *turn = isometry.index();
            }
            let group = &mut groups[i / LANES];
            for (lanes, number) in group.iter_mut().zip(vector.numbers) {
                lanes[i % LANES] = number;
            }
            group[NORMS][i % LANES] = vector.norm;
        }
        Self { pool, groups, turns: canonical.then_some(turns) }
    }

    /// Tells `found` the best domains of the best lanes, in their best orientation.
    pub(super) fn candidates(&self, range: &Block, mut found: impl FnMut(usize, Isometry)) {
        let vector = Vector::of(range);
        let reach = Reach::new(vector.norm);
        let turn = self.turns.map(|_| vector.canonical());
        let range = turn.map_or(vector, |turn| vector.turned(turn));
        let spread = range.numbers.map(|number| [number; LANES]);
        for (part, groups) in self.groups.chunks(MOST_GROUPS).enumerate() {
            let first = part * MOST_GROUPS * LANES;
            for index in on_widest(Comparison { groups, reach, spread: &spread, canonical: turn.is_some() }) {
                let products = Products::of_one(&self.vector(first + index), &range);
                let isometry = match (self.turns, turn) {
                    (Some(turns), Some(turn)) => {
                        let domain = Isometry::from_index(turns[first + index]);
                        domain.then(turn.inverse()).then(products.opposed())
                    }
                    _ => products.isometry(),
                };
                found(first + index, isometry);
            }
        }
    }

    fn vector(&self, index: usize) -> Vector {
        let numbers = self.groups[index / LANES].map(|lanes| lanes[index % LANES]);
        Vector { numbers: core::array::from_fn(|i| numbers[i]), norm: numbers[NORMS] }
    }
}

/// A range against all domains.
struct Comparison<'a> {
    groups: &'a [Group],
    reach: Reach,
    /// The range's numbers.
    spread: &'a [Lanes; 16],
    /// Whether one orientation is compared, or all are.
    canonical: bool,
}

impl Task for Comparison<'_> {
    type Output = heapless::Vec<usize, BEST>;

    /// The lanes are not named: the compiler makes them of loops, with whatever instructions it may use here.
    #[inline(always)]
    fn run<L: lanes::Lanes>(self) -> Self::Output {
        let Self { groups, reach, spread, canonical } = self;
        if canonical {
            best(groups, reach, |group| Products::of(group, spread).in_one_orientation())
        } else {
            best(groups, reach, |group| Products::of(group, spread).largest())
        }
    }
}

/// The best domains of the [`BEST`] best lanes, in the order of the domains; of a lane's the first of those with the highest score.
#[inline(always)]
fn best(groups: &[Group], reach: Reach, dots: impl Fn(&Group) -> Lanes) -> heapless::Vec<usize, BEST> {
    let (mut best, mut at) = ([0_i16; LANES], [0_u16; LANES]);
    for (number, group) in (0_u16..).zip(groups) {
        let scores = reach.scores(&dots(group), &group[NORMS]);
        for lane in 0..LANES {
            let better = scores[lane] > best[lane];
            best[lane] = if better { scores[lane] } else { best[lane] };
            at[lane] = if better { number } else { at[lane] };
        }
    }
    let mut lanes: [usize; LANES] = core::array::from_fn(|lane| lane);
    lanes.sort_unstable_by_key(|&lane| (-best[lane], at[lane], lane));
    let found = lanes[..BEST].iter().filter(|&&lane| best[lane] > 0);
    let mut found: heapless::Vec<_, BEST> = found.map(|&lane| usize::from(at[lane]) * LANES + lane).collect();
    found.sort_unstable();
    found
}

/// What a range of a certain contrast can make of a domain's.
#[derive(Clone, Copy)]
struct Reach {
    /// |D| of 16/15 of |R|, Q6: more is not needed.
    enough: i16,
    /// What brings `enough` near the top of 16 bits.
    shift: u32,
    /// 15/16 of 1/|R|, so that the product with a shifted |D| is the largest c, Q13.
    reciprocal: i16,
}

impl Reach {
    fn new(norm: i16) -> Self {
        let enough = (i32::from(norm.max(1)) * 16 / 15).min(i32::from(i16::MAX)) as i16;
        let shift = enough.leading_zeros() - 1;
        let reciprocal = ((1_i64 << 29) / (i64::from(enough) << shift)).min(i16::MAX.into()) as i16;
        Self { enough, shift, reciprocal }
    }

    /// c·(2t − c), Q12, of every t, Q14.
    #[inline(always)]
    fn scores(self, dots: &Lanes, norms: &Lanes) -> Lanes {
        each(|lane| {
            let half = product(norms[lane].min(self.enough).wrapping_shl(self.shift), self.reciprocal);
            let t = dots[lane];
            let c = t.min(half.wrapping_add(half));
            product(c, t.wrapping_add(t).wrapping_sub(c))
        })
    }
}

/// a·b of two Q15 in Q14, rounded down.
#[inline(always)]
const fn product(a: i16, b: i16) -> i16 {
    ((a as i32 * b as i32) >> 16) as i16
}

// The compiler makes vectors of 16-bit lanes of loops that do one thing to whole arrays, and of no others: half of the speed of
// the search hangs on it. That is also why a range's numbers are spread over all lanes.

#[inline(always)]
fn each(number: impl Fn(usize) -> i16) -> Lanes {
    let mut lanes = [0; LANES];
    for (lane, out) in lanes.iter_mut().enumerate() {
        *out = number(lane);
    }
    lanes
}

/// The sum of the products of the domains' and the range's numbers in `places`, Q14.
#[inline(always)]
fn dot<const N: usize>(group: &Group, range: &[Lanes; 16], places: [(usize, usize); N]) -> Lanes {
    each(|lane| {
        places.into_iter().fold(0_i16, |sum, (domain, place)| {
            sum.wrapping_add(product(group[domain][lane], range[place][lane]))
        })
    })
}

/// The sums of products of domains and a range, Q14.
#[derive(Clone, Copy)]
struct Products<T> {
    a1: T,
    a2: T,
    b1: T,
    b2: T,
    /// Epp, Epq, Eqp, Eqq; the domain's goes first.
    turned: [T; 4],
}

impl Products<Lanes> {
    #[inline(always)]
    fn of(group: &Group, range: &[Lanes; 16]) -> Self {
        let pairs = |d: usize, r: usize| dot(group, range, [8, 10, 12, 14].map(|i| (i + d, i + r)));
        Self {
            a1: dot(group, range, [(0, 0), (1, 1), (2, 2)]),
            a2: dot(group, range, [(3, 3)]),
            b1: dot(group, range, [(4, 4)]),
            b2: dot(group, range, [(5, 5), (6, 6), (7, 7)]),
            turned: [pairs(0, 0), pairs(0, 1), pairs(1, 0), pairs(1, 1)],
        }
    }

    #[inline(always)]
    fn lane(&self, lane: usize) -> Products<i16> {
        let Self { a1, a2, b1, b2, turned } = self;
        let turned = [turned[0][lane], turned[1][lane], turned[2][lane], turned[3][lane]];
        Products { a1: a1[lane], a2: a2[lane], b1: b1[lane], b2: b2[lane], turned }
    }

    /// The largest |dot| of the eight orientations, Q14.
    #[inline(always)]
    fn largest(&self) -> Lanes {
        each(|lane| self.lane(lane).largest())
    }

    /// The |dot| of the orientation in which both gradients agree, Q14.
    #[inline(always)]
    fn in_one_orientation(&self) -> Lanes {
        each(|lane| {
            let (p, e) = self.lane(lane).dots()[0];
            p.wrapping_abs().wrapping_add(e)
        })
    }
}

impl Products<i16> {
    fn of_one(domain: &Vector, range: &Vector) -> Self {
        let mut group = [[0; LANES]; 17];
        group.iter_mut().zip(domain.numbers).for_each(|(lanes, number)| lanes[0] = number);
        Products::of(&group, &range.numbers.map(|number| [number; LANES])).lane(0)
    }

    /// P and E of the four pairs of orientations: by 0° and 180°, by 90° and 270°, mirrored along the axes, mirrored along the diagonals.
    #[inline(always)]
    const fn dots(self) -> [(i16, i16); 4] {
        let Self { a1, a2, b1, b2, turned: [pp, pq, qp, qq] } = self;
        let (rotations, mirrors) = (a1.wrapping_add(a2), a1.wrapping_sub(a2));
        let (axes, diagonals) = (b1.wrapping_add(b2), b1.wrapping_sub(b2));
        [
            (rotations.wrapping_add(axes), pp.wrapping_add(qq)),
            (rotations.wrapping_sub(axes), pq.wrapping_sub(qp)),
            (mirrors.wrapping_add(diagonals), pp.wrapping_sub(qq)),
            (mirrors.wrapping_sub(diagonals), pq.wrapping_add(qp)),
        ]
    }

    #[inline(always)]
    fn largest(self) -> i16 {
        let [a, b, c, d] = self.dots().map(|(p, e)| p.wrapping_abs().wrapping_add(e.wrapping_abs()));
        a.max(b).max(c.max(d))
    }

    /// The orientation of the largest |dot|, of equals the first.
    fn isometry(self) -> Isometry {
        /// Where P and E have the same sign, and where they have not.
        const ISOMETRIES: [[u8; 2]; 4] = [[0, 3], [6, 5], [2, 1], [4, 7]];
        let (mut best, mut isometry) = (-1, 0);
        for ((p, e), pair) in self.dots().into_iter().zip(ISOMETRIES) {
            let size = p.wrapping_abs().wrapping_add(e.wrapping_abs());
            if size > best {
                (best, isometry) = (size, pair[usize::from((p < 0) != (e < 0))]);
            }
        }
        Isometry::from_index(isometry)
    }

    /// The turn that is left where both were turned into their canonical orientation: for a negative contrast the gradients, whose E is never
    /// the smaller, agree after half a turn.
    fn opposed(self) -> Isometry {
        let (p, _) = self.dots()[0];
        Isometry::from_index(if p < 0 { 3 } else { 0 })
    }
}

/// A block's 16 numbers, Q15, and its norm, Q6, as in [`Group`].
#[derive(Clone, Copy)]
struct Vector {
    numbers: [i16; 16],
    norm: i16,
}

impl Vector {
    fn of(block: &Block) -> Self {
        let numbers = in_basis(means(block));
        let norm = numbers.iter().map(|x| (x * x) as u64).sum::<u64>().isqrt().max(1) as i64;
        // The numbers are 32 times those of the 4 × 4 means, times the pixels of one.
        let pixels = (block.side() * block.side() / 16) as i64;
        Self {
            numbers: numbers.map(|x| (x * i64::from(i16::MAX) / norm) as i16),
            norm: (2 * norm / pixels).min(i16::MAX.into()) as i16,
        }
    }

    /// The isometry that turns the gradient into the first eighth of the plane.
    fn canonical(&self) -> Isometry {
        let sum = |first: usize| (first..16).step_by(2).map(|i| i32::from(self.numbers[i])).sum::<i32>();
        let (p, q) = (sum(8), sum(9));
        let sign = |x: i32| if x < 0 { -1 } else { 1 };
        Isometry::of(if p.abs() >= q.abs() { [sign(p), 0, 0, sign(q)] } else { [0, sign(q), sign(p), 0] })
    }

    fn turned(&self, isometry: Isometry) -> Self {
        let [a, b, c, d] = isometry.matrix().map(i16::from);
        let axes = if a == 0 { -1 } else { 1 };
        let rotation = a * d - b * c;
        let mut turned = self.numbers;
        turned[3] *= rotation;
        turned[4] *= axes;
        turned[5..8].iter_mut().for_each(|x| *x *= rotation * axes);
        for pair in turned[8..].as_chunks_mut::<2>().0 {
            let [p, q] = *pair;
            *pair = [a * p + b * q, c * p + d * q];
        }
        Self { numbers: turned, norm: self.norm }
    }
}

/// The 4 × 4 means, 16 times as large and free of the mean over all.
fn means(block: &Block) -> [i64; 16] {
    let (side, cell) = (block.side(), block.side() / 4);
    let mut sums = [0_i64; 16];
    for (v, row) in block.levels().chunks_exact(side).enumerate() {
        for (u, pixels) in row.chunks_exact(cell).enumerate() {
            sums[v / cell * 4 + u] += pixels.iter().map(|&z| i64::from(z)).sum::<i64>();
        }
    }
    sums.map(|sum| 16 * sum - i64::from(block.sum))
}

/// Twice the numbers of a 4 × 4 block in the basis of [`Group`], which is orthonormal.
///
/// The four corners, and the four in the middle, are at (±a, ±a); of the other eight, four lie at (±3, ±1) and four at (±1, ±3). On each four
/// live 1, the sign of x, the sign of y, and the product of both.
fn in_basis(z: [i64; 16]) -> [i64; 16] {
    let four = |[a, b, c, d]: [usize; 4]| {
        let [a, b, c, d] = [z[a], z[b], z[c], z[d]];
        [a + b + c + d, b + d - a - c, c + d - a - b, a + d - b - c]
    };
    let [corner, middle] = [four([0, 3, 12, 15]), four([5, 6, 9, 10])];
    let [wide, tall] = [four([4, 7, 8, 11]), four([1, 2, 13, 14])];
    // By 1/√2: these numbers are made of eight.
    let halved = |x: i64| (x * 46_341) >> 16;
    [
        corner[0],
        middle[0],
        halved(wide[0] + tall[0]),
        halved(wide[3] - tall[3]),
        halved(wide[0] - tall[0]),
        corner[3],
        middle[3],
        halved(wide[3] + tall[3]),
        corner[1],
        corner[2],
        middle[1],
        middle[2],
        wide[1],
        tall[2],
        tall[1],
        wide[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn block(levels: &[u8], side: usize) -> Block {
        Block::at(levels, side, 0, 0, side)
    }

    /// The correlation of two blocks as it is defined.
    fn correlation(a: &[u8], b: &[u8]) -> f64 {
        let free = |block: &[u8]| {
            let mean = block.iter().map(|&z| f64::from(z)).sum::<f64>() / block.len() as f64;
            block.iter().map(|&z| f64::from(z) - mean).collect::<Vec<_>>()
        };
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let (a, b) = (free(a), free(b));
        dot(&a, &b) / (dot(&a, &a) * dot(&b, &b)).sqrt().max(1e-9)
    }

    /// Neither block flat.
    fn levels() -> impl Strategy<Value = Vec<u8>> {
        proptest::collection::vec(any::<u8>(), 16).prop_filter("flat", |block| {
            let (least, most) = (block.iter().min(), block.iter().max());
            most.zip(least).is_some_and(|(most, least)| most - least > 30)
        })
    }

    proptest! {
        #[test]
        fn the_best_of_eight_orientations_is_that_of_the_definition(range in levels(), domain in levels()) {
            let (r, d) = (block(&range, 4), block(&domain, 4));
            let dots: Vec<f64> = (0..8).map(|j| {
                let turned = d.turned(Isometry::from_index(j).strides(0, 4, 4));
                correlation(turned.levels(), &range).abs()
            }).collect();
            let best = dots.iter().copied().fold(0.0, f64::max);
            let products = Products::of_one(&Vector::of(&d), &Vector::of(&r));
            let got = f64::from(products.largest()) / 16_384.0;
            prop_assert!((got - best).abs() < 0.002, "{got} for {best}");
            let chosen = dots[usize::from(products.isometry().index())];
            prop_assert!(chosen > best - 0.003, "chose {chosen} where {best} is best");
        }

        #[test]
        fn turned_blocks_have_one_canonical_vector(domain in levels(), j in 0_u8..8) {
            let d = block(&domain, 4);
            let turned = d.turned(Isometry::from_index(j).strides(0, 4, 4));
            let [a, b] = [d, turned].map(|block| {
                let vector = Vector::of(&block);
                vector.turned(vector.canonical())
            });
            let dot = Products::of_one(&a, &b);
            let (p, e) = dot.dots()[0];
            // Where the gradient lies on the border of two eighths, rounding may choose either.
            let gradient = |v: &Vector| (8..16).step_by(2).fold((0, 0), |(p, q), i| {
                (p + i32::from(v.numbers[i]), q + i32::from(v.numbers[i + 1]))
            });
            let (gp, gq) = gradient(&a);
            prop_assume!(gq > 50 && gp - gq > 50);
            prop_assert!(i32::from(p) + i32::from(e) > 16_300, "{p} + {e}");
        }
    }
}
