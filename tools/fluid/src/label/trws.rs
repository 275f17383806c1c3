//! Sequential tree-reweighted message passing (Kolmogorov, "Convergent tree-reweighted message passing for energy minimization", 2006,
//! section 4), for which the costs of pairs may be any.
//!
//! θ̂ -> `belief`, γ -> `share`, M_st -> a [`Messages`] entry. The lower bound is what the messages to lower nodes were lowered by in one
//! pass: it holds for any messages to higher nodes, as these only move cost from one term to another. Departs: every second pass is read
//! out, and the best choice so far is kept.

use super::problem::{Problem, cheapest};

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    /// The label of every node.
    pub(super) labels: Vec<usize>,
    /// No choice costs less than this (within the rounding of `f32`: about one part in a million).
    pub(super) bound: f64,
    /// How many times the messages went there and back.
    pub(super) iterations: usize,
}

/// A bound that rises by less than this share no longer moves the choice: thirty more rounds changed nothing.
const SETTLED: f64 = 1e-6;

/// The messages of every edge: to its first node, and to its second.
struct Messages {
    to_first: Vec<Vec<f32>>,
    to_second: Vec<Vec<f32>>,
}

/// Minimises the energy in at most `iterations` rounds, each O(edges · labels²).
pub(super) fn trws(problem: &Problem, iterations: usize) -> Outcome {
    let zeros = |node: usize| vec![0.0f32; problem.unary(node).len()];
    let mut messages = Messages {
        to_first: problem.edges().iter().map(|edge| zeros(edge.first)).collect(),
        to_second: problem.edges().iter().map(|edge| zeros(edge.second)).collect(),
    };
    let mut best = Outcome { labels: problem.greedy(), bound: f64::NEG_INFINITY, iterations: 0 };
    let mut energy = problem.energy(&best.labels);
    for round in 1..=iterations {
        up(problem, &mut messages);
        let bound = down(problem, &mut messages);
        let labels = read_out(problem, &messages);
        let found = problem.energy(&labels);
        if found < energy {
            (best.labels, energy) = (labels, found);
        }
        let gained = bound - best.bound;
        best.bound = best.bound.max(bound);
        best.iterations = round;
        if gained <= SETTLED * bound.abs() || energy - bound <= SETTLED * energy.abs() {
            break;
        }
    }
    best
}

/// From the first node to the last.
fn up(problem: &Problem, messages: &mut Messages) {
    let mut scratch = Vec::new();
    for node in 0..problem.nodes() {
        let belief = belief(problem, messages, node);
        let share = share(problem, node);
        for &e in problem.higher(node) {
            lend(&belief, share, &messages.to_first[e], &mut scratch);
            over_rows(&scratch, &problem.edges()[e].costs, &mut messages.to_second[e]);
            lower_to_zero(&mut messages.to_second[e]);
        }
    }
}

/// From the last node to the first. Returns the bound.
fn down(problem: &Problem, messages: &mut Messages) -> f64 {
    let mut scratch = Vec::new();
    let mut bound = 0.0;
    for node in (0..problem.nodes()).rev() {
        let mut belief = belief(problem, messages, node);
        bound += f64::from(lower_to_zero(&mut belief));
        let share = share(problem, node);
        for &e in problem.lower(node) {
            lend(&belief, share, &messages.to_second[e], &mut scratch);
            over_columns(&scratch, &problem.edges()[e].costs, &mut messages.to_first[e]);
            bound += f64::from(lower_to_zero(&mut messages.to_first[e]));
        }
    }
    bound
}

/// Node after node takes its best label beside the labels of those before it and the messages of those after it.
fn read_out(problem: &Problem, messages: &Messages) -> Vec<usize> {
    let mut labels: Vec<usize> = Vec::with_capacity(problem.nodes());
    for node in 0..problem.nodes() {
        let mut costs = problem.unary(node).to_vec();
        for &e in problem.lower(node) {
            let other = labels[problem.edges()[e].first];
            let width = costs.len();
            add(&mut costs, &problem.edges()[e].costs[other * width..][..width]);
        }
        for &e in problem.higher(node) {
            add(&mut costs, &messages.to_first[e]);
        }
        labels.push(cheapest(&costs));
    }
    labels
}

/// What a node's labels cost with all messages to it.
fn belief(problem: &Problem, messages: &Messages, node: usize) -> Vec<f32> {
    let mut belief = problem.unary(node).to_vec();
    problem.lower(node).iter().for_each(|&e| add(&mut belief, &messages.to_second[e]));
    problem.higher(node).iter().for_each(|&e| add(&mut belief, &messages.to_first[e]));
    belief
}

