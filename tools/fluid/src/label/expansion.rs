//! Expansion moves (Boykov, Veksler and Zabih 2001), which the paper names: for the k-th label of all nodes at once, each node keeps its
//! label or takes that one, by a cheapest cut.
//!
//! The costs of pairs here are no metric, and a cut wants `keep-keep + take-take ≤ keep-take + take-keep` of each edge. Where that fails,
//! keep-keep is lowered (Rother and others, "Digital tapestry", 2005): the energy still cannot rise, but the move may miss the best one.
//! How many terms that were is counted.

use super::max_flow::Network;
use super::problem::Problem;

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    /// The label of every node.
    pub(super) labels: Vec<usize>,
    /// The share of all pairs in all moves that had to be lowered, 0..=1.
    pub(super) truncated: f64,
    /// How many times all labels were tried.
    pub(super) rounds: usize,
}

/// Steps of a cost of 1 in the cut, which counts in whole numbers.
const STEPS: f64 = (1 << 24) as f64;

/// Expands from a choice until no label lowers the energy, at most `rounds` times through all labels. Each move is one cut.
pub(super) fn expansion(problem: &Problem, start: Vec<usize>, rounds: usize) -> Outcome {
    let labels = (0..problem.nodes()).map(|node| problem.unary(node).len()).max().unwrap_or(0);
    let mut outcome = Outcome { labels: start, truncated: 0.0, rounds: 0 };
    let mut energy = problem.energy(&outcome.labels);
    let (mut lowered, mut terms) = (0, 0);
    // The label that lowered the energy last: when all others have been tried since, it is over.
    let mut since = 0;
    for alpha in (0..rounds).flat_map(|_| 0..labels) {
        outcome.rounds += usize::from(alpha == 0);
        let (taken, truncated) = expand(problem, &outcome.labels, alpha);
        (lowered, terms) = (lowered + truncated, terms + problem.edges().len());
        let found = problem.energy(&taken);
        since += 1;
        if found < energy {
            (outcome.labels, energy, since) = (taken, found, 0);
        }
        if since == labels {
            break;
        }
    }
    outcome.truncated = lowered as f64 / terms.max(1) as f64;
    outcome
}

/// The best choice in which each node keeps its label or takes its `alpha`-th, and how many terms were lowered for it.
fn expand(problem: &Problem, labels: &[usize], alpha: usize) -> (Vec<usize>, usize) {
    let other = |node: usize| if alpha < problem.unary(node).len() { alpha } else { labels[node] };
    let steps = |cost: f32| (f64::from(cost) * STEPS).round() as i64;
    let mut network = Network::new(problem.nodes());
    // What taking costs more than keeping.
    let mut taking: Vec<i64> = (0..problem.nodes())
        .map(|node| steps(problem.unary(node)[other(node)]) - steps(problem.unary(node)[labels[node]]))
        .collect();
    let mut truncated = 0;
    for (e, edge) in problem.edges().iter().enumerate() {
        let (first, second) = (edge.first, edge.second);
        let pair = |a: usize, b: usize| steps(problem.pair(e, a, b));
        let mut keep = pair(labels[first], labels[second]);
        let half = pair(labels[first], other(second));
        let rest = pair(other(first), labels[second]);
        let take = pair(other(first), other(second));
        let submodular = half + rest - take;
        truncated += usize::from(keep > submodular);
        keep = keep.min(submodular);
        // Kolmogorov and Zabih 2004, section 4.1.
        taking[first] += rest - keep;
        taking[second] += take - rest;
        network.add_arc(first, second, submodular - keep);
    }
    for (node, &cost) in taking.iter().enumerate() {
        network.add_source(node, cost.max(0));
        network.add_sink(node, (-cost).max(0));
    }
    let (_, takes) = network.cut();
    (
        takes
            .iter()
            .enumerate()
            .map(|(node, &takes)| if takes { other(node) } else { labels[node] })
            .collect(),
        truncated,
    )
}

#[cfg(test)]
mod tests {
    use super::super::problem::tests::{brute_force, grid};
    use super::super::problem::{Edge, Problem};
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_move_never_raises_the_energy(problem in grid(3, 3, false), alpha in 0usize..4) {
            let start = problem.greedy();
            let (moved, _) = expand(&problem, &start, alpha);
            prop_assert!(problem.energy(&moved) <= problem.energy(&start) + 1e-5);
        }

        #[test]
        fn expansions_end_between_greedy_and_the_best(problem in grid(3, 3, false)) {
            let outcome = expansion(&problem, problem.greedy(), 10);
            let energy = problem.energy(&outcome.labels);
            prop_assert!(energy <= problem.energy(&problem.greedy()));
            prop_assert!(energy >= brute_force(&problem).1 - 1e-6);
            prop_assert!((0.0..=1.0).contains(&outcome.truncated));
        }

        #[test]
        fn two_labels_that_attract_are_solved_exactly(unary in prop::collection::vec((0f32..2.0, 0f32..2.0), 6)) {
            let edges = [(0, 1), (1, 2), (3, 4), (4, 5), (0, 3), (1, 4), (2, 5)];
            let edges = edges.map(|(first, second)| Edge { first, second, costs: vec![0.0, 1.0, 1.0, 0.0] });
            let problem = Problem::new(unary.iter().map(|&(a, b)| vec![a, b]).collect(), edges.to_vec());
            let outcome = expansion(&problem, vec![0; 6], 10);
            prop_assert_eq!(outcome.truncated, 0.0);
            prop_assert!((problem.energy(&outcome.labels) - brute_force(&problem).1).abs() < 1e-5);
        }
    }
}
