//! Evidence: the dimensionless features that say how probable each candidate is before any flow.
//!
//! Every length is divided by a local diameter, the spacing of the points or another length of the same extraction, so that
//! one set of weights serves thin trees and wide circles, in any unit. A feature is a function of a [`MeasuredCandidate`] and a row of
//! [`FEATURES`]: that is all it takes to add or drop one. d is the gap, D = 2 r + h the child's width, h the spacing.

mod branch_graph;
mod extraction;
mod feedback;

pub use extraction::{Extraction, Fragment, FreeEnd, NetworkPoint, mean_log};
pub use feedback::{FEEDBACK_FEATURES, feedback_features};

use ndarray::Array2;

use super::search::{EndCandidate, rows_by_end};
use willis_core::support::geometry::{Point, cross, distance, dot, lerp, norm_squared, sub, unit};
use willis_core::support::ties::{compare, steady};

/// The features of candidates: a row a candidate, a column a feature of [`FEATURES`].
///
/// Rank, margin and mutual choice compare the candidates given, so these should be all of a search. [`feedback_features`] measures what the
/// posterior of these features says of the other candidates.
pub fn features(extraction: &Extraction, candidates: &[EndCandidate]) -> Array2<f64> {
    let measured = measured(extraction, candidates);
    Array2::from_shape_fn((measured.len(), FEATURES.len()), |(row, column)| FEATURES[column].1(&measured[row]))
}

/// A feature of a candidate.
pub type Feature = fn(&MeasuredCandidate) -> f64;

