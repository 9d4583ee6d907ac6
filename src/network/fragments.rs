//! Connected parts of a network and its independent cycles.

use petgraph::unionfind::UnionFind;

use super::Network;
use super::vessel::Vessel;

/// The connected parts of a network, numbered in the order of their first node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fragments {
    /// Per node the number of its part.
    pub of_node: Vec<usize>,
    /// How many parts there are.
    pub count: usize,
}

/// The connected parts over the vessels that `counts` admits; a node without vessel is a part of its own.
pub fn fragments(network: &Network, counts: impl Fn(usize, &Vessel) -> bool) -> Fragments {
    let mut parts = UnionFind::<usize>::new(network.node_count());
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        if counts(row, vessel) {
            parts.union(ends[0], ends[1]);
        }
    }
    let mut number = vec![usize::MAX; network.node_count()];
    let mut count = 0;
    let of_node = (0..network.node_count())
        .map(|node| {
            let slot = &mut number[parts.find(node)];
            if *slot == usize::MAX {
                *slot = count;
                count += 1;
            }
            *slot
        })
        .collect();
    Fragments { of_node, count }
}

/// The number of independent cycles, E - N + parts, self-loops and parallel vessels included.
pub fn cycles(network: &Network) -> usize {
    network.vessel_count() + fragments(network, |_, _| true).count - network.node_count()
}
