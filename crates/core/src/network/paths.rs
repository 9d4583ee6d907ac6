//! Shortest paths: Dijkstra's algorithm, in memory that is used again. And what hangs on a vessel of a network, and which one of a loop is the
//! weakest.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};

use petgraph::unionfind::UnionFind;

use super::Network;
use super::walks::{Walk, other_end, vessels_at};
use crate::support::{grouped, ties::exceeds};

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

/// Per vessel the length of vessels that hangs on it, m: of the vessels `kept` the shorter side if it were cut, 0 where that cuts
/// nothing off; of others the shorter of the two parts that it would join, 0 where they are one.
///
/// In O(m α): a spanning forest, whose edges are bridges unless another vessel passes them by (Tarjan 1974, by union-find).
pub fn dependents(network: &Network, kept: &[bool]) -> Vec<f64> {
    let nodes = network.node_count();
    let at = vessels_at(network, |row| kept[row]);
    // By node the vessel up to its parent, how deep it lies, and the root of its part; nodes in breadth-first order.
    let (mut up, mut depth, mut root) = (vec![usize::MAX; nodes], vec![0_usize; nodes], vec![usize::MAX; nodes]);
    let mut order = Vec::with_capacity(nodes);
    for start in 0..nodes {
        if root[start] != usize::MAX {
            continue;
        }
        root[start] = start;
        let mut next = VecDeque::from([start]);
        while let Some(node) = next.pop_front() {
            order.push(node);
            for row in &at[node] {
                let other = other_end(network, *row, node);
                if root[other] == usize::MAX {
                    (root[other], up[other], depth[other]) = (start, *row, depth[node] + 1);
                    next.push_back(other);
                }
            }
        }
    }
    let parent = |node: usize| other_end(network, up[node], node);
    // The length below each node, and of each part. What closes a loop takes the way round it off the bridges.
    let (mut below, mut is_bridge) = (vec![0.0; nodes], vec![true; nodes]);
    let mut climbed = UnionFind::<usize>::new(nodes);
    let mut top: Vec<usize> = (0..nodes).collect();
    for (row, ([a, b], vessel)) in network.vessels().enumerate().filter(|(row, _)| kept[*row]) {
        if up[a] == row || up[b] == row {
            continue;
        }
        below[a] += vessel.length;
        let (mut a, mut b) = (top[climbed.find(a)], top[climbed.find(b)]);
        while a != b {
            let deeper = if depth[a] >= depth[b] { &mut a } else { &mut b };
            is_bridge[*deeper] = false;
            let to = top[climbed.find(parent(*deeper))];
            climbed.union(*deeper, to);
            top[climbed.find(to)] = to;
            *deeper = to;
        }
    }
    for node in order.iter().rev().filter(|node| up[**node] != usize::MAX) {
        below[parent(*node)] += below[*node] + network.vessel(up[*node]).length;
    }
    let mut found = vec![0.0; network.vessel_count()];
    for node in (0..nodes).filter(|node| up[*node] != usize::MAX && is_bridge[*node]) {
        let (whole, length) = (below[root[node]], network.vessel(up[node]).length);
        // What rounding leaves of the whole is no vessel.
        let rest = if exceeds(whole, below[node] + length) { whole - below[node] - length } else { 0.0 };
        found[up[node]] = below[node].min(rest);
    }
    for (row, ([a, b], _)) in network.vessels().enumerate().filter(|(row, _)| !kept[*row]) {
        if root[a] != root[b] {
            found[row] = below[root[a]].min(below[root[b]]);
        }
    }
    found
}

/// Of each independent loop of the vessels `kept` the least probable one that is not given, with the length of the way round it, m: what a spanning forest
/// of the most probable vessels leaves over (Kruskal's algorithm).
pub fn weakest_of_loops(network: &Network, kept: &[bool]) -> Vec<(usize, f64)> {
    let chance = |row: usize| network.vessel(row).evidence().map_or(1.0, |evidence| evidence.probability);
    let mut rows: Vec<usize> = (0..network.vessel_count()).filter(|row| kept[*row]).collect();
    rows.sort_by(|a, b| chance(*b).total_cmp(&chance(*a)).then(a.cmp(b)));
    let mut at: Vec<Vec<(usize, usize, f64)>> = vec![Vec::new(); network.node_count()];
    let mut forest = UnionFind::<usize>::new(network.node_count());
    let mut paths = ShortestPaths::new(network.node_count());
    let mut found = Vec::new();
    for row in rows {
        let ([a, b], length) = (network.ends(row), network.vessel(row).length);
        if !forest.union(a, b) && chance(row) < 1.0 {
            paths.search(&[a], f64::INFINITY, |node| at[node].iter().copied(), |_, node| node != b);
            found.push((row, paths.lengths()[b]));
        }
        at[a].push((row, b, length));
        at[b].push((row, a, length));
    }
    found
}

/// What depends on whether vessels that meet at a place are one: were they taken apart in blocks, the shorter side that this sets apart or, where a block
/// stays connected by another way, the way round, m; the longest of the blocks. `ends` are the vessels, each with its node there and its block.
pub fn if_parted(network: &Network, kept: &[bool], ends: &[(usize, usize, usize)]) -> f64 {
    let nodes = network.node_count();
    let blocks = ends.iter().map(|(.., block)| block + 1).max().unwrap_or_default();
    let is_here = |node: usize| ends.iter().any(|(_, at, _)| *at == node);
    let block_of =
        |row: usize, node: usize| ends.iter().find(|(of, at, _)| (*of, *at) == (row, node)).map(|(.., block)| nodes + block);
    // A node for each block, in place of those where the vessels meet.
    let edges = network.vessels().enumerate().filter(|(row, _)| kept[*row]).filter_map(|(row, (pair, vessel))| {
        let [a, b] = pair.map(|node| if is_here(node) { block_of(row, node) } else { Some(node) });
        Some((row, [a?, b?], vessel.length))
    });
    let at = lengths_at(nodes + blocks, edges);
    let next = |node: usize| at[node].iter().copied();
    let mut paths = ShortestPaths::new(nodes + blocks);
    let mut whole = 0.0;
    let mut sides = Vec::with_capacity(blocks);
    for block in nodes..nodes + blocks {
        let mut side = 0.0;
        paths.search(&[block], f64::INFINITY, next, |_, node| {
            side += at[node].iter().map(|(.., length)| 0.5 * length).sum::<f64>();
            true
        });
        let lengths = &paths.lengths()[nodes..];
        let round = (0..blocks).filter(|other| nodes + other != block).map(|other| lengths[other]).fold(f64::INFINITY, f64::min);
        // Each part counts once, for its first block.
        whole += if lengths[..block - nodes].iter().all(|length| length.is_infinite()) { side } else { 0.0 };
        sides.push((side, round));
    }
    sides.into_iter().map(|(side, round)| if round.is_finite() { round } else { side.min(whole - side) }).fold(0.0, f64::max)
}
