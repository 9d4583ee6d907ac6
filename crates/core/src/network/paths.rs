//! Shortest paths: Dijkstra's algorithm, in memory that is used again.

use std::{cmp::Reverse, collections::BinaryHeap};

use super::walks::Walk;
use crate::support::grouped;

/// The edges at each node, as a search takes them: number, node at the other end, length (m).
pub type LengthsAt = Vec<Vec<(usize, usize, f64)>>;

/// The edges at each of so many nodes. They are given with their two nodes.
pub fn lengths_at(nodes: usize, edges: impl Iterator<Item = (usize, [usize; 2], f64)>) -> LengthsAt {
    grouped(nodes, edges.flat_map(|(edge, [a, b], length)| [(a, (edge, b, length)), (b, (edge, a, length))]))
}

/// The shortest paths from some nodes. One value serves many searches over the same nodes.
pub struct ShortestPaths {
    /// Per node its path length, m; infinite where it was not reached.
    lengths: Vec<f64>,
    /// Per reached node the node before it and the edge between; none at a source.
    previous: Vec<Option<(usize, usize)>>,
    reached: Vec<usize>,
    /// The nodes to go on from, by the bits of their path lengths: these are never negative, so that their bits are in their order.
    open: BinaryHeap<Reverse<(u64, usize)>>,
}

impl ShortestPaths {
    /// Memory for so many nodes.
    pub fn new(nodes: usize) -> Self {
        Self { lengths: vec![f64::INFINITY; nodes], previous: vec![None; nodes], reached: Vec::new(), open: BinaryHeap::new() }
    }

    /// Path lengths (m) from the last sources, per node; infinite where none leads within the limit.
    pub fn lengths(&self) -> &[f64] {
        &self.lengths
    }

    /// How many nodes the last search reached.
    pub fn count(&self) -> usize {
        self.reached.len()
    }

    /// Visits the nodes from the nearest to the sources on, as far as `limit` (m), until `visit` returns false. Of equally near
    /// nodes the lower comes first.
    ///
    /// `edges` gives the edges at a node: number, node at the other end, length (m). `visit` gets the path lengths so far, which are
    /// final for the nodes visited.
    pub fn search<E: IntoIterator<Item = (usize, usize, f64)>>(
        &mut self,
        sources: &[usize],
        limit: f64,
        edges: impl Fn(usize) -> E,
        mut visit: impl FnMut(&[f64], usize) -> bool,
    ) {
        for node in self.reached.drain(..) {
            (self.lengths[node], self.previous[node]) = (f64::INFINITY, None);
        }
        self.open.clear();
        for source in sources {
            self.reach(*source, 0.0, None);
        }
        while let Some(Reverse((bits, node))) = self.open.pop() {
            let length = f64::from_bits(bits);
            if length > self.lengths[node] {
                continue;
            }
            if !visit(&self.lengths, node) {
                return;
            }
            for (edge, next, step) in edges(node) {
                if length + step <= limit {
                    self.reach(next, length + step, Some((node, edge)));
                }
            }
        }
    }

    fn reach(&mut self, node: usize, length: f64, from: Option<(usize, usize)>) {
        if length < self.lengths[node] {
            if self.lengths[node] == f64::INFINITY {
                self.reached.push(node);
            }
            (self.lengths[node], self.previous[node]) = (length, from);
            self.open.push(Reverse((length.to_bits(), node)));
        }
    }

    /// The node before a node that was visited, and the edge between; none at a source.
    pub fn previous(&self, node: usize) -> Option<(usize, usize)> {
        self.previous[node]
    }

    /// The walk from a source to a node that was visited.
    pub fn path_to(&self, node: usize) -> Walk {
        let (mut nodes, mut edges) = (vec![node], Vec::new());
        let mut at = node;
        while let Some((previous, edge)) = self.previous[at] {
            nodes.push(previous);
            edges.push(edge);
            at = previous;
        }
        nodes.reverse();
        edges.reverse();
        Walk { nodes, edges }
    }
}
