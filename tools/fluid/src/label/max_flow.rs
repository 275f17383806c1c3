//! The cheapest cut of a small graph, by pushing and lifting (Goldberg and Tarjan 1988): first in, first out, with heights that begin as
//! the true distances to the sink and the gap rule of Cherkassky and Goldberg.

use std::collections::VecDeque;

/// A graph with a source, a sink, and arcs between its nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct Network {
    /// Arcs in pairs: arc `a` and the way back `a ^ 1`.
    arcs: Vec<Arc>,
    /// The arcs that leave each node.
    leaving: Vec<Vec<u32>>,
    /// What could still flow in from the source, and out to the sink.
    source: Vec<i64>,
    sink: Vec<i64>,
}

#[derive(Clone, Debug)]
struct Arc {
    to: u32,
    capacity: i64,
}

impl Network {
    /// Nodes without arcs.
    pub(super) fn new(nodes: usize) -> Self {
        Self {
            arcs: Vec::new(),
            leaving: vec![Vec::new(); nodes],
            source: vec![0; nodes],
            sink: vec![0; nodes],
        }
    }

    /// Lets `capacity` ≥ 0 flow from the source into a node.
    pub(super) fn add_source(&mut self, node: usize, capacity: i64) {
        self.source[node] += capacity;
    }

    /// Lets `capacity` ≥ 0 flow from a node into the sink.
    pub(super) fn add_sink(&mut self, node: usize, capacity: i64) {
        self.sink[node] += capacity;
    }

    /// Lets `capacity` ≥ 0 flow from one node to another.
    pub(super) fn add_arc(&mut self, from: usize, to: usize, capacity: i64) {
        let number = self.arcs.len() as u32;
        self.arcs.push(Arc { to: to as u32, capacity });
        self.arcs.push(Arc { to: from as u32, capacity: 0 });
        self.leaving[from].push(number);
        self.leaving[to].push(number + 1);
    }

    /// The most that flows, and for every node whether it lies on the sink's side of the cut. O(nodes³).
    pub(super) fn cut(mut self) -> (i64, Vec<bool>) {
        let nodes = self.leaving.len();
        let mut excess = std::mem::take(&mut self.source);
        let mut height = self.distances();
        let mut at_height = vec![0usize; nodes + 2];
        height.iter().for_each(|&h| at_height[h] += 1);
        let mut flow = 0;
        let mut current = vec![0usize; nodes];
        let mut active: VecDeque<usize> = (0..nodes).filter(|&node| excess[node] > 0).collect();
        while let Some(node) = active.pop_front() {
            while excess[node] > 0 && height[node] <= nodes {
                // The sink is at height 0, and no way is shorter.
                let out = excess[node].min(self.sink[node]);
                (self.sink[node], excess[node], flow) =
                    (self.sink[node] - out, excess[node] - out, flow + out);
                if excess[node] == 0 {
                    break;
                }
                let Some(&number) = self.leaving[node].get(current[node]) else {
                    self.lift(node, &mut height, &mut at_height);
                    current[node] = 0;
                    continue;
                };
                let to = self.arcs[number as usize].to as usize;
                let pushed = excess[node].min(self.arcs[number as usize].capacity);
                if pushed > 0 && height[node] == height[to] + 1 {
                    self.arcs[number as usize].capacity -= pushed;
                    self.arcs[number as usize ^ 1].capacity += pushed;
                    if excess[to] == 0 {
                        active.push_back(to);
                    }
                    excess[node] -= pushed;
                    excess[to] += pushed;
                } else {
                    current[node] += 1;
                }
            }
        }
        let reaches = self.distances().iter().map(|&distance| distance <= nodes).collect();
        (flow, reaches)
    }

    /// Puts a node just above the lowest that it can push to. Where a height is left empty, nothing above it reaches the sink.
    fn lift(&self, node: usize, height: &mut [usize], at_height: &mut [usize]) {
        let nodes = height.len();
        let old = height[node];
        let open = self.leaving[node]
            .iter()
            .map(|&number| &self.arcs[number as usize])
            .filter(|arc| arc.capacity > 0);
        let lowest = open.map(|arc| height[arc.to as usize]).min().unwrap_or(nodes);
        at_height[old] -= 1;
        height[node] = if self.sink[node] > 0 { 1 } else { (lowest + 1).min(nodes + 1) };
        at_height[height[node]] += 1;
        if at_height[old] == 0 {
            for h in height.iter_mut().filter(|h| **h > old && **h <= nodes) {
                at_height[*h] -= 1;
                *h = nodes + 1;
                at_height[nodes + 1] += 1;
            }
        }
    }

    /// How many arcs it takes from each node to the sink; one more than there are nodes where there is no way.
    fn distances(&self) -> Vec<usize> {
        let nodes = self.leaving.len();
        let mut distance = vec![nodes + 1; nodes];
        let mut queue: VecDeque<usize> = (0..nodes).filter(|&node| self.sink[node] > 0).collect();
        queue.iter().for_each(|&node| distance[node] = 1);
        while let Some(node) = queue.pop_front() {
            for &number in &self.leaving[node] {
                let (to, back) = (self.arcs[number as usize].to as usize, &self.arcs[number as usize ^ 1]);
                if back.capacity > 0 && distance[to] > nodes {
                    distance[to] = distance[node] + 1;
                    queue.push_back(to);
                }
            }
        }
        distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What a cut costs: the capacities from the source's side to the sink's.
    fn price(ends: &[(i64, i64)], arcs: &[(usize, usize, i64)], sink_side: &[bool]) -> i64 {
        let ends =
            ends.iter().zip(sink_side).map(|(&(source, sink), &side)| if side { source } else { sink });
        let arcs =
            arcs.iter().filter(|&&(from, to, _)| !sink_side[from] && sink_side[to]).map(|&(_, _, c)| c);
        ends.sum::<i64>() + arcs.sum::<i64>()
    }

    proptest! {
        #[test]
        fn the_flow_is_the_cheapest_of_all_cuts(
            ends in prop::collection::vec((0i64..20, 0i64..20), 1..9),
            arcs in prop::collection::vec((0usize..8, 0usize..8, 0i64..20), 0..24),
        ) {
            let nodes = ends.len();
            let arcs: Vec<_> = arcs.into_iter().filter(|&(a, b, _)| a != b && a < nodes && b < nodes).collect();
            let mut network = Network::new(nodes);
            for (node, &(source, sink)) in ends.iter().enumerate() {
                network.add_source(node, source);
                network.add_sink(node, sink);
            }
            arcs.iter().for_each(|&(from, to, capacity)| network.add_arc(from, to, capacity));
            let (flow, side) = network.cut();
            let sides = |bits: usize| (0..nodes).map(|n| bits >> n & 1 == 1).collect::<Vec<_>>();
            let least = (0..1 << nodes).map(|bits| price(&ends, &arcs, &sides(bits))).min().unwrap();
            prop_assert_eq!(flow, least);
            prop_assert_eq!(price(&ends, &arcs, &side), least);
        }
    }
}
