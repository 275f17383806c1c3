//! Which patch of a video is given to which patch of the picture (the paper, section 5).
//!
//! ```text
//! words of the picture ──> candidates ──> shifts ──> V ─┐
//! motion of the candidates ─────────────────────────> λW ┴─> solver ──> labelling
//! ```
//!
//! The same on every run: costs are compared in one order, and every sum is taken in the order of the list, whatever the threads.

mod assignment;
mod candidates;
mod expansion;
mod histogram;
mod max_flow;
mod pairwise;
mod problem;
mod scene;
mod target;
mod trws;

pub use self::assignment::assignment;
pub use self::pairwise::Pairwise;
pub use self::scene::scene_class;
pub use self::target::{Look, Motion, Target, Wanted};

use self::{
    candidates::{Candidate, Search, drop_unwanted},
    pairwise::{Comparison, Side},
    problem::{Edge, Problem},
};
use crate::{
    features::Features,
    patch::{PatchRef, SIDE, STRIDE},
};
use rayon::prelude::*;
use std::{fmt, time::Instant};

/// The picture's patches: [`crate::patch::SIDE`] pixels, [`crate::patch::STRIDE`] apart, from the upper left corner on; the last ones may
/// reach beyond the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Patches across.
    pub columns: usize,
    /// Patches down.
    pub rows: usize,
}

impl Grid {
    /// The fewest patches that cover a picture of this size.
    pub fn of(width: usize, height: usize) -> Self {
        let patches = |length: usize| length.saturating_sub(SIDE).div_ceil(STRIDE) + 1;
        Self { columns: patches(width), rows: patches(height) }
    }
}

/// The patch that each patch of the picture was given, row by row; none where there is no fluid.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelling {
    /// How the picture is cut.
    pub grid: Grid,
    /// One a patch.
    pub patches: Vec<Option<PatchRef>>,
}

/// How the choice is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Solver {
    /// What looks most alike, whatever the neighbours.
    Greedy,
    /// Iterated conditional modes from there.
    Icm,
    /// Expansion moves from there, as in the paper.
    Expansion,
    /// Sequential tree-reweighted message passing, then iterated conditional modes.
    Trws,
}

impl Solver {
    /// All of them, from the plainest.
    pub const ALL: [Self; 4] = [Self::Greedy, Self::Icm, Self::Expansion, Self::Trws];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Greedy => "greedy",
            Self::Icm => "icm",
            Self::Expansion => "expansion",
            Self::Trws => "trws",
        }
    }
}

/// How patches are chosen. The cleaning by class is the caller's: it passes the features of one class, or all.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The solver whose choice is taken.
    pub solver: Solver,
    /// Whether the others are run too, to compare their energies.
    pub compare: bool,
    /// Candidates of each patch, before shifts are added: 100 in the paper. At least 1.
    pub candidates: usize,
    /// Whether a patch may also be found by its sharp frame, or, as in the paper, by its mean alone.
    pub both_word_maps: bool,
    /// What neighbours cost.
    pub pairwise: Pairwise,
    /// At most so many rounds of the solvers that go round.
    pub rounds: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            solver: Solver::Trws,
            compare: false,
            candidates: 100,
            both_word_maps: true,
            pairwise: Pairwise::Relative,
            rounds: 30,
        }
    }
}

/// Why there is no labelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelError {
    /// The database has no patch of the class.
    NoPatches,
    /// The picture has no fluid.
    NoFluid,
}

impl fmt::Display for LabelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NoPatches => "the database has no patch of this class: index videos of it first, or name another with --class",
            Self::NoFluid => "the matte leaves no fluid in the picture: its white must cover some of it",
        })
    }
}

impl std::error::Error for LabelError {}

