//! Elimination orders of a graph: least degree, least fill.

use std::collections::BTreeSet;

/// Least fill is tried on programs up to this many joins; finding it costs about the square of the degrees each step.
const FILL_LIMIT: usize = 60_000;

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

    /// The pairs of neighbours of a node that are not joined yet.
    fn fill(&self, node: usize) -> usize {
        let around: Vec<usize> = self.neighbours[node].iter().copied().collect();
        let missing = |(i, a): (usize, &usize)| around[i + 1..].iter().filter(|b| !self.neighbours[*a].contains(b)).count();
        around.iter().enumerate().map(missing).sum()
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
/// `None` when it does not end below `limit` pairs, or is not tried because `limit` is large.
pub fn least_fill(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    if limit > FILL_LIMIT {
        return None;
    }
    let mut graph = Remaining::new(nodes, links);
    let figure = |graph: &Remaining, node: usize| (graph.fill(node), graph.neighbours[node].len(), node);
    let mut figures: Vec<(usize, usize, usize)> = (0..nodes).map(|node| figure(&graph, node)).collect();
    let mut queue: BTreeSet<(usize, usize, usize)> = figures.iter().copied().collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some((_, _, center)) = queue.pop_first() {
        let star = graph.eliminate(center);
        pairs += star.pairs();
        if pairs >= limit {
            return None;
        }
        // A join changes the fill of its two ends and of everything next to them both.
        let mut touched: BTreeSet<usize> = star.neighbours.iter().copied().collect();
        for i in &star.neighbours {
            touched.extend(&graph.neighbours[*i]);
        }
        for node in touched {
            queue.remove(&figures[node]);
            figures[node] = figure(&graph, node);
            queue.insert(figures[node]);
        }
        stars.push(star);
    }
    Some(stars)
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
        for stars in [least_degree(16, &grid(), usize::MAX), least_fill(16, &grid(), FILL_LIMIT)] {
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
