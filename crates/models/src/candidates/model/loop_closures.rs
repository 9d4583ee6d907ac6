//! Candidates within one fragment, which close a loop: a forest has no loops, so they have a model of their own.
//!
//! Anatomy distinguishes a broken ring from a passing vessel: the two sides of the ring are fed from different inlets, the ends match
//! in direction, and the candidate is much shorter than the path along the vessels.

use std::collections::{BTreeMap, BTreeSet};

use super::feature_table::CandidateTable;
use super::likely_inlets::known_or_likely_inlets;
use super::pass::PassWeights;
use crate::candidates::features::candidate_features;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::measured_candidate::{MeasuredCandidate, measured};
use crate::candidates::search::EndCandidate;
use willis_core::forest_posterior::Marginals;
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::support::geometry::distance;
use willis_core::support::statistics::{median, sigmoid};

/// The features of a closure, in the order of their weights.
pub const CLOSURE_FEATURES: [&str; 10] =
    ["one", "score", "detour", "gap", "bend_child_sq", "bend_parent_sq", "wide", "size", "two_inlets", "claimed"];

/// Candidates with a lower score in the first pass close none.
const LEAST_SCORE: f64 = -3.0;

/// A candidate that may close a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure {
    /// The candidate; of two directions the one with the better score.
    pub candidate: EndCandidate,
    /// Its features, as [`CLOSURE_FEATURES`] names them.
    pub features: [f64; 10],
}

impl Closure {
    /// 1/(1 + exp(-b·x)).
    pub fn probability(&self, weights: &[f64]) -> f64 {
        sigmoid(self.features.iter().zip(weights).map(|(x, w)| x * w).sum())
    }
}

/// The candidates that may close a loop once the fragments are joined by the candidates `kept` (per fragment the row of the one
/// that attaches it): those whose ends are left free.
///
/// The features: 1; the score of the first pass, β·x; ln of the path along the vessels over the gap; gap and squared bends
/// as other candidates have them; ln of the end's radius over the median of all ends, and of the thinner radius over the widest end;
/// whether along the joined vessels its two sides are nearest to different inlets; and the sum of the probabilities of the other
/// candidates at its end.
pub fn closures(
    extraction: &Extraction,
    table: &CandidateTable,
    first: &PassWeights,
    marginals: &Marginals,
    kept: &[Option<usize>],
) -> Vec<Closure> {
    let kept: Vec<[usize; 2]> = kept.iter().flatten().map(|row| table.candidates[*row].points(extraction)).collect();
    let used: BTreeSet<usize> = kept.iter().flatten().copied().collect();
    let mut claimed = vec![0.0; extraction.position.len()];
    for (candidate, p) in table.candidates.iter().zip(&marginals.edges) {
        for point in candidate.points(extraction) {
            claimed[point] += p;
        }
    }
    let inlet = nearest_inlet(extraction, &kept);
    let middling = median(&extraction.ends.iter().map(|e| e.radius).collect::<Vec<_>>()).unwrap_or(1.0);
    let score = table.within_features.dot(&ndarray::ArrayView1::from(&first.candidate));
    let features = |c: &MeasuredCandidate, score: f64| {
        let [from, to] = [inlet[c.child.point], inlet[c.point]];
        let two = from.is_some() && to.is_some() && from != to;
        [
            1.0,
            score,
            candidate_features::log_detour(c),
            candidate_features::gap(c),
            candidate_features::bend_child_squared(c),
            candidate_features::bend_parent_squared(c),
            (c.child.radius / middling).ln(),
            candidate_features::relative_size(c),
            if two { 1.0 } else { 0.0 },
            f64::min(claimed[c.child.point], 1.0),
        ]
    };
    let mut best: BTreeMap<[usize; 2], (usize, f64)> = BTreeMap::new();
    let measured = measured(extraction, &table.within);
    for (row, (candidate, score)) in measured.iter().zip(&score).enumerate() {
        let (from, to) = (candidate.child.point, candidate.point);
        if *score > LEAST_SCORE && !used.contains(&from) && !(candidate.parent_end.is_some() && used.contains(&to)) {
            let best = best.entry([from.min(to), from.max(to)]).or_insert((row, *score));
            if *score > best.1 {
                *best = (row, *score);
            }
        }
    }
    let mut rows: Vec<usize> = best.into_values().map(|(row, _)| row).collect();
    rows.sort_unstable();
    rows.iter().map(|row| Closure { candidate: table.within[*row], features: features(&measured[*row], score[*row]) }).collect()
}

/// Per point the inlet that is nearest along the vessels and the candidates kept; none where no inlet is joined.
fn nearest_inlet(extraction: &Extraction, kept: &[[usize; 2]]) -> Vec<Option<usize>> {
    let points = extraction.position.len();
    let steps = extraction.lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]]));
    let length = |[a, b]: [usize; 2]| distance(extraction.position[a], extraction.position[b]);
    let edges = steps.chain(kept.iter().copied()).enumerate().map(|(row, ends)| (row, ends, length(ends)));
    let edges = lengths_at(points, edges);
    let mut nearest = vec![(f64::INFINITY, None); points];
    let mut paths = ShortestPaths::new(points);
    for inlet in known_or_likely_inlets(extraction) {
        paths.search(&[inlet], f64::INFINITY, |point| edges[point].iter().copied(), |_, _| true);
        for (nearest, length) in nearest.iter_mut().zip(paths.lengths()) {
            if *length < nearest.0 {
                *nearest = (*length, Some(inlet));
            }
        }
    }
    nearest.into_iter().map(|(_, inlet)| inlet).collect()
}
