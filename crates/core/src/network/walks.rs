//! Walks along edges: runs of vessels that follow each other at nodes where nothing else begins, and parts of a walk.

use super::{Network, PathPoint};
use crate::support::grouped;

/// Nodes and the edges between them: vessels of a network, or links of centerlines.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Walk {
    /// The nodes in order, one more than there are edges.
    pub nodes: Vec<usize>,
    /// The edges in order.
    pub edges: Vec<usize>,
}

impl Walk {
    /// The walk from a node along an edge. It goes on at the nodes that `passes` admits where just two edges are, and not round a ring twice.
    /// `at` are the edges at every node, `ends` the nodes of an edge.
    pub fn along(
        node: usize,
        first: usize,
        at: &[Vec<usize>],
        ends: impl Fn(usize) -> [usize; 2],
        passes: impl Fn(usize) -> bool,
    ) -> Self {
        let mut walk = Self { nodes: vec![node], edges: Vec::new() };
        let (mut node, mut edge) = (node, first);
        loop {
            node = other(ends(edge), node);
            walk.nodes.push(node);
            walk.edges.push(edge);
            match at[node][..] {
                [a, b] if passes(node) => edge = if a == edge { b } else { a },
                _ => return walk,
            }
            if edge == first {
                return walk;
            }
        }
    }

    /// The nodes where it begins and ends.
    pub fn ends(&self) -> [usize; 2] {
        [self.nodes[0], self.nodes[self.edges.len()]]
    }

    /// The points of its vessels in a network, in its direction, each shared node once.
    pub fn points(&self, network: &Network) -> Vec<PathPoint> {
        let mut points = Vec::new();
        for (row, node) in self.edges.iter().zip(&self.nodes) {
            points.extend_from_slice(&network.path_from(*row, *node)[usize::from(!points.is_empty())..]);
        }
        points
    }

    /// The part after its last node in `others`.
    #[must_use]
    pub fn after(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().rposition(|node| others.nodes.contains(node)).unwrap_or(0);
        Self { nodes: self.nodes[cut..].to_vec(), edges: self.edges[cut..].to_vec() }
    }

    /// The part before its first node in `others`.
    #[must_use]
    pub fn before(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().position(|node| others.nodes.contains(node)).unwrap_or(self.nodes.len() - 1);
        Self { nodes: self.nodes[..=cut].to_vec(), edges: self.edges[..cut].to_vec() }
    }

    /// Its first vessels up to a length (m), at least one.
    #[must_use]
    pub fn start(&self, network: &Network, most: f64) -> Self {
        let mut length = 0.0;
        let enough = |row: &usize| {
            length += network.vessel(*row).length;
            length >= most
        };
        let cut = self.edges.iter().position(enough).map_or(self.edges.len(), |at| at + 1);
        Self { nodes: self.nodes[..=cut].to_vec(), edges: self.edges[..cut].to_vec() }
    }
}

/// The edges at each of so many nodes, an edge from a node to itself twice. Edges are given by number with their nodes.
pub fn edges_at(nodes: usize, edges: impl Iterator<Item = (usize, [usize; 2])>) -> Vec<Vec<usize>> {
    grouped(nodes, edges.flat_map(|(edge, ends)| ends.map(|node| (node, edge))))
}

/// The vessels at every node that `counts` admits, a vessel from a node to itself twice.
pub fn vessels_at(network: &Network, counts: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    edges_at(network.node_count(), network.vessels().map(|(ends, _)| ends).enumerate().filter(|(row, _)| counts(*row)))
}

/// Every vessel in one run. A run goes on at the nodes that `passes` admits, where just two vessels of `at` have to be; it has the direction of
/// the first of its vessels. A ring of such nodes begins where its first vessel ends.
pub fn runs(network: &Network, at: &[Vec<usize>], passes: impl Fn(usize) -> bool) -> Vec<Walk> {
    let mut is_used = vec![false; network.vessel_count()];
    let along = |node: usize, first: usize| Walk::along(node, first, at, |row| network.ends(row), &passes);
    let mut found = Vec::new();
    for row in 0..network.vessel_count() {
        if is_used[row] {
            continue;
        }
        let back = along(network.ends(row)[1], row);
        let run = along(back.ends()[1], back.edges[back.edges.len() - 1]);
        run.edges.iter().for_each(|row| is_used[*row] = true);
        found.push(run);
    }
    found
}

/// Every edge in one run between nodes where not just two edges are, in the order of the nodes where they begin; then the rings without such a
/// node, from the first of their nodes on. `at` are the edges at every node, `ends` the nodes of an edge.
pub fn runs_by_node(at: &[Vec<usize>], ends: impl Fn(usize) -> [usize; 2]) -> Vec<Walk> {
    let mut is_used = vec![false; at.iter().flatten().max().map_or(0, |last| last + 1)];
    let mut found = Vec::new();
    for start in (0..at.len()).filter(|node| at[*node].len() != 2).chain(0..at.len()) {
        for first in &at[start] {
            if !is_used[*first] {
                let run = Walk::along(start, *first, at, &ends, |_| true);
                run.edges.iter().for_each(|edge| is_used[*edge] = true);
                found.push(run);
            }
        }
    }
    found
}

/// The other of the two nodes of an edge.
pub fn other([a, b]: [usize; 2], node: usize) -> usize {
    if a == node { b } else { a }
}

/// The node at the other end of a vessel.
pub fn other_end(network: &Network, row: usize, node: usize) -> usize {
    other(network.ends(row), node)
}
