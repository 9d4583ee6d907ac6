//! Elimination orders of a graph: least degree, least fill.

use std::collections::BTreeSet;

use super::graph::{BitMatrix, Lists, Remaining};
use crate::support::{marked, placed};

/// Up to so many nodes a matrix of bits is used; it then takes at most 32 MB.
pub const MOST_IN_BITS: usize = 1 << 14;

/// Larger graphs are lists until no node has fewer neighbours than this: the rest is dense, and bits where it fits.
pub const DENSE: usize = 32;

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

/// Eliminates the node of least degree, ties to the lower number, until none is left.
///
/// `None` as soon as the pairs of neighbours, summed over the stars, exceed `limit`.
pub fn least_degree(nodes: usize, links: &[[usize; 2]], limit: usize) -> Option<Vec<Star>> {
    if nodes <= MOST_IN_BITS {
        return by_degree(nodes, &mut BitMatrix::new(nodes, links), usize::MAX, limit);
    }
    let (mut stars, left) = low_degrees(nodes, links, DENSE - 1, limit)?;
    let pairs: usize = stars.iter().map(Star::pairs).sum();
    stars.extend(of_the_rest(&stars, &left, limit - pairs)?);
    Some(stars)
}

/// The stars of the nodes that `gone` leaves, whose neighbours that remain are given; in the same order as if nobody had stopped.
fn of_the_rest(gone: &[Star], neighbours: &[Vec<usize>], limit: usize) -> Option<Vec<Star>> {
    let is_gone = marked(neighbours.len(), gone.iter().map(|star| star.center));
    let rest: Vec<usize> = (0..neighbours.len()).filter(|node| !is_gone[*node]).collect();
    let place = placed(neighbours.len(), rest.iter().copied());
    let pairs = rest.iter().flat_map(|a| neighbours[*a].iter().filter(move |b| a < *b).map(move |b| [*a, *b]));
    let links: Vec<[usize; 2]> = pairs.map(|pair| pair.map(|node| place[node])).collect();
    let mut stars = if rest.len() <= MOST_IN_BITS {
        by_degree(rest.len(), &mut BitMatrix::new(rest.len(), &links), usize::MAX, limit)
    } else {
        by_degree(rest.len(), &mut Lists::new(rest.len(), &links), usize::MAX, limit)
    }?;
    for star in &mut stars {
        star.center = rest[star.center];
        star.neighbours.iter_mut().for_each(|node| *node = rest[*node]);
    }
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

/// The stars of [`least_degree`] and [`low_degrees`].
pub fn by_degree(nodes: usize, graph: &mut impl Remaining, most: usize, limit: usize) -> Option<Vec<Star>> {
    let mut degree: Vec<usize> = (0..nodes).map(|node| graph.degree(node)).collect();
    let mut queue: BTreeSet<(usize, usize)> = degree.iter().copied().zip(0..nodes).filter(|(of, _)| *of <= most).collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some((least, center)) = queue.pop_first() {
        if least + stars.len() + 1 == nodes {
            // All that are left are joined to one another, and wait in the order of their numbers.
            let rest: Vec<usize> = std::iter::once(center).chain(queue.iter().map(|(_, node)| *node)).collect();
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
        for node in &star.neighbours {
            queue.remove(&(degree[*node], *node));
            degree[*node] = graph.degree(*node);
            if degree[*node] <= most {
                queue.insert((degree[*node], *node));
            }
        }
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
    let mut graph = BitMatrix::new(nodes, links);
    let mut figures: Vec<(usize, usize, usize)> = (0..nodes).map(|node| figure(&graph, node)).collect();
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
        graph.eliminate(center);
        for node in graph.surroundings(&star.neighbours, fill > 0) {
            let figure = figure(&graph, node);
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

/// The pairs of neighbours not joined yet, the degree, and the node.
fn figure(graph: &BitMatrix, node: usize) -> (usize, usize, usize) {
    let around = graph.neighbours(node);
    let joined: usize = around.iter().map(|other| graph.shared(node, *other)).sum();
    let pairs = around.len() * around.len().saturating_sub(1);
    ((pairs - joined) / 2, around.len(), node)
}