/// A labelling, and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Labelled {
    /// The choice.
    pub labelling: Labelling,
    /// How the chosen patches move; none where there is no fluid.
    pub motions: Vec<Option<Motion>>,
    /// The energy of each solver that ran: that of greedy, of the one asked for, and of all if they were compared.
    pub energies: Vec<(Solver, f64)>,
    /// No choice has less energy than this; known if message passing ran.
    pub bound: Option<f64>,
    /// The share of terms that expansion had to lower, if it ran.
    pub truncated: Option<f64>,
    /// How much the choice changes from frame to frame, against greedy's; under 0.7 a labelling is dull.
    pub amplitude_ratio: f64,
    /// λ: what the pairs are multiplied by.
    pub lambda: f64,
    /// Fluid patches, labels of all of them, and pairs of neighbours.
    pub size: [usize; 3],
    /// Fluid patches for which no candidate moves as was asked: they keep what comes nearest.
    pub unguided: usize,
    /// Seconds of each step.
    pub seconds: Vec<(&'static str, f64)>,
}

impl fmt::Display for Labelled {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nodes, labels, edges] = self.size;
        writeln!(f, "{nodes} patches, {labels} candidates, {edges} pairs, lambda {:.3}", self.lambda)?;
        for (solver, energy) in &self.energies {
            writeln!(f, "energy of {:<10} {energy:.4}", solver.name())?;
        }
        if let Some(bound) = self.bound {
            writeln!(f, "lower bound          {bound:.4}")?;
        }
        if let Some(truncated) = self.truncated {
            writeln!(f, "expansion truncated  {:.1} % of the terms", truncated * 100.0)?;
        }
        writeln!(f, "amplitude            {:.2} of greedy's", self.amplitude_ratio)?;
        if self.unguided > 0 {
            writeln!(f, "no motion as asked   {} patches", self.unguided)?;
        }
        for (step, seconds) in &self.seconds {
            writeln!(f, "{step:<20} {seconds:.3} s")?;
        }
        Ok(())
    }
}

