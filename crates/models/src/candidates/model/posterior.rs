//! The posterior over the forests of an extraction, and the probability of every candidate.

use super::feature_table::CandidateTable;
use super::likely_inlets::known_or_likely_inlets;
use super::loop_closures::closures;
use super::weights::{FEW, Weights};
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::feedback::Feedback;
use crate::candidates::search::EndCandidate;
use willis_core::error::{Error, Result};
use willis_core::forest_posterior::{Forests, Marginals, arborescence, marginals};
use willis_core::support::calibration::Calibration;

/// The posterior over how the fragments of an extraction are connected.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestPosterior {
    /// The candidates with their features; those between fragments are the edges of the forests, in their order.
    pub table: CandidateTable,
    /// The weights of the last pass.
    pub forests: Forests,
    /// The marginals of the last pass, not calibrated.
    pub marginals: Marginals,
    /// Per candidate the calibrated probability of its pair.
    pub probability: Vec<f64>,
    /// Per fragment the score of leaving it a root then.
    pub root_scores: Vec<f64>,
    /// The candidates within a fragment with the probability that they close a loop that is there.
    pub closures: Vec<(EndCandidate, f64)>,
}

/// The posterior that `weights` give the candidates of an extraction, which should be all of a search.
///
/// # Errors
///
/// Weights without a pass, or of other features than this program measures; fragments in a tangle.
pub fn posterior(extraction: &Extraction, candidates: &[EndCandidate], weights: &Weights) -> Result<ForestPosterior> {
    weights.validate()?;
    let table = CandidateTable::new(extraction, candidates)?;
    let (forests, marginals) = last_pass(extraction, &table, weights)?;
    let calibration = weights.calibration_of(&marginals);
    let of_pair: Vec<f64> = table.summed_by_pair(&marginals.edges).into_iter().map(|p| calibration.apply(p)).collect();
    let probability = table.pairs.of.iter().map(|pair| of_pair[*pair]).collect();
    let root_scores = root_scores(extraction, &marginals);
    let closures = if weights.closure.is_empty() {
        Vec::new()
    } else {
        let kept = arborescence(&forests, &attachment_scores(&table, &marginals, calibration), &root_scores);
        let found = closures(extraction, &table, &weights.passes[0], &marginals, &kept);
        found.iter().map(|c| (c.candidate, c.probability(&weights.closure))).collect()
    };
    Ok(ForestPosterior { table, forests, marginals, probability, root_scores, closures })
}

/// Weights and marginals of the last of all passes; each pass sees the posterior of the one before.
///
/// # Errors
///
/// A graph whose elimination has more joins than memory holds.
pub fn last_pass(extraction: &Extraction, table: &CandidateTable, weights: &Weights) -> Result<(Forests, Marginals)> {
    let mut last: Option<(Forests, Marginals)> = None;
    let mut feedback = None;
    for pass in &weights.passes {
        let forests = match &last {
            None => table.forests(pass, &table.features)?,
            Some((forests, marginals)) => {
                let feedback = feedback.get_or_insert_with(|| Feedback::new(extraction, &table.candidates));
                table.forests(pass, &table.features_and(&feedback.features(forests, marginals)))?
            }
        };
        let marginals = marginals(&forests);
        last = Some((forests, marginals));
    }
    last.ok_or_else(|| Error::parameter("weights", "of no pass", "expected one pass at least"))
}

/// A fragment that blood enters is no false one, so leaving it a root can only lose a connection.
const FED: f64 = 0.3;
/// Where no inlet is given, inlets that nobody marked make every fragment somewhat more likely to lead to one.
const UNMARKED: f64 = 0.7;

/// Per fragment P(root) times 0.3 where blood enters it, times n/(n + 10) elsewhere, n the number of fragments; times 0.7 when no
/// inlet is given. In a circle of few fragments one lost connection changes the whole, in a brain of a hundred one false twig more joins it.
pub fn root_scores(extraction: &Extraction, marginals: &Marginals) -> Vec<f64> {
    let n = extraction.fragments.len() as f64;
    let mut fed = vec![false; extraction.fragments.len()];
    for point in known_or_likely_inlets(extraction) {
        fed[extraction.fragment[point]] = true;
    }
    let unmarked = if extraction.inlets.is_empty() { UNMARKED } else { 1.0 };
    marginals.roots.iter().zip(fed).map(|(p, fed)| p * unmarked * if fed { FED } else { n / (n + FEW) }).collect()
}

/// Per candidate the score of attaching its child by it: the share that its direction has of the calibrated probability of its pair.
pub fn attachment_scores(table: &CandidateTable, marginals: &Marginals, calibration: Calibration) -> Vec<f64> {
    let sum = table.summed_by_pair(&marginals.edges);
    let share = |(p, pair): (&f64, &usize)| if sum[*pair] > 0.0 { calibration.apply(sum[*pair]) * (p / sum[*pair]) } else { 0.0 };
    marginals.edges.iter().zip(&table.pairs.of).map(share).collect()
}
