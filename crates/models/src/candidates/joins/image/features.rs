//! What the image shows between two points, along the straight line and along the cheapest path, and the names of these features.
//!
//! Contrast is brightness above the background, as a share of that of the vessels at the two ends. All features are dimensionless.

use super::ways::{Ahead, CheapestPath, MOST_COST, MOST_MET, across, cheapest_path};
use crate::candidates::features::Extraction;
use willis_core::support::arc_lengths::{arc_lengths, in_direction, place_at};
use willis_core::support::geometry::{Point, distance, lerp, sub, unit};
use willis_io::masks::Scene;

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
/// Added to the cost of the way to a vessel met, before its logarithm.
const LEAST_COST: f64 = 0.01;
/// Bounds of a margin, and its value where there is no rival.
pub(super) const MOST_MARGIN: f64 = 8.0;

/// The features of a pair but those of scores and rivals, and the cheapest path, or the way to the vessel met.
pub(super) type PairSeen = (Vec<f64>, CheapestPath);

/// Two of the features that need no score and no rival, which are compared with those of rivals.
pub(super) const PATH_COST: usize = 13;
pub(super) const PATH_MEAN: usize = 17;

/// What a pair shows, along the straight line and along the cheapest path, or along the way by which it was found.
pub(super) fn see(scene: &Scene, e: &Extraction, points: [usize; 2], ahead: &Ahead, way: Option<&[Point]>) -> Option<PairSeen> {
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
    for n in 0..=steps {
        let s = from + (upto - from) * n as f64 / steps as f64;
        let (segment, on) = place_at(&arc, s);
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
