//! Elimination orders of a graph: least degree, least fill.

use std::collections::BTreeSet;

/// Least fill is tried on graphs of so many nodes and programs of so many joins; finding it takes longer than least degree.
const FILL_NODES: usize = 4096;
const FILL_JOINS: usize = 60_000;

/// A node at the moment of its elimination.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Star {
    /// The node eliminated.
    pub center: usize,
    /// Its neighbours then, all eliminated later.
    pub neighbours: Vec<usize>,
}

impl Star {
    /// The pairs of its neighbours.
    pub fn pairs(&self) -> usize {
        self.neighbours.len() * self.neighbours.len().saturating_sub(1) / 2
    }
}

/// The graph while it is eliminated.
struct Remaining {
    neighbours: Vec<BTreeSet<usize>>,
}

impl Remaining {
    fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let mut neighbours = vec![BTreeSet::new(); nodes];
        for [a, b] in links.iter().filter(|[a, b]| a != b) {
            neighbours[*a].insert(*b);
            neighbours[*b].insert(*a);
        }
        Self { neighbours }
    }

    /// Takes a node out and joins its neighbours pairwise.
    fn eliminate(&mut self, center: usize) -> Star {
        let neighbours: Vec<usize> = std::mem::take(&mut self.neighbours[center]).into_iter().collect();
        for i in &neighbours {
            self.neighbours[*i].remove(&center);
            self.neighbours[*i].extend(neighbours.iter().filter(|j| *j != i));
        }
        Star { center, neighbours }
    }
}

/// Eliminates the node of least degree, ties to the lower number, until none is left.
///
/// `None` as soon as the pairs of neighbours, summed over the stars, exceed `limit`.
pub fn least_degree(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    let mut graph = Remaining::new(nodes, links);
    let mut queue: BTreeSet<(usize, usize)> = graph.neighbours.iter().enumerate().map(|(node, n)| (n.len(), node)).collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some((_, center)) = queue.pop_first() {
        for i in &graph.neighbours[center] {
            queue.remove(&(graph.neighbours[*i].len(), *i));
        }
        let star = graph.eliminate(center);
        pairs += star.pairs();
        if pairs > limit {
            return None;
        }
        queue.extend(star.neighbours.iter().map(|i| (graph.neighbours[*i].len(), *i)));
        stars.push(star);
    }
    Some(stars)
}

/// Eliminates the node whose elimination joins the fewest pairs anew, ties to the lower degree, then the lower number.
///
/// `None` when it does not end below `limit` pairs, or is not tried because the graph or `limit` is large.
pub fn least_fill(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    if limit > FILL_JOINS || nodes > FILL_NODES {
        return None;
    }
    let mut graph = Joined::new(nodes, links);
    let mut figures: Vec<(usize, usize, usize)> = (0..nodes).map(|node| graph.figure(node)).collect();
    let mut queue: BTreeSet<(usize, usize, usize)> = figures.iter().copied().collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some((fill, _, center)) = queue.pop_first() {
        let star = Star { center, neighbours: graph.neighbours(center) };
        pairs += star.pairs();
        if pairs >= limit {
            return None;
        }
        // A join changes the figure of its two ends and of whatever is next to them both.
        let touched = graph.eliminate(&star, fill > 0);
        for node in touched {
            let figure = graph.figure(node);
            if figure != figures[node] {
                queue.remove(&figures[node]);
                queue.insert(figure);
                figures[node] = figure;
            }
        }
        stars.push(star);
    }
    Some(stars)
}

/// A graph as a matrix of bits.
struct Joined {
    words: usize,
    bits: Vec<u64>,
}

impl Joined {
    fn new(nodes: usize, links: &[[usize; 2]]) -> Self {
        let words = nodes.div_ceil(64);
        let mut graph = Self { words, bits: vec![0; nodes * words] };
        for [a, b] in links.iter().filter(|[a, b]| a != b) {
            graph.join(*a, *b);
        }
        graph
    }

    fn join(&mut self, a: usize, b: usize) {
        self.bits[a * self.words + b / 64] |= 1 << (b % 64);
        self.bits[b * self.words + a / 64] |= 1 << (a % 64);
    }

    fn row(&self, node: usize) -> &[u64] {
        &self.bits[node * self.words..(node + 1) * self.words]
    }

    fn neighbours(&self, node: usize) -> Vec<usize> {
        ones(self.row(node))
    }

    /// The pairs of neighbours not joined yet, the degree, and the node.
    fn figure(&self, node: usize) -> (usize, usize, usize) {
        let around = self.neighbours(node);
        let shared = |other: &usize| {
            let both = self.row(node).iter().zip(self.row(*other)).map(|(a, b)| (a & b).count_ones() as usize);
            both.sum::<usize>()
        };
        let joined: usize = around.iter().map(shared).sum();
        let pairs = around.len() * around.len().saturating_sub(1);
        ((pairs - joined) / 2, around.len(), node)
    }

    /// Takes out the center of a star and joins its neighbours; returns the nodes whose figure may have changed.
    fn eliminate(&mut self, star: &Star, joins: bool) -> Vec<usize> {
        for (i, a) in star.neighbours.iter().enumerate() {
            self.bits[a * self.words + star.center / 64] &= !(1 << (star.center % 64));
            for b in &star.neighbours[i + 1..] {
                self.join(*a, *b);
            }
        }
        let mut touched = vec![0; self.words];
        for node in &star.neighbours {
            touched[node / 64] |= 1 << (node % 64);
            if joins {
                touched.iter_mut().zip(self.row(*node)).for_each(|(t, row)| *t |= row);
            }
        }
        self.bits[star.center * self.words..(star.center + 1) * self.words].fill(0);
        ones(&touched)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A 4 x 4 grid.
    fn grid() -> Vec<[usize; 2]> {
        let right = (0..16).filter(|i| i % 4 < 3).map(|i| [i, i + 1]);
        right.chain((0..12).map(|i| [i, i + 4])).collect()
    }

    #[test]
    fn both_orders_eliminate_every_node_once_and_join_neighbours() {
        for stars in [least_degree(16, &grid(), usize::MAX), least_fill(16, &grid(), FILL_JOINS)] {
            let stars = stars.expect("below the limit");
            let mut seen: Vec<usize> = stars.iter().map(|s| s.center).collect();
            let place: Vec<usize> = (0..16).map(|n| seen.iter().position(|s| *s == n).expect("each node")).collect();
            for star in &stars {
                assert!(star.neighbours.iter().all(|n| place[*n] > place[star.center]));
                let first = star.neighbours.iter().min_by_key(|n| place[**n]);
                let later = |n: &&usize| Some(*n) != first;
                assert!(
                    first.is_none_or(|f| star.neighbours.iter().filter(later).all(|n| stars[place[*f]].neighbours.contains(n)))
                );
            }
            seen.sort_unstable();
            assert!(seen.into_iter().eq(0..16));
        }
    }

    #[test]
    fn a_limit_ends_the_search() {
        assert_eq!(least_degree(16, &grid(), 10), None);
        assert_eq!(least_degree(3, &[[0, 1], [1, 2], [2, 2]], 0).map(|s| s.len()), Some(3));
    }
}
