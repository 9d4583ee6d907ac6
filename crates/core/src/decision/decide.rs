//! The answer: which vessels are kept, what the kept graph looks like, and which decisions are still open.

use super::{DecidingFigure, Keep, best_first_of, has_evidence, probabilities, probable, reconnected, threshold};
use crate::error::{Error, Result};
use crate::flow::{Boundary, parts_that_carry};
use crate::network::{Network, Origin, cycles, fragments};
use crate::{sampling::Likelihood, support::ties::exceeds};

/// A vessel whose L is within so many standard errors of the threshold is undecided.
pub const UNDECIDED_Z: f64 = 2.0;
/// A vessel whose probability is closer to the cut than this is undecided. The cut of [`Keep::Probable`] is one half; what it keeps below that
/// is undecided too. What has another in its place is undecided only from one half on, or where it is as near to that one.
pub const UNDECIDED_BAND: f64 = 0.2;

/// The decision on every vessel.
#[derive(Debug, Clone, PartialEq)]
pub struct Decision {
    /// The threshold of the rule; `None` when no uncertain vessel has L > 0.
    pub threshold: Option<f64>,
    /// The median of L over the uncertain vessels with L > 0, W/m³.
    pub median: Option<f64>,
    /// Whether each vessel is kept by the rule. Vessels that are not uncertain always are.
    pub kept: Vec<bool>,
    /// Whether each vessel is above the median. Vessels that are not uncertain always are.
    pub above_median: Vec<bool>,
    /// Rows of the uncertain vessels that a person should look at: within two standard errors of the threshold, with a probability near the cut,
    /// left open, or kept though improbable; not those with a far more probable one in their place.
    pub undecided: Vec<usize>,
    /// Those of them that the most probable forest has and that are not as probable as they need to be, so that they are not kept.
    pub left_open: Vec<usize>,
    /// Per vessel the least probability with which the rule keeps it; no number where the rule asks for none.
    pub needed: Vec<f64>,
    /// Per vessel the row of the one that the most probable forest has in its place, if any.
    pub instead: Vec<Option<usize>>,
}

/// The size and the connections of a kept graph.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Topology {
    /// Uncertain vessels that stay.
    pub kept: usize,
    /// Uncertain vessels that go.
    pub pruned: usize,
    /// Candidates among the kept.
    pub kept_candidates: usize,
    /// Observed vessels among the uncertain, and how many of them go.
    pub observed: [usize; 2],
    /// Connected parts.
    pub components: usize,
    /// Independent cycles.
    pub cycles: usize,
    /// Connected parts with a vessel that blood cannot flow through: no condition, or one only.
    pub unperfused: usize,
}

/// Applies a rule to the likelihoods, or to the evidence of the network that was sampled.
///
/// # Errors
///
/// A rule that asks for evidence where the network has none.
pub fn decide(rule: Keep, network: &Network, result: &Likelihood) -> Result<Decision> {
    let cut = threshold(rule, result);
    let median = threshold(Keep::Median, result);
    let is_above = |row: usize| !result.uncertain[row] || median.is_some_and(|m| exceeds(result.likelihood[row], m));
    let above_median = (0..result.likelihood.len()).map(is_above).collect();
    let (mut left_open, mut needed, mut instead) =
        (Vec::new(), vec![f64::NAN; network.vessel_count()], vec![None; network.vessel_count()]);
    let (mut kept, close) = match rule {
        Keep::Probability(least) => {
            let probability = evidence(rule, network)?;
            (probability.iter().map(|p| p.is_some_and(|p| p >= least)).collect(), near(&probability, rule))
        }
        Keep::Probable(price) => {
            let probability = evidence(rule, network)?;
            let forest = probable(network, price)?;
            let mut close = near(&probability, rule);
            left_open = forest.left_open;
            left_open.retain(|row| result.uncertain[*row]);
            for row in &left_open {
                close[*row] = true;
            }
            let known = |row: usize| probability[row].unwrap_or(0.0);
            for row in (0..close.len()).filter(|row| rule.turning_point().is_some_and(|turn| known(*row) < turn)) {
                let replaced = forest.instead[row].is_some_and(|other| known(other) - known(row) >= UNDECIDED_BAND);
                close[row] = !replaced && (close[row] || forest.kept[row] && probability[row].is_some());
            }
            (needed, instead) = (forest.needed, forest.instead);
            (forest.kept, close)
        }
        Keep::BestFirst(least) => (best_first_of(network, least), near(&evidence_if_asked(rule, network)?, rule)),
        Keep::Reconnect(least) => (reconnected(network, least), near(&evidence_if_asked(rule, network)?, rule)),
        _ => by_samples(rule, cut, result),
    };
    // What has A = 0, as one that a person rejected, is in no sample: there is nothing to keep, or to decide.
    let is_gone = |row: usize| network.vessel(row).prior <= 0.0 && result.frequency[row] <= 0.0;
    for (row, kept) in kept.iter_mut().enumerate() {
        *kept = !result.uncertain[row] || *kept && !is_gone(row);
    }
    let undecided = (0..kept.len()).filter(|row| result.uncertain[*row] && close[*row] && !is_gone(*row)).collect();
    Ok(Decision { threshold: cut, median, kept, above_median, undecided, left_open, needed, instead })
}

