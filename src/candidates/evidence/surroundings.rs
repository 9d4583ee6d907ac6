//! Features of the surroundings: rivals, what lies between, and where on the parent the bridge arrives.

use super::span::Span;
use crate::geometry::{Point, distance, lerp};

/// Ranks beyond this are all alike.
const MOST_RANK: f64 = 8.0;
/// Bound of the margin, in ln.
const MOST_MARGIN: f64 = 2.0;
/// What is so near to the bridge, in gaps, stands in its way.
const CLEARANCE: f64 = 0.35;
/// Where on the bridge that is asked.
const STATIONS: [f64; 5] = [0.25, 0.375, 0.5, 0.625, 0.75];

/// How many branches are nearer to the child, at most 8.
pub fn rank(s: &Span) -> f64 {
    (s.rank as f64).min(MOST_RANK)
}

/// ln of the gap over the gap to the best other branch, in [-2, 2]: below 0 the parent is the clear choice.
pub fn margin(s: &Span) -> f64 {
    (s.gap / s.rival_gap).ln().clamp(-MOST_MARGIN, MOST_MARGIN)
}

/// Whether the parent's free end has its own shortest bridge to the child, 1 or 0.
pub fn mutual(s: &Span) -> f64 {
    if s.mutual { 1.0 } else { 0.0 }
}

/// How far a third branch stands in the way: the largest 1 - c/(0.35 d), at least 0, over five stations of the bridge where the
/// nearest point, at distance c, is of a third branch. Vessels do not run through each other.
pub fn blocked(s: &Span) -> f64 {
    let e = s.extraction;
    let [own, parent] = [s.child.point, s.point].map(|p| e.branch[p]);
    let reach = CLEARANCE * s.gap;
    let way: [Point; 2] = [s.child.point, s.point].map(|p| e.position[p]);
    let third = |hit: &usize| e.branch[*hit] != own && e.branch[*hit] != parent;
    let at = |share: &f64| {
        let station = lerp(way[0], way[1], *share);
        // The ends of the bridge are nearer than what is beyond them.
        let nearest = e.index.nearest(station, reach.min(distance(station, way[0])).min(distance(station, way[1])));
        if nearest.points.iter().any(third) { (1.0 - nearest.distance / reach).max(0.0) } else { 0.0 }
    };
    STATIONS.iter().map(at).fold(0.0, f64::max)
}

/// exp(-l/(2 r_p + h)) where the parent is met on its way, else 0: l the path to its nearest free end. A vessel about to end is
/// met at its end.
pub fn near_free_end(s: &Span) -> f64 {
    s.on_the_way() * (-s.extraction.to_free_end[s.point] / parent_width(s)).exp()
}

/// exp(-l/(2 r_p + h)) where the parent is met on its way, else 0: l the path to its nearest junction. Junctions keep apart.
pub fn near_junction(s: &Span) -> f64 {
    s.on_the_way() * (-s.extraction.to_junction[s.point] / parent_width(s)).exp()
}

fn parent_width(s: &Span) -> f64 {
    2.0 * s.parent_radius + s.extraction.spacing
}
