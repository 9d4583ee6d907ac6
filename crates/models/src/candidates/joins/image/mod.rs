//! A skeleton in an image: more candidates than shape gives, and what the image shows between the points of all, where a vessel that fell below the
//! threshold is faintly there still: along the straight line and along the cheapest path.

pub mod features;
pub mod ways;

use ndarray::{Array2, Axis, Slice, concatenate};

use super::features::{join_features, second_features};
use super::model::JoinModel;
use super::{JoinTable, ShapeScores};
use crate::candidates::search::{EndCandidate, Pairs};
use features::{MOST_MARGIN, PATH_COST, PATH_MEAN, PairSeen, image_feature_names, see};
use ways::Ahead;
use willis_core::support::arc_lengths::in_direction;
use willis_core::support::boosted_trees::{Boosted, stored};
use willis_core::support::geometry::Point;
use willis_core::support::numbered::grouped;
use willis_io::masks::Scene;

/// Pairs with a lower score (log-odds) than this are judged without the image: they would have to be a thousand times as probable.
const LEAST_SCORE: f64 = -7.0;

/// The candidates of a skeleton in an image.
pub struct InImage {
    /// Those of the table, then those that only the image shows.
    pub candidates: Vec<EndCandidate>,
    /// The candidates as pairs of points; those of the table come first.
    pub pairs: Pairs,
    /// What each pair shows; `None` where the image ends.
    seen: Vec<Option<PairSeen>>,
    /// The first of the pairs that were found in the image.
    first_met: usize,
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
        let all = join_features(e, &table.courses, &candidates, &pairs);
        let more = all.slice_axis(Axis(0), Slice::from(table.candidates.len()..)).mapv(stored);
        let first_met = pairs.points.len() - ways.len();
        let seen = willis_core::support::in_order(&pairs.points, |pair, points| {
            let way = pair.checked_sub(first_met).map(|met| ways[met]);
            let is_possible = way.is_some() || scores.is_none_or(|scores| scores[pair] >= LEAST_SCORE);
            is_possible.then(|| see(scene, e, *points, &ahead, way)).flatten()
        });
        Self { candidates, pairs, seen, first_met, more }
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
            for (pair, score) in seen.into_iter().enumerate().filter(|(pair, _)| self.is_seen(*pair, scores[*pair])) {
                probability[pair] = pass.probability(score);
            }
        }
        probability
    }

    /// Whether the image decides about a pair with this score: it shows what lies between its points, and the pair is possible or was
    /// found in the image.
    pub fn is_seen(&self, pair: usize, score: f64) -> bool {
        self.seen[pair].is_some() && (score >= LEAST_SCORE || pair >= self.first_met)
    }

    /// The places (m) between the points of a pair on its cheapest path, from one of the two on; none where nothing is seen.
    pub fn course(&self, pair: usize, from: usize) -> Vec<Point> {
        let Some((_, path)) = &self.seen[pair] else { return Vec::new() };
        in_direction(path.points[1..path.points.len() - 1].to_vec(), self.pairs.points[pair][0] == from)
    }

    /// The features of the third pass, given the scores by shape: a row a pair, a column one of [`image_feature_names`]; zeros where nothing is seen.
    pub fn features(&self, table: &JoinTable, scores: &[f64]) -> Array2<f32> {
        let (e, pairs) = (&table.extraction, &self.pairs);
        let is_rival = |pair: usize| scores[pair] >= LEAST_SCORE || pair >= self.first_met;
        let rivals = pairs.points.iter().enumerate().filter(|(pair, _)| is_rival(*pair));
        let at = grouped(e.position.len(), rivals.flat_map(|(pair, points)| points.map(|point| (point, pair))));
        // What the best rival at a place leaves: free ends have rivals, other places take any number.
        let margin = |pair: usize, point: usize, of: &dyn Fn(usize) -> Option<f64>| {
            let own = of(pair).unwrap_or(0.0);
            let rivals = at[point].iter().filter(|other| **other != pair && e.end_at[point].is_some());
            let best = rivals.filter_map(|other| of(*other)).fold(f64::NEG_INFINITY, f64::max);
            (own - best).clamp(-MOST_MARGIN, MOST_MARGIN)
        };
        let mut out = Array2::zeros((pairs.points.len(), image_feature_names().len()));
        for (pair, seen) in self.seen.iter().enumerate() {
            let Some((seen, _)) = seen.as_ref().filter(|_| is_rival(pair)) else { continue };
            let margins = |of: &dyn Fn(usize) -> Option<f64>| {
                let [a, b] = pairs.points[pair].map(|point| margin(pair, point, of));
                [a.min(b), a.max(b)]
            };
            let score = margins(&|pair| Some(scores[pair]));
            let cost = margins(&|pair| self.seen[pair].as_ref().map(|(seen, _)| -seen[PATH_COST]));
            let contrast = margins(&|pair| self.seen[pair].as_ref().map(|(seen, _)| seen[PATH_MEAN]));
            let values = [scores[pair]].into_iter().chain(score).chain(seen.iter().copied()).chain(cost).chain(contrast);
            for (column, x) in values.enumerate() {
                out[[pair, column]] = stored(x);
            }
        }
        out
    }
}
