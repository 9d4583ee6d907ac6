//! Joins on automatic skeletons: candidates judged one by one, each knowing its rivals.
//!
//! Where a segmentation was thinned, vessels that touch are fused, and the fragments of the skeleton are no longer pieces of one forest: true
//! gaps lie within a fragment and close loops of fragments. So each candidate has a probability of its own, from boosted trees over what a
//! tracing shows and more ([`features`]), in two passes: the second sees how probable the first made the other candidates for the same places.
//! Where there is an image a third pass sees what it shows between the ends ([`image`]).

pub mod features;
pub mod image;
pub mod model;

use std::collections::{BTreeMap, BTreeSet};

use ndarray::{Array2, Axis, concatenate};

use super::features::{Extraction, FreeEnd};
use super::resample::{CenterlineKind, Resampled};
use super::search::{EndCandidate, Pairs, SearchOptions, search};
use features::{EndCourse, join_features, second_features};
use model::JoinModel;
use willis_core::network::Network;
use willis_core::support::boosted_trees::stored;
use willis_core::support::geometry::{dot, sub};
use willis_core::support::in_order;
use willis_core::support::numbered::grouped;
use willis_core::support::ties::{compare, steady};

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
    /// Features: a row a candidate, a column one of [`join_feature_names`](features::join_feature_names).
    pub features: Array2<f32>,
}

impl JoinTable {
    /// Searches and measures the candidates of the observed vessels of a network, to so many of the nearest branches of each free end.
    ///
    /// # Errors
    ///
    /// A node without position or with more than 1000 vessels, or points that are crowded.
    pub fn new(network: &Network, branches: usize) -> willis_core::error::Result<Self> {
        let resampled = Resampled::new(network, CenterlineKind::Skeleton);
        let extraction = resampled.extraction(&[])?;
        let courses: Vec<EndCourse> = (0..extraction.ends.len()).map(|end| EndCourse::new(&extraction, end)).collect();
        // Those of the search, and further ones in the direction of each free end.
        let (e, options) = (&extraction, SearchOptions { branches, ..SearchOptions::default() });
        let near = search(e, &options)?;
        let mut of_end = grouped(e.ends.len(), near.into_iter().map(|candidate| (candidate.end, candidate)));
        let is_at_border = |end: &FreeEnd| e.at_border[end.point];
        let far = in_order(&e.ends, |row, end| if is_at_border(end) { Vec::new() } else { ahead(e, &courses, row) });
        for (candidates, far) in of_end.iter_mut().zip(far) {
            let there: BTreeSet<usize> = candidates.iter().map(|c| c.point).collect();
            let fits = |c: &EndCandidate| !there.contains(&c.point) && !e.at_border[c.point];
            candidates.extend(far.into_iter().filter(fits));
        }
        let candidates = of_end.concat();
        let pairs = Pairs::new(&extraction, &candidates);
        let features = join_features(&extraction, &courses, &candidates, &pairs).mapv(stored);
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

/// The reach along a direction, in spacings and radii of the end.
const REACH_SPACINGS: f64 = 40.0;
const REACH_RADII: f64 = 20.0;
/// So many free ends ahead, each within these cosines of the two directions, ...
const ENDS: usize = 4;
const END_COS: f64 = 0.75;
const BACK_COS: f64 = 0.3;
/// ... and so many branches within this one.
const BRANCHES: usize = 2;
const BRANCH_COS: f64 = 0.9;

/// The free ends and branches of other fragments that lie ahead of a free end.
fn ahead(e: &Extraction, courses: &[EndCourse], row: usize) -> Vec<EndCandidate> {
    let (end, course) = (&e.ends[row], &courses[row]);
    let from = e.position[end.point];
    let reach = REACH_SPACINGS * e.spacing + REACH_RADII * end.radius;
    let mut free: Vec<([f64; 2], usize)> = Vec::new();
    let mut branches: BTreeMap<usize, ([f64; 2], usize)> = BTreeMap::new();
    for (gap, point) in e.index.around(from, reach) {
        if e.fragment[point] == end.fragment || gap <= 0.0 {
            continue;
        }
        let u = sub(e.position[point], from).map(|x| x / gap);
        let cos = dot(u, course.directions[1]).max(dot(u, course.directions[2]));
        let width = steady(e.smooth.radius[point] / e.spacing);
        if let Some(other) = e.end_at[point] {
            let back = -dot(u, courses[other].directions[1]);
            if steady(cos) > END_COS && steady(back) > BACK_COS {
                free.push(([steady(gap / e.spacing * (1.6 - cos - 0.5 * back)), width], point));
            }
        }
        if steady(cos) > BRANCH_COS {
            let order = [steady(gap / e.spacing * (1.3 - cos)), width];
            let best = branches.entry(e.branch[point]).or_insert((order, point));
            if compare(&order, &best.0).then(point.cmp(&best.1)).is_lt() {
                *best = (order, point);
            }
        }
    }
    let by_order = |list: &mut Vec<([f64; 2], usize)>| list.sort_by(|a, b| compare(&a.0, &b.0).then(a.1.cmp(&b.1)));
    let mut branches: Vec<([f64; 2], usize)> = branches.into_values().collect();
    by_order(&mut free);
    by_order(&mut branches);
    let found = free.iter().take(ENDS).chain(branches.iter().take(BRANCHES));
    let points: BTreeSet<usize> = found.map(|(_, point)| *point).collect();
    points.into_iter().map(|point| EndCandidate { end: row, point, within: false }).collect()
}
