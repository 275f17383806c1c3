//! The quadtree: which ranges there are, and which domain describes each.

use super::{
    Code, LARGEST, Leaf, SMALLEST, Search,
    block::{Block, Fit},
    contract,
    search::{self, Finder},
    slot,
};
use crate::{
    effect::{
        StorageTooSmall,
        storage::{take, words},
    },
    frame::Size,
};

/// How a picture is coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Where domains are looked for.
    pub search: Search,
    /// A range whose error is larger than this is cut in four, while it can be: the root of the mean square, in levels, Q4.
    pub tolerance_q4: u16,
    /// The side of the smallest ranges: 4, 8 or 16.
    pub smallest: u8,
}

impl Default for Options {
    /// A tolerance of 8, which is that of the published comparisons of coders.
    fn default() -> Self {
        Self { search: Search::default(), tolerance_q4: 8 << 4, smallest: SMALLEST as u8 }
    }
}

impl Options {
    /// Whether ranges of `side` are not cut.
    fn is_last(&self, side: usize) -> bool {
        side <= usize::from(self.smallest).max(SMALLEST)
    }

    /// The largest error of a range that is not cut in four, Q20.
    const fn allowed(&self, side: usize) -> u64 {
        let tolerance = self.tolerance_q4 as u64;
        (tolerance * tolerance * (side * side) as u64) << 12
    }
}

/// The most leaves of a plane of `size`.
pub const fn most_leaves(size: Size) -> usize {
    size.pixels() / (SMALLEST * SMALLEST)
}

/// Words of 64 bits that [`encode`] needs for a plane of `size` besides the leaves.
pub const fn scratch_len(size: Size, search: Search) -> usize {
    words::<u8>(size.pixels() / 4) + search::pool_len(size, search)
}

/// Codes the `levels` of a plane of `size`, a size that [`super::plane_size`] gave, into `leaves`, which holds [`most_leaves`]. `progress` is told
/// how many of the plane's pixels have become part of a leaf, after every row of ranges.
///
/// # Errors
/// If `scratch` is shorter than [`scratch_len`].
///
/// # Panics
/// If the lengths of `levels` or `leaves` are not those of the plane.
pub fn encode<'a>(
    levels: &[u8],
    size: Size,
    options: &Options,
    scratch: &mut [u64],
    leaves: &'a mut [Leaf],
    mut progress: impl FnMut(usize),
) -> Result<Code<'a>, StorageTooSmall> {
    assert_eq!(levels.len(), size.pixels(), "the plane does not have its size");
    assert_eq!(leaves.len(), most_leaves(size), "the leaves do not have their most");
    let too_small = StorageTooSmall { needed: scratch_len(size, options.search), got: scratch.len() };
    if too_small.got < too_small.needed {
        return Err(too_small);
    }
    let mut memory = scratch;
    let contracted = take::<u8>(&mut memory, size.pixels() / 4).ok_or(too_small)?;
    contract(levels, size.width as usize, contracted);
    let planes = Planes { levels, contracted, size };
    leaves.fill(Leaf::default());
    let mut done = 0;
    let mut side = LARGEST;
    while side >= SMALLEST {
        let mut finder = Finder::new(&planes, side, options.search, &mut *memory);
        for y in (0..size.height as usize).step_by(side) {
            for x in (0..size.width as usize).step_by(side) {
                let first = slot(x, y, size);
                let places = &mut leaves[first..first + (side / SMALLEST).pow(2)];
                if settle(&planes, &mut finder, options, (x, y), side, places) {
                    done += side * side;
                }
            }
            progress(done);
        }
        if options.is_last(side) {
            break;
        }
        side /= 2;
    }
    Ok(Code { plane: size, leaves: compacted(leaves) })
}

/// Makes the range of `side` at (x, y) one leaf, in `places`, if it is not cut yet and need not be.
fn settle(
    planes: &Planes<'_>,
    finder: &mut Finder<'_>,
    options: &Options,
    (x, y): (usize, usize),
    side: usize,
    places: &mut [Leaf],
) -> bool {
    if places[0].side != 0 {
        return false;
    }
    let (leaf, error) = best(planes, finder, x, y, side);
    let settled = options.is_last(side) || error <= options.allowed(side);
    if settled {
        places.iter_mut().for_each(|place| place.side = Leaf::COVERED);
        places[0] = leaf;
    }
    settled
}

