//! The features of a candidate: its gap, its bends, its radii, the fragments it joins, and its rivals.
//!
//! d is the gap, D = 2 r + h the child's width, h the spacing.

use super::extraction::Extraction;
use super::fragment::Fragment;
use super::measured_candidate::{MeasuredCandidate, angle};
use willis_core::support::geometry::{Point, distance, dot, lerp};

/// A feature of a candidate.
pub type Feature = fn(&MeasuredCandidate) -> f64;

/// The features of a candidate, by the names that weights have in a file.
pub const FEATURES: &[(&str, Feature)] = &[
    // Whether the parent is met at a free end (1) or between its ends (0): most gaps are breaks, not lost branches.
    ("is_end", |c| 1.0 - c.between_ends()),
    ("gap", gap),
    ("bend_child_sq", bend_child_squared),
    ("bend_child", bend_child),
    // [`gap`] where the parent is met at a free end, else 0: breaks and lost branches have gaps of their own lengths.
    ("gap_end", |c| (1.0 - c.between_ends()) * gap(c)),
    ("bend_parent_sq", bend_parent_squared),
    // The gap to the wall in widths where the parent is met between its ends, else 0: a branch begins at the wall of its parent.
    ("wall_branch", |c| c.between_ends() * wall(c)),
    // [`gap`] where the parent is met between its ends, else 0.
    ("gap_branch", |c| c.between_ends() * gap(c)),
    ("kink", kink_towards),
    ("ratio_branch", branch_ratio),
    // The angle between the candidate and the child's direction over twice the length.
    ("bend_far", |c| angle(c.child.far_direction, c.across)),
    // [`radius_step`] squared, the step at most 1.5: small steps are noise.
    ("ratio_end_sq", |c| radius_step(c).min(MOST_STEP).powi(2)),
    ("wall", log_gap_to_wall),
    // ln D/h where the parent is met between its ends, else 0: branches of well resolved vessels are lost less.
    ("resolution_branch", |c| c.between_ends() * (c.width() / c.extraction.spacing).ln()),
    // [`branch_ratio`] squared: nor is it ever so thin.
    ("ratio_branch_sq", |c| branch_ratio(c).powi(2)),
    // The larger of the bends at the two ends: one bend is likelier than two.
    ("turn", |c| bend_child(c).max(bend_parent(c))),
    // [`bend_child`] times the gap in widths, at most 3: over a short gap an angle says little.
    ("bend_gap", |c| bend_child(c) * gap(c).min(BEND_MOST_WIDTHS)),
    // ln of the gap over the gap to the best other branch, in [-2, 2]: below 0 the parent is the clear choice.
    ("margin", |c| (c.gap / c.rival_gap).ln().clamp(-MOST_MARGIN, MOST_MARGIN)),
    ("blocked", blocked),
    ("bend_parent", bend_parent),
    ("ratio_end", radius_step),
    // How many branches are nearer to the child, at most 8.
    ("rank", |c| (c.rank as f64).min(MOST_RANK)),
    // ln(L/L_max + 0.01) of the parent's fragment: L_max the length of the longest fragment. Most fragments are attached to large ones.
    ("share_parent", |c| share(c.extraction, parent(c))),
    // How much better blood divides at the junctions of the child's fragment if it comes from this end, in [-1.5, 1.5].
    ("orientation", |c| c.child.orientation),
    // Whether the parent's fragment holds an inlet, 1 or 0.
    ("fed_parent", |c| if parent(c).fed { 1.0 } else { 0.0 }),
    // exp(-l/(2 r_p + h)) where the parent is met between its ends, else 0: l the path to its nearest free end. A vessel about to end is
    // met at its end.
    ("near_tip", |c| c.between_ends() * (-c.extraction.to_free_end[c.point] / parent_width(c)).exp()),
    // Whether the gap to the wall of a parent met between its ends is below 0.6 widths, 1 or 0: no more than what thinning takes away.
    ("touch_branch", |c| if wall(c) < TOUCH { c.between_ends() } else { 0.0 }),
    // Whether the shortest candidate of the parent's free end leads to the child, 1 or 0.
    ("mutual", |c| if c.mutual { 1.0 } else { 0.0 }),
    // How many widths the gap to the wall is beyond 3, at least 0.
    ("wall_over_3", |c| (wall(c) - FAR_REACH).max(0.0)),
    // How many widths the gap to the wall is beyond 1.5, at least 0: what falls with distance falls otherwise near and far.
    ("wall_over_1_5", |c| (wall(c) - REACH).max(0.0)),
    // -κ·u with the kink over 4 radii: the bend of the parent as a whole, which says less for a branch than a short kink in it.
    ("kink_wide", |c| -c.between_ends() * along(c, c.extraction.shape[c.point].far_kink)),
    ("kink_excess", kink_excess),
    // exp(-l/(2 r_p + h)) where the parent is met between its ends, else 0: l the path to its nearest junction. Junctions are rarely close to one another.
    ("near_junction", |c| c.between_ends() * (-c.extraction.to_junction[c.point] / parent_width(c)).exp()),
];

