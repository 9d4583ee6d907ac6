//! Features of the gap: how far, in widths of the child, and how far it is to the parent's wall.
//!
//! d is the gap, D = 2 r + h the child's width, h the spacing.

use super::candidate::{Span, angle};
use super::extraction::Extraction;
use super::fragment::Fragment;
use crate::support::geometry::{Point, distance, dot, lerp};

/// A gap in widths beyond which it is just long.
const MOST_WIDTHS: f64 = 10.0;
/// The least distance to a wall in [`log_gap_to_wall`], in spacings.
const LEAST_WALL: f64 = 0.5;
/// A child so many widths from the wall touches it ...
const TOUCH: f64 = 0.6;
/// ... and beyond so many it is out of its reach, and far out of it.
const REACH: f64 = 1.5;
const FAR_REACH: f64 = 3.0;

/// min(d/D, 10). Gestalt proximity: a gap is as long as the vessels are wide (inference.md §5).
pub fn gap(s: &Span) -> f64 {
    (s.gap / s.width()).min(MOST_WIDTHS)
}

/// [`gap`] where the parent is met at a free end, else 0: breaks and lost branches have gaps of their own lengths.
pub fn gap_at_free_end(s: &Span) -> f64 {
    (1.0 - s.on_the_way()) * gap(s)
}

/// [`gap`] where the parent is met on its way, else 0.
pub fn gap_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * gap(s)
}

/// ln max(d - r, h/2)/D with r the parent's radius where it is met on its way: the gap to its wall, not to its axis.
pub fn log_gap_to_wall(s: &Span) -> f64 {
    let wall = s.gap - s.on_the_way() * s.parent_radius;
    (wall.max(LEAST_WALL * s.extraction.spacing) / s.width()).ln()
}

/// The gap to the wall in widths where the parent is met on its way, else 0: a branch begins at the wall of its parent.
pub fn wall_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * wall(s)
}

/// How many widths the gap to the wall is beyond 1.5, at least 0: what falls with distance falls otherwise near and far.
pub fn wall_beyond_reach(s: &Span) -> f64 {
    (wall(s) - REACH).max(0.0)
}

/// How many widths the gap to the wall is beyond 3, at least 0.
pub fn wall_far_beyond_reach(s: &Span) -> f64 {
    (wall(s) - FAR_REACH).max(0.0)
}

/// Whether the gap to the wall of a parent met on its way is below 0.6 widths, 1 or 0: no more than what thinning takes away.
pub fn touches_wall(s: &Span) -> f64 {
    if wall(s) < TOUCH { s.on_the_way() } else { 0.0 }
}

/// ln D/h where the parent is met on its way, else 0: branches of well resolved vessels are lost less.
pub fn log_width_on_the_way(s: &Span) -> f64 {
    s.on_the_way() * (s.width() / s.extraction.spacing).ln()
}

/// ln of path along the vessels over gap, at most 200, of a bridge within a fragment; 0 between fragments.
pub fn log_detour(s: &Span) -> f64 {
    s.detour.map_or(0.0, f64::ln)
}

/// max(d - r, 0)/D, at most 10: r the parent's radius where it is met on its way, else 0.
fn wall(s: &Span) -> f64 {
    ((s.gap - s.on_the_way() * s.parent_radius).max(0.0) / s.width()).min(MOST_WIDTHS)
}

/// Gaps in widths beyond which a bend over them counts no more.
const BEND_MOST_WIDTHS: f64 = 3.0;
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
    bend_child(s) * gap(s).min(BEND_MOST_WIDTHS)
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

/// Bound of the step between two free ends before it is squared, in ln.
const MOST_STEP: f64 = 1.5;
/// Bounds of ln r_c/r_p where the parent is met on its way.
const RATIOS: [f64; 2] = [-2.0, 1.0];

/// |ln r_c/r_p| where two free ends meet, else 0: one vessel keeps its radius across a gap.
pub fn radius_step(s: &Span) -> f64 {
    (1.0 - s.on_the_way()) * log_ratio(s).abs()
}

/// [`radius_step`] squared, the step at most 1.5: small steps are noise.
pub fn radius_step_squared(s: &Span) -> f64 {
    radius_step(s).min(MOST_STEP).powi(2)
}

/// ln r_c/r_p in [-2, 1] where the parent is met on its way, else 0: a branch is no wider than its parent (Murray's law).
pub fn branch_ratio(s: &Span) -> f64 {
    s.on_the_way() * log_ratio(s).clamp(RATIOS[0], RATIOS[1])
}

/// [`branch_ratio`] squared: nor is it ever so thin.
pub fn branch_ratio_squared(s: &Span) -> f64 {
    branch_ratio(s).powi(2)
}

/// ln of the thinner of the two radii over that of the widest free end of all: bridges of a circle are thick vessels.
pub fn relative_size(s: &Span) -> f64 {
    let widest = s.extraction.ends.iter().map(|end| end.radius).fold(0.0, f64::max);
    (s.child.radius.min(s.parent_radius) / widest).ln()
}

/// ln r_c/r_p.
fn log_ratio(s: &Span) -> f64 {
    (s.child.radius / s.parent_radius).ln()
}

/// Added to a share, so that the shortest fragment has a logarithm.
const LEAST_SHARE: f64 = 0.01;

/// Whether the parent is met at a free end (1) or on its way (0): most gaps are breaks, not lost branches.
pub fn at_free_end(s: &Span) -> f64 {
    1.0 - s.on_the_way()
}

/// ln(L/L_max + 0.01) of the parent's fragment: L_max the length of the longest fragment. Fragments hang on large ones.
pub fn parent_share(s: &Span) -> f64 {
    share(s.extraction, parent(s))
}

/// Whether the parent's fragment holds an inlet, 1 or 0.
pub fn parent_fed(s: &Span) -> f64 {
    if parent(s).fed { 1.0 } else { 0.0 }
}

fn parent<'a>(s: &Span<'a>) -> &'a Fragment {
    &s.extraction.fragments[s.extraction.fragment[s.point]]
}

/// ln(1 + L/(2 r + h)) of a fragment: L its length, r its mean radius, h the spacing. Short fat fragments are noise.
pub fn slenderness(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.length / (2.0 * fragment.radius + extraction.spacing)).ln_1p()
}

/// ln(L/L_max + 0.01) of a fragment.
pub fn share(extraction: &Extraction, fragment: &Fragment) -> f64 {
    let longest = extraction.fragments.iter().map(|f| f.length).fold(0.0, f64::max);
    let share = if longest > 0.0 { fragment.length / longest } else { 1.0 };
    (share + LEAST_SHARE).ln()
}

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
