//! The decision that keeps the most probability: the maximum arborescence over the fragments, as far as its connections are more likely right
//! than what hangs on them is nothing.
//!
//! And the decision on candidates and contacts that are judged one by one: the most probable first, a free end once, and what joins parts.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::unionfind::UnionFind;

use crate::forest_posterior::{Edge, Forests, arborescence};
use crate::network::{Network, Origin, Vessel, fragments};
use crate::{error::Result, support::counted, support::ties::exceeds};

/// The usual price of a false connection.
pub const PRICE: f64 = 1.5;

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
    let probability = |v: &Vessel| v.evidence().map(|e| e.probability);
    network.vessels().map(|(_, v)| if v.is_given() { Some(1.0) } else { probability(v) }).collect()
}

/// The most probable forest, and how much of it is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct ProbableForest {
    /// Per vessel whether it is kept: observed or certain, or at least as probable as it needs to be.
    pub kept: Vec<bool>,
    /// Per vessel the least probability with which it is kept; no number where it is given, without evidence, or not of the forest while
    /// another candidate attaches a fragment that it would join.
    pub needed: Vec<f64>,
    /// Per candidate that is not of the forest the row of the one by which the forest attaches a fragment that it would join; of two the
    /// more probable one.
    pub instead: Vec<Option<usize>>,
    /// Rows of the connections of the forest that are not probable enough, ascending.
    pub left_open: Vec<usize>,
}

/// The share of the price that is asked where no piece hangs on the decision: of the roots in the forest, which therefore attaches nearly
/// every fragment that a candidate reaches (what stays alone is decided afterwards), and of a loop, whose two ends have blood already.
pub const WITHOUT_PIECE: f64 = 0.2;

/// The forest of fragments with the largest sum of the probabilities of its attachments and a fifth of the price of its roots, and which of them are worth making: those with
///
/// P >= price · q,  q = s · Π (1 - P' (1 - q'))
///
/// where s is the score of the fragment that hangs for being attached to nothing ([`root_score`](crate::network::Node::root_score)), and the
/// product is over the connections of the forest by which others hang on it. q is the probability that all that hangs there is
/// nothing: a false piece carries no true vessel. A candidate that closes a loop within one fragment carries no piece;
/// it is kept from a fifth of the price on.
///
/// A candidate marked certain joins its fragments to one beforehand. A fragment whose nodes have no root score gets what its candidates
/// leave of one.
///
/// # Errors
///
/// More fragments or candidates than can be numbered.
pub fn probable(network: &Network, price: f64) -> Result<ProbableForest> {
    let parts = fragments(network, |_, v| v.is_given());
    let mut known = vec![f64::NAN; parts.count];
    for (node, part) in network.nodes().zip(&parts.of_node) {
        known[*part] = node.root_score.map_or(known[*part], |p| p.min(known[*part]));
    }
    let vessels = network.vessel_count();
    let mut kept: Vec<bool> = network.vessels().map(|(_, v)| v.is_given()).collect();
    let (mut needed, mut instead, mut left_open) = (vec![f64::NAN; vessels], vec![None; vessels], Vec::new());
    let probability: Vec<f64> = network.vessels().map(|(_, v)| v.evidence().map_or(0.0, |e| e.probability)).collect();
    let (mut edges, mut scores, mut vessel) = (Vec::new(), Vec::new(), Vec::new());
    let mut left = vec![1.0; parts.count];
    for (row, (ends, v)) in network.vessels().enumerate().filter(|(_, (_, v))| !v.is_given()) {
        let Some(evidence) = v.evidence() else { continue };
        let [a, b] = ends.map(|node| parts.of_node[node]);
        if a == b {
            needed[row] = WITHOUT_PIECE * price;
            kept[row] = is_enough(evidence.probability, needed[row]);
            continue;
        }
        for (child, parent, score) in [(a, b, evidence.attached[0]), (b, a, evidence.attached[1])] {
            left[child] -= evidence.probability;
            if score > 0.0 {
                edges.push(Edge { child, parent, log_weight: 0.0 });
                scores.push(score);
                vessel.push(row);
            }
        }
    }
    let alone = known.iter().zip(&left).map(|(known, left)| if known.is_nan() { left.max(0.0) } else { *known });
    let alone: Vec<f64> = alone.collect();
    let forests = Forests::new(vec![0.0; parts.count], edges)?;
    let roots: Vec<f64> = alone.iter().map(|p| WITHOUT_PIECE * price * p).collect();
    let attached = arborescence(&forests, &scores, &roots);
    let row_of = |child: usize| attached[child].map(|edge: usize| vessel[edge]);
    let mut nothing = alone.clone();
    for child in leaves_first(&forests, &attached) {
        let Some(edge) = attached[child] else { continue };
        let row = vessel[edge];
        needed[row] = price * nothing[child];
        kept[row] = is_enough(probability[row], needed[row]);
        if !kept[row] {
            left_open.push(row);
        }
        nothing[forests.edges()[edge].parent] *= 1.0 - probability[row] * (1.0 - nothing[child]);
    }
    for (row, (ends, v)) in network.vessels().enumerate() {
        if !kept[row] && needed[row].is_nan() && v.evidence.is_some() {
            let joined = ends.map(|node| parts.of_node[node]);
            let attaching = joined.into_iter().filter_map(row_of);
            instead[row] = attaching.max_by(|a, b| probability[*a].total_cmp(&probability[*b]).then(b.cmp(a)));
            if instead[row].is_none() {
                needed[row] = price * alone[joined[0]].max(alone[joined[1]]);
            }
        }
    }
    left_open.sort_unstable();
    Ok(ProbableForest { kept, needed, instead, left_open })
}

