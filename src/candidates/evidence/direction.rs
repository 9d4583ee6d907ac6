//! Features of direction: how much the vessels have to bend. Angles in rad.

use super::frame::NOISE;
use super::span::{Span, angle};
use crate::geometry::dot;

/// Bends beyond so many standard errors are all alike.
const MOST_ERRORS: f64 = 8.0;
/// Vessels bend by so much between extractions' ends anyway, rad.
const NATURAL_BEND: f64 = 0.2;

/// The angle between the child's direction and the bridge. Good continuation: the strongest feature (inference.md §5).
pub fn bend_child(s: &Span) -> f64 {
    angle(s.child.direction, s.across)
}

/// [`bend_child`] over its standard error, at most 8: that of the fit, of the gap's ends, and 0.2 rad.
pub fn bend_child_in_errors(s: &Span) -> f64 {
    in_errors(s, bend_child(s), s.child.direction_error)
}

/// The angle between the bridge and the child's direction over twice the length.
pub fn bend_far(s: &Span) -> f64 {
    angle(s.child.far_direction, s.across)
}

/// The angle between the bridge and the inward direction of the parent's free end; 0 where it is met on its way.
pub fn bend_parent(s: &Span) -> f64 {
    s.parent_end.map_or(0.0, |end| angle(end.direction.map(|x| -x), s.across))
}

/// [`bend_parent`] over its standard error, at most 8.
pub fn bend_parent_in_errors(s: &Span) -> f64 {
    s.parent_end.map_or(0.0, |end| in_errors(s, bend_parent(s), end.direction_error))
}

/// The angle between the child's direction and the inward direction of the parent's free end; 0 where it is met on its way.
pub fn turn(s: &Span) -> f64 {
    s.parent_end.map_or(0.0, |end| angle(s.child.direction, end.direction.map(|x| -x)))
}

/// The sine of the angle at which the parent is met on its way; 0 at a free end. Branches leave across, not along.
pub fn sine_at_parent(s: &Span) -> f64 {
    let along = along_parent(s);
    s.on_the_way() * (1.0 - along * along).max(0.0).sqrt()
}

/// κ·u: the kink of the parent towards the bridge, in [-2, 2]; 0 at a free end. A vessel turns away from a branch it gives
/// off, so a bend with its outside towards the child marks a lost branch: the best feature of inference.md §5.
pub fn kink_towards(s: &Span) -> f64 {
    s.on_the_way() * dot(s.extraction.course[s.point].kink, s.across).clamp(-1.0, 1.0)
}

/// -t·u along the parent's flow where that is known: 1 when the branch goes on with the flow, -1 against it; 0 at a free end.
pub fn with_the_flow(s: &Span) -> f64 {
    if s.extraction.course[s.point].flow_known { -s.on_the_way() * along_parent(s) } else { 0.0 }
}

fn along_parent(s: &Span) -> f64 {
    dot(s.extraction.course[s.point].tangent, s.across).clamp(-1.0, 1.0)
}

/// A bend over sqrt(σ² + 2(0.3 h/d)² + 0.2²): σ that of the direction, 0.3 h the scatter of a point, d the gap.
fn in_errors(s: &Span, bend: f64, direction_error: f64) -> f64 {
    let jitter = NOISE * s.extraction.spacing / s.gap;
    let error = (direction_error.powi(2) + 2.0 * jitter.powi(2) + NATURAL_BEND.powi(2)).sqrt();
    (bend / error).min(MOST_ERRORS)
}
