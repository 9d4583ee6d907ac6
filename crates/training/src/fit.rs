//! Fits weights to cases: maximum conditional likelihood pass by pass, in standardised weights, then the calibration.

use std::{borrow::Cow, collections::BTreeSet};

use ndarray::{Array2, ArrayView1};

use super::example::{CandidateExample, Case, LEAST_LISTED, share_of};
use super::minimise::{calibrate, logistic, minimise, spread};
use willis_core::error::{Result, require};
use willis_core::forest_posterior::{Forests, Marginals, arborescence, log_likelihood, marginals};
use willis_core::support::{in_order, model_provenance::ModelProvenance};
use willis_models::candidates::features::feedback_features;
use willis_models::candidates::model::weights::input_features;
use willis_models::candidates::model::{
    Closure, PassWeights, Usual, Weights, attachment_scores, closures, is_cut, last_pass, root_scores,
};

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
        require((0.0..=1e6).contains(&self.l2), "l2", self.l2, "expected a number from 0 to 1e6")?;
        let accepted = "expected one pass at least, of one iteration at least";
        let is_right = !self.iterations.is_empty() && !self.iterations.contains(&0);
        require(is_right, "iterations", format!("{:?}", self.iterations), accepted)?;
        let is_share = (0.0..=1.0).contains(&self.without_inlets);
        require(is_share, "share without inlets", self.without_inlets, "expected a number from 0 to 1")
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
/// Parameters out of range, no case, none with a true connection within reach of the side that hangs on the other.
pub fn fit(
    examples: &[&CandidateExample],
    calibrating: &[&CandidateExample],
    params: &TrainParams,
    progress: &mut dyn FnMut(&FittedPass),
) -> Result<Weights> {
    params.validate()?;
    let is_enough = examples.iter().any(|e| e.allowed.contains(&true));
    let accepted = "expected one at least with a true connection within reach of the side that hangs on the other";
    require(is_enough, "cases", examples.len(), accepted)?;
    let mut designs: Vec<Cow<Array2<f64>>> = examples.iter().map(|e| Cow::Borrowed(&e.table.features)).collect();
    let mut posteriors: Vec<(Forests, Marginals)> = Vec::new();
    let mut passes: Vec<PassWeights> = Vec::new();
    for (number, iterations) in params.iterations.iter().enumerate() {
        if number > 0 {
            designs = in_order(examples, |at, e| {
                let (forests, marginals) = &posteriors[at];
                Cow::Owned(e.table.features_and(&feedback_features(&e.extraction, &e.table.candidates, forests, marginals)))
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
        let row = |c: &Closure| (c.features.to_vec(), e.case.truth.matching(point(c), c.candidate.point).is_some(), 1.0);
        found.iter().map(row).collect::<Vec<_>>()
    });
    let rows: Vec<_> = of_case.into_iter().flatten().collect();
    if rows.iter().any(|(_, right, _)| *right) { logistic(&rows, CLOSURE_L2) } else { Vec::new() }
}

/// Zeros, or the weights of the pass before with zeros for what it did not know.
fn first_guess(number: usize, before: Option<&PassWeights>) -> PassWeights {
    let zeros = || PassWeights { candidate: Vec::new(), root: vec![0.0; PassWeights::root_features().count()] };
    let mut pass = before.cloned().unwrap_or_else(zeros);
    pass.candidate.resize(PassWeights::candidate_features(number).count(), 0.0);
    pass
}

/// Added to the spread of a candidate's feature. One that hardly varies at all is not scaled.
const LEAST_SPREAD: f64 = 1e-6;
/// The least spread of a root's feature.
const LEAST_ROOT_SPREAD: f64 = 0.3;

/// λ Σ y² - Σ ω ln P(truth) / Σ ω over cases, y = weight times standard deviation of its feature over all rows, ω the share of
/// [`case_weights`].
pub struct Objective<'a> {
    examples: &'a [&'a CandidateExample<'a>],
    /// Per case the features of its candidates in this pass.
    designs: &'a [Cow<'a, Array2<f64>>],
    case_weights: Vec<f64>,
    /// Standard deviations: candidate features, then root features.
    scale: Vec<f64>,
    candidate_features: usize,
    l2: f64,
}

