//! The best single forest: the maximum spanning arborescence over a virtual ground, by Edmonds' algorithm.
//!
//! In O(m log² m), with heaps of which the smaller is moved to the larger, and a union-find that can be rolled back (Gabow, Galil, Spencer and Tarjan 1986).

use std::{cmp::Reverse, collections::BinaryHeap};

use super::Forests;

/// Scores beyond this are cut.
const MOST_SCORE: f64 = 1000.0;
/// Scores are compared in units of 2⁻⁶⁰.
const SCORE_BITS: i32 = 60;
/// Below them, the sum of the edges' rows. Lowered costs stay within twice the largest: 119 bits.
const ROW_BITS: u32 = 48;

/// The forest with the largest sum of scores: per fragment the edge that attaches it, `None` for a root.
///
/// `edges` and `roots` are the scores of each; they are taken to 2⁻⁶⁰ and summed exactly, cut at ±1000. An edge scored -∞ is not taken.
/// Among forests of the same score the one with the smallest sum of rows wins, roots counted after all edges;
/// what still ties goes to the lower row.
///
/// # Panics
///
/// The scores belong to other forests.
pub fn arborescence(forests: &Forests, edges: &[f64], roots: &[f64]) -> Vec<Option<usize>> {
    assert_eq!(edges.len(), forests.edges().len(), "one score per edge");
    assert_eq!(roots.len(), forests.fragments(), "one score per fragment");
    let ground = forests.fragments();
    let arc = |from: usize, to: usize, cost: i128, row: Option<usize>| Arc { from, to, cost, row };
    let possible = forests.edges().iter().zip(edges).enumerate().filter(|(_, (_, score))| **score != f64::NEG_INFINITY);
    let between = possible.map(|(row, (edge, score))| arc(edge.parent, edge.child, cost(*score, row), Some(row)));
    let to_ground = roots.iter().enumerate().map(|(at, score)| arc(ground, at, cost(*score, edges.len() + at), None));
    let arcs: Vec<Arc> = between.chain(to_ground).collect();
    chosen(&arcs, ground).into_iter().map(|arc| arcs[arc].row).collect()
}

/// An arc from a parent to its child.
struct Arc {
    from: usize,
    to: usize,
    cost: i128,
    row: Option<usize>,
}

/// The score first, then the row, as one whole number: smaller is better, and no sum is rounded.
fn cost(score: f64, row: usize) -> i128 {
    let units = (score.clamp(-MOST_SCORE, MOST_SCORE) * 2_f64.powi(SCORE_BITS)).round() as i128;
    (-units << ROW_BITS) + row as i128
}

/// A cycle that became one node, to be opened again.
struct Cycle {
    node: usize,
    joins: usize,
    arcs: Vec<usize>,
}

/// Per node below `root` the arc of the cheapest arborescence that enters it. Every node has an arc from the root.
fn chosen(arcs: &[Arc], root: usize) -> Vec<usize> {
    let mut entering: Vec<EnteringArcs> = (0..=root).map(|_| EnteringArcs::default()).collect();
    for (at, arc) in arcs.iter().enumerate() {
        entering[arc.to].heap.push(Reverse((arc.cost, at)));
    }
    let mut union = UnionFind::new(root + 1);
    let mut seen = vec![usize::MAX; root + 1];
    seen[root] = root;
    let mut enters = vec![usize::MAX; root + 1];
    let mut cycles = Vec::new();
    for start in 0..root {
        let (mut path, mut node) = (Vec::new(), start);
        while seen[node] == usize::MAX {
            // The cheapest arc lowers the costs of all others by its own.
            let Some(Reverse((cost, arc))) = entering[node].heap.pop() else { break };
            entering[node].lowered = cost;
            path.push((node, arc));
            seen[node] = start;
            node = union.find(arcs[arc].from);
            if seen[node] == start {
                // Back on the path: what lies on the cycle becomes one node with all its arcs.
                let (joins, end) = (union.joined.len(), path.len());
                let (mut whole, mut from) = (EnteringArcs::default(), end);
                loop {
                    from -= 1;
                    let member = path[from].0;
                    whole.meld(std::mem::take(&mut entering[member]));
                    if !union.join(node, member) {
                        break;
                    }
                }
                node = union.find(node);
                entering[node] = whole;
                seen[node] = usize::MAX;
                cycles.push(Cycle { node, joins, arcs: path.drain(from..).map(|(_, arc)| arc).collect() });
            }
        }
        for (_, arc) in path {
            enters[union.find(arcs[arc].to)] = arc;
        }
    }
    for cycle in cycles.iter().rev() {
        union.roll_back(cycle.joins);
        let from_outside = enters[cycle.node];
        for arc in &cycle.arcs {
            enters[union.find(arcs[*arc].to)] = *arc;
        }
        enters[union.find(arcs[from_outside].to)] = from_outside;
    }
    enters.truncate(root);
    enters
}

/// The arcs that enter a node, the cheapest on top; of equally cheap ones the lower.
#[derive(Default)]
struct EnteringArcs {
    /// Costs, all larger by `lowered` than they are.
    heap: BinaryHeap<Reverse<(i128, usize)>>,
    lowered: i128,
}

impl EnteringArcs {
    /// Takes in those of another node; the fewer are moved to the more.
    fn meld(&mut self, mut other: Self) {
        if self.heap.len() < other.heap.len() {
            std::mem::swap(self, &mut other);
        }
        let by = self.lowered - other.lowered;
        self.heap.extend(other.heap.into_iter().map(|Reverse((cost, arc))| Reverse((cost + by, arc))));
    }
}

/// Sets of numbered items, each with a representative.
#[derive(Debug, Clone)]
pub struct UnionFind {
    parent: Vec<usize>,
    size: Vec<usize>,
    /// The representatives that ceased to be ones, in order.
    joined: Vec<usize>,
}

impl UnionFind {
    /// Every item by itself.
    pub fn new(items: usize) -> Self {
        Self { parent: (0..items).collect(), size: vec![1; items], joined: Vec::new() }
    }

    /// The representative of an item's set.
    pub fn find(&self, mut item: usize) -> usize {
        while self.parent[item] != item {
            item = self.parent[item];
        }
        item
    }

    /// Joins two sets; `false` when they are one already.
    pub fn join(&mut self, a: usize, b: usize) -> bool {
        let (a, b) = (self.find(a), self.find(b));
        if a == b {
            return false;
        }
        let (large, small) = if self.size[a] >= self.size[b] { (a, b) } else { (b, a) };
        self.parent[small] = large;
        self.size[large] += self.size[small];
        self.joined.push(small);
        true
    }

    /// Undoes the last joins until so many are left.
    pub fn roll_back(&mut self, joins: usize) {
        for small in self.joined.drain(joins..).rev() {
            self.size[self.parent[small]] -= self.size[small];
            self.parent[small] = small;
        }
    }
}
