//! Bridges within one fragment, which close a loop: no forest knows them, so they have a model of their own.
//!
//! What tells a ring from a passing vessel is its anatomy: the two sides of a ring that is broken are fed from different
//! inlets, the ends match in direction, and the bridge saves a long way.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

use super::alone::{alone, entries};
use super::hangs::hangs;
use super::rows::Rows;
use super::weights::Pass;
use crate::candidates::evidence::{Bridge, Extraction, Span, direction, gap, radius, spans};
use crate::geometry::distance;
use crate::posterior::{Forests, Marginals, arborescence};
use crate::stats::median;

/// The features of a closure, in the order of their weights.
pub const CLOSURE_FEATURES: [&str; 10] =
    ["one", "score", "detour", "gap", "bend_child_sq", "bend_parent_sq", "wide", "size", "two_inlets", "claimed"];

/// Bridges with a lower score in the first pass are none.
const LEAST_SCORE: f64 = -3.0;

/// A bridge that may close a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct Closure {
    /// The bridge; of two directions the one with the better score.
    pub bridge: Bridge,
    /// Its features, as [`CLOSURE_FEATURES`] names them.
    pub features: [f64; 10],
}

impl Closure {
    /// 1/(1 + exp(-b·x)).
    pub fn probability(&self, weights: &[f64]) -> f64 {
        1.0 / (1.0 + (-self.features.iter().zip(weights).map(|(x, w)| x * w).sum::<f64>()).exp())
    }
}

/// The bridges of an extraction that may close a loop once its fragments are joined to the most probable forest: those whose
/// ends that forest leaves free.
///
/// The features: 1; the score of the first pass, β·x; ln of the way along the vessels over the gap; gap and squared bends
/// as bridges have them; ln of the end's radius over the median of all ends, and of the thinner radius over the widest end; whether along the
/// joined vessels its two sides are nearest to different inlets; and how much of the posterior other bridges at its end have.
pub fn closures(
    extraction: &Extraction,
    rows: &Rows,
    first: &Pass,
    (forests, marginals): (&Forests, &Marginals),
) -> Vec<Closure> {
    let hangs = hangs(extraction, &rows.bridges, marginals);
    let kept: Vec<[usize; 2]> = arborescence(forests, &hangs, &alone(extraction, marginals))
        .into_iter()
        .flatten()
        .map(|row| [extraction.ends[rows.bridges[row].end].point, rows.bridges[row].point])
        .collect();
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
            gap::log_detour(span),
            gap::gap(span),
            direction::bend_child_squared(span),
            direction::bend_parent_squared(span),
            (span.child.radius / middling).ln(),
            radius::relative_size(span),
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
    let length = |[a, b]: [usize; 2]| distance(extraction.position[a], extraction.position[b]);
    let mut around: Vec<Vec<(usize, f64)>> = vec![Vec::new(); extraction.position.len()];
    let steps = extraction.lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]]));
    for [a, b] in steps.chain(kept.iter().copied()) {
        around[a].push((b, length([a, b])));
        around[b].push((a, length([a, b])));
    }
    let mut from: Vec<Option<usize>> = vec![None; around.len()];
    // Lengths are positive, so their bits order as they do.
    let mut open = BinaryHeap::new();
    for entry in entries(extraction) {
        open.push(Reverse((0_u64, entry, entry)));
    }
    while let Some(Reverse((bits, point, entry))) = open.pop() {
        if from[point].is_some() {
            continue;
        }
        from[point] = Some(entry);
        let here = f64::from_bits(bits);
        open.extend(around[point].iter().map(|(next, step)| Reverse(((here + step).to_bits(), *next, entry))));
    }
    from
}
