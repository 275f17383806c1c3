//! The choice as a problem of energy: every node takes one of its labels; a label has a cost, and so has each pair across an edge (the
//! paper, eq. 4). Here too are the two plainest solvers.

/// Two nodes whose labels cost together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Edge {
    /// The node of the lower number.
    pub(super) first: usize,
    /// The node of the higher number.
    pub(super) second: usize,
    /// A row for each label of the first, a column for each of the second.
    pub(super) costs: Vec<f32>,
}

/// Nodes with labels, and edges between them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Problem {
    unary: Vec<Vec<f32>>,
    edges: Vec<Edge>,
    /// The edges of each node whose other node is lower, and those whose other node is higher.
    lower: Vec<Vec<usize>>,
    higher: Vec<Vec<usize>>,
}

impl Problem {
    /// A problem of nodes with these costs of labels.
    ///
    /// # Panics
    ///
    /// If a node has no label, if an edge's nodes are not in order, or if its table is of another size than its nodes ask for.
    pub(super) fn new(unary: Vec<Vec<f32>>, edges: Vec<Edge>) -> Self {
        assert!(unary.iter().all(|costs| !costs.is_empty()), "every node has a label");
        let (mut lower, mut higher) = (vec![Vec::new(); unary.len()], vec![Vec::new(); unary.len()]);
        for (number, edge) in edges.iter().enumerate() {
            assert!(edge.first < edge.second, "the nodes of an edge are in order");
            assert_eq!(edge.costs.len(), unary[edge.first].len() * unary[edge.second].len());
            higher[edge.first].push(number);
            lower[edge.second].push(number);
        }
        Self { unary, edges, lower, higher }
    }

    /// How many nodes there are.
    pub(super) fn nodes(&self) -> usize {
        self.unary.len()
    }

    /// The costs of a node's labels.
    pub(super) fn unary(&self, node: usize) -> &[f32] {
        &self.unary[node]
    }

    /// All edges.
    pub(super) fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// The numbers of a node's edges to lower nodes.
    pub(super) fn lower(&self, node: usize) -> &[usize] {
        &self.lower[node]
    }

    /// The numbers of a node's edges to higher nodes.
    pub(super) fn higher(&self, node: usize) -> &[usize] {
        &self.higher[node]
    }

    /// What an edge costs when its nodes have these labels.
    pub(super) fn pair(&self, edge: usize, first: usize, second: usize) -> f32 {
        let edge = &self.edges[edge];
        edge.costs[first * self.unary[edge.second].len() + second]
    }

    /// What a choice costs. O(nodes + edges).
    pub(super) fn energy(&self, labels: &[usize]) -> f64 {
        let unary: f64 = self.unary.iter().zip(labels).map(|(costs, &label)| f64::from(costs[label])).sum();
        let pairs = self.edges.iter().enumerate();
        unary
            + pairs
                .map(|(e, edge)| f64::from(self.pair(e, labels[edge.first], labels[edge.second])))
                .sum::<f64>()
    }

    /// The cheapest label of every node, whatever its neighbours take; the first of equals.
    pub(super) fn greedy(&self) -> Vec<usize> {
        self.unary.iter().map(|costs| cheapest(costs)).collect()
    }

    /// Iterated conditional modes (Besag 1986): node after node takes the label that is cheapest beside its neighbours', until none
    /// changes. The energy never rises, and ends in the nearest valley.
    pub(super) fn icm(&self, labels: &mut [usize]) {
        let mut costs = Vec::new();
        loop {
            let mut changed = false;
            for node in 0..self.nodes() {
                costs.clone_from(&self.unary[node]);
                for &e in &self.lower[node] {
                    let other = labels[self.edges[e].first];
                    costs
                        .iter_mut()
                        .enumerate()
                        .for_each(|(label, cost)| *cost += self.pair(e, other, label));
                }
                for &e in &self.higher[node] {
                    let other = labels[self.edges[e].second];
                    costs
                        .iter_mut()
                        .enumerate()
                        .for_each(|(label, cost)| *cost += self.pair(e, label, other));
                }
                let best = cheapest(&costs);
                // Only what is cheaper by more than rounding counts, so that it ends.
                if costs[best] < costs[labels[node]] * (1.0 - f32::EPSILON) - f32::EPSILON {
                    labels[node] = best;
                    changed = true;
                }
            }
            if !changed {
                return;
            }
        }
    }
}

