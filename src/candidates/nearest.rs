//! Candidates by distance alone: free ends joined to the nodes nearest to them, wherever these point.

use std::collections::HashSet;

use super::in_order;
use super::knn::PointIndex;
use crate::geometry::distance;
use crate::network::{Network, Origin, Vessel};
use crate::units::as_stored;

/// Joins every node of `ends` to the `k` nodes nearest to it by straight candidates of prior 1, without limit of distance.
///
/// Left out are nodes without position, the node itself, those that a vessel joins to it already, and
/// the second of a pair that comes twice. Candidates follow in the order of `ends`, nearest first, ties in node order. Their radius is the
/// smaller of the two nodes', m.
pub fn join_nearest(network: &mut Network, ends: &[usize], k: usize) {
    let rows: Vec<usize> = (0..network.node_count()).filter(|row| network.node(*row).position.is_some()).collect();
    let index = PointIndex::new(rows.iter().filter_map(|row| network.node(*row).position).collect());
    let ends: Vec<usize> = ends.iter().copied().filter(|end| network.node(*end).position.is_some()).collect();
    let ordered = |a: usize, b: usize| [a.min(b), a.max(b)];
    let among: HashSet<usize> = ends.iter().copied().collect();
    let vessels = network.vessels().map(|(ends, _)| ends).filter(|ends| ends.iter().any(|end| among.contains(end)));
    let mut joined: HashSet<[usize; 2]> = vessels.map(|[a, b]| ordered(a, b)).collect();
    let degree = network.degrees(|_| true);
    let near: Vec<Vec<usize>> = in_order(&ends, |_, end| {
        let hits = index.first(network.node(*end).position.unwrap_or_default(), k + 1 + degree[*end]);
        let others = hits.into_iter().map(|(_, hit)| rows[hit]).filter(|row| row != end);
        others.filter(|row| !joined.contains(&ordered(*end, *row))).take(k).collect()
    });
    for (end, near) in ends.into_iter().zip(near) {
        for other in near.into_iter().filter(|other| joined.insert(ordered(end, *other))) {
            let (a, b) = (network.node(end), network.node(other));
            let length = distance(a.position.unwrap_or_default(), b.position.unwrap_or_default());
            let radius = a.radius.unwrap_or(f64::INFINITY).min(b.radius.unwrap_or(f64::INFINITY));
            let vessel = Vessel::new(as_stored(length), as_stored(radius), Origin::Candidate);
            network.add_vessel([end, other], vessel);
        }
    }
}
