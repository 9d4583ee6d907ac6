//! What a fit minimises: the penalised negative log-likelihood of the truth of all cases, in standardised weights.

use std::borrow::Cow;

use ndarray::{Array2, ArrayView1};

use super::example::CandidateExample;
use super::logistic::spread;
use willis_core::error::Result;
use willis_core::forest_posterior::{log_likelihood, marginals};
use willis_core::support::in_order;
use willis_models::candidates::model::{PassWeights, is_cut};

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
