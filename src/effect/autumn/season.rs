//! The season on the symbol space: which twig is how far at which time.
//!
//! The paper's eq. 15: the shift operator S_i removes the leading symbol of the addresses that start with i; i is chosen anew each
//! step, with probability p_i. K symbols removed of M are stage 6K/M of a twig. Departs from the paper:
//!
//! 1. The draw is a smooth weighted round robin that the whole tree shares, so that boughs turn together; with the probability
//!    1 − patchiness a twig takes a draw of its own instead: strays.
//! 2. Shade delays: by 6(1 − L) steps, L the share of sunlight that comes through to the twig.
//! 3. Steps are not stages. The clock maps a stage t of the tree to the step where the mean of K/M is t/6, between steps in
//!    proportion: with steps for a clock the tree is red for half of the season.
//! 4. Leaves fall, each once its own colours are done. The paper leaves that open.

use super::species::Species;
use crate::math::{Factor, random::scatter};
use bytemuck::{Pod, Zeroable};

/// The most symbols of an address.
pub(super) const MOST_SYMBOLS: usize = 11;

/// Steps after which every symbol is removed, come what may: no species of the program takes more than 70.
const LAST_STEP: u32 = 200;

/// Fractional bits of a step.
const STEP_BITS: u32 = 8;

/// The most steps by which shade delays a twig: the paper has no number; with 6 the inner leaves are a stage behind.
const MOST_DELAY: u32 = 6 << STEP_BITS;

/// Where in the season a tree is: 0 is green, 6 has all the colour (the paper's seven stages), 7 is bare.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Stage(u16);

impl Stage {
    const BITS: u32 = 12;
    /// No leaf has turned.
    pub const GREEN: Self = Self(0);
    /// All colours are there.
    pub const COLOURED: Self = Self(6 << Self::BITS);
    /// All leaves are gone.
    pub const BARE: Self = Self(7 << Self::BITS);

    /// The stage `stage`, 0..=7, in steps of 2^-12.
    pub fn new(stage: Factor) -> Self {
        let bits = stage.to_bits() >> (Factor::FRAC_NBITS - Self::BITS);
        Self(bits.clamp(0, Self::BARE.0.into()) as u16)
    }

    /// The stage at `done` of `whole` parts of the way from this one to `other`.
    #[must_use]
    pub fn towards(self, other: Self, done: u64, whole: u64) -> Self {
        let whole = whole.max(1);
        let way = i128::from(other.0) - i128::from(self.0);
        let gone = way * i128::from(done.min(whole)) / i128::from(whole);
        Self((i128::from(self.0) + gone) as u16)
    }
}

impl core::str::FromStr for Stage {
    type Err = &'static str;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let stage = word.parse::<Factor>().ok();
        let stage = stage.filter(|stage| (Factor::ZERO..=Factor::from_num(7)).contains(stage));
        stage.map(Self::new).ok_or("a stage is 0 (green) to 6 (all colours) or 7 (bare), like 3.5")
    }
}

/// When a twig turns and drops.
#[derive(Clone, Copy, Debug, Zeroable, Pod)]
#[repr(C)]
pub(super) struct Calendar {
    /// The step at which each of its M symbols is removed, in steps of 2^-8.
    removals: [u16; MOST_SYMBOLS],
    /// The stage of the tree at which its leaves fall.
    fall: u16,
}

impl Calendar {
    /// K, in steps of 2^-8, at the time `step`. A removal takes a step of time, and ends at its own.
    fn removed(&self, step: u32, depth: usize) -> u32 {
        let done = |&end: &u16| (step + (1 << STEP_BITS)).saturating_sub(end.into()).min(1 << STEP_BITS);
        self.removals[..depth].iter().map(done).sum()
    }
}

/// Mean K/M of the tree at whole steps, 0..=2^16.
pub(super) type Knots = [u32; KNOTS];
/// Every step, and the longest delay.
const KNOTS: usize = (LAST_STEP + (MOST_DELAY >> STEP_BITS) + 1) as usize;

/// What decides when a leaf turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Turning {
    /// The shift operator, and the sunlight (the paper's fig. 6 and 11).
    #[default]
    Shifts,
    /// The sunlight alone (fig. 5).
    Sunlight,
    /// Nothing: all leaves have one colour, and change it together (fig. 13).
    Together,
}

