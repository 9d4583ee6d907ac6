//! The decision on candidates and contacts that are judged one by one: the most probable first, a free end once, and what joins parts.

use std::collections::BTreeSet;

use petgraph::unionfind::UnionFind;

use super::knows_fragments;
use crate::network::{Network, Origin};

/// The usual least probability.
pub const BEST_FIRST: f64 = 0.4;

/// The usual least probability by the partitions of a contact that joins two parts: a cut opens a loop and sets nothing apart.
pub const RECONNECT: f64 = 0.0;
/// A candidate that was not probable enough by itself joins two parts from this probability on.
pub const DOUBTFUL: f64 = 0.1;

/// How much of its P a candidate keeps beside one at its free end that a person accepted: nothing where at most one is true
/// ([`knows_fragments`]). Judged one by one, those with P above .2 led on from there to yet another vessel half as often as P says
/// (`experiments/proofreading`).
pub fn beside_accepted(network: &Network) -> f64 {
    if knows_fragments(network) { 0.0 } else { 0.5 }
}

/// Per candidate whether it is kept: the most probable first, those above `least`, each free end once. `ends` are the free ends it joins,
/// `used` those that are joined already. Of equally probable ones the first comes first.
pub fn best_first(probability: &[f64], ends: &[[Option<usize>; 2]], mut used: BTreeSet<usize>, least: f64) -> Vec<bool> {
    let mut order: Vec<usize> = (0..probability.len()).filter(|row| probability[*row] > least).collect();
    order.sort_by(|a, b| probability[*b].total_cmp(&probability[*a]).then(a.cmp(b)));
    let mut kept = vec![false; probability.len()];
    for row in order {
        let free = || ends[row].iter().flatten();
        if free().all(|end| !used.contains(end)) {
            used.extend(free().copied());
            kept[row] = true;
        }
    }
    kept
}

/// Per vessel whether it is observed or certain, or kept by [`best_first`].
pub fn best_first_of(network: &Network, least: f64) -> Vec<bool> {
    let degree = network.degrees(|v| v.origin == Origin::Observed || v.certain && v.origin != Origin::Candidate);
    let joins = network.vessels().filter(|(_, v)| v.certain && v.origin == Origin::Candidate);
    let used = joins.flat_map(|(ends, _)| ends).filter(|end| degree[*end] <= 1).collect();
    let candidates = network.vessels().enumerate().filter(|(_, (_, v))| !v.is_given() && v.origin == Origin::Candidate);
    let free = |ends: [usize; 2]| ends.map(|end| (degree[end] <= 1).then_some(end));
    let (rows, (probability, ends)): (Vec<usize>, (Vec<f64>, Vec<_>)) =
        candidates.filter_map(|(row, (ends, v))| Some((row, (v.evidence()?.probability, free(ends))))).unzip();
    let mut kept: Vec<bool> = network.vessels().map(|(_, v)| v.is_given()).collect();
    for (row, keeps) in rows.into_iter().zip(best_first(&probability, &ends, used, least)) {
        kept[row] = keeps;
    }
    kept
}

/// Per vessel whether it is observed or certain, or kept by [`best_first`], or joins two parts of what is kept: contacts at least as
/// probable as `least`, and candidates of [`DOUBTFUL`] probability, the most probable first (Kruskal's algorithm). Cuts at contacts stay
/// where they set nothing apart, or where the connection is less probable than `least`.
///
/// A contact counts here by what the partitions say ([`Evidence::attached`](crate::network::Evidence::attached)), which is less than its
/// probability: a contact that is kept by mistake makes two vessels one, and on a par with doubtful candidates fewer fusions were undone.
pub fn reconnected(network: &Network, least: f64) -> Vec<bool> {
    let mut kept = best_first_of(network, BEST_FIRST);
    let mut parts = UnionFind::<usize>::new(network.node_count());
    let mut open: Vec<(f64, usize, [usize; 2])> = Vec::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        if kept[row] {
            parts.union(ends[0], ends[1]);
        } else if let Some(evidence) = vessel.evidence().filter(|evidence| evidence.probability > 0.0) {
            // What a person rejected has P = 0, and joins nothing.
            let (score, least) = match vessel.origin {
                Origin::Contact => (evidence.attached.iter().sum(), least),
                _ => (evidence.probability, least.max(DOUBTFUL)),
            };
            open.extend((score >= least).then_some((score, row, ends)));
        }
    }
    open.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    for (_, row, [a, b]) in open {
        kept[row] = parts.union(a, b);
    }
    kept
}
