//! The maximum spanning forest of resilience, equal to the minimum spanning forest of 1/ρ, by Kruskal's algorithm.
//!
//! Of a pattern of an enumeration the expected one: each vessel with the share of the orders of equal resiliences in which the maximum
//! spanning forest has it, where every order is as likely as any other.

use std::collections::BTreeMap;

use petgraph::unionfind::UnionFind;
use rand::Rng;

use super::coins::rounded;
use crate::support::{random, random::stream};

/// The memory of Kruskal's algorithm for one worker.
#[derive(Debug, Clone, Default)]
pub struct Kruskal {
    keys: Vec<u64>,
    parent: Vec<u32>,
}

impl Kruskal {
    /// Forgets the vessels of the last sample.
    pub fn clear(&mut self) {
        self.keys.clear();
    }

    /// Adds a diffused vessel by its key.
    pub fn add(&mut self, key: u64) {
        self.keys.push(key);
    }

    /// Calls `take` for each vessel of the maximum spanning forest, largest resilience first; `row` tells where a key's vessel is among `ends`.
    pub fn grow(&mut self, nodes: usize, ends: &[[usize; 2]], row: impl Fn(u64) -> usize, mut take: impl FnMut(usize)) {
        self.keys.sort_unstable_by(|a, b| b.cmp(a));
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        for key in &self.keys {
            let vessel = row(*key);
            let [a, b] = ends[vessel].map(|node| root(&mut self.parent, node as u32));
            if a != b {
                self.parent[a.max(b) as usize] = a.min(b);
                take(vessel);
            }
        }
    }
}

/// The root of a node's tree, halving the path on the way.
fn root(parent: &mut [u32], mut node: u32) -> u32 {
    while parent[node as usize] != node {
        parent[node as usize] = parent[parent[node as usize] as usize];
        node = parent[node as usize];
    }
    node
}

/// States of a group of equals, after so many of its vessels were taken, that are followed at the most.
const MOST_STATES: usize = 1 << 10;
/// Orders that are drawn of a larger group.
const DRAWN: u32 = 1 << 12;

/// A diffused vessel, or a chain of vessels in series.
#[derive(Debug, Clone, Copy)]
pub struct ForestEdge {
    /// Its resilience, or that of the weakest of the chain, W/m³.
    pub resilience: f64,
    /// Its row, which `take` is told.
    pub row: usize,
    /// Its nodes.
    pub ends: [usize; 2],
    /// How many vessels of the chain tie for the weakest; 1 for a single vessel.
    pub weakest: usize,
}

/// The memory of one worker.
#[derive(Debug, Clone, Default)]
pub struct ExpectedForest {
    parent: Vec<u32>,
    /// Those of a group of equals that lie between two parts which larger ones leave; their nodes are these parts.
    equal: Vec<ForestEdge>,
}

