//! The features of a pair of points by what the image shows between them: along the straight line and along the cheapest path.
//!
//! Contrast is brightness above the background, as a share of that of the vessels at the two ends. All are dimensionless.

use std::collections::BTreeMap;

use ndarray::Array2;

use super::ahead::{Ahead, MOST_COST, MOST_MET};
use super::path::{Between, CheapestPath, across, cheapest_path};
use crate::candidates::features::Extraction;
use crate::candidates::pairs::Pairs;
use willis_core::support::arc_lengths::{ArcWalk, arc_lengths, in_direction};
use willis_core::support::boosted_trees::stored;
use willis_core::support::geometry::{Point, distance, lerp, sub, unit};
use willis_core::support::in_order;
use willis_core::support::statistics::quantile;
use willis_io::masks::{Level, Scene};

/// What the image stage sees, by name in one text; `score` is that of the second pass.
const IMAGE_FEATURES: &str = "\
    score score_margin_near score_margin_far log_gap_spacings log_gap_widths noise typical_contrast dimmer_end step_of_ends \
    line_least line_quarter line_mean line_noise_mean line_ring_least line_ring_mean line_inside path_cost path_cost_least \
    path_least path_quarter path_mean path_noise_least path_noise_quarter path_noise_mean path_ring_least path_ring_quarter \
    path_ring_mean path_ring_noise path_tortuosity path_inside path_widest_dip met_rank met_cost met_margin cost_margin_near \
    cost_margin_far contrast_margin_near contrast_margin_far";

/// The names of what the image stage sees, in their order.
pub fn image_feature_names() -> Vec<&'static str> {
    IMAGE_FEATURES.split(' ').collect()
}

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

/// What the image shows between the points of pairs, before any score.
pub struct ImageTable {
    /// What each pair shows; `None` where the image ends.
    seen: Vec<Option<PairSeen>>,
    /// The first of the pairs that were found in the image.
    first_met: usize,
}

/// The features of a pair but those of scores and rivals, and the cheapest path, or the way to the vessel met.
type PairSeen = ([f64; BETWEEN], CheapestPath);

/// The features that need no score and no rival; two of them are compared with those of rivals.
const BETWEEN: usize = 31;
const PATH_COST: usize = 13;
const PATH_MEAN: usize = 17;

impl ImageTable {
    /// Measures pairs of points in an image: those that `scores` of the second pass leave possible, without scores all; and the last of them,
    /// which were found in the image by the ways given.
    pub fn new(scene: &Scene, e: &Extraction, pairs: &Pairs, ahead: &Ahead, ways: &[&[Point]], scores: Option<&[f64]>) -> Self {
        let first_met = pairs.points.len() - ways.len();
        let seen = in_order(&pairs.points, |pair, points| {
            let way = pair.checked_sub(first_met).map(|met| ways[met]);
            let is_possible = way.is_some() || scores.is_none_or(|scores| scores[pair] >= LEAST_SCORE);
            is_possible.then(|| see(scene, e, *points, ahead, way)).flatten()
        });
        Self { seen, first_met }
    }

    /// Whether the image decides about a pair with this score: it shows what lies between its points, and the pair is possible or was
    /// found in the image.
    pub fn is_seen(&self, pair: usize, score: f64) -> bool {
        self.seen[pair].is_some() && (score >= LEAST_SCORE || pair >= self.first_met)
    }

    /// The cheapest path of a pair from one of its points (m); `None` where nothing is seen.
    pub fn course(&self, pair: usize, from: usize, pairs: &Pairs) -> Option<Vec<Point>> {
        let (_, path) = self.seen[pair].as_ref()?;
        Some(in_direction(path.points.clone(), pairs.points[pair][0] == from))
    }

    /// A row a pair, a column one of [`image_feature_names`], given the scores of the second pass; zeros where nothing is seen.
    pub fn features(&self, e: &Extraction, pairs: &Pairs, scores: &[f64]) -> Array2<f32> {
        let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        let is_rival = |pair: usize| scores[pair] >= LEAST_SCORE || pair >= self.first_met;
        for (pair, points) in pairs.points.iter().enumerate().filter(|(pair, _)| is_rival(*pair)) {
            for point in points {
                at.entry(*point).or_default().push(pair);
            }
        }
        // What the best rival at a place leaves: free ends have rivals, other places take any number.
        let margin = |pair: usize, point: usize, of: &dyn Fn(usize) -> Option<f64>| {
            let own = of(pair).unwrap_or(0.0);
            let rivals = at.get(&point).into_iter().flatten().filter(|other| **other != pair && e.end_at[point].is_some());
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
            let values = [scores[pair]].into_iter().chain(score).chain(*seen).chain(cost).chain(contrast);
            for (column, x) in values.enumerate() {
                out[[pair, column]] = stored(x);
            }
        }
        out
    }
}

