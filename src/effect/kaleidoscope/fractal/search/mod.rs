//! Where the domain of a range is looked for.
//!
//! Domains start at every second pixel of the contracted plane, which is every fourth of the picture.

mod classes;
mod matched;

use super::{block::Block, coder::Planes, isometry::Isometry};
use crate::frame::Size;
use classes::Classes;
use matched::Matched;

/// Where domains are looked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Search {
    /// Nowhere: the domain around the range, in all orientations.
    None,
    /// Among 7 × 7 domains around the range, in all orientations.
    #[default]
    Local,
    /// Everywhere in all orientations, by a matched filter whose best 8 are compared exactly.
    Filter8,
    /// Everywhere in the one orientation in which the gradients agree, by the same filter: half the time.
    FilterC,
    /// Everywhere among domains of the same of Fisher's 72 classes, all of which are compared exactly.
    Classes72,
}

named!(
    Search,
    "search",
    None = "none",
    Local = "local",
    Filter8 = "filter8",
    FilterC = "filterC",
    Classes72 = "classes72"
);

/// Pixels of the contracted plane from domain to domain.
const STEP: usize = 2;

/// Domains to each side of the one around the range in [`Search::Local`].
const LOCAL_REACH: isize = 3;

/// The domains of one side.
#[derive(Clone, Copy, Debug)]
struct Pool {
    side: usize,
    columns: usize,
    rows: usize,
}

impl Pool {
    const fn new(plane: Size, side: usize) -> Self {
        const fn count(length: u32, side: usize) -> usize {
            (length as usize / 2 - side) / STEP + 1
        }
        Self { side, columns: count(plane.width, side), rows: count(plane.height, side) }
    }

    const fn len(self) -> usize {
        self.columns * self.rows
    }

    /// Where the domain of an index starts in the contracted plane.
    const fn place(self, index: usize) -> (usize, usize) {
        (index % self.columns * STEP, index / self.columns * STEP)
    }

    fn block(self, planes: &Planes<'_>, index: usize) -> Block {
        let (x, y) = self.place(index);
        Block::at(planes.contracted, planes.size.width as usize / 2, x, y, self.side)
    }
}

/// Words of 64 bits that a search takes in a plane of `size`.
pub(super) const fn pool_len(size: Size, search: Search) -> usize {
    // There are most of the smallest.
    let count = Pool::new(size, super::SMALLEST).len();
    match search {
        Search::None | Search::Local => 0,
        Search::Filter8 | Search::FilterC => matched::len(count),
        Search::Classes72 => classes::len(count),
    }
}

/// Finds candidates for ranges of one side.
#[expect(clippy::large_enum_variant, reason = "one is there at a time, on the stack")]
pub(super) enum Finder<'a> {
    /// None but the domain around the range, upright, which is always compared.
    Around,
    Concentric,
    Local,
    Matched(Matched<'a>),
    Classes(Classes<'a>),
}

impl<'a> Finder<'a> {
    /// Looks at all domains once. `memory` holds [`pool_len`] words.
    pub(super) fn new(planes: &Planes<'_>, side: usize, search: Search, memory: &'a mut [u64]) -> Self {
        let pool = Pool::new(planes.size, side);
        match search {
            Search::None => Self::Concentric,
            Search::Local => Self::Local,
            Search::Filter8 => Self::Matched(Matched::new(planes, pool, false, memory)),
            Search::FilterC => Self::Matched(Matched::new(planes, pool, true, memory)),
            Search::Classes72 => Self::Classes(Classes::new(planes, pool, memory)),
        }
    }

    /// Tells `found` the places and isometries that are worth an exact comparison.
    pub(super) fn candidates(
        &mut self,
        planes: &Planes<'_>,
        range: &Block,
        (x, y): (usize, usize),
        mut found: impl FnMut(u16, u16, u8),
    ) {
        match self {
            Self::Around => {}
            Self::Concentric => local(planes, range.side(), (x, y), 0, found),
            Self::Local => local(planes, range.side(), (x, y), LOCAL_REACH, found),
            Self::Matched(matched) => matched.candidates(range, |index, isometry| {
                let (x, y) = matched.pool.place(index);
                found(x as u16, y as u16, isometry.index());
            }),
            Self::Classes(classes) => classes.candidates(range, |index, isometry| {
                let (x, y) = classes.pool.place(index);
                found(x as u16, y as u16, isometry.index());
            }),
        }
    }
}

/// The domains up to `reach` steps from the one around the range at (x, y).
fn local(
    planes: &Planes<'_>,
    side: usize,
    (x, y): (usize, usize),
    reach: isize,
    mut found: impl FnMut(u16, u16, u8),
) {
    let middle = super::Leaf::concentric(x as u16, y as u16, side as u8, planes.size);
    let most = |length: u32| length as isize / 2 - side as isize;
    let places = |at: u16, length: u32| {
        (-reach..=reach)
            .map(move |i| at as isize + i * STEP as isize)
            .filter(move |place| (0..=most(length)).contains(place))
    };
    for domain_y in places(middle.domain_y, planes.size.height) {
        for domain_x in places(middle.domain_x, planes.size.width) {
            (0..Isometry::COUNT).for_each(|j| found(domain_x as u16, domain_y as u16, j));
        }
    }
}
