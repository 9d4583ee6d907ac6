//! Minimum-degree elimination order of a graph, with the fill it makes.

use std::collections::BTreeSet;

/// A node at the moment of its elimination.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Star {
    /// The node eliminated.
    pub center: usize,
    /// Its neighbours then, all eliminated later.
    pub neighbours: Vec<usize>,
}

/// Eliminates the node of least degree (ties to the lower number) until none is left.
///
/// `None` as soon as the pairs of neighbours, summed over the stars, exceed `limit`.
pub fn minimum_degree(nodes: usize, links: impl Iterator<Item = [usize; 2]>, limit: usize) -> Option<Vec<Star>> {
    let mut neighbours = vec![BTreeSet::new(); nodes];
    for [a, b] in links {
        neighbours[a].insert(b);
        neighbours[b].insert(a);
    }
    let mut queue: BTreeSet<(usize, usize)> = neighbours.iter().enumerate().map(|(node, n)| (n.len(), node)).collect();
    let mut stars = Vec::with_capacity(nodes);
    let mut pairs = 0;
    while let Some((degree, center)) = queue.pop_first() {
        pairs += degree * degree.saturating_sub(1) / 2;
        if pairs > limit {
            return None;
        }
        let star: Vec<usize> = std::mem::take(&mut neighbours[center]).into_iter().collect();
        for i in &star {
            queue.remove(&(neighbours[*i].len(), *i));
            neighbours[*i].remove(&center);
            neighbours[*i].extend(star.iter().filter(|j| *j != i));
        }
        queue.extend(star.iter().map(|i| (neighbours[*i].len(), *i)));
        stars.push(Star { center, neighbours: star });
    }
    Some(stars)
}
