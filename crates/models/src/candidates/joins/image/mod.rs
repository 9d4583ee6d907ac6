//! A skeleton in an image: more candidates than shape gives, and what the image shows between the points of all, where a vessel that fell below the
//! threshold is faintly there still: along the straight line and along the cheapest path.
//!
//! Contrast is brightness above the background, as a share of that of the vessels at the two ends. All features are dimensionless.

pub mod ways;

use ndarray::{Array2, Axis, Slice, concatenate};

use super::features::{join_features, second_features};
use super::model::{JoinModel, image_feature_names};
use super::{JoinTable, ShapeScores};
use crate::candidates::features::Extraction;
use crate::candidates::search::{EndCandidate, Pairs};
use ways::{Ahead, CheapestPath, MOST_COST, MOST_MET, across, cheapest_path};
use willis_core::support::arc_lengths::{ArcWalk, arc_lengths, in_direction};
use willis_core::support::boosted_trees::{Boosted, stored};
use willis_core::support::geometry::{Point, distance, lerp, sub, unit};
use willis_core::support::numbered::grouped;
use willis_io::masks::Scene;

/// Places on a line or path lie so many spacings apart.
const STEP: f64 = 0.5;
/// Around it the ring lies so many spacings outside the narrower end.
const RING: f64 = 1.75;
const RING_PLACES: usize = 8;
/// Both ends of a line are left out as far as their radius, but no more than this share of it.
const TRIM: f64 = 0.3;
/// The contrast of a pair is at least this share of the typical one.
const LEAST_CONTRAST: f64 = 0.2;
/// A place with less contrast than this is part of a dip.
const DIP: f64 = 0.4;
/// Pairs with a lower score (log-odds) than this are judged without the image: they would have to be a thousand times as probable.
const LEAST_SCORE: f64 = -7.0;
/// Added to the cost of the way to a vessel met, before its logarithm.
const LEAST_COST: f64 = 0.01;
/// Bounds of a margin, and its value where there is no rival.
const MOST_MARGIN: f64 = 8.0;

/// The features of a pair but those of scores and rivals, and the cheapest path, or the way to the vessel met.
type PairSeen = (Vec<f64>, CheapestPath);