/// Whether no uncertain vessel is undecided. A rule that asks for evidence does not depend on samples: then the median decides.
///
/// # Errors
///
/// As [`decide`].
pub fn all_decided(rule: Keep, network: &Network, result: &Likelihood) -> Result<bool> {
    let rule = if rule.asks_evidence() { Keep::Median } else { rule };
    Ok(decide(rule, network, result)?.undecided.is_empty())
}

/// The probability of each vessel, which a rule asks for; nothing is asked where every vessel is given.
fn evidence_if_asked(rule: Keep, network: &Network) -> Result<Vec<Option<f64>>> {
    if network.vessels().all(|(_, vessel)| vessel.is_given()) { Ok(probabilities(network)) } else { evidence(rule, network) }
}

/// The probability of each vessel, which a rule asks for.
fn evidence(rule: Keep, network: &Network) -> Result<Vec<Option<f64>>> {
    if has_evidence(network) {
        return Ok(probabilities(network));
    }
    let accepted = "asks for probabilities, which come with the evidence model on centerlines, or as probability in a graph";
    Err(Error::parameter("keep", rule.word(), accepted))
}

/// Per vessel whether its probability is near the turning point of a rule.
fn near(probability: &[Option<f64>], rule: Keep) -> Vec<bool> {
    let is_near = |p: f64| rule.turning_point().is_some_and(|turn| (p - turn).abs() < UNDECIDED_BAND);
    probability.iter().map(|p| p.is_some_and(is_near)).collect()
}

/// Per vessel whether it passes, and whether its figure is within chance of the threshold.
fn by_samples(rule: Keep, cut: Option<f64>, result: &Likelihood) -> (Vec<bool>, Vec<bool>) {
    let figure = if rule.figure() == DecidingFigure::Frequency { &result.frequency } else { &result.likelihood };
    let passes = |row: usize| match (rule, cut) {
        (Keep::Frequency(_), Some(cut)) => !exceeds(cut, figure[row]),
        (_, Some(cut)) => exceeds(figure[row], cut),
        (_, None) => false,
    };
    let flip = cut.and_then(|cut| flipping_point(rule, cut, result));
    let error = |row: usize| match rule {
        Keep::Frequency(_) => (figure[row] * (1.0 - figure[row]) / result.samples.max(1) as f64).sqrt(),
        _ => result.std_error[row],
    };
    // Without a threshold nothing has L > 0: that is certain only where the errors are known.
    let close = |row: usize| flip.map_or_else(|| error(row).is_nan(), |flip| !decided(figure[row] - flip, error(row)));
    let rows = 0..figure.len();
    (rows.clone().map(passes).collect(), rows.map(close).collect())
}

/// Whether a distance from the threshold is more than chance; never when the error is unknown.
fn decided(distance: f64, error: f64) -> bool {
    distance.abs() >= UNDECIDED_Z * error
}

/// The figure at which a decision would flip. A threshold that is itself one of the figures, such as a median, flips no decision until a
/// rank changes; then it lies midway between the nearest figures on its two sides.
fn flipping_point(rule: Keep, cut: f64, result: &Likelihood) -> Option<f64> {
    if rule.is_fixed() {
        return Some(cut);
    }
    let positive = || result.likelihood.iter().zip(&result.uncertain).filter(|(l, u)| **u && **l > 0.0).map(|(l, _)| *l);
    let below = positive().filter(|l| !exceeds(*l, cut)).reduce(f64::max)?;
    let above = positive().filter(|l| exceeds(*l, cut)).reduce(f64::min)?;
    Some(0.5 * (below + above))
}

impl Topology {
    /// Counts the graph of the vessels `kept`.
    pub fn of(network: &Network, uncertain: &[bool], kept: &[bool], boundary: &Boundary) -> Self {
        let (graph, _) = network.subgraph(|row| kept[row]);
        let parts = fragments(&graph, |_, _| true);
        let carries = parts_that_carry(&parts, boundary);
        let mut unperfused = vec![false; parts.count];
        for ([a, _], _) in graph.vessels() {
            unperfused[parts.of_node[a]] = !carries[parts.of_node[a]];
        }
        let count = |of: &dyn Fn(Origin, bool) -> bool| {
            let rows = network.vessels().zip(kept).zip(uncertain).filter(|(_, uncertain)| **uncertain);
            rows.filter(|(((_, vessel), kept), _)| of(vessel.origin, **kept)).count()
        };
        let observed = |all: bool| count(&|origin, kept| origin == Origin::Observed && (all || !kept));
        Self {
            kept: count(&|_, kept| kept),
            pruned: count(&|_, kept| !kept),
            kept_candidates: count(&|origin, kept| kept && origin == Origin::Candidate),
            observed: [observed(true), observed(false)],
            components: parts.count,
            cycles: cycles(&graph),
            unperfused: unperfused.iter().filter(|u| **u).count(),
        }
    }
}
