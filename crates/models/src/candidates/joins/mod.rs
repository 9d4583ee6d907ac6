//! Joins on automatic skeletons: candidates judged one by one, each knowing its rivals.
//!
//! Where a segmentation was thinned, vessels that touch are fused, and the fragments of the skeleton are no longer pieces of one forest: true
//! gaps lie within a fragment and close loops of fragments. So each candidate has a probability of its own, from boosted trees over what a
//! tracing shows and more ([`features`]), in two passes: the second sees how probable the first made the other candidates for the same places.
//! Where there is an image a third pass sees what it shows between the ends ([`image`]).

pub mod course;
pub mod features;
pub mod image;
pub mod in_image;
pub mod model;
pub mod rivals;
pub mod search;

use ndarray::{Array2, Axis, concatenate};

use super::features::Extraction;
use super::kind::Kind;
use super::resample::Resampled;
use super::search::Candidate;
use course::Course;
use features::join_features;
use in_image::InImage;
use model::JoinModel;
use rivals::{Pairs, second_features};
use search::search_joins;
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
    pub courses: Vec<Course>,
    /// The candidates, by free end.
    pub candidates: Vec<Candidate>,
    /// The candidates as pairs of points.
    pub pairs: Pairs,
    /// Features: a row a candidate, a column one of [`features::join_feature_names`].
    pub features: Array2<f32>,
}

impl JoinTable {
    /// Searches and measures the candidates of the observed vessels of a network, to so many of the nearest branches of each free end.
    ///
    /// # Errors
    ///
    /// A node without position or with more than 1000 vessels, or points that are crowded.
    pub fn new(network: &Network, branches: usize) -> Result<Self> {
        let resampled = Resampled::new(network, Kind::Skeleton);
        let extraction = resampled.extraction(&[])?;
        let courses: Vec<Course> = (0..extraction.ends.len()).map(|end| Course::new(&extraction, end)).collect();
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
    pub fn scores(&self, model: &JoinModel) -> Scores {
        let first = model.passes[0].scores(&self.features);
        let second = self.pairs.mean(&model.passes[1].scores(&self.second(&first)));
        Scores { first, second }
    }

    /// Per pair its probability by shape.
    pub fn probabilities(&self, model: &JoinModel, scores: &Scores) -> Vec<f64> {
        scores.second.iter().map(|score| model.probability(*score)).collect()
    }

    /// Per pair of a skeleton in an image its probability: by what the image shows where it decides, else by shape.
    pub fn probabilities_in(&self, model: &JoinModel, scores: &Scores, image: &InImage) -> Vec<f64> {
        let scores = image.scores(self, model.passes.each_ref(), scores);
        let mut probability: Vec<f64> = scores.iter().map(|score| model.probability(*score)).collect();
        if let Some(pass) = &model.image {
            let seen = pass.trees.scores(&image.features(self, &scores));
            for (pair, score) in seen.into_iter().enumerate().filter(|(pair, _)| image.between.is_seen(*pair, scores[*pair])) {
                probability[pair] = pass.probability(score);
            }
        }
        probability
    }
}

/// Scores (log-odds) of the two passes over shape.
#[derive(Debug, Clone)]
pub struct Scores {
    /// Per candidate that of the first pass.
    pub first: Vec<f64>,
    /// Per pair the mean of its candidates in the second pass.
    pub second: Vec<f64>,
}