/// Two of the features that need no score and no rival, which are compared with those of rivals.
const PATH_COST: usize = 13;
const PATH_MEAN: usize = 17;

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
        let all = join_features(e, &table.courses, &candidates);
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

    /// The cheapest path of a pair from one of its points (m); `None` where nothing is seen.
    pub fn course(&self, pair: usize, from: usize) -> Option<Vec<Point>> {
        let (_, path) = self.seen[pair].as_ref()?;
        Some(in_direction(path.points.clone(), self.pairs.points[pair][0] == from))
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

/// What a pair shows, along the straight line and along the cheapest path, or along the way by which it was found.
fn see(scene: &Scene, e: &Extraction, points: [usize; 2], ahead: &Ahead, way: Option<&[Point]>) -> Option<PairSeen> {
    let h = e.spacing;
    let ends = points.map(|p| e.position[p]);
    let radius = points.map(|p| e.radius_at(p));
    let gap = distance(ends[0], ends[1]);
    let own = points.map(|p| scene.contrast[p]);
    let dimmer = own[0].min(own[1]);
    let contrast = dimmer.clamp(LEAST_CONTRAST * scene.typical, scene.typical);
    let levels = [ends[0], lerp(ends[0], ends[1], 0.5), ends[1]].map(|p| scene.level(p));
    let background = levels.iter().map(|l| l.background).sum::<f64>() / 3.0;
    let noise = levels.iter().map(|l| l.noise).sum::<f64>() / 3.0 / contrast;
    let ring = radius[0].min(radius[1]) + RING * h;
    let (line, line_ring, line_inside) = along(scene, &ends, radius, background, contrast, ring, h)?;
    let [a, b] = points;
    let found = || [[a, b], [b, a]].into_iter().filter_map(|pair| ahead.of(e, pair));
    let path = match way {
        None => cheapest_path(scene, ends, radius.map(|r| r + h), [background, contrast], h)?,
        Some(way) => CheapestPath {
            points: in_direction(way.to_vec(), way.first() == Some(&ends[0])),
            cost: found().map(|(_, cost, _)| cost).fold(MOST_COST, f64::min),
        },
    };
    let (course, course_ring, course_inside) = along(scene, &path.points, radius, background, contrast, ring, h)?;
    let length: f64 = path.points.windows(2).map(|w| distance(w[0], w[1])).sum();
    // The least, the lower quartile and the mean.
    let spread = |x: Vec<f64>| {
        let least = x.iter().copied().fold(f64::INFINITY, f64::min);
        [least, willis_core::support::statistics::quantile(&x, 0.25).unwrap_or(0.0), x.iter().sum::<f64>() / x.len() as f64]
    };
    let dips = course.chunk_by(|a, b| (*a < DIP) == (*b < DIP)).filter(|run| run[0] < DIP);
    let widest_dip = dips.map(<[f64]>::len).max().unwrap_or(0) as f64 * STEP;
    let [line, line_ring, course, course_ring] = [line, line_ring, course, course_ring].map(spread);
    let steady_noise = noise.max(1e-3);
    // How the pair compares with the vessels met from its free ends: rank and ln of the cost, the least of both, and ln of that cost over the
    // least of the other vessels.
    let best = found().min_by(|x, y| x.1.total_cmp(&y.1).then(x.0.cmp(&y.0)));
    let ln = |cost: f64| (cost + LEAST_COST).ln();
    let [rank, met_cost, margin] = best.map_or([MOST_MET as f64, ln(2.0 * MOST_COST), MOST_MARGIN], |(rank, cost, other)| {
        [rank as f64, ln(cost), ln(cost) - ln(other.unwrap_or(MOST_COST))]
    });
    let [here, there] = own.map(|contrast| contrast.max(1e-3 * scene.typical));
    let mut values = vec![(gap / h + 0.1).ln(), (gap / (radius[0] + radius[1])).ln(), noise];
    values.extend([(scene.typical / contrast).ln(), (dimmer / scene.typical).max(0.01).ln(), (here / there).ln().abs()]);
    values.extend(line);
    values.extend([line[2] / steady_noise, line_ring[0], line_ring[2], line_inside]);
    values.extend([(path.cost / (gap / h).max(1.0)).ln(), path.cost.max(1e-3).ln()]);
    values.extend([course, course.map(|x| x / steady_noise), course_ring].concat());
    values.extend([course_ring[2] / steady_noise, (length / gap.max(h)).ln(), course_inside, widest_dip]);
    values.extend([rank, met_cost, margin]);
    Some((values, path))
}

/// What the image shows along a line: contrast at places, the same less that of the ring around, and the share of places inside vessels.
type Along = (Vec<f64>, Vec<f64>, f64);

/// What the image shows along a line between two ends; `None` where it is not known.
fn along(scene: &Scene, line: &[Point], radius: [f64; 2], background: f64, contrast: f64, ring: f64, h: f64) -> Option<Along> {
    let arc = arc_lengths(line.iter().copied());
    let length = arc[arc.len() - 1];
    let [from, upto] = [radius[0].min(TRIM * length), length - radius[1].min(TRIM * length)];
    let steps = ((upto - from) / (STEP * h)).ceil().max(2.0) as usize;
    let share = |x: f64| (x - background) / contrast;
    let (mut values, mut rings, mut inside) = (Vec::new(), Vec::new(), 0);
    let mut walk = ArcWalk::new(&arc);
    for n in 0..=steps {
        let s = from + (upto - from) * n as f64 / steps as f64;
        let (segment, on) = walk.to(s);
        let at = lerp(line[segment], line[segment + 1], on);
        let c = share(scene.brightness(at)?);
        let [e1, e2] = across(unit(sub(line[segment + 1], line[segment])));
        let (mut sum, mut count) = (0.0, 0.0);
        for k in 0..RING_PLACES {
            let (sin, cos) = (std::f64::consts::TAU * k as f64 / RING_PLACES as f64).sin_cos();
            let beside = [0, 1, 2].map(|axis| at[axis] + ring * (cos * e1[axis] + sin * e2[axis]));
            // A vessel beside is no background.
            if let Some(x) = scene.brightness(beside).filter(|_| !scene.is_inside(beside)) {
                sum += share(x);
                count += 1.0;
            }
        }
        values.push(c);
        rings.push(if count > 0.0 { c - sum / count } else { c });
        inside += usize::from(scene.is_inside(at));
    }
    let inside = inside as f64 / values.len() as f64;
    Some((values, rings, inside))
}
