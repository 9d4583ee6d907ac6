//! A skeleton in an image: more candidates than shape gives, and what lies between the points of all.

use ndarray::{Array2, Axis, Slice, concatenate};

use super::features::join_features;
use super::image::ahead::Ahead;
use super::image::features::ImageTable;
use super::model::JoinModel;
use super::rivals::second_features;
use super::table::{JoinTable, ShapeScores};
use crate::candidates::pairs::Pairs;
use crate::candidates::search::EndCandidate;
use willis_core::support::boosted_trees::{Boosted, stored};
use willis_io::masks::Scene;

/// The candidates of a skeleton in an image.
pub struct InImage {
    /// Those of the table, then those that only the image shows.
    pub candidates: Vec<EndCandidate>,
    /// The candidates as pairs of points; those of the table come first.
    pub pairs: Pairs,
    /// What lies between the points of each pair.
    pub between: ImageTable,
    /// The features by shape of the candidates that only the image shows.
    more: Array2<f32>,
}

impl InImage {
    /// Searches the image and measures in it the pairs that `scores` of the second pass leave possible; without scores all of them.
    pub fn new(table: &JoinTable, scene: &Scene, scores: Option<&[f64]>) -> Self {
        let e = &table.extraction;
        let ahead = Ahead::new(scene, e);
        let (more, ways): (Vec<EndCandidate>, Vec<_>) = ahead.candidates(e, &table.candidates).into_iter().unzip();
        let candidates = [table.candidates.clone(), more].concat();
        let pairs = Pairs::new(e, &candidates);
        let all = join_features(e, &table.courses, &candidates);
        let more = all.slice_axis(Axis(0), Slice::from(table.candidates.len()..)).mapv(stored);
        let between = ImageTable::new(scene, e, &pairs, &ahead, &ways, scores);
        Self { candidates, pairs, between, more }
    }

    /// Per pair its score by shape: those of the table have theirs, the others are compared with them and with one another.
    pub fn scores(&self, table: &JoinTable, [first, second]: [&Boosted; 2], scores: &ShapeScores) -> Vec<f64> {
        let known = table.candidates.len();
        let firsts = [scores.first.clone(), first.scores(&self.more)].concat();
        let features = second_features(&table.extraction, &self.candidates, &self.pairs, &firsts);
        let features = features.slice_axis(Axis(0), Slice::from(known..)).mapv(stored);
        // Both have a row a candidate.
        let features = concatenate(Axis(1), &[features.view(), self.more.view()]).unwrap_or(features);
        let mut all = vec![0.0; known];
        all.extend(second.scores(&features));
        let more = self.pairs.mean(&all).split_off(scores.second.len());
        scores.second.iter().copied().chain(more).collect()
    }

    /// Per pair its probability: by what the image shows where it decides, else by shape.
    pub fn probabilities(&self, table: &JoinTable, model: &JoinModel, scores: &ShapeScores) -> Vec<f64> {
        let scores = self.scores(table, model.passes.each_ref(), scores);
        let mut probability: Vec<f64> = scores.iter().map(|score| model.probability(*score)).collect();
        if let Some(pass) = &model.image {
            let seen = pass.trees.scores(&self.features(table, &scores));
            for (pair, score) in seen.into_iter().enumerate().filter(|(pair, _)| self.between.is_seen(*pair, scores[*pair])) {
                probability[pair] = pass.probability(score);
            }
        }
        probability
    }

    /// The features of the third pass, given the scores by shape: a row a pair.
    pub fn features(&self, table: &JoinTable, scores: &[f64]) -> Array2<f32> {
        self.between.features(&table.extraction, &self.pairs, scores)
    }
}