/// The share of a node's belief that belongs to each of the chains through it.
fn share(problem: &Problem, node: usize) -> f32 {
    1.0 / problem.lower(node).len().max(problem.higher(node).len()).max(1) as f32
}

/// The part of the belief that goes along an edge, without what came from there.
fn lend(belief: &[f32], share: f32, came: &[f32], out: &mut Vec<f32>) {
    out.clear();
    out.extend(belief.iter().zip(came).map(|(b, c)| share * b - c));
}

/// For every column the least of `lent` and the table's rows.
fn over_rows(lent: &[f32], costs: &[f32], out: &mut [f32]) {
    out.fill(f32::INFINITY);
    for (&from, row) in lent.iter().zip(costs.chunks_exact(out.len())) {
        for (least, &cost) in out.iter_mut().zip(row) {
            *least = lesser(*least, from + cost);
        }
    }
}

/// For every row the least of `lent` and the table's columns.
fn over_columns(lent: &[f32], costs: &[f32], out: &mut [f32]) {
    /// Columns that are compared at once.
    const LANES: usize = 16;
    for (least, row) in out.iter_mut().zip(costs.chunks_exact(lent.len())) {
        let mut lanes = [f32::INFINITY; LANES];
        let (from, cost) = (lent.chunks_exact(LANES), row.chunks_exact(LANES));
        let rest = from.remainder().iter().zip(cost.remainder());
        for (from, cost) in from.zip(cost) {
            for lane in 0..LANES {
                lanes[lane] = lesser(lanes[lane], from[lane] + cost[lane]);
            }
        }
        let rest = rest.map(|(from, cost)| from + cost);
        let across = lanes.into_iter().fold(f32::INFINITY, lesser);
        *least = rest.fold(across, lesser);
    }
}

/// The lesser of two numbers, neither of which is NaN: one instruction.
fn lesser(a: f32, b: f32) -> f32 {
    if b < a { b } else { a }
}

/// Takes the least from all and returns it.
fn lower_to_zero(costs: &mut [f32]) -> f32 {
    let least = costs.iter().copied().fold(f32::INFINITY, lesser);
    costs.iter_mut().for_each(|cost| *cost -= least);
    least
}

fn add(to: &mut [f32], from: &[f32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to += from);
}

#[cfg(test)]
mod tests {
    use super::super::problem::tests::{brute_force, grid};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn trees_are_solved_exactly(problem in grid(3, 3, true)) {
            let outcome = trws(&problem, 100);
            let (_, least) = brute_force(&problem);
            prop_assert!((problem.energy(&outcome.labels) - least).abs() < 1e-4);
            prop_assert!((outcome.bound - least).abs() < 1e-3, "{} of {least}", outcome.bound);
        }

        #[test]
        fn the_bound_is_under_every_choice(problem in grid(3, 3, false)) {
            let outcome = trws(&problem, 30);
            let (_, least) = brute_force(&problem);
            prop_assert!(outcome.bound <= least + 1e-4, "{} over {least}", outcome.bound);
            prop_assert!(problem.energy(&outcome.labels) >= least - 1e-6);
        }
    }

    #[test]
    fn rows_and_columns_of_any_length_are_searched() {
        for (rows, columns) in [(1, 1), (3, 16), (5, 17), (2, 50)] {
            let costs: Vec<f32> = (0..rows * columns).map(|i| ((i * 37) % 101) as f32).collect();
            let down: Vec<f32> = (0..columns).map(|i| ((i * 11) % 7) as f32).collect();
            let across: Vec<f32> = (0..rows).map(|i| ((i * 5) % 3) as f32).collect();
            let mut out = vec![0.0; rows];
            over_columns(&down, &costs, &mut out);
            let least = |row: usize| {
                (0..columns).map(|c| down[c] + costs[row * columns + c]).fold(f32::INFINITY, f32::min)
            };
            assert_eq!(out, (0..rows).map(least).collect::<Vec<_>>());
            let mut out = vec![0.0; columns];
            over_rows(&across, &costs, &mut out);
            let least = |c: usize| {
                (0..rows).map(|row| across[row] + costs[row * columns + c]).fold(f32::INFINITY, f32::min)
            };
            assert_eq!(out, (0..columns).map(least).collect::<Vec<_>>());
        }
    }
}
