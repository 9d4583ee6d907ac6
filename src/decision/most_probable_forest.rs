//! The decision that keeps the most probability: the maximum arborescence over the fragments, as far as its connections are more likely right
//! than wrong.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::forest_posterior::{Edge, Forests, arborescence};
use crate::network::{Evidence, Network, Origin, Vessel, fragments};

/// The usual root factor: what is kept is more likely right than wrong.
pub const ROOT_FACTOR: f64 = 1.0;

/// Whether the network knows how probably its fragments are roots, as one built by evidence does.
pub fn knows_fragments(network: &Network) -> bool {
    network.nodes().any(|n| n.root_score.is_some())
}

/// Whether the evidence says how probable candidates are; it may allow none.
pub fn has_evidence(network: &Network) -> bool {
    knows_fragments(network) || network.vessels().any(|(_, v)| v.evidence.is_some())
}

/// The calibrated probability of each vessel: one if it is observed or certain, else that of its evidence; `None` without evidence.
pub fn probabilities(network: &Network) -> Vec<Option<f64>> {
    let probability = |v: &Vessel| v.evidence.map(|e| e.probability);
    network.vessels().map(|(_, v)| if v.origin == Origin::Observed || v.certain { Some(1.0) } else { probability(v) }).collect()
}

/// The most probable forest, and how much of it is kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProbableForest {
    /// Per vessel whether it is kept: observed or certain, or a connection of the forest, or a loop, whose odds are at least the root factor.
    pub kept: Vec<bool>,
    /// Rows of the connections of the forest whose odds are too low, ascending: each the most probable one of a fragment, and still more
    /// likely wrong than right.
    pub left_open: Vec<usize>,
}

/// The forest of fragments with the largest sum of scores (of attachments and, times `root_factor`, of roots), and which of its connections
/// ([`Evidence::connection`]) have odds P/(1 - P) of at least `root_factor`. Candidates that close a loop within one fragment are kept
/// from the same odds on.
///
/// A candidate marked certain joins its fragments to one beforehand. A fragment whose nodes have no root score gets what its candidates
/// leave of one.
///
/// # Errors
///
/// More fragments or candidates than can be numbered.
pub fn probable(network: &Network, root_factor: f64) -> Result<ProbableForest> {
    let given = |v: &Vessel| v.origin == Origin::Observed || v.certain;
    let least = root_factor / (1.0 + root_factor);
    let is_likely = |evidence: &Evidence| evidence.connection() >= least;
    let parts = fragments(network, |_, v| given(v));
    let mut known = vec![f64::NAN; parts.count];
    for (node, part) in network.nodes().zip(&parts.of_node) {
        known[*part] = node.root_score.map_or(known[*part], |p| p.min(known[*part]));
    }
    let mut kept: Vec<bool> = network.vessels().map(|(_, v)| given(v)).collect();
    let mut left_open = Vec::new();
    let (mut edges, mut scores, mut vessel) = (Vec::new(), Vec::new(), Vec::new());
    let mut left = vec![1.0; parts.count];
    for (row, ([a, b], v)) in network.vessels().enumerate().filter(|(_, (_, v))| !given(v)) {
        let Some(evidence) = v.evidence else { continue };
        let [a, b] = [a, b].map(|node| parts.of_node[node]);
        if a == b {
            kept[row] = evidence.probability >= least;
            continue;
        }
        for (child, parent, score) in [(a, b, evidence.attached[0]), (b, a, evidence.attached[1])] {
            if score > 0.0 {
                left[child] -= score;
                edges.push(Edge { child, parent, log_weight: 0.0 });
                scores.push(score);
                vessel.push((row, is_likely(&evidence)));
            }
        }
    }
    let roots: Vec<f64> =
        known.iter().zip(&left).map(|(known, left)| if known.is_nan() { left.max(0.0) } else { *known }).collect();
    let forests = Forests::new(vec![0.0; parts.count], edges)?;
    let scaled: Vec<f64> = roots.iter().map(|p| root_factor * p).collect();
    for edge in arborescence(&forests, &scores, &scaled).into_iter().flatten() {
        let (row, is_likely) = vessel[edge];
        kept[row] = is_likely;
        left_open.extend((!is_likely).then_some(row));
    }
    left_open.sort_unstable();
    Ok(ProbableForest { kept, left_open })
}

/// How many errors a decision is expected to make among the candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedErrors {
    /// Kept candidates that are no true connection.
    pub wrong: f64,
    /// True connections that are not kept: pairs of fragments that belong together and that no kept candidate joins, and loops.
    pub missed: f64,
}

/// The expected number of errors among the vessels `kept`, by the probabilities of connections ([`Evidence::connection`]); `None` without
/// evidence.
///
/// The probability that two fragments belong together is that of the candidate that represents them, over both directions:
/// candidates a few voxels from it are other places of the same connection, so their probabilities are not added.
pub fn expected_errors(network: &Network, kept: &[bool]) -> Option<ExpectedErrors> {
    if !has_evidence(network) {
        return None;
    }
    let parts = fragments(network, |_, v| v.origin == Origin::Observed || v.certain);
    let (mut wrong, mut missed) = (0.0, 0.0);
    // Per pair of fragments the largest score of attaching the one and the other, and whether they are joined.
    let mut pairs: BTreeMap<[usize; 2], ([f64; 2], bool)> = BTreeMap::new();
    for ((ends, v), kept) in network.vessels().zip(kept) {
        let Some(evidence) = v.evidence else { continue };
        let [x, y] = v.shares();
        wrong += if *kept { 1.0 - f64::min(x + y, 1.0).max(evidence.probability) } else { 0.0 };
        let [a, b] = ends.map(|end| parts.of_node[end]);
        if a == b {
            missed += if *kept { 0.0 } else { evidence.probability };
            continue;
        }
        let (pair, scores) = if a < b { ([a, b], [x, y]) } else { ([b, a], [y, x]) };
        let (most, joined) = pairs.entry(pair).or_default();
        *most = [most[0].max(scores[0]), most[1].max(scores[1])];
        *joined |= *kept;
    }
    missed += pairs.values().filter(|(_, joined)| !joined).map(|([x, y], _)| f64::min(x + y, 1.0)).sum::<f64>();
    Some(ExpectedErrors { wrong, missed })
}