/// The features of a candidate, by the names that weights have in a file.
pub const FEATURES: &[(&str, Feature)] = &[
    // Whether the parent is met at a free end (1) or between its ends (0): most gaps are breaks, not lost branches.
    ("is_end", |c| 1.0 - c.between_ends()),
    ("gap", gap),
    // With it a Gaussian in the angle.
    ("bend_child_sq", |c| bend_child(c).powi(2)),
    ("bend_child", bend_child),
    // [`gap`] where the parent is met at a free end, else 0: breaks and lost branches have gaps of their own lengths.
    ("gap_end", |c| (1.0 - c.between_ends()) * gap(c)),
    ("bend_parent_sq", |c| bend_parent(c).powi(2)),
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
    ("near_tip", |c| c.between_ends() * (-c.extraction.to_free_end[c.point] / c.parent_width()).exp()),
    // Whether the gap to the wall of a parent met between its ends is below 0.6 widths, 1 or 0: no more than what thinning takes away.
    ("touch_branch", |c| if wall(c) < TOUCH { c.between_ends() } else { 0.0 }),
    // Whether the shortest candidate of the parent's free end leads to the child, 1 or 0.
    ("mutual", |c| if c.mutual { 1.0 } else { 0.0 }),
    // How many widths the gap to the wall is beyond 3, at least 0.
    ("wall_over_3", |c| (wall(c) - FAR_REACH).max(0.0)),
    // How many widths the gap to the wall is beyond 1.5, at least 0: what falls with distance falls otherwise near and far.
    ("wall_over_1_5", |c| (wall(c) - REACH).max(0.0)),
    // -κ·u with the kink over 4 radii: the bend of the parent as a whole, which says less for a branch than a short kink in it.
    ("kink_wide", |c| -c.between_ends() * dot(c.extraction.shape[c.point].far_kink, c.across)),
    ("kink_excess", kink_excess),
    // exp(-l/(2 r_p + h)) where the parent is met between its ends, else 0: l the path to its nearest junction. Junctions are rarely close to one another.
    ("near_junction", |c| c.between_ends() * (-c.extraction.to_junction[c.point] / c.parent_width()).exp()),
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

/// The angle between the candidate and the inward direction of the parent's free end; 0 where it is met between its ends.
pub fn bend_parent(c: &MeasuredCandidate) -> f64 {
    c.parent_end.map_or(0.0, |end| angle(end.direction.map(|x| -x), c.across))
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
    dot(c.extraction.shape[point].kink, c.across)
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
fn branch_ratio(c: &MeasuredCandidate) -> f64 {
    c.between_ends() * log_ratio(c).clamp(RATIOS[0], RATIOS[1])
}

/// ln of the thinner of the two radii over that of the widest free end of all: the connections of a circle are thick vessels.
pub fn relative_size(c: &MeasuredCandidate) -> f64 {
    (c.child.radius.min(c.parent_radius) / c.extraction.widest_end).ln()
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
    let longest = extraction.longest;
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

/// No gap is shorter than this, in spacings.
const LEAST_GAP: f64 = 1e-6;
/// A path saves at most so many gaps.
const MOST_DETOUR: f64 = 200.0;
/// A candidate without rival is taken to have one so many gaps away.
const LONE: f64 = 8.0;

/// A candidate between a free end, the *child*, and a point of the vessel it may be attached to, the *parent*.
pub struct MeasuredCandidate<'a> {
    /// The extraction that it belongs to.
    pub extraction: &'a Extraction,
    /// The free end.
    pub child: &'a FreeEnd,
    /// The parent's free end where it is met there; `None` where it is met between its ends.
    pub parent_end: Option<&'a FreeEnd>,
    /// The point of the parent.
    pub point: usize,
    /// Length of the gap, m, positive.
    pub gap: f64,
    /// Unit vector across the gap, from the child.
    pub across: Point,
    /// The parent's radius at the meeting point, m: that of its free end, else the smoothed one.
    pub parent_radius: f64,
    /// Branches nearer to the child.
    pub rank: usize,
    /// Gap of the best other branch from the child, m.
    pub rival_gap: f64,
    /// Whether the shortest candidate of the free end it reaches leads to the child.
    pub mutual: bool,
    /// Path along the vessels over the gap, at most 200, for a candidate within a fragment.
    pub detour: Option<f64>,
}

impl MeasuredCandidate<'_> {
    /// Width of the child as an extraction shows it, m: its diameter and a spacing.
    pub fn width(&self) -> f64 {
        2.0 * self.child.radius + self.extraction.spacing
    }

    /// The parent's width (m) as features see it.
    pub fn parent_width(&self) -> f64 {
        2.0 * self.parent_radius + self.extraction.spacing
    }

    /// 1 where the parent is met between its ends, 0 where it is met at a free end.
    pub fn between_ends(&self) -> f64 {
        if self.parent_end.is_some() { 0.0 } else { 1.0 }
    }
}

/// The angle between two vectors, rad; a zero vector is across everything.
pub fn angle(a: Point, b: Point) -> f64 {
    if a == [0.0; 3] || b == [0.0; 3] { std::f64::consts::FRAC_PI_2 } else { norm_squared(cross(a, b)).sqrt().atan2(dot(a, b)) }
}

/// The candidates of one search, measured, in their order.
pub fn measured<'a>(extraction: &'a Extraction, candidates: &[EndCandidate]) -> Vec<MeasuredCandidate<'a>> {
    let mut out: Vec<MeasuredCandidate<'a>> = candidates.iter().map(|c| without_rivals(extraction, *c)).collect();
    let mut of_end = rows_by_end(extraction, candidates);
    // Per free end the points that its shortest candidates reach.
    let mut first: Vec<Vec<usize>> = vec![Vec::new(); extraction.ends.len()];
    for (end, rows) in of_end.iter_mut().enumerate() {
        let order = |c: &MeasuredCandidate| {
            let bend = 2.0 - dot(c.child.direction, c.across);
            [c.gap / extraction.spacing, bend, extraction.smooth.radius[c.point] / extraction.spacing].map(steady)
        };
        rows.sort_by(|a, b| compare(&order(&out[*a]), &order(&out[*b])).then(a.cmp(b)));
        let mut near: Vec<(usize, f64)> = Vec::new();
        for row in rows.iter() {
            let (branch, gap) = (extraction.branch[out[*row].point], out[*row].gap);
            let rank = near.iter().position(|(b, _)| *b == branch).unwrap_or_else(|| {
                near.push((branch, gap));
                near.len() - 1
            });
            out[*row].rank = rank;
            if order(&out[*row])[0] == order(&out[rows[0]])[0] {
                first[end].push(out[*row].point);
            }
        }
        for row in rows.iter() {
            let other = if out[*row].rank > 0 { near.first() } else { near.get(1) };
            out[*row].rival_gap = other.map_or(LONE * out[*row].gap, |(_, gap)| *gap);
        }
    }
    for (measured, candidate) in out.iter_mut().zip(candidates) {
        let there = extraction.end_at[measured.point];
        measured.mutual = there.is_some_and(|end| first[end].contains(&extraction.ends[candidate.end].point));
    }
    // The detours of the candidates within a fragment.
    let mut paths = willis_core::network::paths::ShortestPaths::new(extraction.graph.nodes());
    let mut from = None;
    for (row, candidate) in candidates.iter().enumerate().filter(|(_, c)| c.within) {
        if from != Some(candidate.end) {
            let same = candidates.iter().zip(out.iter()).skip(row).take_while(|(c, _)| c.end == candidate.end);
            let longest = same.clone().map(|(_, measured)| measured.gap).fold(0.0, f64::max);
            let mut left: Vec<usize> = same.filter(|(c, _)| c.within).map(|(c, _)| c.point).collect();
            // What is visited later is further away, so that no path to a point gets shorter than it was reached.
            extraction.graph.search(&[out[row].child.point], MOST_DETOUR * longest, &mut paths, |lengths, node| {
                while left.last().is_some_and(|point| extraction.graph.to_point(lengths, *point) <= lengths[node]) {
                    left.pop();
                }
                !left.is_empty()
            });
            from = Some(candidate.end);
        }
        let path = extraction.graph.to_point(paths.lengths(), candidate.point);
        out[row].detour = Some((path / out[row].gap).min(MOST_DETOUR));
    }
    out
}

