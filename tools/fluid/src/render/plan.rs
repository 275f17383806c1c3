//! Which patches hang together, when each starts, and how much of each is seen at every pixel.

use crate::label::{Grid, Labelling};
use crate::patch::{PatchRef, SIDE, STRIDE};

/// Levels of the pyramid on which patches are blended.
pub(super) const LEVELS: usize = 4;

/// Half the width of the fade between neighbours, in pixels, on every level: fine detail changes over quickly, lest two textures lie over
/// each other; a broad change takes the whole overlap.
const FADES: [f32; LEVELS] = [5.0, 8.0, 12.0, 12.0];

/// Where neighbours leave more than this of a pixel to nobody, what is there is let fade out.
const LEAST: f32 = 0.2;

/// Neighbours whose places in a video are this near to being neighbours there show the same pixels, so that their changes add up as they
/// are and not as noise does.
const SAME_PIXELS: i32 = 2;

/// Neighbours whose places are this near go by the same clock; a patch that is merely repeated does not.
const SAME_TIME: i32 = STRIDE as i32 - 4;

/// A patch of the picture that was given one of a video.
#[derive(Clone, Debug)]
pub(super) struct Laid {
    /// Column and row in the grid.
    pub(super) place: (usize, usize),
    /// What it was given.
    pub(super) patch: PatchRef,
    /// When it starts in its loop, in clips: 0..1.
    pub(super) start: f32,
    /// The share of its neighbours that show the same pixels as itself: broad changes may be kept.
    pub(super) company: f32,
    /// How much of it is seen, on every level.
    pub(super) weights: [Vec<f32>; LEVELS],
}

/// All of them, row by row.
pub(super) fn plan(labelling: &Labelling) -> Vec<Laid> {
    let grid = labelling.grid;
    let sames = Sets::of(labelling, SAME_PIXELS);
    let times = Sets::of(labelling, SAME_TIME);
    let profiles = FADES.map(profile);
    let laid = labelling.patches.iter().enumerate().filter_map(|(index, patch)| {
        let patch = (*patch)?;
        let place = (index % grid.columns, index / grid.columns);
        let near: Vec<_> =
            neighbours(grid, place).filter(|&(_, other)| labelling.patches[other].is_some()).collect();
        let alike = near.iter().filter(|&&(_, other)| sames.root(other) == sames.root(index)).count();
        let weights = core::array::from_fn(|level| weights(&profiles[level], level, index, &near, &sames));
        // Multiples of the golden ratio spread evenly, however many there are.
        let start = (times.root(index) as f32 * 0.618_034).fract();
        Some(Laid { place, patch, start, company: alike as f32 / near.len().max(1) as f32, weights })
    });
    laid.collect()
}