/// A gap in widths beyond which it is just long.
const MOST_WIDTHS: f64 = 10.0;
/// The least distance to a wall in [`log_gap_to_wall`], in spacings.
const LEAST_WALL: f64 = 0.5;
/// A child so many widths from the wall touches it ...
const TOUCH: f64 = 0.6;
/// ... and beyond so many it is out of its reach, and far out of it.
const REACH: f64 = 1.5;
const FAR_REACH: f64 = 3.0;

/// min(d/D, 10). Gestalt proximity: a gap is as long as the vessels are wide.
pub fn gap(c: &MeasuredCandidate) -> f64 {
    (c.gap / c.width()).min(MOST_WIDTHS)
}

/// ln max(d - r, h/2)/D with r the parent's radius where it is met between its ends: the gap to its wall, not to its axis.
pub fn log_gap_to_wall(c: &MeasuredCandidate) -> f64 {
    let wall = c.gap - c.between_ends() * c.parent_radius;
    (wall.max(LEAST_WALL * c.extraction.spacing) / c.width()).ln()
}

/// ln of path along the vessels over gap, at most 200, of a candidate within a fragment; 0 between fragments.
pub fn log_detour(c: &MeasuredCandidate) -> f64 {
    c.detour.map_or(0.0, f64::ln)
}

/// max(d - r, 0)/D, at most 10: r the parent's radius where it is met between its ends, else 0.
fn wall(c: &MeasuredCandidate) -> f64 {
    ((c.gap - c.between_ends() * c.parent_radius).max(0.0) / c.width()).min(MOST_WIDTHS)
}

/// Gaps in widths beyond which a bend over them counts no more.
const BEND_MOST_WIDTHS: f64 = 3.0;
/// The kink around a point is measured so many points from it.
const AROUND: usize = 4;

/// The angle between the child's direction and the candidate. Good continuation: the strongest feature.
pub fn bend_child(c: &MeasuredCandidate) -> f64 {
    angle(c.child.direction, c.across)
}

/// [`bend_child`] squared: with it a Gaussian in the angle.
pub fn bend_child_squared(c: &MeasuredCandidate) -> f64 {
    bend_child(c).powi(2)
}

/// The angle between the candidate and the inward direction of the parent's free end; 0 where it is met between its ends.
pub fn bend_parent(c: &MeasuredCandidate) -> f64 {
    c.parent_end.map_or(0.0, |end| angle(end.direction.map(|x| -x), c.across))
}

/// [`bend_parent`] squared.
pub fn bend_parent_squared(c: &MeasuredCandidate) -> f64 {
    bend_parent(c).powi(2)
}

/// κ·u: the kink of the parent towards the candidate, in [-1, 1]; 0 at a free end. A vessel turns away from a branch it gives
/// off, so a bend with its outside towards the child marks a lost branch: one of the best features.
pub fn kink_towards(c: &MeasuredCandidate) -> f64 {
    kink_at(c, c.point).clamp(-1.0, 1.0) * c.between_ends()
}

/// [`kink_towards`] less the mean of the same four points away on either side: this distinguishes a kink from a long bend.
pub fn kink_excess(c: &MeasuredCandidate) -> f64 {
    let headings = c.extraction.graph.headings(&c.extraction.lines, c.point);
    let around = headings.iter().map(|heading| kink_at(c, heading.walk(AROUND))).sum::<f64>();
    c.between_ends() * (kink_towards(c) - around / headings.len().max(1) as f64)
}