/// Whether a probability is no less than what is needed, but for [rounding](crate::support::ties::TIE): P = 0.6 alone between two fragments is 1.5 times the
/// 0.4 that it leaves.
fn is_enough(probability: f64, needed: f64) -> bool {
    !exceeds(needed, probability)
}

/// The fragments of a forest, each after all those that hang on it.
fn leaves_first(forests: &Forests, attached: &[Option<usize>]) -> Vec<usize> {
    let parent = |child: usize| attached[child].map(|edge| forests.edges()[edge].parent);
    let mut hanging = counted(attached.len(), (0..attached.len()).filter_map(parent));
    let mut order: Vec<usize> = (0..attached.len()).filter(|fragment| hanging[*fragment] == 0).collect();
    let mut at = 0;
    while at < order.len() {
        if let Some(parent) = parent(order[at]) {
            hanging[parent] -= 1;
            if hanging[parent] == 0 {
                order.push(parent);
            }
        }
        at += 1;
    }
    order
}

/// How many errors a decision is expected to make among the candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExpectedErrors {
    /// Kept candidates that are no true connection.
    pub wrong: f64,
    /// True connections that are not kept: pairs of fragments that belong together and that no kept candidate joins, and loops.
    pub missed: f64,
}

/// The expected number of errors among the vessels `kept`, by their probabilities; `None` without evidence.
///
/// The probability that two fragments belong together is that of the most probable candidate between them: others are other places of the
/// same connection, so their probabilities are not added.
pub fn expected_errors(network: &Network, kept: &[bool]) -> Option<ExpectedErrors> {
    if !has_evidence(network) {
        return None;
    }
    let parts = fragments(network, |_, v| v.is_given());
    let (mut wrong, mut missed) = (0.0, 0.0);
    // Per pair of fragments the largest probability, and whether they are joined.
    let mut pairs: BTreeMap<[usize; 2], (f64, bool)> = BTreeMap::new();
    for ((ends, v), kept) in network.vessels().zip(kept) {
        let Some(evidence) = v.evidence() else { continue };
        wrong += if *kept { 1.0 - evidence.probability } else { 0.0 };
        let [a, b] = ends.map(|end| parts.of_node[end]);
        if a == b {
            missed += if *kept { 0.0 } else { evidence.probability };
            continue;
        }
        let (most, joined) = pairs.entry([a.min(b), a.max(b)]).or_default();
        *most = most.max(evidence.probability);
        *joined |= *kept;
    }
    missed += pairs.values().filter(|(_, joined)| !joined).map(|(p, _)| p).sum::<f64>();
    Some(ExpectedErrors { wrong, missed })
}

/// The usual least probability.
pub const BEST_FIRST: f64 = 0.4;

/// The usual least probability by the partitions of a contact that joins two parts: a cut opens a loop and sets nothing apart.
pub const RECONNECT: f64 = 0.0;
/// A candidate that was not probable enough by itself joins two parts from this probability on.
pub const DOUBTFUL: f64 = 0.1;

/// How much of its P a candidate that was judged by itself keeps beside one at its free end that a person accepted: those with P above .2 led on from
/// there to yet another vessel half as often as P says (`experiments/proofreading`).
pub const BESIDE_ACCEPTED: f64 = 0.5;

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