named!(Turning, "turning", Shifts = "shifts", Sunlight = "sunlight", Together = "together");

/// How the season runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    pub(super) turning: Turning,
    /// With which probability a twig follows the draw of the whole tree, of 2^16.
    pub(super) patchiness: u32,
    pub(super) seed: u64,
    pub(super) leaf_fall: bool,
}

impl Course {
    pub(super) fn of(settings: &super::Settings) -> Self {
        let patchiness = (settings.patchiness.to_bits() >> (Factor::FRAC_NBITS - 16)).max(0) as u32;
        Self { turning: settings.turning, patchiness, seed: settings.seed, leaf_fall: settings.leaf_fall }
    }
}

/// Fills the calendars of all twigs, of which `sunlight` holds the L, 255 being all light.
pub(super) fn fill(
    calendars: &mut [Calendar],
    sunlight: &[u8],
    knots: &mut Knots,
    species: &Species,
    course: Course,
) {
    let shared = shared_draws(species);
    for (twig, (calendar, &light)) in calendars.iter_mut().zip(sunlight).enumerate() {
        let delay = (255 - u32::from(light)) * MOST_DELAY / 255;
        turn(calendar, twig, delay, &shared, species, course);
    }
    calibrate(calendars, knots, species.depth as usize);
    let depth = species.depth as usize;
    for (twig, calendar) in calendars.iter_mut().enumerate() {
        calendar.fall = fall(calendar, twig, knots, depth, course);
    }
}

/// The draws of the whole tree: each symbol as often as its chance says, and as evenly spread as can be.
fn shared_draws(species: &Species) -> [u8; LAST_STEP as usize] {
    let mut credit = [0_i32; super::lsystem::MOST_BOUGHS];
    core::array::from_fn(|_| {
        let mut best = 0;
        for (i, chance) in species.chances.iter().enumerate() {
            credit[i] += chance;
            if credit[i] > credit[best] {
                best = i;
            }
        }
        credit[best] -= 1 << 16;
        best as u8
    })
}

/// A draw of its own, by `chance` of 0..2^16.
fn own_draw(species: &Species, chance: i32) -> u8 {
    let mut left = chance;
    let drawn = species.chances.iter().position(|chance| {
        left -= chance;
        left < 0
    });
    drawn.unwrap_or(species.chances.len() - 1) as u8
}

/// The symbols of a twig's address, the leading one first.
pub(super) fn symbols(twig: usize, species: &Species) -> impl Iterator<Item = u8> {
    let (boughs, depth) = (species.rule.boughs.len(), species.depth);
    (0..depth).map(move |k| (twig / boughs.pow(depth - 1 - k) % boughs) as u8)
}

fn turn(calendar: &mut Calendar, twig: usize, delay: u32, shared: &[u8], species: &Species, course: Course) {
    calendar.removals = [0; MOST_SYMBOLS];
    let mut step = 0;
    for (removal, leading) in calendar.removals.iter_mut().zip(symbols(twig, species)) {
        if course.turning != Turning::Shifts {
            step += 1;
            *removal = (step << STEP_BITS) as u16
                + if course.turning == Turning::Together { 0 } else { delay as u16 };
            continue;
        }
        while step < LAST_STEP {
            let chance = scatter(course.seed ^ (twig as u64) << 32 ^ u64::from(step) ^ 0x5ea5_0000_0000_0000);
            let drawn = match (chance & 0xffff) < u64::from(course.patchiness) {
                true => shared[step as usize],
                false => own_draw(species, (chance >> 16 & 0xffff) as i32),
            };
            step += 1;
            if drawn == leading {
                break;
            }
        }
        *removal = ((step << STEP_BITS) + delay).min(u16::MAX.into()) as u16;
    }
}

fn calibrate(calendars: &[Calendar], knots: &mut Knots, depth: usize) {
    for (step, knot) in knots.iter_mut().enumerate() {
        let step = (step as u32) << STEP_BITS;
        let sum: u64 = calendars.iter().map(|calendar| u64::from(calendar.removed(step, depth))).sum();
        *knot = ((sum << (16 - STEP_BITS)) / (calendars.len() * depth).max(1) as u64) as u32;
    }
}

