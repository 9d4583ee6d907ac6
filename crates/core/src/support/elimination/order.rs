//! Elimination orders of a graph: least degree, least fill.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::graph::{BitMatrix, Lists, Remaining};
use crate::support::numbered::{marked, placed};

/// Up to so many nodes a matrix of bits is used, which then takes at most 32 MB; larger graphs are lists.
pub const MOST_IN_BITS: usize = 1 << 14;

/// In lists nodes of at most so many neighbours are eliminated; what is left is mostly so small and dense that bits are faster.
const FEW: usize = 32;

/// Least fill is only tried on graphs of at most so many nodes and programs of at most so many joins: it takes longer than least degree.
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

/// The order of fewest joins: by least degree or by least fill. `None` for more than `limit` pairs by least degree.
pub fn fewest_joins(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    let by_degree = least_degree(nodes, links, limit)?;
    let pairs = by_degree.iter().map(Star::pairs).sum();
    let may_fill = nodes <= FILL_NODES && pairs <= FILL_JOINS;
    let by_fill = if may_fill { least_fill(nodes, links, pairs) } else { None };
    Some(by_fill.unwrap_or(by_degree))
}

/// Eliminates the node of least degree, ties to the lower number, until none is left.
///
/// `None` as soon as the pairs of neighbours, summed over the stars, exceed `limit`.
pub fn least_degree(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    if nodes <= MOST_IN_BITS {
        return by_degree(nodes, &mut BitMatrix::new(nodes, links), usize::MAX, limit);
    }
    let (mut stars, lists) = low_degrees(nodes, links, FEW, limit)?;
    let is_gone = marked(nodes, stars.iter().map(|star| star.center));
    let left: Vec<usize> = (0..nodes).filter(|node| !is_gone[*node]).collect();
    let row = placed(nodes, left.iter().copied());
    // Rows in the order of the nodes, so that ties go to the lower number as before.
    let links: Vec<[usize; 2]> = left.iter().flat_map(|a| lists[*a].iter().map(|b| [row[*a], row[*b]])).collect();
    let limit = limit - stars.iter().map(Star::pairs).sum::<usize>();
    let rest = if left.len() <= MOST_IN_BITS {
        by_degree(left.len(), &mut BitMatrix::new(left.len(), &links), usize::MAX, limit)
    } else {
        by_degree(left.len(), &mut Lists::new(left.len(), &links), usize::MAX, limit)
    };
    stars.extend(rest?.into_iter().map(|Star { center, neighbours }| Star {
        center: left[center],
        neighbours: neighbours.into_iter().map(|node| left[node]).collect(),
    }));
    Some(stars)
}

/// Eliminates the node of least degree, ties to the lower number, as long as that is at most `most`. Returns the stars and,
/// per node that remains, its neighbours that remain; `None` for more than `limit` pairs.
pub fn low_degrees(nodes: usize, links: &[[usize; 2]], most: usize, limit: usize) -> Option<(Vec<Star>, Vec<Vec<usize>>)> {
    let mut graph = Lists::new(nodes, links);
    let stars = by_degree(nodes, &mut graph, most, limit)?;
    Some((stars, graph.into_lists()))
}

/// The order of Cuthill and McKee (1969), reversed, of the nodes that `among` admits: neighbours lie near to one another.
pub fn reverse_cuthill_mckee(neighbours: &[Vec<usize>], among: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut seen: Vec<bool> = (0..neighbours.len()).map(|node| !among(node)).collect();
    let mut order = Vec::new();
    for first in 0..neighbours.len() {
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut next = order.len();
        order.push(first);
        while next < order.len() {
            let begin = order.len();
            for node in &neighbours[order[next]] {
                if !std::mem::replace(&mut seen[*node], true) {
                    order.push(*node);
                }
            }
            order[begin..].sort_by_key(|node| neighbours[*node].len());
            next += 1;
        }
    }
    order.reverse();
    order
}

/// The degree, or the pairs to join, of a node that has been eliminated.
const GONE: usize = usize::MAX;

/// The stars of [`least_degree`] and [`low_degrees`].
pub fn by_degree(nodes: usize, graph: &mut impl Remaining, most: usize, limit: usize) -> Option<Vec<Star>> {
    let mut degree: Vec<usize> = (0..nodes).map(|node| graph.degree(node)).collect();
    let low = degree.iter().copied().zip(0..nodes).filter(|(degree, _)| *degree <= most);
    let mut queue: BinaryHeap<Reverse<(usize, usize)>> = low.map(Reverse).collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some(Reverse((least, center))) = queue.pop() {
        // What has another degree by now stands further on; what is gone has none.
        if degree[center] != least {
            continue;
        }
        if least + stars.len() + 1 == nodes {
            // All that are left are joined to one another.
            let rest: Vec<usize> = (0..nodes).filter(|node| degree[*node] != GONE).collect();
            pairs += (0..=least).map(|rays| rays * rays.saturating_sub(1) / 2).sum::<usize>();
            if pairs > limit {
                return None;
            }
            stars.extend((0..rest.len()).map(|at| Star { center: rest[at], neighbours: rest[at + 1..].to_vec() }));
            break;
        }
        let star = Star { center, neighbours: graph.eliminate(center) };
        pairs += star.pairs();
        if pairs > limit {
            return None;
        }
        degree[center] = GONE;
        for node in &star.neighbours {
            let now = graph.degree(*node);
            if now != degree[*node] && now <= most {
                queue.push(Reverse((now, *node)));
            }
            degree[*node] = now;
        }
        stars.push(star);
    }
    Some(stars)
}

/// Eliminates the node whose elimination joins the fewest pairs anew, ties to the lower degree, then the lower number.
///
/// `None` when it does not end below `limit` pairs.
pub fn least_fill(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    let mut graph = BitMatrix::new(nodes, links);
    let mut figures: Vec<(usize, usize, usize)> = (0..nodes).map(|node| figure(&graph, node)).collect();
    let mut queue: BinaryHeap<Reverse<(usize, usize, usize)>> = figures.iter().copied().map(Reverse).collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some(Reverse(least)) = queue.pop() {
        let (fill, _, center) = least;
        if figures[center] != least {
            continue;
        }
        let star = Star { center, neighbours: graph.eliminate(center) };
        figures[center].0 = GONE;
        pairs += star.pairs();
        if pairs >= limit {
            return None;
        }
        // A join changes the figure of its two ends and of whatever is next to them both.
        for node in graph.surroundings(&star.neighbours, fill > 0) {
            let figure = figure(&graph, node);
            if figure != figures[node] {
                queue.push(Reverse(figure));
                figures[node] = figure;
            }
        }
        stars.push(star);
    }
    Some(stars)
}

/// The pairs of neighbours not joined yet, the degree, and the node.
fn figure(graph: &BitMatrix, node: usize) -> (usize, usize, usize) {
    let (mut degree, mut joined) = (0, 0);
    for other in graph.neighbours(node) {
        degree += 1;
        joined += graph.shared(node, other);
    }
    ((degree * usize::saturating_sub(degree, 1) - joined) / 2, degree, node)
}