/// The first of the least.
pub(super) fn cheapest(costs: &[f32]) -> usize {
    let mut best = 0;
    for (label, &cost) in costs.iter().enumerate() {
        if cost < costs[best] {
            best = label;
        }
    }
    best
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every choice there is: the slow twin of all solvers.
    pub(in crate::label) fn brute_force(problem: &Problem) -> (Vec<usize>, f64) {
        let mut labels = vec![0; problem.nodes()];
        let mut best = (labels.clone(), problem.energy(&labels));
        'all: loop {
            for node in 0..labels.len() {
                labels[node] += 1;
                if labels[node] < problem.unary(node).len() {
                    let energy = problem.energy(&labels);
                    if energy < best.1 {
                        best = (labels.clone(), energy);
                    }
                    continue 'all;
                }
                labels[node] = 0;
            }
            return best;
        }
    }

    /// A grid whose nodes have 1 to 4 labels, with costs in 0..1; a tree if `tree`: the rows hang together by their first column only.
    pub(in crate::label) fn grid(columns: usize, rows: usize, tree: bool) -> impl Strategy<Value = Problem> {
        let nodes = columns * rows;
        (prop::collection::vec(1usize..=4, nodes), any::<u64>()).prop_map(move |(sizes, seed)| {
            let mut state = seed | 1;
            let mut next = || {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                (state >> 40) as f32 / (1u32 << 24) as f32
            };
            let unary: Vec<Vec<f32>> = sizes.iter().map(|&n| (0..n).map(|_| next()).collect()).collect();
            let mut edges = Vec::new();
            for node in 0..nodes {
                let (x, y) = (node % columns, node / columns);
                let right = (x + 1 < columns).then_some(node + 1);
                let down = (y + 1 < rows && (!tree || x == 0)).then_some(node + columns);
                for second in [right, down].into_iter().flatten() {
                    let costs = (0..sizes[node] * sizes[second]).map(|_| next()).collect();
                    edges.push(Edge { first: node, second, costs });
                }
            }
            Problem::new(unary, edges)
        })
    }

    #[test]
    fn the_energy_is_the_sum_of_labels_and_pairs() {
        let edge = Edge { first: 0, second: 1, costs: vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0] };
        let problem = Problem::new(vec![vec![0.5, 0.25], vec![3.0, 5.0, 7.0]], vec![edge]);
        assert_eq!(problem.energy(&[0, 0]), 4.5);
        assert_eq!(problem.energy(&[1, 2]), 0.25 + 7.0 + 32.0);
        assert_eq!(problem.greedy(), [1, 0]);
        assert_eq!(brute_force(&problem).0, [0, 0]);
    }

    proptest! {
        #[test]
        fn icm_never_raises_the_energy_and_rests_in_a_valley(problem in grid(3, 2, false)) {
            let greedy = problem.greedy();
            let mut labels = greedy.clone();
            problem.icm(&mut labels);
            let energy = problem.energy(&labels);
            prop_assert!(energy <= problem.energy(&greedy) + 1e-6);
            prop_assert!(energy >= brute_force(&problem).1 - 1e-6);
            for node in 0..problem.nodes() {
                for label in 0..problem.unary(node).len() {
                    let mut other = labels.clone();
                    other[node] = label;
                    prop_assert!(problem.energy(&other) >= energy - 1e-5);
                }
            }
        }
    }
}
