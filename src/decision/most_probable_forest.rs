//! The decision that keeps the most probability: the maximum arborescence over the fragments.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::forest_posterior::{Bridge, Forests, arborescence};
use crate::network::{Network, Origin, Vessel, fragments};

/// A candidate that closes a loop within one fragment competes with no other. It is kept if it has at least this probability.
const KEPT_CLOSURE: f64 = 0.2;

/// The usual root factor.
pub const ROOT_FACTOR: f64 = 1.0;

/// Whether the network has the probabilities that its fragments stay alone, as one that was built by evidence has.
pub fn knows_fragments(network: &Network) -> bool {
    network.nodes().any(|n| n.alone.is_some())
}

/// Whether the network has evidence on its candidates. There may be evidence and no candidate that it takes for possible.
pub fn has_evidence(network: &Network) -> bool {
    knows_fragments(network) || network.vessels().any(|(_, v)| v.evidence.is_some())
}

/// The calibrated probability of each vessel: one if it is observed or certain, else that of its evidence; `None` without evidence.
pub fn probabilities(network: &Network) -> Vec<Option<f64>> {
    let probability = |v: &Vessel| v.evidence.map(|e| e.probability);
    network.vessels().map(|(_, v)| if v.origin == Origin::Observed || v.certain { Some(1.0) } else { probability(v) }).collect()
}

/// Per vessel whether it is observed, or in the forest of fragments with the largest sum of the probabilities by which
/// fragments hang on one another and, times `root_factor`, stay alone; or closes a probable loop.
///
/// A candidate marked certain joins its fragments to one beforehand. The probability that a node itself gives for
/// its fragment to stay alone is used rather than one minus those of its candidates.
///
/// # Errors
///
/// More fragments or candidates than can be numbered.
pub fn probable(network: &Network, root_factor: f64) -> Result<Vec<bool>> {
    let given = |v: &Vessel| v.origin == Origin::Observed || v.certain;
    let parts = fragments(network, |_, v| given(v));
    let mut alone = vec![f64::NAN; parts.count];
    for (node, part) in network.nodes().zip(&parts.of_node) {
        alone[*part] = node.alone.map_or(alone[*part], |p| p.min(alone[*part]));
    }
    let mut kept: Vec<bool> = network.vessels().map(|(_, v)| given(v)).collect();
    let (mut bridges, mut scores, mut vessel) = (Vec::new(), Vec::new(), Vec::new());
    let mut left = vec![1.0; parts.count];
    for (row, ([a, b], v)) in network.vessels().enumerate().filter(|(_, (_, v))| !given(v)) {
        let Some(evidence) = v.evidence else { continue };
        let [a, b] = [a, b].map(|node| parts.of_node[node]);
        if a == b {
            kept[row] = evidence.probability >= KEPT_CLOSURE;
            continue;
        }
        for (child, parent, score) in [(a, b, evidence.hangs[0]), (b, a, evidence.hangs[1])] {
            if score > 0.0 {
                left[child] -= score;
                bridges.push(Bridge { child, parent, log_weight: 0.0 });
                scores.push(score);
                vessel.push(row);
            }
        }
    }
    let roots: Vec<f64> =
        alone.iter().zip(&left).map(|(alone, left)| if alone.is_nan() { left.max(0.0) } else { *alone }).collect();
    let forests = Forests::new(vec![0.0; parts.count], bridges)?;
    let scaled: Vec<f64> = roots.iter().map(|p| root_factor * p).collect();
    for bridge in arborescence(&forests, &scores, &scaled).into_iter().flatten() {
        kept[vessel[bridge]] = true;
    }
    Ok(kept)
}

/// How many errors a decision is expected to make among the candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedErrors {
    /// Kept candidates that are no true connection.
    pub wrong: f64,
    /// True connections that are not kept: pairs of fragments that belong together and that no kept candidate joins, and loops.
    pub missed: f64,
}

/// The expected number of errors among the vessels `kept`, by the probabilities; `None` without evidence.
///
/// Two fragments belong together as probably as either hangs on the other by the candidate that stands for them: candidates a
/// few voxels apart are other places of one connection, so their probabilities do not add up.
pub fn expected_errors(network: &Network, kept: &[bool]) -> Option<ExpectedErrors> {
    if !has_evidence(network) {
        return None;
    }
    let parts = fragments(network, |_, v| v.origin == Origin::Observed || v.certain);
    let (mut wrong, mut missed) = (0.0, 0.0);
    // Per pair of fragments how probably the one and the other hangs, and whether they are joined.
    let mut pairs: BTreeMap<[usize; 2], ([f64; 2], bool)> = BTreeMap::new();
    for ((ends, v), kept) in network.vessels().zip(kept) {
        let Some(evidence) = v.evidence else { continue };
        wrong += if *kept { 1.0 - evidence.probability } else { 0.0 };
        let [a, b] = ends.map(|end| parts.of_node[end]);
        if a == b {
            missed += if *kept { 0.0 } else { evidence.probability };
            continue;
        }
        let [x, y] = evidence.hangs;
        let (pair, hangs) = if a < b { ([a, b], [x, y]) } else { ([b, a], [y, x]) };
        let (most, joined) = pairs.entry(pair).or_default();
        *most = [most[0].max(hangs[0]), most[1].max(hangs[1])];
        *joined |= *kept;
    }
    missed += pairs.values().filter(|(_, joined)| !joined).map(|([x, y], _)| f64::min(x + y, 1.0)).sum::<f64>();
    Some(ExpectedErrors { wrong, missed })
}
