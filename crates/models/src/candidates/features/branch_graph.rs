//! The branches as a graph: path lengths along them, and the directions in which they leave a point.

use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::support::arc_lengths::arc_lengths;

/// The branches as edges between nodes. Lengths in m.
pub struct BranchGraph {
    /// The length of each branch, m.
    pub length: Vec<f64>,
    /// The two nodes of each branch.
    pub ends: Vec<[usize; 2]>,
    /// Per node its branches, with the node at the other end and the length, m.
    pub branches: Vec<Vec<(usize, usize, f64)>>,
    /// Per inner point its branch and the length from the branch's first node to it.
    arc: Vec<(usize, f64)>,
}

impl BranchGraph {
    /// The graph of branches whose inner points are numbered after the nodes, branch by branch.
    pub fn new(nodes: usize, lines: &[Vec<usize>], position: &[willis_core::support::geometry::Point]) -> Self {
        let (mut length, mut ends, mut inner) = (Vec::new(), Vec::new(), Vec::new());
        for (branch, line) in lines.iter().enumerate() {
            let (arc, last) = (arc_lengths(line.iter().map(|point| position[*point])), line.len() - 1);
            inner.extend(arc[1..last].iter().map(|arc| (branch, *arc)));
            length.push(arc[last]);
            ends.push([line[0], line[last]]);
        }
        let branches = lengths_at(nodes, (0..lines.len()).map(|branch| (branch, ends[branch], length[branch])));
        Self { length, ends, branches, arc: inner }
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.branches.len()
    }

    /// Visits the nodes along the branches, as [`ShortestPaths::search`] does.
    pub fn search(&self, sources: &[usize], limit: f64, paths: &mut ShortestPaths, visit: impl FnMut(&[f64], usize) -> bool) {
        paths.search(sources, limit, |node| self.branches[node].iter().copied(), visit);
    }

    /// The path length (m) to a point, given those to the nodes; infinite where neither node of its branch was reached.
    pub fn to_point(&self, to_node: &[f64], point: usize) -> f64 {
        let Some(inner) = point.checked_sub(self.branches.len()) else { return to_node[point] };
        let (branch, arc) = self.arc[inner];
        let [first, last] = self.ends[branch];
        (to_node[first] + arc).min(to_node[last] + (self.length[branch] - arc))
    }

    /// Per point the path length (m) to the nearest source; infinite without a path.
    pub fn to_nearest(&self, sources: &[usize]) -> Vec<f64> {
        let mut paths = ShortestPaths::new(self.nodes());
        self.search(sources, f64::INFINITY, &mut paths, |_, _| true);
        (0..self.nodes() + self.arc.len()).map(|point| self.to_point(paths.lengths(), point)).collect()
    }

    /// The directions in which branches leave a point: two between the ends of a branch, at a node as many as branches end there. The
    /// `lines` are those of the graph; others may follow.
    pub fn headings<'a>(&self, lines: &'a [Vec<usize>], point: usize) -> Vec<Heading<'a>> {
        let heading = |branch: usize, at, forwards| Heading { branch, line: &lines[branch], at, forwards };
        if let Some(inner) = point.checked_sub(self.nodes()) {
            let (branch, _) = self.arc[inner];
            // The inner points of a branch have consecutive numbers.
            let at = 1 + point - lines[branch][1];
            return vec![heading(branch, at, false), heading(branch, at, true)];
        }
        let mut branches: Vec<usize> = self.branches[point].iter().map(|(branch, ..)| *branch).collect();
        // A branch that returns to its node is there twice.
        branches.dedup();
        let mut headings = Vec::new();
        for branch in branches {
            let line = &lines[branch];
            let last = line.len() - 1;
            headings.extend((line[0] == point).then(|| heading(branch, 0, true)));
            headings.extend((line[last] == point).then(|| heading(branch, last, false)));
        }
        headings
    }
}

/// One of the two directions along a branch, from a point of it.
pub struct Heading<'a> {
    /// The branch.
    pub branch: usize,
    /// Its points.
    line: &'a [usize],
    /// The point's place among them.
    at: usize,
    forwards: bool,
}

impl Heading<'_> {
    /// The point so many steps on, or the node that ends the branch before that.
    pub fn walk(&self, steps: usize) -> usize {
        self.line[if self.forwards { (self.at + steps).min(self.line.len() - 1) } else { self.at.saturating_sub(steps) }]
    }
}
