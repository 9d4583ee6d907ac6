//! Fits weights to cases: maximum conditional likelihood pass by pass, then the calibration.

use std::borrow::Cow;
use std::collections::BTreeSet;

use ndarray::Array2;

use super::example::{CandidateExample, Case, share_of};
use super::logistic::{calibrate, logistic};
use super::minimise::minimise;
use super::objective::{Objective, case_weights};
use willis_core::error::{Error, Result};
use willis_core::forest_posterior::{Forests, Marginals, arborescence, marginals};
use willis_core::support::in_order;
use willis_core::support::model_provenance::ModelProvenance;
use willis_models::candidates::features::Feedback;
use willis_models::candidates::model::weights::input_features;
use willis_models::candidates::model::{
    Closure, PassWeights, Usual, Weights, attachment_scores, closures, last_pass, root_scores,
};

/// Pairs no more probable than this are left out of calibration and scores.
pub(crate) const LEAST_LISTED: f64 = 1e-3;
/// So many cases it takes to learn how calibration depends on the whole of one, and what is usual.
const LEAST_CASES: usize = 50;
/// Penalty of the standardised weights of closures.
const CLOSURE_L2: f64 = 1e-3;

/// How weights are fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainParams {
    /// Penalty of the squares of standardised weights, not negative.
    pub l2: f64,
    /// Iterations of each pass; as many passes. One pass at least, one iteration at least.
    pub iterations: Vec<usize>,
    /// The share of cases that are used without their inlets, so that the weights serve where none are given; 0 to 1.
    pub without_inlets: f64,
}

impl Default for TrainParams {
    fn default() -> Self {
        Self { l2: 0.002, iterations: vec![60, 40, 25], without_inlets: 0.3 }
    }
}

impl TrainParams {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        if !(0.0..=1e6).contains(&self.l2) {
            return Err(Error::parameter("l2", self.l2, "expected a number from 0 to 1e6"));
        }
        if self.iterations.is_empty() || self.iterations.contains(&0) {
            let accepted = "expected one pass at least, of one iteration at least";
            return Err(Error::parameter("iterations", format!("{:?}", self.iterations), accepted));
        }
        if !(0.0..=1.0).contains(&self.without_inlets) {
            return Err(Error::parameter("share without inlets", self.without_inlets, "expected a number from 0 to 1"));
        }
        Ok(())
    }
}

/// A pass that has been fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedPass {
    /// Its number, counted from 1.
    pub pass: usize,
    /// The objective before and after.
    pub objective: [f64; 2],
    /// How often it was evaluated.
    pub evaluations: usize,
}

/// Whether a case is used without its inlets, by a hash of subject and name.
pub fn goes_without_inlets(case: &Case, share: f64) -> bool {
    share_of(&["inlets", &case.subject, &case.name]) < share
}

