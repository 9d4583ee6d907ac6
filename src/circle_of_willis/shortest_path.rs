//! The shortest way between sets of nodes over some of the vessels.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use crate::network::Network;

/// A way through a network.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Way {
    /// Its nodes from the first to the last.
    pub nodes: Vec<usize>,
    /// The vessels between them.
    pub vessels: Vec<usize>,
}

/// Sets of nodes as flags by row.
pub(crate) type Marks = Vec<bool>;

/// Flags of some nodes.
pub(crate) fn marks(network: &Network, nodes: impl IntoIterator<Item = usize>) -> Marks {
    let mut marks = vec![false; network.node_count()];
    for node in nodes {
        marks[node] = true;
    }
    marks
}

/// The shortest way by length from any node of `from` to any of `to` over the vessels that `may` admits, through no node of `avoid`
/// but at its ends; a node of both sets is a way without vessels. Ways longer than `most` (m) do not count. Dijkstra's algorithm.
pub(crate) fn shortest(network: &Network, [from, to, avoid]: [&Marks; 3], may: impl Fn(usize) -> bool, most: f64) -> Option<Way> {
    let mut best = vec![f64::INFINITY; network.node_count()];
    let mut came: Vec<Option<(usize, usize)>> = vec![None; network.node_count()];
    // Lengths are never negative, so that their bits are in their order.
    let mut open = BinaryHeap::new();
    for node in (0..from.len()).filter(|node| from[*node]) {
        best[node] = 0.0;
        open.push(Reverse((0_u64, node)));
    }
    while let Some(Reverse((bits, node))) = open.pop() {
        let length = f64::from_bits(bits);
        if length > best[node] {
            continue;
        }
        if to[node] {
            return Some(back(&came, node));
        }
        if avoid[node] && !from[node] {
            continue;
        }
        for edge in network.graph().edges(NodeIndex::new(node)) {
            let (vessel, next) = (edge.id().index(), edge.target().index());
            let further = length + edge.weight().length.max(0.0);
            if may(vessel) && further < best[next] && further <= most {
                best[next] = further;
                came[next] = Some((node, vessel));
                open.push(Reverse((further.to_bits(), next)));
            }
        }
    }
    None
}

fn back(came: &[Option<(usize, usize)>], end: usize) -> Way {
    let mut way = Way { nodes: vec![end], vessels: Vec::new() };
    let mut at = end;
    while let Some((node, vessel)) = came[at] {
        way.nodes.push(node);
        way.vessels.push(vessel);
        at = node;
    }
    way.nodes.reverse();
    way.vessels.reverse();
    way
}

impl Way {
    /// What is left of it from its last node that `others` has.
    pub fn after(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().rposition(|node| others.nodes.contains(node)).unwrap_or(0);
        Self { nodes: self.nodes[cut..].to_vec(), vessels: self.vessels[cut..].to_vec() }
    }

    /// What is left of it up to its first node that `others` has.
    pub fn before(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().position(|node| others.nodes.contains(node)).unwrap_or(self.nodes.len() - 1);
        Self { nodes: self.nodes[..=cut].to_vec(), vessels: self.vessels[..cut].to_vec() }
    }

    /// Its first vessels, up to a length (m); one at least.
    pub fn start(&self, network: &Network, most: f64) -> Self {
        let mut length = 0.0;
        let enough = |vessel: &usize| {
            length += network.vessel(*vessel).length;
            length >= most
        };
        let cut = self.vessels.iter().position(enough).map_or(self.vessels.len(), |at| at + 1);
        Self { nodes: self.nodes[..=cut].to_vec(), vessels: self.vessels[..cut].to_vec() }
    }
}
