//! The skeleton's voxels as a graph of nodes and branches, and its spurs.

use std::collections::{BTreeMap, BTreeSet};

use super::{Foreground, neighbours};
use willis_core::{network::Fragments, network::walks::edges_at, support::numbered::counted, support::numbered::marked};

/// A branch is a spur if its tip reaches less than this many of its own diameters beyond the wall of the vessel that it leaves.
const SPUR: f64 = 1.0;

/// A skeleton as nodes and the branches between them. Voxels are rows of the foreground.
#[derive(Debug, Clone, Default)]
pub struct Skeleton {
    /// The voxels of each node: one, or those of a junction.
    pub nodes: Vec<Vec<u32>>,
    /// The branches.
    pub branches: Vec<Branch>,
    /// Skeleton voxels without a neighbour, which make no vessel.
    pub specks: usize,
}

/// A line of voxels between two nodes.
#[derive(Debug, Clone)]
pub struct Branch {
    /// The nodes at its ends.
    pub ends: [usize; 2],
    /// The voxels between them, from the first end to the second.
    pub voxels: Vec<u32>,
}

/// The graph of a skeleton's voxels.
pub fn skeleton(vessels: &Foreground, thinned: &[u32]) -> Skeleton {
    let links = links(vessels, thinned);
    let mut found = Skeleton { specks: links.iter().filter(|at| at.is_empty()).count(), ..Skeleton::default() };
    // Voxels of which a line passes through have two links; the others are nodes, junctions of many voxels one.
    let mut node_of = vec![usize::MAX; thinned.len()];
    for cluster in clusters(&links) {
        for at in &cluster {
            node_of[*at] = found.nodes.len();
        }
        found.nodes.push(cluster.into_iter().map(|at| thinned[at]).collect());
    }
    let mut walked = vec![false; thinned.len()];
    for first in 0..thinned.len() {
        if node_of[first] != usize::MAX {
            found.add_branches(first, &links, &node_of, &mut walked, thinned);
        }
    }
    // What is left are rings without a junction: each gets a node at its first voxel.
    for first in 0..thinned.len() {
        if links[first].len() == 2 && node_of[first] == usize::MAX && !walked[first] {
            node_of[first] = found.nodes.len();
            found.nodes.push(vec![thinned[first]]);
            found.add_branches(first, &links, &node_of, &mut walked, thinned);
        }
    }
    found
}

impl Skeleton {
    /// Adds the branches from a voxel of a node. A link is taken from its lower voxel, and not at all within a node; a longer line, or a ring,
    /// the first time that it is met.
    fn add_branches(&mut self, first: usize, links: &[BTreeSet<usize>], node_of: &[usize], walked: &mut [bool], thinned: &[u32]) {
        for next in &links[first] {
            let line = walk(first, *next, links, node_of);
            let last = line[line.len() - 1];
            let between = &line[1..line.len() - 1];
            let ends = [node_of[first], node_of[last]];
            let is_taken = match between {
                [] => last < first || ends[0] == ends[1],
                [next, ..] => walked[*next],
            };
            if !is_taken {
                for at in between {
                    walked[*at] = true;
                }
                self.branches.push(Branch { ends, voxels: between.iter().map(|at| thinned[*at]).collect() });
            }
        }
    }

    /// How many ends of branches each node has.
    pub fn degrees(&self) -> Vec<usize> {
        counted(self.nodes.len(), self.branches.iter().flat_map(|branch| branch.ends))
    }

    /// Removes the spurs and joins the branches that they leave behind; returns how many there were. At each junction the one that
    /// reaches least goes first, then all are looked at again, so that of a fork at the tip of a vessel one arm stays.
    pub fn prune(&mut self, reach: impl Fn(&Self, &Branch, usize) -> f64) -> usize {
        let mut removed = 0;
        loop {
            let degrees = self.degrees();
            let mut least: BTreeMap<usize, (f64, usize)> = BTreeMap::new();
            for (row, branch) in self.branches.iter().enumerate() {
                let [a, b] = branch.ends;
                let (junction, tip) = if degrees[a] == 1 { (b, a) } else { (a, b) };
                if degrees[tip] == 1 && degrees[junction] > 2 {
                    let reach = reach(self, branch, junction);
                    if reach < SPUR && least.get(&junction).is_none_or(|(known, _)| reach < *known) {
                        least.insert(junction, (reach, row));
                    }
                }
            }
            if least.is_empty() {
                return removed;
            }
            removed += least.len();
            self.remove(&marked(self.branches.len(), least.values().map(|(_, row)| *row)));
        }
    }

    /// Removes branches, given by row, and joins those that they leave behind.
    pub fn remove(&mut self, gone: &[bool]) {
        self.leave_out(gone);
        self.join_through();
    }

    fn leave_out(&mut self, gone: &[bool]) {
        let mut gone = gone.iter();
        self.branches.retain(|_| gone.next() == Some(&false));
    }

