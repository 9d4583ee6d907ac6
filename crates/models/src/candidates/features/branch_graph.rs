//! The branches as a graph: path lengths along them, and the directions in which they leave a point.

use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, distance};

/// The branches as edges between nodes. Lengths in m.
pub struct BranchGraph {
    /// The length of each branch, m.
    pub length: Vec<f64>,
    /// The two nodes of each branch.
    pub ends: Vec<[usize; 2]>,
    /// Per node its branches, with the node at the other end.
    branches: Vec<Vec<(usize, usize)>>,
    /// Per inner point its branch and the length from the branch's first node to it.
    arc: Vec<(usize, f64)>,
}

impl BranchGraph {
    /// The graph of branches whose inner points are numbered after the nodes, branch by branch.
    pub fn new(nodes: usize, lines: &[Vec<usize>], position: &[Point]) -> Self {
        let mut graph = Self { length: Vec::new(), ends: Vec::new(), branches: vec![Vec::new(); nodes], arc: Vec::new() };
        for (branch, line) in lines.iter().enumerate() {
            let (first, last) = (line[0], line[line.len() - 1]);
            let mut arc = 0.0;
            for pair in line.windows(2) {
                arc += distance(position[pair[0]], position[pair[1]]);
                graph.arc.push((branch, arc));
            }
            graph.arc.pop();
            graph.length.push(arc);
            graph.ends.push([first, last]);
            graph.branches[first].push((branch, last));
            graph.branches[last].push((branch, first));
        }
        graph
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        self.branches.len()
    }

    /// The branches at a node, each with the node at its other end.
    pub fn branches(&self, node: usize) -> &[(usize, usize)] {
        &self.branches[node]
    }

    /// Visits the nodes along the branches, as [`ShortestPaths::search`] does.
    pub fn search(&self, sources: &[usize], limit: f64, paths: &mut ShortestPaths, visit: impl FnMut(&[f64], usize) -> bool) {
        let edges = |node: usize| self.branches[node].iter().map(|(branch, next)| (*branch, *next, self.length[*branch]));
        paths.search(sources, limit, edges, visit);
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
        let mut branches: Vec<usize> = self.branches(point).iter().map(|(branch, _)| *branch).collect();
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
#[derive(Debug, Clone, Copy)]
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