/// Brings the leaves of the block of [`LARGEST`] pixels at `corner` up to date with `levels` and their contraction. While all describe their ranges to
/// 3/2 of the tolerance they stay; the smallest are good for anything. Else the block is coded anew by the domains around its ranges, as they are: turning
/// them about takes eight times as long, and nothing of it is seen in what moves.
///
/// A block whose leaves are all small costs nothing; another, an evaluation of each larger leaf.
pub(in super::super) fn follow(
    levels: &[u8],
    contracted: &[u8],
    size: Size,
    options: &Options,
    corner: (usize, usize),
    leaves: &mut [Leaf],
) {
    let planes = Planes { levels, contracted, size };
    let stays = |leaf: &Leaf| {
        let (x, y, side) = leaf.range();
        side == SMALLEST || {
            let range = Block::at(levels, size.width as usize, x, y, side);
            4 * Candidate::evaluate(&planes, &range, *leaf).error <= 9 * options.allowed(side)
        }
    };
    if leaves[0].side != 0 && leaves.iter().filter(|leaf| leaf.is_range()).all(stays) {
        return;
    }
    leaves.fill(Leaf::default());
    for side in [16, 8, 4] {
        for (i, places) in leaves.chunks_exact_mut((side / SMALLEST).pow(2)).enumerate() {
            // The order of the quadtree: quarters, then cells.
            let (x, y) = match side {
                16 => (0, 0),
                8 => (i & 1, i >> 1),
                _ => ((i & 4) >> 1 | i & 1, (i & 8) >> 2 | (i & 2) >> 1),
            };
            let place = (corner.0 + x * side, corner.1 + y * side);
            settle(&planes, &mut Finder::Around, options, place, side, places);
        }
    }
}

/// What is coded.
pub(super) struct Planes<'a> {
    pub(super) levels: &'a [u8],
    pub(super) contracted: &'a [u8],
    pub(super) size: Size,
}

impl Planes<'_> {
    /// The domain of a leaf, as its range sees it.
    fn domain(&self, leaf: Leaf) -> Block {
        Block::read(self.contracted, leaf.strides(self.size.width as usize / 2), leaf.side.into())
    }
}

/// Ranges whose levels deviate by less than this are flat: any domain would do, and the one around them leaves skies smooth where
/// others turn them into chequers.
const FLAT_DEVIATION: u64 = 3;

/// The best leaf of a range, with its error, Q20.
fn best(planes: &Planes<'_>, finder: &mut Finder<'_>, x: usize, y: usize, side: usize) -> (Leaf, u64) {
    let range = Block::at(planes.levels, planes.size.width as usize, x, y, side);
    let concentric = Leaf::concentric(x as u16, y as u16, side as u8, planes.size);
    let mut best = Candidate::evaluate(planes, &range, concentric);
    let pixels = (side * side) as u64;
    if range.spread() >= FLAT_DEVIATION * FLAT_DEVIATION * pixels * pixels {
        finder.candidates(planes, &range, (x, y), |domain_x, domain_y, isometry| {
            let leaf = Leaf { domain_x, domain_y, isometry, ..concentric };
            let candidate = Candidate::evaluate(planes, &range, leaf);
            if candidate.error < best.error && candidate.leaf.contrast != 0 {
                best = candidate;
            }
        });
    }
    if !matches!(finder, Finder::Around) {
        best = Candidate::finest(planes, &range, best.leaf);
    }
    (best.leaf, best.error)
}

/// A leaf with its error, Q20.
struct Candidate {
    leaf: Leaf,
    error: u64,
}

impl Candidate {
    /// `leaf` with its best contrast and brightness.
    fn evaluate(planes: &Planes<'_>, range: &Block, leaf: Leaf) -> Self {
        Self::new(leaf, Fit::new(range, &planes.domain(leaf)))
    }

    /// The same, with more care.
    fn finest(planes: &Planes<'_>, range: &Block, leaf: Leaf) -> Self {
        Self::new(leaf, Fit::finest(range, &planes.domain(leaf)))
    }

    const fn new(leaf: Leaf, Fit { contrast, brightness, error }: Fit) -> Self {
        Self { leaf: Leaf { contrast, brightness, ..leaf }, error }
    }
}

/// The leaves without the places that are none.
fn compacted(leaves: &mut [Leaf]) -> &[Leaf] {
    let mut count = 0;
    for i in 0..leaves.len() {
        if leaves[i].side != Leaf::COVERED {
            leaves[count] = leaves[i];
            count += 1;
        }
    }
    &leaves[..count]
}
