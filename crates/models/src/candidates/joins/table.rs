//! The candidates of a skeleton with their features by shape, and their scores and probabilities by these.

use ndarray::{Array2, Axis, concatenate};

use super::course::EndCourse;
use super::features::join_features;
use super::model::JoinModel;
use super::rivals::second_features;
use super::search::search_joins;
use crate::candidates::features::Extraction;
use crate::candidates::kind::CenterlineKind;
use crate::candidates::pairs::Pairs;
use crate::candidates::resample::Resampled;
use crate::candidates::search::EndCandidate;
use willis_core::error::Result;
use willis_core::network::Network;
use willis_core::support::boosted_trees::stored;

/// The candidates of a skeleton with their features.
pub struct JoinTable {
    /// The resampled skeleton, on which everything is measured.
    pub resampled: Resampled,
    /// Its points.
    pub extraction: Extraction,
    /// The course of each free end.
    pub courses: Vec<EndCourse>,
    /// The candidates, by free end.
    pub candidates: Vec<EndCandidate>,
    /// The candidates as pairs of points.
    pub pairs: Pairs,
    /// Features: a row a candidate, a column one of [`join_feature_names`](super::features::join_feature_names).
    pub features: Array2<f32>,
}

impl JoinTable {
    /// Searches and measures the candidates of the observed vessels of a network, to so many of the nearest branches of each free end.
    ///
    /// # Errors
    ///
    /// A node without position or with more than 1000 vessels, or points that are crowded.
    pub fn new(network: &Network, branches: usize) -> Result<Self> {
        let resampled = Resampled::new(network, CenterlineKind::Skeleton);
        let extraction = resampled.extraction(&[])?;
        let courses: Vec<EndCourse> = (0..extraction.ends.len()).map(|end| EndCourse::new(&extraction, end)).collect();
        let candidates = search_joins(&extraction, &courses, branches)?;
        let features = join_features(&extraction, &courses, &candidates).mapv(stored);
        let pairs = Pairs::new(&extraction, &candidates);
        Ok(Self { resampled, extraction, courses, candidates, pairs, features })
    }

    /// The features of the second pass, given the scores of the first.
    pub fn second(&self, scores: &[f64]) -> Array2<f32> {
        let first = second_features(&self.extraction, &self.candidates, &self.pairs, scores).mapv(stored);
        // Both have a row a candidate.
        concatenate(Axis(1), &[first.view(), self.features.view()]).unwrap_or(first)
    }

    /// The scores of both passes.
    pub fn scores(&self, model: &JoinModel) -> ShapeScores {
        let first = model.passes[0].scores(&self.features);
        let second = self.pairs.mean(&model.passes[1].scores(&self.second(&first)));
        ShapeScores { first, second }
    }

    /// Per pair its probability by shape.
    pub fn probabilities(&self, model: &JoinModel, scores: &ShapeScores) -> Vec<f64> {
        scores.second.iter().map(|score| model.probability(*score)).collect()
    }
}

/// Scores (log-odds) of the two passes over shape.
#[derive(Debug, Clone)]
pub struct ShapeScores {
    /// Per candidate that of the first pass.
    pub first: Vec<f64>,
    /// Per pair the mean of its candidates in the second pass.
    pub second: Vec<f64>,
}
