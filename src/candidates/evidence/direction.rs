//! Features of direction: how much the vessels have to bend. Angles in rad.

use super::gap::gap;
use super::span::{Span, angle};
use crate::geometry::{Point, dot};

/// Gaps in widths beyond which a bend over them counts no more.
const MOST_WIDTHS: f64 = 3.0;
/// The kink around a point is measured so many points from it.
const AROUND: usize = 4;

/// The angle between the child's direction and the bridge. Good continuation: the strongest feature (inference.md §5).
pub fn bend_child(s: &Span) -> f64 {
    angle(s.child.direction, s.across)
}

/// [`bend_child`] squared: with it a Gaussian in the angle.
pub fn bend_child_squared(s: &Span) -> f64 {
    bend_child(s).powi(2)
}

/// [`bend_child`] times the gap in widths, at most 3: over a short gap an angle says little.
pub fn bend_child_over_gap(s: &Span) -> f64 {
    bend_child(s) * gap(s).min(MOST_WIDTHS)
}

/// The angle between the bridge and the child's direction over twice the length.
pub fn bend_far(s: &Span) -> f64 {
    angle(s.child.far_direction, s.across)
}

/// The angle between the bridge and the inward direction of the parent's free end; 0 where it is met on its way.
pub fn bend_parent(s: &Span) -> f64 {
    s.parent_end.map_or(0.0, |end| angle(end.direction.map(|x| -x), s.across))
}

/// [`bend_parent`] squared.
pub fn bend_parent_squared(s: &Span) -> f64 {
    bend_parent(s).powi(2)
}

/// The larger of the bends at the two ends: one bend is likelier than two.
pub fn worst_bend(s: &Span) -> f64 {
    bend_child(s).max(bend_parent(s))
}

/// κ·u: the kink of the parent towards the bridge, in [-1, 1]; 0 at a free end. A vessel turns away from a branch it gives
/// off, so a bend with its outside towards the child marks a lost branch: the best feature of inference.md §5.
pub fn kink_towards(s: &Span) -> f64 {
    kink_at(s, s.point).clamp(-1.0, 1.0) * s.on_the_way()
}

/// -κ·u with the kink over 4 radii: the bend of the parent as a whole, which says less for a branch than a short kink in it.
pub fn far_kink_from(s: &Span) -> f64 {
    -s.on_the_way() * along(s, s.extraction.course[s.point].far_kink)
}

/// [`kink_towards`] less the mean of the same four points away on either side: a kink stands out, a bend goes on.
pub fn kink_excess(s: &Span) -> f64 {
    let ways = s.extraction.ways(s.point);
    let around = ways.iter().map(|way| kink_at(s, s.extraction.along(*way, AROUND))).sum::<f64>();
    s.on_the_way() * (kink_towards(s) - around / ways.len().max(1) as f64)
}

/// How much better blood divides at the junctions of the child's fragment if it comes from this end, in [-1.5, 1.5].
pub fn orientation(s: &Span) -> f64 {
    s.child.orientation
}

fn kink_at(s: &Span, point: usize) -> f64 {
    along(s, s.extraction.course[point].kink)
}

fn along(s: &Span, vector: Point) -> f64 {
    dot(vector, s.across)
}