/// Writes down how long steps take.
struct Watch(Instant, Vec<(&'static str, f64)>);

impl Watch {
    fn lap(&mut self, step: &'static str) {
        let now = Instant::now();
        self.1.push((step, (now - self.0).as_secs_f64()));
        self.0 = now;
    }
}

/// Chooses a patch of the database for each fluid patch of the picture.
///
/// With 350 patches, 100,000 features and 130 labels each: the scan reads 10¹⁰ bytes, the tables of pairs take 50 MB.
pub fn label(target: &Target, features: &[Features], options: &Options) -> Result<Labelled, LabelError> {
    if features.is_empty() {
        return Err(LabelError::NoPatches);
    }
    if target.looks.iter().all(Option::is_none) {
        return Err(LabelError::NoFluid);
    }
    let mut watch = Watch(Instant::now(), Vec::new());
    let search = Search::new(features, options.both_word_maps);
    let count = options.candidates.max(1);
    let mut lists = search.scan(target, count);
    watch.lap("candidates");
    search.add_shifts(target, &mut lists);
    let unguided = drop_unwanted(&mut lists);
    search.spread(target, &mut lists, count);
    search.enliven(&mut lists, count);
    watch.lap("shifts");
    let comparison = Comparison::new(features, options.pairwise, &lists);
    let (problem, lambda) = pose(target.grid, &lists, &comparison);
    watch.lap("pairs");
    let mut labelled = solve(&problem, options, &mut watch);
    let greedy = problem.greedy();
    let chosen = labelled.labels;
    let fluid: Vec<_> = lists.iter().filter(|list| !list.is_empty()).collect();
    let amplitude = |labels: &[usize]| -> f64 {
        fluid
            .iter()
            .zip(labels)
            .map(|(list, &label)| f64::from(search.motion(list[label].patch).amplitude))
            .sum()
    };
    let (still, greedy) = (amplitude(&chosen), amplitude(&greedy));
    let amplitude_ratio = if greedy > 0.0 { still / greedy } else { 1.0 };
    let mut labels = chosen.iter();
    let chosen: Vec<Option<u32>> = lists
        .iter()
        .map(|list| if list.is_empty() { None } else { labels.next().map(|&label| list[label].patch) })
        .collect();
    labelled.energies.sort_by_key(|&(solver, _)| solver);
    Ok(Labelled {
        labelling: Labelling {
            grid: target.grid,
            patches: chosen.iter().map(|patch| patch.map(|patch| features[patch as usize].patch)).collect(),
        },
        motions: chosen.iter().map(|patch| patch.map(|patch| *search.motion(patch))).collect(),
        energies: labelled.energies,
        bound: labelled.bound,
        truncated: labelled.truncated,
        amplitude_ratio,
        lambda,
        size: [fluid.len(), fluid.iter().map(|list| list.len()).sum(), problem.edges().len()],
        unguided,
        seconds: watch.1,
    })
}

/// The problem of the fluid patches, in the order of the picture, and its λ: pairs vary twice as much as likeness does, within the labels
/// of a patch and within the table of a pair; what is common to all of them decides nothing.
fn pose(grid: Grid, lists: &[Vec<Candidate>], comparison: &Comparison) -> (Problem, f64) {
    let mut nodes = vec![0; lists.len()];
    let mut fluid = Vec::new();
    for (number, list) in lists.iter().enumerate().filter(|(_, list)| !list.is_empty()) {
        nodes[number] = fluid.len();
        fluid.push(list.iter().map(|candidate| candidate.cost).collect::<Vec<_>>());
    }
    let mut pairs = Vec::new();
    for number in 0..lists.len() {
        let right = (number % grid.columns + 1 < grid.columns).then_some((number + 1, Side::Right));
        let below = (number + grid.columns < lists.len()).then_some((number + grid.columns, Side::Below));
        let beside = [right, below].into_iter().flatten().map(|(other, side)| (number, other, side));
        pairs.extend(beside.filter(|&(a, b, _)| !lists[a].is_empty() && !lists[b].is_empty()));
    }
    let mut edges: Vec<_> = pairs
        .par_iter()
        .map(|&(first, second, side)| Edge {
            first: nodes[first],
            second: nodes[second],
            costs: comparison.table(&lists[first], &lists[second], side),
        })
        .collect();
    let varied: Vec<_> = edges.par_iter().map(|edge| scatter(&edge.costs)).collect();
    let likeness = deviation(fluid.iter().map(|costs| scatter(costs)));
    let pairwise = deviation(varied.into_iter());
    // With one label everywhere there is nothing to weigh.
    let lambda = if likeness > 0.0 && pairwise > 0.0 { 2.0 * likeness / pairwise } else { 1.0 };
    edges.par_iter_mut().for_each(|edge| edge.costs.iter_mut().for_each(|cost| *cost *= lambda as f32));
    (Problem::new(fluid, edges), lambda)
}

/// The sum of squared distances from the mean, and how many there are.
fn scatter(values: &[f32]) -> (f64, usize) {
    let mean = values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64;
    (values.iter().map(|&value| (f64::from(value) - mean).powi(2)).sum(), values.len())
}

fn deviation(groups: impl Iterator<Item = (f64, usize)>) -> f64 {
    let (sum, count) = groups.fold((0.0, 0), |(sum, count), group| (sum + group.0, count + group.1));
    (sum / count.max(1) as f64).sqrt()
}

/// What the solvers say.
struct Solved {
    labels: Vec<usize>,
    energies: Vec<(Solver, f64)>,
    bound: Option<f64>,
    truncated: Option<f64>,
}

fn solve(problem: &Problem, options: &Options, watch: &mut Watch) -> Solved {
    let mut solved = Solved { labels: Vec::new(), energies: Vec::new(), bound: None, truncated: None };
    for solver in Solver::ALL {
        if !(options.compare || solver == options.solver || solver == Solver::Greedy) {
            continue;
        }
        let mut labels = problem.greedy();
        match solver {
            Solver::Greedy => {}
            Solver::Icm => problem.icm(&mut labels),
            Solver::Expansion => {
                let outcome = expansion::expansion(problem, labels, options.rounds);
                labels = outcome.labels;
                solved.truncated = Some(outcome.truncated);
            }
            Solver::Trws => {
                let outcome = trws::trws(problem, options.rounds);
                labels = outcome.labels;
                problem.icm(&mut labels);
                solved.bound = Some(outcome.bound);
            }
        }
        solved.energies.push((solver, problem.energy(&labels)));
        watch.lap(solver.name());
        if solver == options.solver {
            solved.labels = labels;
        }
    }
    solved
}

#[cfg(test)]
mod tests;
