//! Elimination of fragments in order of least degree.

use std::collections::BTreeSet;

/// A matrix of bits is several times faster than lists; so many nodes take 128 MB.
const MOST_IN_BITS: usize = 1 << 15;

/// A fragment at the moment of its elimination.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Star {
    /// The fragment eliminated.
    pub center: usize,
    /// Its neighbours then, in order of number; all are eliminated later.
    pub neighbours: Vec<usize>,
}

/// Takes out the fragment with the fewest neighbours, the lower number on ties, and joins its neighbours, until none is left.
pub fn least_degree(nodes: usize, links: &[[usize; 2]]) -> Vec<Star> {
    if nodes <= MOST_IN_BITS { by_degree(nodes, Bits::new(nodes, links)) } else { by_degree(nodes, Lists::new(nodes, links)) }
}

fn by_degree(nodes: usize, mut graph: impl Neighbours) -> Vec<Star> {
    let mut degree: Vec<usize> = (0..nodes).map(|node| graph.degree(node)).collect();
    let mut queue: BTreeSet<(usize, usize)> = degree.iter().copied().zip(0..nodes).collect();
    let mut stars = Vec::with_capacity(nodes);
    while let Some((least, center)) = queue.pop_first() {
        if least == queue.len() {
            // All that are left are joined to one another.
            let mut rest: Vec<usize> = queue.iter().map(|(_, node)| *node).chain([center]).collect();
            rest.sort_unstable();
            stars.extend((0..rest.len()).map(|at| Star { center: rest[at], neighbours: rest[at + 1..].to_vec() }));
            break;
        }
        let neighbours = graph.eliminate(center);
        for node in &neighbours {
            queue.remove(&(degree[*node], *node));
            degree[*node] = graph.degree(*node);
            queue.insert((degree[*node], *node));
        }
        stars.push(Star { center, neighbours });
    }
    stars
}

/// A graph whose nodes are taken out.
trait Neighbours {
    fn degree(&self, node: usize) -> usize;

    /// Takes a node out and joins its neighbours, which are returned.
    fn eliminate(&mut self, center: usize) -> Vec<usize>;
}

/// A row of bits per node.
struct Bits {
    words: usize,
    bits: Vec<u64>,
}

impl Bits {
    fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let words = nodes.div_ceil(64);
        let mut bits = vec![0; nodes * words];
        for [a, b] in links {
            bits[a * words + b / 64] |= 1 << (b % 64);
            bits[b * words + a / 64] |= 1 << (a % 64);
        }
        Self { words, bits }
    }
}

impl Neighbours for Bits {
    fn degree(&self, node: usize) -> usize {
        self.bits[node * self.words..(node + 1) * self.words].iter().map(|word| word.count_ones() as usize).sum()
    }

    fn eliminate(&mut self, center: usize) -> Vec<usize> {
        let around = self.bits[center * self.words..(center + 1) * self.words].to_vec();
        let neighbours = ones(&around);
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
fn ones(words: &[u64]) -> Vec<usize> {
    let mut out = Vec::new();
    for (at, word) in words.iter().enumerate() {
        let mut rest = *word;
        while rest != 0 {
            out.push(at * 64 + rest.trailing_zeros() as usize);
            rest &= rest - 1;
        }
    }
    out
}

/// A sorted list per node.
struct Lists(Vec<Vec<usize>>);

impl Lists {
    fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let mut lists = vec![Vec::new(); nodes];
        for [a, b] in links {
            lists[*a].push(*b);
            lists[*b].push(*a);
        }
        for list in &mut lists {
            list.sort_unstable();
            list.dedup();
        }
        Self(lists)
    }
}

impl Neighbours for Lists {
    fn degree(&self, node: usize) -> usize {
        self.0[node].len()
    }

    fn eliminate(&mut self, center: usize) -> Vec<usize> {
        let around = std::mem::take(&mut self.0[center]);
        for node in &around {
            let list = &mut self.0[*node];
            list.extend_from_slice(&around);
            #[expect(clippy::stable_sort_primitive, reason = "two sorted runs, which the stable sort only merges")]
            list.sort();
            list.dedup();
            list.retain(|other| *other != center && other != node);
        }
        around
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By hand: a ring of four with a tail. The tail goes first, then the ring is closed by the edge 1-3.
    #[test]
    fn the_order_and_the_fill_of_a_ring_with_a_tail() {
        let stars = least_degree(5, &[[0, 1], [1, 2], [2, 3], [3, 0], [2, 4], [4, 2]]);
        let star = |center, neighbours: &[usize]| Star { center, neighbours: neighbours.to_vec() };
        assert_eq!(stars, [star(4, &[2]), star(0, &[1, 3]), star(1, &[2, 3]), star(2, &[3]), star(3, &[])]);
    }

    #[test]
    fn bits_and_lists_give_the_same_order() {
        let links: Vec<[usize; 2]> = (0..300).flat_map(|i| [[i, (i + 1) % 300], [i, (i * i + 7) % 300]]).collect();
        let links: Vec<[usize; 2]> = links.into_iter().filter(|[a, b]| a != b).collect();
        let stars = by_degree(300, Bits::new(300, &links));
        assert!(stars.len() == 300 && stars[0].neighbours.len() < 10);
        assert_eq!(stars, by_degree(300, Lists::new(300, &links)));
    }
}