impl<'a> Objective<'a> {
    /// The objective of cases with the features of their candidates, shape (candidates, features) each.
    pub fn new(examples: &'a [&'a CandidateExample<'a>], designs: &'a [Cow<'a, Array2<f64>>], l2: f64) -> Self {
        let standing = |s: f64| if s > LEAST_SPREAD { s + LEAST_SPREAD } else { 1.0 };
        let spread_of = |tables: &[&Array2<f64>]| {
            let rows: Vec<ArrayView1<f64>> = tables.iter().flat_map(|table| table.rows()).collect();
            spread(tables.first().map_or(0, |table| table.ncols()), &rows)
        };
        let candidates: Vec<&Array2<f64>> = designs.iter().map(AsRef::as_ref).collect();
        let roots: Vec<&Array2<f64>> = examples.iter().map(|e| &e.table.root_features).collect();
        let mut scale: Vec<f64> = spread_of(&candidates).into_iter().map(standing).collect();
        let candidate_features = scale.len();
        scale.extend(spread_of(&roots).into_iter().map(|s| s.max(LEAST_ROOT_SPREAD)));
        Self { examples, designs, case_weights: case_weights(examples), scale, candidate_features, l2 }
    }

    /// The standardised weights of a pass.
    pub fn standardised(&self, pass: &PassWeights) -> Vec<f64> {
        pass.candidate.iter().chain(&pass.root).zip(&self.scale).map(|(w, s)| w * s).collect()
    }

    /// The pass of standardised weights.
    pub fn pass(&self, y: &[f64]) -> PassWeights {
        let weights: Vec<f64> = y.iter().zip(&self.scale).map(|(y, s)| y / s).collect();
        let (candidate, root) = weights.split_at(self.candidate_features);
        PassWeights { candidate: candidate.to_vec(), root: root.to_vec() }
    }

    /// Value and gradient. Infinite where a weight is no number.
    pub fn at(&self, y: &[f64]) -> (f64, Vec<f64>) {
        let pass = self.pass(y);
        let terms = in_order(self.examples, |number, example| gradient(example, &self.designs[number], &pass));
        let mut value = self.l2 * y.iter().map(|y| y * y).sum::<f64>();
        let mut slope: Vec<f64> = y.iter().map(|y| 2.0 * self.l2 * y).collect();
        for (term, weight) in terms.into_iter().zip(&self.case_weights) {
            let Ok((log_likelihood, gradient)) = term else { return (f64::INFINITY, vec![0.0; y.len()]) };
            value -= weight * log_likelihood;
            for ((slope, g), scale) in slope.iter_mut().zip(gradient).zip(&self.scale) {
                *slope -= weight * g / scale;
            }
        }
        (value, slope)
    }
}

/// ln P of a case's truth and its derivatives by the weights of the candidates' and the roots' features.
fn gradient(example: &CandidateExample, design: &Array2<f64>, pass: &PassWeights) -> Result<(f64, Vec<f64>)> {
    let forests = example.table.forests(pass, design)?;
    let (value, gradient) = log_likelihood(&forests, &marginals(&forests), &example.allowed);
    let mut out = vec![0.0; pass.candidate.len() + pass.root.len()];
    let (of_candidate, of_root) = out.split_at_mut(pass.candidate.len());
    let edges = forests.edges().iter().map(|edge| edge.log_weight).zip(gradient.edges);
    for (row, (log_weight, g)) in design.rows().into_iter().zip(edges) {
        add(of_candidate, if is_cut(log_weight) { 0.0 } else { g }, &row);
    }
    let roots = forests.log_roots().iter().zip(gradient.roots);
    for (row, (log_weight, g)) in example.table.root_features.rows().into_iter().zip(roots) {
        add(of_root, if is_cut(*log_weight) { 0.0 } else { g }, &row);
    }
    Ok((value, out))
}

fn add(sum: &mut [f64], factor: f64, row: &ArrayView1<f64>) {
    if factor != 0.0 {
        sum.iter_mut().zip(row).for_each(|(sum, x)| *sum += factor * x);
    }
}

/// Per case the weight n^-0.5 over the sum of all, n its fragments: a brain of a hundred fragments teaches more than a circle
/// of ten, but there are not ten times as many independent things to learn from it.
pub fn case_weights(examples: &[&CandidateExample]) -> Vec<f64> {
    let of: Vec<f64> = examples.iter().map(|e| (e.extraction.fragments.len().max(1) as f64).powf(-0.5)).collect();
    let sum: f64 = of.iter().sum();
    of.into_iter().map(|w| w / sum).collect()
}