/// Fits weights to measured cases, and their calibration to these and those in `calibrating`; `progress` is called after every pass.
///
/// Pass k starts from the weights of the pass before and sees the features of its posterior. The same cases give the same bits
/// at any number of threads.
///
/// # Errors
///
/// Parameters out of range, no case, none with a true connection within reach.
pub fn fit(
    examples: &[&CandidateExample],
    calibrating: &[&CandidateExample],
    params: &TrainParams,
    progress: &mut dyn FnMut(&FittedPass),
) -> Result<Weights> {
    params.validate()?;
    if !examples.iter().any(|e| e.allowed.contains(&true)) {
        return Err(Error::parameter("cases", examples.len(), "expected one at least with a true connection within reach"));
    }
    let mut designs: Vec<Cow<Array2<f64>>> = examples.iter().map(|e| Cow::Borrowed(&e.table.features)).collect();
    let mut posteriors: Vec<(Forests, Marginals)> = Vec::new();
    let mut passes: Vec<PassWeights> = Vec::new();
    for (number, iterations) in params.iterations.iter().enumerate() {
        if number > 0 {
            designs = in_order(examples, |at, e| {
                let (forests, marginals) = &posteriors[at];
                Cow::Owned(e.table.features_and(&Feedback::new(&e.extraction, &e.table.candidates).features(forests, marginals)))
            });
        }
        let objective = Objective::new(examples, &designs, params.l2);
        let start = objective.standardised(&first_guess(number, passes.last()));
        let before = objective.at(&start).0;
        let found = minimise(start, *iterations, &|y| objective.at(y));
        let pass = objective.pass(&found.point);
        progress(&FittedPass { pass: number + 1, objective: [before, found.value], evaluations: found.evaluations });
        let next = in_order(examples, |at, e| e.table.forests(&pass, &designs[at]).map(|f| (marginals(&f), f)));
        posteriors = next.into_iter().map(|p| p.map(|(m, f)| (f, m))).collect::<Result<_>>()?;
        passes.push(pass);
    }
    let subjects: BTreeSet<&str> = examples.iter().map(|e| e.case.subject.as_str()).collect();
    let mut weights = Weights {
        passes,
        calibration: [0.0, 1.0, 0.0],
        provenance: ModelProvenance::of(examples.len(), subjects.len()),
        ..Weights::default()
    };
    let further = in_order(calibrating, |_, e| Ok(last_pass(&e.extraction, &e.table, &weights)?.1));
    let further = further.into_iter().collect::<Result<Vec<Marginals>>>()?;
    let all: Vec<&CandidateExample> = examples.iter().chain(calibrating).copied().collect();
    let mut pairs = Vec::new();
    let found = posteriors.iter().map(|(_, marginals)| marginals).chain(&further);
    for ((example, marginals), weight) in all.iter().zip(found).zip(case_weights(&all)) {
        let of_input = input_features(marginals);
        let p = example.table.summed_by_pair(&marginals.edges);
        let listed = p.iter().zip(&example.matches).filter(|(p, _)| **p > LEAST_LISTED);
        pairs.extend(listed.map(|(p, right)| (*p, of_input, right.is_some(), weight)));
    }
    if all.len() < LEAST_CASES {
        weights.calibration = calibrate(pairs.into_iter().map(|(p, _, right, weight)| (p, [], right, weight))).0;
    } else {
        (weights.calibration, weights.of_input) = calibrate(pairs.into_iter());
        weights.usual = all.iter().filter_map(|e| Usual::new(&e.extraction)).reduce(Usual::with);
    }
    weights.closure = fit_closures(examples, &weights, &posteriors);
    Ok(weights)
}

/// The weights of closures by logistic regression; none where no case has a right one within reach.
fn fit_closures(examples: &[&CandidateExample], weights: &Weights, posteriors: &[(Forests, Marginals)]) -> Vec<f64> {
    let of_case = in_order(examples, |at, e| {
        let (forests, marginals) = &posteriors[at];
        let attached = attachment_scores(&e.table, marginals, weights.calibration_of(marginals));
        let kept = arborescence(forests, &attached, &root_scores(&e.extraction, marginals));
        let found = closures(&e.extraction, &e.table, &weights.passes[0], marginals, &kept);
        let point = |c: &Closure| e.extraction.ends[c.candidate.end].point;
        found
            .iter()
            .map(|c| (c.features.to_vec(), e.case.truth.matching(point(c), c.candidate.point).is_some(), 1.0))
            .collect::<Vec<_>>()
    });
    let rows: Vec<_> = of_case.into_iter().flatten().collect();
    if rows.iter().any(|(_, right, _)| *right) { logistic(&rows, CLOSURE_L2) } else { Vec::new() }
}

/// Zeros, or the weights of the pass before with zeros for what it did not know.
fn first_guess(number: usize, before: Option<&PassWeights>) -> PassWeights {
    let mut pass = before
        .cloned()
        .unwrap_or_else(|| PassWeights { candidate: Vec::new(), root: vec![0.0; PassWeights::root_features().count()] });
    pass.candidate.resize(PassWeights::candidate_features(number).count(), 0.0);
    pass
}
