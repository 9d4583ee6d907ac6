//! The ways out of a point along its branches.

use super::extraction::Extraction;
use crate::candidates::NetworkPoint;

/// A way out of a point: along a branch to one of its nodes.
#[derive(Debug, Clone, Copy)]
pub struct Way {
    /// The branch.
    pub branch: usize,
    /// The point's place on the branch.
    at: usize,
    forwards: bool,
}

impl Extraction {
    /// The ways out of a point: two on the way of a branch, at a node as many as it has links.
    pub(super) fn ways(&self, point: usize) -> Vec<Way> {
        let way = |branch, at, forwards| Way { branch, at, forwards };
        if let NetworkPoint::Along { .. } = self.place[point] {
            let branch = self.branch[point];
            // The inner points of a branch have consecutive numbers.
            let at = 1 + point - self.lines[branch][1];
            return vec![way(branch, at, false), way(branch, at, true)];
        }
        let mut branches: Vec<usize> = self.roads.around(point).iter().map(|(branch, _)| *branch).collect();
        // A branch that returns to its node is there twice.
        branches.dedup();
        let mut ways = Vec::with_capacity(self.degree[point]);
        for branch in branches {
            let line = &self.lines[branch];
            let last = line.len() - 1;
            ways.extend((line[0] == point).then(|| way(branch, 0, true)));
            ways.extend((line[last] == point).then(|| way(branch, last, false)));
        }
        ways
    }

    /// The point so many steps on, or the node that ends the branch before that.
    pub(super) fn along(&self, way: Way, steps: usize) -> usize {
        let line = &self.lines[way.branch];
        line[if way.forwards { (way.at + steps).min(line.len() - 1) } else { way.at.saturating_sub(steps) }]
    }
}
