//! Bridges within one fragment, which close a loop: no forest knows them, so they have a model of their own.
//!
//! What tells a ring from a passing vessel is its anatomy: the two sides of a ring that is broken are fed from different
//! inlets, the ends match in direction, and the bridge saves a long way.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::dijkstra;
use petgraph::graph::{NodeIndex, UnGraph};

use super::decision_scores::entries;
use super::feature_table::Rows;
use super::weights::Pass;
use crate::candidates::features::candidate::{Span, spans};
use crate::candidates::features::candidate_features;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::search::by_evidence::FoundBridge;
use crate::forest_posterior::Marginals;
use crate::support::geometry::distance;
use crate::support::statistics::{median, sigmoid};

/// The features of a closure, in the order of their weights.
pub const CLOSURE_FEATURES: [&str; 10] =
    ["one", "score", "detour", "gap", "bend_child_sq", "bend_parent_sq", "wide", "size", "two_inlets", "claimed"];

/// Bridges with a lower score in the first pass are none.
const LEAST_SCORE: f64 = -3.0;

/// A bridge that may close a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure {
    /// The bridge; of two directions the one with the better score.
    pub bridge: FoundBridge,
    /// Its features, as [`CLOSURE_FEATURES`] names them.
    pub features: [f64; 10],
}

impl Closure {
    /// 1/(1 + exp(-b·x)).
    pub fn probability(&self, weights: &[f64]) -> f64 {
        sigmoid(self.features.iter().zip(weights).map(|(x, w)| x * w).sum())
    }
}

/// The bridges of an extraction that may close a loop once its fragments are joined by the bridges `kept` (per fragment the
/// row of the one it hangs by): those whose ends are left free.
///
/// The features: 1; the score of the first pass, β·x; ln of the way along the vessels over the gap; gap and squared bends
/// as bridges have them; ln of the end's radius over the median of all ends, and of the thinner radius over the widest end; whether along the
/// joined vessels its two sides are nearest to different inlets; and how much of the posterior other bridges at its end have.
pub fn closures(
    extraction: &Extraction,
    rows: &Rows,
    first: &Pass,
    marginals: &Marginals,
    kept: &[Option<usize>],
) -> Vec<Closure> {
    let ends = |row: &usize| [extraction.ends[rows.bridges[*row].end].point, rows.bridges[*row].point];
    let kept: Vec<[usize; 2]> = kept.iter().flatten().map(ends).collect();
    let used: BTreeSet<usize> = kept.iter().flatten().copied().collect();
    let mut claimed = vec![0.0; extraction.position.len()];
    for (bridge, p) in rows.bridges.iter().zip(&marginals.bridges) {
        claimed[extraction.ends[bridge.end].point] += p;
        claimed[bridge.point] += p;
    }
    let entry = nearest_entry(extraction, &kept);
    let middling = median(&extraction.ends.iter().map(|e| e.radius).collect::<Vec<_>>()).unwrap_or(1.0);
    let score = rows.inside_features.dot(&ndarray::ArrayView1::from(&first.bridge));
    let features = |span: &Span, score: f64| {
        let [from, to] = [entry[span.child.point], entry[span.point]];
        let two = from.is_some() && to.is_some() && from != to;
        [
            1.0,
            score,
            candidate_features::log_detour(span),
            candidate_features::gap(span),
            candidate_features::bend_child_squared(span),
            candidate_features::bend_parent_squared(span),
            (span.child.radius / middling).ln(),
            candidate_features::relative_size(span),
            if two { 1.0 } else { 0.0 },
            f64::min(claimed[span.child.point], 1.0),
        ]
    };
    let mut best: BTreeMap<[usize; 2], (usize, f64)> = BTreeMap::new();
    let spans = spans(extraction, &rows.inside);
    for (row, (span, score)) in spans.iter().zip(&score).enumerate() {
        let (from, to) = (span.child.point, span.point);
        if *score > LEAST_SCORE && !used.contains(&from) && !(span.parent_end.is_some() && used.contains(&to)) {
            let best = best.entry([from.min(to), from.max(to)]).or_insert((row, *score));
            if *score > best.1 {
                *best = (row, *score);
            }
        }
    }
    let mut rows_of: Vec<usize> = best.into_values().map(|(row, _)| row).collect();
    rows_of.sort_unstable();
    rows_of.iter().map(|row| Closure { bridge: rows.inside[*row], features: features(&spans[*row], score[*row]) }).collect()
}

/// Per point the entry of blood that is nearest along the vessels and the bridges kept; none where no entry is joined.
fn nearest_entry(extraction: &Extraction, kept: &[[usize; 2]]) -> Vec<Option<usize>> {
    let points = extraction.position.len();
    let steps = extraction.lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]]));
    let mut graph = UnGraph::<(), f64, usize>::with_capacity(points, points);
    for _ in 0..points {
        graph.add_node(());
    }
    for [a, b] in steps.chain(kept.iter().copied()) {
        let length = distance(extraction.position[a], extraction.position[b]);
        graph.add_edge(NodeIndex::new(a), NodeIndex::new(b), length);
    }
    let mut nearest = vec![(f64::INFINITY, None); points];
    for entry in entries(extraction) {
        for (point, length) in dijkstra(&graph, NodeIndex::new(entry), None, |step| *step.weight()) {
            if length < nearest[point.index()].0 {
                nearest[point.index()] = (length, Some(entry));
            }
        }
    }
    nearest.into_iter().map(|(_, entry)| entry).collect()
}
