//! A graph whose nodes are removed one after another; the neighbours of a removed node are joined to one another.

use crate::support::{distinct, grouped};

/// The graph of the nodes that remain.
pub trait Remaining {
    /// How many neighbours a node has.
    fn degree(&self, node: usize) -> usize;

    /// Removes a node and joins its neighbours. Returns these in order of number.
    fn eliminate(&mut self, center: usize) -> Vec<usize>;
}

/// As a matrix of bits, several times faster than lists as long as it is small.
pub struct BitMatrix {
    words: usize,
    bits: Vec<u64>,
}

impl BitMatrix {
    /// Links from a node to itself count for nothing.
    pub fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let words = nodes.div_ceil(64);
        let mut bits = vec![0; nodes * words];
        for [a, b] in links.iter().filter(|[a, b]| a != b) {
            bits[a * words + b / 64] |= 1 << (b % 64);
            bits[b * words + a / 64] |= 1 << (a % 64);
        }
        Self { words, bits }
    }

    fn row(&self, node: usize) -> &[u64] {
        &self.bits[node * self.words..(node + 1) * self.words]
    }

    /// The neighbours in order of number.
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> {
        ones(self.row(node))
    }

    /// How many neighbours two nodes have in common.
    pub fn shared(&self, a: usize, b: usize) -> usize {
        self.row(a).iter().zip(self.row(b)).map(|(a, b)| (a & b).count_ones() as usize).sum()
    }

    /// Some nodes and, where asked for, their neighbours, in order of number.
    pub fn surroundings(&self, nodes: &[usize], with_neighbours: bool) -> Vec<usize> {
        let mut found = vec![0; self.words];
        for node in nodes {
            found[node / 64] |= 1 << (node % 64);
            if with_neighbours {
                found.iter_mut().zip(self.row(*node)).for_each(|(found, row)| *found |= row);
            }
        }
        ones(&found).collect()
    }
}

impl Remaining for BitMatrix {
    fn degree(&self, node: usize) -> usize {
        self.row(node).iter().map(|word| word.count_ones() as usize).sum()
    }

    fn eliminate(&mut self, center: usize) -> Vec<usize> {
        let around = self.row(center).to_vec();
        let neighbours: Vec<usize> = ones(&around).collect();
        for node in &neighbours {
            let row = &mut self.bits[node * self.words..(node + 1) * self.words];
            row.iter_mut().zip(&around).for_each(|(row, around)| *row |= around);
            row[node / 64] &= !(1 << (node % 64));
            row[center / 64] &= !(1 << (center % 64));
        }
        neighbours
    }
}

/// The numbers of the bits that are set.
fn ones(words: &[u64]) -> impl Iterator<Item = usize> {
    words.iter().enumerate().flat_map(|(at, word)| {
        let mut rest = *word;
        std::iter::from_fn(move || {
            let bit = (rest != 0).then(|| at * 64 + rest.trailing_zeros() as usize);
            rest &= rest.saturating_sub(1);
            bit
        })
    })
}

/// As a sorted list per node. What was removed may still stand in the lists of others, so that a leaf leaves a hub without a look at its list.
pub struct Lists {
    neighbours: Vec<Vec<usize>>,
    removed: Vec<bool>,
    degree: Vec<usize>,
}

impl Lists {
    /// Links from a node to itself count for nothing.
    pub fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let links = links.iter().filter(|[a, b]| a != b);
        let neighbours = grouped(nodes, links.flat_map(|[a, b]| [(*a, *b), (*b, *a)]));
        let neighbours: Vec<Vec<usize>> = neighbours.into_iter().map(distinct).collect();
        Self { removed: vec![false; nodes], degree: neighbours.iter().map(Vec::len).collect(), neighbours }
    }

    /// Per node its neighbours that have not been removed.
    pub fn into_lists(self) -> Vec<Vec<usize>> {
        let Self { mut neighbours, removed, .. } = self;
        for list in &mut neighbours {
            list.retain(|other| !removed[*other]);
        }
        neighbours
    }
}

impl Remaining for Lists {
    fn degree(&self, node: usize) -> usize {
        self.degree[node]
    }

    fn eliminate(&mut self, center: usize) -> Vec<usize> {
        let Self { neighbours, removed, degree } = self;
        let mut around = std::mem::take(&mut neighbours[center]);
        around.retain(|node| !removed[*node]);
        (removed[center], degree[center]) = (true, 0);
        if let [node] = around[..] {
            degree[node] -= 1;
            return around;
        }
        for node in &around {
            let list = &mut neighbours[*node];
            list.extend_from_slice(&around);
            #[expect(clippy::stable_sort_primitive, reason = "two sorted runs, which the stable sort only merges")]
            list.sort();
            list.dedup();
            list.retain(|other| !removed[*other] && other != node);
            degree[*node] = list.len();
        }
        around
    }
}