fn without_rivals(extraction: &Extraction, candidate: EndCandidate) -> MeasuredCandidate<'_> {
    let child = &extraction.ends[candidate.end];
    let parent_end = extraction.end_at[candidate.point].map(|end| &extraction.ends[end]);
    let (from, to) = (extraction.position[child.point], extraction.position[candidate.point]);
    MeasuredCandidate {
        extraction,
        child,
        parent_end,
        point: candidate.point,
        gap: distance(from, to).max(LEAST_GAP * extraction.spacing),
        across: unit(sub(to, from)),
        parent_radius: extraction.radius_at(candidate.point),
        rank: 0,
        rival_gap: 0.0,
        mutual: false,
        detour: None,
    }
}

/// A feature of a fragment.
pub type RootFeature = fn(&Extraction, &Fragment) -> f64;

/// The features of a root, by name. Their products with the clutter let a whole brain of a hundred fragments and a circle of
/// ten differ: in a circle an inlet's tree is often a root, in a brain it is one of several parts of one tree.
pub const ROOT_FEATURES: &[(&str, RootFeature)] = &[
    // 1: how readily a fragment is a root.
    ("one", |_, _| 1.0),
    ("inlet", inlet),
    ("slim", slenderness),
    ("share", share),
    ("width", relative_width),
    ("resolution", width_in_spacings),
    ("clutter", clutter),
    ("radius_variation", radius_variation),
    // ln of the number of its free ends, at least 0: what branches is a vessel, and has more ends to be attached by.
    ("free_ends", |_, fragment| (fragment.free_ends as f64).max(1.0).ln()),
    // ln of one more than the number of its junctions.
    ("junctions", |_, fragment| (fragment.junctions as f64).ln_1p()),
    ("inlet_clutter", |e, f| inlet(e, f) * clutter(e, f)),
    ("slim_clutter", |e, f| slenderness(e, f) * clutter(e, f)),
    ("share_clutter", |e, f| share(e, f) * clutter(e, f)),
    ("width_clutter", |e, f| relative_width(e, f) * clutter(e, f)),
];

/// ln of a middling number of fragments.
const USUAL_CLUTTER: f64 = 3.0;
/// Bound of the variation of the radius.
const MOST_VARIATION: f64 = 0.6;

/// The features of every fragment as a root: a row a fragment, a column a feature of [`ROOT_FEATURES`].
pub fn root_features(extraction: &Extraction) -> Array2<f64> {
    let fragments = &extraction.fragments;
    Array2::from_shape_fn((fragments.len(), ROOT_FEATURES.len()), |(row, column)| {
        ROOT_FEATURES[column].1(extraction, &fragments[row])
    })
}

/// Whether it holds an inlet, 1 or 0.
pub fn inlet(_: &Extraction, fragment: &Fragment) -> f64 {
    if fragment.fed { 1.0 } else { 0.0 }
}

/// ln of the radius of its widest free end over that of the widest fragment's.
pub fn relative_width(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.end_radius(extraction.spacing) / extraction.widest_end.max(0.5 * extraction.spacing)).ln()
}

/// ln of the radius of its widest free end in spacings.
pub fn width_in_spacings(extraction: &Extraction, fragment: &Fragment) -> f64 {
    (fragment.end_radius(extraction.spacing) / extraction.spacing).ln()
}

/// ln of the number of fragments, less 3: the more there are, the more are false.
pub fn clutter(extraction: &Extraction, _: &Fragment) -> f64 {
    (extraction.fragments.len() as f64).ln() - USUAL_CLUTTER
}

/// The standard deviation of ln of its radii along it, at most 0.6: vessels taper, noise has any radius.
pub fn radius_variation(_: &Extraction, fragment: &Fragment) -> f64 {
    fragment.radius_spread.min(MOST_VARIATION)
}