fn kink_at(c: &MeasuredCandidate, point: usize) -> f64 {
    along(c, c.extraction.shape[point].kink)
}

fn along(c: &MeasuredCandidate, vector: Point) -> f64 {
    dot(vector, c.across)
}

/// Bound of the step between two free ends before it is squared, in ln.
const MOST_STEP: f64 = 1.5;
/// Bounds of ln r_c/r_p where the parent is met between its ends.
const RATIOS: [f64; 2] = [-2.0, 1.0];

/// |ln r_c/r_p| where two free ends meet, else 0: one vessel keeps its radius across a gap.
pub fn radius_step(c: &MeasuredCandidate) -> f64 {
    (1.0 - c.between_ends()) * log_ratio(c).abs()
}

/// ln r_c/r_p in [-2, 1] where the parent is met between its ends, else 0: a branch is no wider than its parent (Murray's law).
pub fn branch_ratio(c: &MeasuredCandidate) -> f64 {
    c.between_ends() * log_ratio(c).clamp(RATIOS[0], RATIOS[1])
}

/// ln of the thinner of the two radii over that of the widest free end of all: the connections of a circle are thick vessels.
pub fn relative_size(c: &MeasuredCandidate) -> f64 {
    (c.child.radius.min(c.parent_radius) / c.extraction.largest.end).ln()
}

/// ln r_c/r_p.
fn log_ratio(c: &MeasuredCandidate) -> f64 {
    (c.child.radius / c.parent_radius).ln()
}

/// Added to a share, so that the shortest fragment has a logarithm.
const LEAST_SHARE: f64 = 0.01;

fn parent<'a>(c: &MeasuredCandidate<'a>) -> &'a Fragment {
    &c.extraction.fragments[c.extraction.fragment[c.point]]
}

/// ln(1 + L/(2 r + h)) of a fragment: L its length, r its mean radius, h the spacing. Short fat fragments are noise.
pub fn slenderness(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.length / (2.0 * fragment.radius + extraction.spacing)).ln_1p()
}

/// ln(L/L_max + 0.01) of a fragment.
pub fn share(extraction: &Extraction, fragment: &Fragment) -> f64 {
    let longest = extraction.largest.length;
    let share = if longest > 0.0 { fragment.length / longest } else { 1.0 };
    (share + LEAST_SHARE).ln()
}

/// Ranks beyond this are all alike.
const MOST_RANK: f64 = 8.0;
/// Bound of the margin, in ln.
const MOST_MARGIN: f64 = 2.0;
/// What is nearer to the candidate than so many gaps blocks it.
const CLEARANCE: f64 = 0.35;
/// The places along the candidate where that is checked.
const STATIONS: [f64; 5] = [0.25, 0.375, 0.5, 0.625, 0.75];

/// How much a third branch blocks the candidate: the largest 1 - c/(0.35 d), at least 0, over five places along it where the
/// nearest point, at distance c, is of a third branch. Vessels do not run through each other.
pub fn blocked(c: &MeasuredCandidate) -> f64 {
    let e = c.extraction;
    let [own, parent] = [c.child.point, c.point].map(|p| e.branch[p]);
    let reach = CLEARANCE * c.gap;
    let ends: [Point; 2] = [c.child.point, c.point].map(|p| e.position[p]);
    let third = |hit: &usize| e.branch[*hit] != own && e.branch[*hit] != parent;
    let at = |share: &f64| {
        let station = lerp(ends[0], ends[1], *share);
        // What is beyond the candidate's ends is further than the ends.
        let nearest = e.index.nearest(station, reach.min(distance(station, ends[0])).min(distance(station, ends[1])));
        if nearest.points.iter().any(third) { (1.0 - nearest.distance / reach).max(0.0) } else { 0.0 }
    };
    STATIONS.iter().map(at).fold(0.0, f64::max)
}

fn parent_width(c: &MeasuredCandidate) -> f64 {
    2.0 * c.parent_radius + c.extraction.spacing
}
