//! The candidates of an extraction with their features, and the weights that a pass gives them.

use ndarray::{Array1, Array2, ArrayView1, Axis};

use super::pass::PassWeights;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::features;
use crate::candidates::features::root_features::root_features;
use crate::candidates::pairs::{Pairs, unordered};
use crate::candidates::search::EndCandidate;
use willis_core::error::{Error, Result};
use willis_core::forest_posterior::{Edge, Forests, MOST_PAIRS, is_tangle};
use willis_core::network::units::millimetres;

/// Log weights are cut at ±25, so that one odd feature does not decide everything.
const MOST_LOG_WEIGHT: f64 = 25.0;

/// The candidates of an extraction, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateTable {
    /// The candidates between fragments, in the order of the search.
    pub candidates: Vec<EndCandidate>,
    /// The candidates within a fragment.
    pub within: Vec<EndCandidate>,
    /// The features of those within a fragment, shape (candidates within a fragment, features).
    pub within_features: Array2<f64>,
    /// Child and parent fragment of each candidate between fragments.
    pub fragments: Vec<[usize; 2]>,
    /// Those between fragments as pairs of points.
    pub pairs: Pairs,
    /// The features of those between fragments, shape (candidates, features).
    pub features: Array2<f64>,
    /// Features of the fragments as roots, shape (fragments, features).
    pub root_features: Array2<f64>,
}

impl CandidateTable {
    /// Measures the candidates of a search; those within a fragment count among the rivals of the others.
    ///
    /// # Errors
    ///
    /// Fragments in a tangle, before anything is measured.
    pub fn new(extraction: &Extraction, found: &[EndCandidate]) -> Result<Self> {
        check_tangle(extraction, found)?;
        let (within, between): (Vec<usize>, Vec<usize>) = (0..found.len()).partition(|row| found[*row].within);
        let all = features(extraction, found);
        let [features, within_features] = [&between, &within].map(|rows| all.select(Axis(0), rows));
        let [candidates, within] = [between, within].map(|rows| rows.into_iter().map(|row| found[row]).collect::<Vec<_>>());
        let pairs = Pairs::new(extraction, &candidates);
        let fragments = candidates.iter().map(|candidate| candidate.fragments(extraction)).collect();
        let root_features = root_features(extraction);
        Ok(Self { candidates, within, within_features, fragments, pairs, features, root_features })
    }

    /// The features of the candidates with more columns.
    pub fn features_and(&self, more: &Array2<f64>) -> Array2<f64> {
        let (rows, own) = self.features.dim();
        Array2::from_shape_fn((rows, own + more.ncols()), |(row, column)| {
            if column < own { self.features[[row, column]] } else { more[[row, column - own]] }
        })
    }

    /// Per pair the sum of a quantity over its candidates, at most 1.
    pub fn summed_by_pair(&self, of_candidate: &[f64]) -> Vec<f64> {
        self.pairs.sum(of_candidate).into_iter().map(|x: f64| x.min(1.0)).collect()
    }

    /// The forests that the weights of a pass make of the features of its candidates.
    ///
    /// # Errors
    ///
    /// A feature or weight that is no number.
    pub fn forests(&self, pass: &PassWeights, features: &Array2<f64>) -> Result<Forests> {
        let cut = |x: &f64| x.clamp(-MOST_LOG_WEIGHT, MOST_LOG_WEIGHT);
        let log_weights: Array1<f64> = features.dot(&ArrayView1::from(&pass.candidate));
        let edge = |([child, parent], w): (&[usize; 2], &f64)| Edge { child: *child, parent: *parent, log_weight: cut(w) };
        let roots = self.root_features.dot(&ArrayView1::from(&pass.root));
        Forests::new(roots.iter().map(cut).collect(), self.fragments.iter().zip(&log_weights).map(edge).collect())
    }
}

/// Refuses fragments that depend on one another so much that their posterior would take very long, before anything is measured.
///
/// # Errors
///
/// More than 500 million pairs of fragments meet when they are eliminated one after another.
fn check_tangle(extraction: &Extraction, candidates: &[EndCandidate]) -> Result<()> {
    let between = || candidates.iter().filter(|candidate| !candidate.within);
    let mut links: Vec<[usize; 2]> = between().map(|c| unordered(c.fragments(extraction))).collect();
    links.sort_unstable();
    links.dedup();
    let count = extraction.fragments.len();
    if !is_tangle(count, &links) {
        return Ok(());
    }
    let mut gaps: Vec<f64> = between().map(|c| c.gap(extraction)).collect();
    gaps.sort_unstable_by(f64::total_cmp);
    let found = format!(
        "{count}, of which {} pairs may be joined: by way of others, more than {MOST_PAIRS} pairs depend on one another",
        links.len()
    );
    let most = millimetres(gaps[gaps.len() / 2]);
    let accepted =
        format!("evidence takes fewer: give `max_gap` below {most:.3} mm, which half of the candidates are, or `prior=none`");
    Err(Error::parameter("fragments", found, accepted))
}

/// Whether a log weight is at its limit, where the weights of features no longer move it.
pub fn is_cut(log_weight: f64) -> bool {
    log_weight.abs() >= MOST_LOG_WEIGHT
}