/// The step at which the mean of K/M is a sixth of `stage`.
fn step_at(stage: Stage, knots: &Knots) -> u32 {
    let share = (u32::from(stage.0.min(Stage::COLOURED.0)) << (16 - Stage::BITS)) / 6;
    let after = knots.partition_point(|&knot| knot < share).min(KNOTS - 1);
    let Some(before) = after.checked_sub(1) else { return 0 };
    let (low, high) = (knots[before], knots[after]);
    let rest = ((share.saturating_sub(low)) << STEP_BITS) / (high - low).max(1);
    ((before as u32) << STEP_BITS) + rest.min(1 << STEP_BITS)
}

/// The stage of the tree at which the first leaves fall, if their own colours are done, in 2^-12.
const FIRST_FALL: u64 = 4 << Stage::BITS;

/// Leaves that are done first fall first, but chance has as much to say.
fn fall(calendar: &Calendar, twig: usize, knots: &Knots, depth: usize, course: Course) -> u16 {
    if !course.leaf_fall {
        return u16::MAX;
    }
    let done = knots[(usize::from(calendar.removals[depth - 1] >> STEP_BITS) + 1).min(KNOTS - 1)];
    let done = u64::from((done * 6) >> (16 - Stage::BITS)); // in stages of the tree
    let chance = scatter(course.seed ^ twig as u64 ^ 0xfa11_0000_0000_0000) >> 48;
    let order = (chance + (done << 16) / u64::from(Stage::COLOURED.0)) / 2;
    let planned = FIRST_FALL + (u64::from(Stage::BARE.0) - FIRST_FALL) * order / (1 << 16);
    planned.max(done).min(u64::from(Stage::BARE.0) - FALL_TIME) as u16
}

/// How long the leaves of a twig take to fall, in stages of 2^-12.
const FALL_TIME: u64 = 1 << (Stage::BITS - 5);

/// The season of a tree at one stage.
#[derive(Clone, Copy, Debug)]
pub(super) struct Now {
    step: u32,
    stage: Stage,
    depth: usize,
}

impl Now {
    pub(super) fn new(stage: Stage, knots: &Knots, species_depth: u32) -> Self {
        Self { step: step_at(stage, knots), stage, depth: species_depth as usize }
    }

    /// A twig's own stage, 0..=6, in steps of 2^-8.
    pub(super) fn stage(&self, calendar: &Calendar) -> u32 {
        calendar.removed(self.step, self.depth) * 6 / self.depth as u32
    }

    /// Whether a leaf of this twig may be seen to fall: its own time is near.
    pub(super) fn loosens(&self, calendar: &Calendar) -> bool {
        let time = 1 << (Stage::BITS - 1);
        self.stage.0 < Stage::BARE.0 && calendar.fall.abs_diff(self.stage.0) < time
    }