/// What the image shows along a line.
struct Along {
    /// Contrast at places.
    contrast: Vec<f64>,
    /// Less that of the ring around.
    ring: Vec<f64>,
    /// The share of places inside vessels.
    inside: f64,
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
    let level = Level { background, noise };
    let ring = radius[0].min(radius[1]) + RING * h;
    let between = Between { ends, own: radius.map(|r| r + h), background, contrast, spacing: h };
    let line = along(scene, &ends, radius, level, contrast, ring, h)?;
    let [a, b] = points;
    let found = || [[a, b], [b, a]].into_iter().filter_map(|pair| ahead.of(e, pair));
    let path = match way {
        None => cheapest_path(scene, &between)?,
        Some(way) => CheapestPath {
            points: in_direction(way.to_vec(), way.first() == Some(&ends[0])),
            cost: found().map(|(_, cost, _)| cost).fold(MOST_COST, f64::min),
        },
    };
    let course = along(scene, &path.points, radius, level, contrast, ring, h)?;
    let length: f64 = path.points.windows(2).map(|w| distance(w[0], w[1])).sum();
    let cost = (path.cost / (gap / h).max(1.0)).ln();
    let least = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len() as f64;
    let quarter = |x: &[f64]| quantile(x, 0.25).unwrap_or(0.0);
    let steady_noise = noise.max(1e-3);
    let dips = course.contrast.chunk_by(|a, b| (*a < DIP) == (*b < DIP)).filter(|run| run[0] < DIP);
    let widest_dip = dips.map(<[f64]>::len).max().unwrap_or(0) as f64 * STEP;
    // How the pair compares with the vessels met from its free ends: rank and ln of the cost, the least of both, and ln of that cost over the
    // least of the other vessels.
    let best = found().min_by(|x, y| x.1.total_cmp(&y.1).then(x.0.cmp(&y.0)));
    let ln = |cost: f64| (cost + LEAST_COST).ln();
    let [rank, met_cost, margin] = best.map_or([MOST_MET as f64, ln(2.0 * MOST_COST), MOST_MARGIN], |(rank, cost, other)| {
        [rank as f64, ln(cost), ln(cost) - ln(other.unwrap_or(MOST_COST))]
    });
    let values = [
        (gap / h + 0.1).ln(),
        (gap / (radius[0] + radius[1])).ln(),
        noise,
        (scene.typical / contrast).ln(),
        (dimmer / scene.typical).max(0.01).ln(),
        (own[0].max(1e-3 * scene.typical) / own[1].max(1e-3 * scene.typical)).ln().abs(),
        least(&line.contrast),
        quarter(&line.contrast),
        mean(&line.contrast),
        mean(&line.contrast) / steady_noise,
        least(&line.ring),
        mean(&line.ring),
        line.inside,
        cost,
        path.cost.max(1e-3).ln(),
        least(&course.contrast),
        quarter(&course.contrast),
        mean(&course.contrast),
        least(&course.contrast) / steady_noise,
        quarter(&course.contrast) / steady_noise,
        mean(&course.contrast) / steady_noise,
        least(&course.ring),
        quarter(&course.ring),
        mean(&course.ring),
        mean(&course.ring) / steady_noise,
        (length / gap.max(h)).ln(),
        course.inside,
        widest_dip,
        rank,
        met_cost,
        margin,
    ];
    Some((values, path))
}

/// What the image shows along a line between two ends; `None` where it is not known.
fn along(scene: &Scene, line: &[Point], radius: [f64; 2], level: Level, contrast: f64, ring: f64, h: f64) -> Option<Along> {
    let arc = arc_lengths(line.iter().copied());
    let length = arc[arc.len() - 1];
    let [from, upto] = [radius[0].min(TRIM * length), length - radius[1].min(TRIM * length)];
    let steps = ((upto - from) / (STEP * h)).ceil().max(2.0) as usize;
    let share = |x: f64| (x - level.background) / contrast;
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
    Some(Along { contrast: values, ring: rings, inside })
}