/// How much of a patch is seen along one axis of a level, before its neighbours are asked.
fn profile(fade: f32) -> [f32; SIDE] {
    core::array::from_fn(|i| {
        let distance = (i as f32 - (SIDE as f32 - 1.0) / 2.0).abs();
        let t = ((STRIDE as f32 / 2.0 + fade - distance) / (2.0 * fade)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    })
}

/// The weights of patch `index` on a level. The sum of changes that know nothing of each other varies by the root of the sum of squares.
fn weights(
    profile: &[f32; SIDE],
    level: usize,
    index: usize,
    near: &[((i32, i32), usize)],
    sames: &Sets,
) -> Vec<f32> {
    let side = SIDE >> level;
    let at = |position: i32| {
        usize::try_from(position).ok().and_then(|position| profile.get(position)).copied().unwrap_or(0.0)
    };
    let own = sames.root(index);
    let weight = |i: usize| {
        let (x, y) = (((i % side) << level) as i32, ((i / side) << level) as i32);
        let mine = at(x) * at(y);
        let mut groups = vec![(own, mine)];
        for &((column, row), other) in near {
            let share = at(x - column * STRIDE as i32) * at(y - row * STRIDE as i32);
            if share > 0.0 {
                let root = sames.root(other);
                match groups.iter_mut().find(|(group, _)| *group == root) {
                    Some((_, sum)) => *sum += share,
                    None => groups.push((root, share)),
                }
            }
        }
        let power: f32 = groups.iter().map(|(_, sum)| sum * sum).sum();
        mine / power.sqrt().max(LEAST)
    };
    (0..side * side).map(weight).collect()
}

/// The up to eight neighbours of a place: how far to the right and down, and their index.
pub(super) fn neighbours(
    grid: Grid,
    (column, row): (usize, usize),
) -> impl Iterator<Item = ((i32, i32), usize)> {
    let around =
        (-1..=1).flat_map(|down| (-1..=1).map(move |right| (right, down))).filter(|&offset| offset != (0, 0));
    around.filter_map(move |(right, down)| {
        let column = column.checked_add_signed(right as isize).filter(|&column| column < grid.columns)?;
        let row = row.checked_add_signed(down as isize).filter(|&row| row < grid.rows)?;
        Some(((right, down), row * grid.columns + column))
    })
}

/// Sets of neighbours that belong together.
struct Sets(Vec<usize>);

impl Sets {
    /// Neighbours whose patches lie within `reach` pixels of where neighbours would lie in their video.
    fn of(labelling: &Labelling, reach: i32) -> Self {
        let grid = labelling.grid;
        let mut sets = Self((0..labelling.patches.len()).collect());
        for (index, patch) in labelling.patches.iter().enumerate() {
            let Some(patch) = patch else { continue };
            for ((right, down), other) in neighbours(grid, (index % grid.columns, index / grid.columns)) {
                let Some(neighbour) = labelling.patches[other] else { continue };
                let x = i32::from(neighbour.x) - i32::from(patch.x) - right * STRIDE as i32;
                let y = i32::from(neighbour.y) - i32::from(patch.y) - down * STRIDE as i32;
                let one = (patch.video, patch.version) == (neighbour.video, neighbour.version);
                if one && x.abs() <= reach && y.abs() <= reach {
                    let (a, b) = (sets.root(index), sets.root(other));
                    sets.0[a.max(b)] = a.min(b);
                }
            }
        }
        sets
    }

    /// The least member of the set that `index` belongs to.
    fn root(&self, mut index: usize) -> usize {
        while self.0[index] != index {
            index = self.0[index];
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::Version;

    fn labelling(columns: usize, patches: &[Option<(u32, i16, i16)>]) -> Labelling {
        let version = Version::all().next().expect("there is a first version");
        let patches = patches
            .iter()
            .map(|patch| patch.map(|(video, x, y)| PatchRef { video, version, x, y }))
            .collect::<Vec<_>>();
        Labelling { grid: Grid { columns, rows: patches.len() / columns }, patches }
    }

    /// The sum over the patches of their weights at a pixel of level 0, and that of their squares.
    fn sums(laid: &[Laid], x: usize, y: usize) -> (f32, f32) {
        let inside = |laid: &Laid| {
            let (x, y) = (x.checked_sub(laid.place.0 * STRIDE)?, y.checked_sub(laid.place.1 * STRIDE)?);
            (x < SIDE && y < SIDE).then(|| laid.weights[0][y * SIDE + x])
        };
        laid.iter()
            .filter_map(inside)
            .fold((0.0, 0.0), |(sum, squares), weight| (sum + weight, squares + weight * weight))
    }

    #[test]
    fn neighbours_that_continue_each_other_are_shown_as_they_are() {
        let laid =
            plan(&labelling(2, &[Some((1, 0, 0)), Some((1, 24, 0)), Some((1, 0, 24)), Some((1, 24, 24))]));
        assert!(laid.iter().all(|one| one.start == laid[0].start && one.company == 1.0));
        for (x, y) in [(30, 30), (36, 33), (36, 36)] {
            assert!((sums(&laid, x, y).0 - 1.0).abs() < 1e-4, "at {x}, {y}");
        }
    }

    #[test]
    fn strangers_keep_the_contrast_of_one() {
        let laid =
            plan(&labelling(2, &[Some((1, 0, 0)), Some((2, 24, 0)), Some((3, 0, 24)), Some((4, 24, 24))]));
        for (x, y) in [(30, 30), (36, 33), (36, 36)] {
            assert!((sums(&laid, x, y).1 - 1.0).abs() < 1e-4, "at {x}, {y}");
        }
    }

    #[test]
    fn a_patch_that_is_repeated_starts_at_another_time() {
        let laid = plan(&labelling(2, &[Some((1, 0, 0)), Some((1, 0, 0))]));
        assert_ne!(laid[0].start, laid[1].start);
    }

    #[test]
    fn places_without_a_fluid_are_left_out() {
        assert_eq!(plan(&labelling(2, &[None, Some((1, 0, 0))])).len(), 1);
    }
}