    /// Makes one branch of the two that meet at a node where no other does.
    fn join_through(&mut self) {
        let mut at = edges_at(self.nodes.len(), self.branches.iter().map(|branch| branch.ends).enumerate());
        let mut gone = vec![false; self.branches.len()];
        for node in 0..self.nodes.len() {
            let &[a, b] = at[node].as_slice() else { continue };
            if a == b {
                continue;
            }
            // The first is turned to end here, the second to begin here.
            let turned = |branch: &Branch, last: bool| {
                let mut branch = branch.clone();
                if (branch.ends[usize::from(last)]) != node {
                    branch.ends.reverse();
                    branch.voxels.reverse();
                }
                branch
            };
            let (first, second) = (turned(&self.branches[a], true), turned(&self.branches[b], false));
            let mut voxels = first.voxels;
            voxels.push(self.nodes[node][self.nodes[node].len() / 2]);
            voxels.extend(second.voxels);
            self.branches[a] = Branch { ends: [first.ends[0], second.ends[1]], voxels };
            gone[b] = true;
            at[second.ends[1]].iter_mut().filter(|row| **row == b).for_each(|row| *row = a);
            at[node].clear();
        }
        self.leave_out(&gone);
    }
}

/// The neighbours of each voxel of the skeleton, less the diagonals beside a way of shorter steps.
///
/// The union of the voxels has the homotopy type of the complex of all sets of mutual neighbours (boxes that touch in pairs have a
/// point in common). Removing an edge keeps it if one voxel touches both ends and every other voxel that does: Boissonnat and Pritam,
/// "Edge collapse and persistence of flag complexes" (2020). The longest edges go first, so that no triangle is left to look like a loop.
fn links(vessels: &Foreground, thinned: &[u32]) -> Vec<BTreeSet<usize>> {
    let at: BTreeMap<u32, usize> =
        thinned.iter().enumerate().map(|(row, voxel)| (vessels.place(*voxel as usize) as u32, row)).collect();
    let steps = neighbours(vessels.strides());
    let mut links: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); thinned.len()];
    let mut edges = Vec::new();
    for (row, voxel) in thinned.iter().enumerate() {
        let place = vessels.place(*voxel as usize) as isize;
        for (step, by) in steps {
            let Some(other) = u32::try_from(place + step).ok().and_then(|place| at.get(&place)).copied() else { continue };
            links[row].insert(other);
            if other > row {
                edges.push((by.iter().filter(|x| **x != 0).count(), row, other));
            }
        }
    }
    edges.sort_unstable_by(|a, b| b.cmp(a));
    loop {
        let before = edges.len();
        edges.retain(|(_, a, b)| {
            let common: Vec<usize> = links[*a].intersection(&links[*b]).copied().collect();
            let is_dominated = common.iter().any(|c| common.iter().all(|d| c == d || links[*c].contains(d)));
            if is_dominated {
                links[*a].remove(b);
                links[*b].remove(a);
            }
            !is_dominated
        });
        if edges.len() == before {
            return links;
        }
    }
}

/// The voxels of each node, in the order of their first: an end alone, the connected voxels of three or more links together, unless they
/// make a ring, which one node would hide.
fn clusters(links: &[BTreeSet<usize>]) -> Vec<Vec<usize>> {
    let is_junction = |at: usize| links[at].len() > 2;
    let within = |at: usize| links[at].iter().copied().filter(move |to| is_junction(at) && is_junction(*to));
    let parts = Fragments::over(links.len(), (0..links.len()).flat_map(|at| within(at).map(move |to| [at, to])));
    let mut clusters: Vec<(Vec<usize>, usize)> = vec![(Vec::new(), 0); parts.count];
    for at in (0..links.len()).filter(|at| is_junction(*at) || links[*at].len() == 1) {
        let (cluster, count) = &mut clusters[parts.of_node[at]];
        cluster.push(at);
        *count += within(at).count();
    }
    // Each link within was met from both ends.
    let parted = |(cluster, count): (Vec<usize>, usize)| {
        if count / 2 + 1 > cluster.len() { cluster.into_iter().map(|at| vec![at]).collect() } else { vec![cluster] }
    };
    let mut found: Vec<Vec<usize>> = clusters.into_iter().flat_map(parted).collect();
    found.sort_unstable_by_key(|cluster| cluster[0]);
    found
}

/// The voxels from a node over its neighbour to the next node, both included.
fn walk(first: usize, next: usize, links: &[BTreeSet<usize>], node_of: &[usize]) -> Vec<usize> {
    let mut line = vec![first, next];
    let (mut before, mut here) = (first, next);
    while node_of[here] == usize::MAX {
        let onward = links[here].iter().find(|to| **to != before);
        (before, here) = (here, onward.copied().unwrap_or(before));
        line.push(here);
    }
    line
}