impl ExpectedForest {
    /// Calls `take` with the row of each candidate that may be in the forest and the probability that all of it is. `all` is sorted on the way.
    pub fn grow(&mut self, nodes: usize, all: &mut [ForestEdge], mut take: impl FnMut(usize, f64)) {
        all.sort_unstable_by(|a, b| rounded(b.resilience).total_cmp(&rounded(a.resilience)).then(a.row.cmp(&b.row)));
        self.parent.clear();
        self.parent.extend(0..nodes as u32);
        for group in all.chunk_by(|a, b| rounded(a.resilience) == rounded(b.resilience)) {
            self.equal.clear();
            for edge in group {
                let ends = edge.ends.map(|node| root(&mut self.parent, node as u32) as usize);
                if ends[0] != ends[1] {
                    self.equal.push(ForestEdge { ends, ..*edge });
                }
            }
            match &self.equal[..] {
                [only] => take(only.row, 1.0),
                several => {
                    for part in loops(several, &mut take) {
                        part.iter().zip(shares(&part)).for_each(|(tied, share)| take(tied.row, share));
                    }
                }
            }
            for ForestEdge { ends, .. } in &self.equal {
                let [a, b] = ends.map(|node| root(&mut self.parent, node as u32));
                self.parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
}

/// The connected parts of a group of equals without the branches that close no loop: those are in every forest, and taken.
fn loops(equal: &[ForestEdge], take: &mut impl FnMut(usize, f64)) -> Vec<Vec<ForestEdge>> {
    let mut around: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (at, tied) in equal.iter().enumerate() {
        tied.ends.iter().for_each(|node| around.entry(*node).or_default().push(at));
    }
    let mut open: Vec<usize> = around.keys().copied().collect();
    while let Some(node) = open.pop() {
        if let [only] = around[&node][..] {
            take(equal[only].row, 1.0);
            for node in equal[only].ends {
                around.entry(node).or_default().retain(|at| *at != only);
                open.push(node);
            }
        }
    }
    let (mut parts, mut seen) = (Vec::new(), vec![false; equal.len()]);
    for start in around.values().flatten() {
        let (mut part, mut stack) = (Vec::new(), vec![*start]);
        while let Some(at) = stack.pop() {
            if !std::mem::replace(&mut seen[at], true) {
                part.push(equal[at]);
                stack.extend(equal[at].ends.iter().flat_map(|node| &around[node]));
            }
        }
        if !part.is_empty() {
            parts.push(part);
        }
    }
    parts
}

/// The probability of each of a connected part to be in the forest. Of a ring of n vessels each is left out once in n orders. In other parts
/// all orders are followed, those that leave the same parts connected together; of a part too large for that, orders are drawn.
fn shares(part: &[ForestEdge]) -> Vec<f64> {
    let mut nodes: Vec<usize> = part.iter().flat_map(|tied| tied.ends).collect();
    nodes.sort_unstable();
    if nodes.chunk_by(|a, b| a == b).all(|same| same.len() == 2) {
        let vessels: usize = part.iter().map(|tied| tied.weakest).sum();
        return part.iter().map(|tied| 1.0 - tied.weakest as f64 / vessels as f64).collect();
    }
    nodes.dedup();
    let place = |node: usize| nodes.partition_point(|other| *other < node);
    // A chain is taken vessel by vessel, with nodes of its own between them.
    let (mut vessels, mut count) = (Vec::new(), nodes.len());
    for (at, tied) in part.iter().enumerate() {
        let [mut from, to] = tied.ends.map(place);
        for _ in 1..tied.weakest {
            vessels.push((at, [from, count]));
            (from, count) = (count, count + 1);
        }
        vessels.push((at, [from, to]));
    }
    let mut inside = vec![0.0; part.len()];
    if !follow(&vessels, count, &mut inside) {
        draw(&vessels, count, &mut inside);
    }
    // At most one vessel of a chain is left out.
    part.iter().zip(inside).map(|(tied, inside)| inside - (tied.weakest - 1) as f64).collect()
}

/// Adds up the expected number of vessels of each of a part in the forest, over all orders; false where that takes too many states. A state
/// is which nodes are connected: the next vessel is any of those that connect two others.
fn follow(vessels: &[(usize, [usize; 2])], nodes: usize, inside: &mut [f64]) -> bool {
    let mut states = BTreeMap::from([((0..nodes).collect::<Vec<usize>>(), 1.0)]);
    inside.fill(0.0);
    while !states.is_empty() && states.len() <= MOST_STATES {
        let mut next = BTreeMap::new();
        for (label, probability) in &states {
            let joins = |(_, ends): &&(usize, [usize; 2])| label[ends[0]] != label[ends[1]];
            let each = probability / vessels.iter().filter(joins).count().max(1) as f64;
            for (at, [a, b]) in vessels.iter().filter(joins) {
                inside[*at] += each;
                let (kept, gone) = (label[*a].min(label[*b]), label[*a].max(label[*b]));
                let joined = label.iter().map(|l| if *l == gone { kept } else { *l }).collect();
                *next.entry(joined).or_insert(0.0) += each;
            }
        }
        states = next;
    }
    states.is_empty()
}

/// The same from orders that are drawn.
fn draw(vessels: &[(usize, [usize; 2])], nodes: usize, inside: &mut [f64]) {
    inside.fill(0.0);
    let mut rng = stream(0, random::VESSELS_THAT_TIE);
    let mut order: Vec<(u64, usize)> = (0..vessels.len()).map(|at| (0, at)).collect();
    for _ in 0..DRAWN {
        for (key, _) in &mut order {
            *key = rng.next_u64();
        }
        order.sort_unstable();
        let mut joined = UnionFind::<usize>::new(nodes);
        for (_, at) in &order {
            let (of, [a, b]) = vessels[*at];
            if joined.union(a, b) {
                inside[of] += 1.0 / f64::from(DRAWN);
            }
        }
    }
}