    /// How much of a twig's leaves is still there, 0..=255.
    pub(super) fn leaves(&self, calendar: &Calendar) -> u8 {
        let since = u64::from(self.stage.0.saturating_sub(calendar.fall));
        255 - (since * 255 / FALL_TIME).min(255) as u8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Tree {
        species: Species,
        calendars: Vec<Calendar>,
        knots: Knots,
    }

    impl Tree {
        fn new(name: &str, leaf_fall: bool, light: impl Fn(usize) -> u8) -> Self {
            let species = Species::known(name).unwrap();
            let mut calendars = vec![Calendar::zeroed(); species.twigs()];
            let sunlight: Vec<u8> = (0..species.twigs()).map(light).collect();
            let mut knots = [0; KNOTS];
            let course = Course { turning: Turning::Shifts, patchiness: 62_259, seed: 1, leaf_fall };
            fill(&mut calendars, &sunlight, &mut knots, &species, course);
            Self { species, calendars, knots }
        }

        fn at(&self, stage: f64) -> Now {
            Now::new(Stage::new(Factor::from_num(stage)), &self.knots, self.species.depth)
        }

        fn mean(&self, stage: f64) -> f64 {
            let now = self.at(stage);
            let sum: u32 = self.calendars.iter().map(|calendar| now.stage(calendar)).sum();
            f64::from(sum) / 256. / self.calendars.len() as f64
        }
    }

    #[test]
    fn the_clock_brings_the_mean_of_the_twigs_to_the_stage_that_was_asked_for() {
        for name in ["maple", "paper"] {
            let tree = Tree::new(name, false, |twig| (twig % 256) as u8);
            for stage in (0..=60).map(|tenth| f64::from(tenth) / 10.) {
                let mean = tree.mean(stage);
                assert!((mean - stage).abs() < 0.04, "{name} at {stage}: the mean stage is {mean}");
            }
        }
    }

    #[test]
    fn every_leaf_begins_green_and_ends_in_the_last_stage() {
        let tree = Tree::new("maple", false, |twig| (twig % 256) as u8);
        let (first, last) = (tree.at(0.), tree.at(6.));
        assert!(tree.calendars.iter().all(|calendar| first.stage(calendar) == 0));
        assert!(tree.calendars.iter().all(|calendar| last.stage(calendar) == 6 << 8));
        assert!(tree.calendars.iter().all(|calendar| tree.at(7.).leaves(calendar) == 255), "nothing falls");
    }

    #[test]
    fn a_twig_never_turns_back() {
        let tree = Tree::new("maple", true, |twig| (twig % 256) as u8);
        let mut before = vec![(0, 255); tree.calendars.len()];
        for stage in (0..=140).map(|i| f64::from(i) / 20.) {
            let now = tree.at(stage);
            for (before, calendar) in before.iter_mut().zip(&tree.calendars) {
                let here = (now.stage(calendar), now.leaves(calendar));
                assert!(here.0 >= before.0 && here.1 <= before.1, "at {stage}: {before:?} then {here:?}");
                assert!(here.1 == 255 || here.0 == 6 << 8, "a leaf falls at its stage {}", here.0);
                *before = here;
            }
        }
        assert!(before.iter().all(|&(_, leaves)| leaves == 0), "all have fallen");
    }

    #[test]
    fn the_draws_of_the_tree_are_as_frequent_as_their_chances() {
        let species = Species::known("maple").unwrap();
        let draws = shared_draws(&species);
        for (symbol, &chance) in species.chances.iter().enumerate() {
            let count = draws.iter().filter(|&&draw| usize::from(draw) == symbol).count();
            let expected = f64::from(chance) / 65_536. * f64::from(LAST_STEP);
            assert!((count as f64 - expected).abs() <= 1., "{symbol}: {count} of {expected}");
        }
    }

    /// The mean stage of the twigs that `which` names, in the middle of the season.
    fn mean_of(tree: &Tree, which: impl Fn(usize) -> bool) -> f64 {
        let now = tree.at(3.);
        let stages = tree.calendars.iter().enumerate().filter(|(twig, _)| which(*twig));
        let (sum, count) = stages.fold((0, 0), |(sum, count), (_, twig)| (sum + now.stage(twig), count + 1));
        f64::from(sum) / f64::from(count) / 256.
    }

    #[test]
    fn shade_delays() {
        let is_lit = |twig: usize| twig & 16 == 0;
        let tree = Tree::new("maple", false, |twig| if is_lit(twig) { 255 } else { 0 });
        let (lit, dark) = (mean_of(&tree, is_lit), mean_of(&tree, |twig| !is_lit(twig)));
        assert!(lit > dark + 0.3, "{lit} in the light, {dark} in the shade");
    }

    #[test]
    fn the_apex_turns_first() {
        let species = Species::known("maple").unwrap();
        let tree = Tree::new("maple", false, |_| 255);
        let apexes = |twig| symbols(twig, &species).filter(|&symbol| symbol == 3).count();
        let (crown, rest) =
            (mean_of(&tree, |twig| apexes(twig) >= 3), mean_of(&tree, |twig| apexes(twig) <= 1));
        assert!(crown > rest + 0.5, "{crown} in the crown, {rest} below");
    }

    #[test]
    fn a_bough_turns_together() {
        // Of two twigs of one bough of fourth order, and two from anywhere: how far they are apart.
        let tree = Tree::new("maple", false, |_| 255);
        let now = tree.at(3.);
        let stage = |twig: usize| f64::from(now.stage(&tree.calendars[twig])) / 256.;
        let apart =
            |step: usize| (0..4096).map(|twig| (stage(twig) - stage(twig ^ step)).abs()).sum::<f64>() / 4096.;
        assert!(
            apart(1) * 2. < apart(1 << 11),
            "{} within a bough, {} across the tree",
            apart(1),
            apart(1 << 11)
        );
    }
}
