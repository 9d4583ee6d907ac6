//! Path lengths along the vessels.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::support::geometry::{Point, distance};

/// The branches as roads between nodes. Lengths in m.
pub struct Roads {
    /// The length of each branch, m.
    pub length: Vec<f64>,
    /// The two nodes of each branch.
    pub ends: Vec<[usize; 2]>,
    /// Per node its branches, with the node at the other end.
    around: Vec<Vec<(usize, usize)>>,
    /// Per inner point its branch and the length from the branch's first node to it.
    on: Vec<(usize, f64)>,
}

/// Path lengths from some nodes as far as a limit, kept to be used again.
pub struct Reached {
    /// Per node its path length, m; infinite where it was not reached.
    length: Vec<f64>,
    touched: Vec<usize>,
    /// The nodes to go on from, by the bits of their path lengths: these are never negative, so that their bits are in their order.
    open: BinaryHeap<Reverse<(u64, usize)>>,
}

impl Reached {
    /// How many nodes were reached.
    pub fn count(&self) -> usize {
        self.touched.len()
    }
}

impl Roads {
    /// The roads of branches whose inner points are numbered after the nodes, branch by branch.
    pub fn new(nodes: usize, lines: &[Vec<usize>], position: &[Point]) -> Self {
        let mut roads = Self { length: Vec::new(), ends: Vec::new(), around: vec![Vec::new(); nodes], on: Vec::new() };
        for (branch, line) in lines.iter().enumerate() {
            let (first, last) = (line[0], line[line.len() - 1]);
            let mut arc = 0.0;
            for pair in line.windows(2) {
                arc += distance(position[pair[0]], position[pair[1]]);
                roads.on.push((branch, arc));
            }
            roads.on.pop();
            roads.length.push(arc);
            roads.ends.push([first, last]);
            roads.around[first].push((branch, last));
            roads.around[last].push((branch, first));
        }
        roads
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.around.len()
    }

    /// The branches at a node, each with the node at its other end.
    pub fn around(&self, node: usize) -> &[(usize, usize)] {
        &self.around[node]
    }

    /// Room for the path lengths.
    pub fn room(&self) -> Reached {
        Reached { length: vec![f64::INFINITY; self.around.len()], touched: Vec::new(), open: BinaryHeap::new() }
    }

    /// Path lengths from the sources to all nodes no further than `limit`.
    pub fn reach(&self, sources: &[usize], limit: f64, reached: &mut Reached) {
        self.visit(sources, limit, reached, |_, _| true);
    }

    /// Goes through the nodes from the nearest to the sources on, as far as `limit`, by Dijkstra's algorithm, while `on` of the
    /// path lengths and the node says so. Path lengths are final for the nodes gone through.
    pub fn visit(&self, sources: &[usize], limit: f64, reached: &mut Reached, mut on: impl FnMut(&[f64], usize) -> bool) {
        for node in reached.touched.drain(..) {
            reached.length[node] = f64::INFINITY;
        }
        reached.open.clear();
        for node in sources {
            if reached.length[*node] > 0.0 {
                reached.length[*node] = 0.0;
                reached.touched.push(*node);
                reached.open.push(Reverse((0, *node)));
            }
        }
        while let Some(Reverse((bits, node))) = reached.open.pop() {
            let length = f64::from_bits(bits);
            if length > reached.length[node] {
                continue;
            }
            if !on(&reached.length, node) {
                return;
            }
            for (branch, next) in &self.around[node] {
                let there = length + self.length[*branch];
                if there < reached.length[*next] && there <= limit {
                    if reached.length[*next] == f64::INFINITY {
                        reached.touched.push(*next);
                    }
                    reached.length[*next] = there;
                    reached.open.push(Reverse((there.to_bits(), *next)));
                }
            }
        }
    }

    /// The path length (m) to a point, infinite where no path within the limit leads to one of its nodes.
    pub fn to_point(&self, reached: &Reached, point: usize) -> f64 {
        let [first, last] = self.ways(&reached.length, point);
        first.min(last)
    }

    /// The path lengths to a point by the first and by the last node of its branch; to a node twice the same.
    pub fn ways(&self, to_node: &[f64], point: usize) -> [f64; 2] {
        let Some(inner) = point.checked_sub(self.around.len()) else { return [to_node[point]; 2] };
        let (branch, arc) = self.on[inner];
        let [first, last] = self.ends[branch];
        [to_node[first] + arc, to_node[last] + (self.length[branch] - arc)]
    }

    /// Per node the path length (m) to the nearest source; infinite without a path.
    pub fn to_nearest(&self, sources: &[usize]) -> Vec<f64> {
        let mut reached = self.room();
        self.reach(sources, f64::INFINITY, &mut reached);
        reached.length
    }

    /// Per point what its nodes' path lengths make of it.
    pub fn of_points(&self, to_node: &[f64]) -> Vec<f64> {
        let points = self.around.len() + self.on.len();
        (0..points).map(|p| self.ways(to_node, p)).map(|[a, b]| a.min(b)).collect()
    }
}
