//! The features of a candidate on an automatic skeleton: those of a tracing, and more of the course of a vessel from a free end inwards, rivals and
//! surroundings. Rivals, which want the same places, are compared by cost before any model, by probability after the first pass.
//!
//! d is the gap, h the spacing, r the radius of a free end. All are dimensionless.

use std::collections::{BTreeMap, BTreeSet};

use ndarray::Array2;

use crate::candidates::features::{
    Extraction, FEATURES, Feature, Fragment, MeasuredCandidate, angle, log_detour, mean_log, measured, slenderness,
};
use crate::candidates::search::{EndCandidate, Pairs, PointIndex, rows_by_end, unordered};
use willis_core::support::arc_lengths::{arc_lengths, in_direction};
use willis_core::support::geometry::{Point, centroid, distance, dot, norm_squared, straightest, sub, unit};
use willis_core::support::in_order;
use willis_core::support::normal_equations::{normal_equations, solve};
use willis_core::support::statistics::{median, sigmoid};
use willis_core::support::ties::{near_zero, steady};

/// Features of tracings that say nothing of a skeleton, or depend on what a user clicked.
const LEFT_OUT: [&str; 2] = ["fed_parent", "share_parent"];

/// A candidate on a skeleton.
struct Join<'a> {
    measured: &'a MeasuredCandidate<'a>,
    /// The course of the child.
    child: &'a EndCourse,
    /// The course of the parent's free end, where it is met there.
    parent: Option<&'a EndCourse>,
}

/// A feature of a candidate on a skeleton.
type JoinFeature = fn(&Join) -> f64;

/// The features that only skeletons have, by name; those of [`rivals`] and of [`surroundings`] follow.
const MORE_FEATURES: &[(&str, JoinFeature)] = &[
    ("log_gap", |j| (j.measured.gap / j.measured.width()).ln()),
    ("gap_spacings", |j| (j.measured.gap / h(j)).ln()),
    ("bend_3", |j| bend(j, 0)),
    ("bend_6", |j| bend(j, 1)),
    ("bend_12", |j| bend(j, 2)),
    ("bend_24", |j| bend(j, 3)),
    ("parent_bend_3", |j| parent_bend(j, 0)),
    ("parent_bend_6", |j| parent_bend(j, 1)),
    ("parent_bend_12", |j| parent_bend(j, 2)),
    ("parent_bend_24", |j| parent_bend(j, 3)),
    ("least_bend", least_bend),
    ("least_parent_bend", least_parent_bend),
    ("least_bends", |j| least_bend(j) + least_parent_bend(j)),
    ("tip_bend", |j| angle(j.child.tip_direction, j.measured.across)),
    ("parent_tip_bend", |j| j.parent.map_or(0.0, |p| angle(p.tip_direction, reversed(j.measured.across)))),
    ("miss", |j| miss(j, j.child, j.measured.across)),
    ("parent_miss", |j| j.parent.map_or(0.0, |p| miss(j, p, reversed(j.measured.across)))),
    ("energy_3", |j| bending(j, 0)[0]),
    ("energy_6", |j| bending(j, 1)[0]),
    ("energy_12", |j| bending(j, 2)[0]),
    ("torsion", |j| if j.parent.is_some() { bending(j, 1)[1] } else { 0.0 }),
    ("facing", |j| j.parent.map_or(0.0, |p| angle(j.child.directions[1], reversed(p.directions[1])))),
    ("width_child", |j| (j.measured.child.radius / h(j)).ln()),
    ("width_parent", |j| (j.measured.parent_radius / h(j)).ln()),
    ("run_child", |j| (j.child.first_run / j.measured.width() + 0.1).ln()),
    ("run_parent", |j| j.parent.map_or(0.0, |p| (p.first_run / j.measured.parent_width() + 0.1).ln())),
    ("spur_child", |j| spur(j, j.child)),
    ("spur_parent", |j| j.parent.map_or(0.0, |p| spur(j, p))),
    ("tip_child", |j| (j.child.tip_radius / j.measured.child.radius).ln()),
    ("tip_parent", |j| j.parent.map_or(0.0, |p| (p.tip_radius / j.measured.parent_radius).ln())),
    ("taper_child", |j| (j.child.far_radius / j.measured.child.radius).ln()),
    ("taper_parent", |j| j.parent.map_or(0.0, |p| (p.far_radius / j.measured.parent_radius).ln())),
    ("far_step", |j| j.parent.map_or(0.0, |p| (j.child.far_radius / p.far_radius).ln().abs())),
    ("far_ratio", |j| (j.child.far_radius / j.parent.map_or(j.measured.parent_radius, |p| p.far_radius)).ln()),
    ("slim_child", |j| slim(j)[0]),
    ("slim_least", |j| slim(j)[0].min(slim(j)[1])),
    ("ends_child", |j| free_ends(j)[0]),
    ("ends_parent", |j| free_ends(j)[1]),
    ("gap_over_length", |j| ((j.measured.gap + h(j)) / (lengths(j)[0].min(lengths(j)[1]) + h(j))).ln()),
    ("tiny", |j| if lengths(j)[0].max(lengths(j)[1]) < 8.0 * h(j) { 1.0 } else { 0.0 }),
    ("detour", |j| log_detour(j.measured)),
    ("wiggle_child", |j| j.child.wiggle.min(3.0)),
    ("wiggle_parent", |j| j.parent.map_or(0.0, |p| p.wiggle.min(3.0))),
    ("course_child", |j| (j.child.length / j.measured.width() + 0.2).ln()),
    ("course_parent", |j| j.parent.map_or(0.0, |p| (p.length / j.measured.parent_width() + 0.2).ln())),
];

/// The features of a tracing that a skeleton has too.
fn shared_features() -> impl Iterator<Item = &'static (&'static str, Feature)> {
    FEATURES.iter().filter(|(name, _)| !LEFT_OUT.contains(name))
}

/// The names of all features, in the order of their columns.
pub fn join_feature_names() -> Vec<&'static str> {
    let own = shared_features().map(|(name, _)| *name).chain(MORE_FEATURES.iter().map(|(name, _)| *name));
    own.chain(RIVALS).chain(SURROUNDINGS).collect()
}

/// The features of the candidates of one search: a row a candidate, a column a feature of [`join_feature_names`].
pub fn join_features(e: &Extraction, courses: &[EndCourse], candidates: &[EndCandidate], pairs: &Pairs) -> Array2<f64> {
    let course_at = |point: usize| e.end_at[point].map(|end| &courses[end]);
    let measured = measured(e, candidates);
    // By this candidates compete before any model: length and bends, as a logarithm.
    let cost = |(m, candidate): (&MeasuredCandidate, &EndCandidate)| {
        let least = |of: &EndCourse, across: Point| (0..3).map(|k| angle(of.directions[k], across)).fold(f64::INFINITY, f64::min);
        let parent = course_at(m.point).map_or(0.6, |course| least(course, reversed(m.across)));
        (m.gap + 0.5 * e.spacing).ln() - e.spacing.ln() + 0.9 * least(&courses[candidate.end], m.across) + 0.6 * parent
    };
    let costs: Vec<f64> = measured.iter().zip(candidates).map(cost).collect();
    let rivals = rivals(e, courses, candidates, pairs, &costs);
    let around = surroundings(e, courses, candidates);
    let shared: Vec<Feature> = shared_features().map(|(_, feature)| *feature).collect();
    let rows = in_order(candidates, |row, candidate| {
        let m = &measured[row];
        let join = Join { measured: m, child: &courses[candidate.end], parent: course_at(m.point) };
        let more = MORE_FEATURES.iter().map(|(_, feature)| feature(&join));
        shared.iter().map(|feature| feature(m)).chain(more).chain(rivals[row]).chain(around[row]).collect::<Vec<f64>>()
    });
    Array2::from_shape_fn((rows.len(), join_feature_names().len()), |(row, column)| rows[row][column])
}

fn reversed(a: Point) -> Point {
    a.map(|x| -x)
}

fn h(j: &Join) -> f64 {
    j.measured.extraction.spacing
}

fn bend(j: &Join, scale: usize) -> f64 {
    angle(j.child.directions[scale], j.measured.across)
}

fn parent_bend(j: &Join, scale: usize) -> f64 {
    j.parent.map_or(0.0, |p| angle(p.directions[scale], reversed(j.measured.across)))
}

fn least_bend(j: &Join) -> f64 {
    (0..4).map(|scale| bend(j, scale)).fold(f64::INFINITY, f64::min)
}

fn least_parent_bend(j: &Join) -> f64 {
    (0..4).map(|scale| parent_bend(j, scale)).fold(f64::INFINITY, f64::min)
}

/// How far from the other place a course ends that is continued with its curvature over the gap, in gaps, at most 3.
fn miss(j: &Join, course: &EndCourse, across: Point) -> f64 {
    let d = j.measured.gap;
    let curved = d.min(12.0 * h(j) + 4.0 * j.measured.child.radius).powi(2);
    let off = [0, 1, 2].map(|k| course.tip_direction[k] * d + course.curvature[k] * curved - across[k] * d);
    (norm_squared(off).sqrt() / d).min(3.0)
}

/// The bending of a cubic across the gap that leaves and arrives in the directions of a scale, and the product of its two bends.
fn bending(j: &Join, scale: usize) -> [f64; 2] {
    let u = j.measured.across;
    let bends = |direction: Point| {
        let along = dot(direction, u);
        let sideways = unit([0, 1, 2].map(|k| near_zero(direction[k] - along * u[k])));
        sideways.map(|x| x * angle(direction, u))
    };
    let a = bends(j.child.directions[scale]);
    let c = bends(j.parent.map_or(u, |p| reversed(p.directions[scale])));
    [(norm_squared(a) + dot(a, c) + norm_squared(c)).max(0.0).sqrt(), dot(a, c)]
}

/// ln of the first run over the radius at its junction: what is shorter than wide is a spur.
fn spur(j: &Join, course: &EndCourse) -> f64 {
    ((course.first_run + 0.5 * h(j)) / (course.junction_radius + h(j))).ln()
}

/// The fragments of the child and of the parent.
fn fragments<'a>(j: &Join<'a>) -> [&'a Fragment; 2] {
    let e = j.measured.extraction;
    [j.measured.child.point, j.measured.point].map(|point| &e.fragments[e.fragment[point]])
}

fn slim(j: &Join) -> [f64; 2] {
    fragments(j).map(|fragment| slenderness(j.measured.extraction, fragment))
}

fn free_ends(j: &Join) -> [f64; 2] {
    fragments(j).map(|fragment| (fragment.free_ends as f64).ln_1p())
}

fn lengths(j: &Join) -> [f64; 2] {
    fragments(j).map(|fragment| fragment.length)
}

/// Free ends are counted over so many spacings around a free end, ...
const CROWD: f64 = 12.0;
/// ... and over so many around either place.
const NEARBY: f64 = 25.0;
/// Two free ends face one another within so many widths, each no further off the other's course than this cosine.
const FACING_WIDTHS: f64 = 4.0;
const FACING_COS: f64 = 0.825;

/// The features of [`surroundings`].
const SURROUNDINGS: [&str; 8] = [
    "crowd",
    "ends_around_child",
    "ends_around_parent",
    "points_around",
    "ends_per_length",
    "ends_facing",
    "usual_width",
    "fragments",
];

/// What lies around a candidate, and what the whole extraction is like: ln(1 + free ends within 12 spacings of the child); ln of free ends per
/// twenty points within 25 spacings of the child and of the parent; ln of the points within 25 spacings of the child; of the
/// extraction ln of free ends per hundred spacings of length, ln of the share of free ends that face another, the median of ln r/h, and ln of the
/// number of fragments.
fn surroundings(e: &Extraction, courses: &[EndCourse], candidates: &[EndCandidate]) -> Vec<[f64; SURROUNDINGS.len()]> {
    let is_end = |point: &usize| e.end_at[*point].is_some();
    let h = e.spacing;
    let ends_within = |point: usize, reach: f64| {
        let near = e.index.around(e.position[point], reach);
        let ends = near.iter().filter(|(_, point)| is_end(point)).count();
        (ends as f64, near.len() as f64)
    };
    let places: BTreeSet<usize> = candidates.iter().flat_map(|c| c.points(e)).collect();
    let places: Vec<usize> = places.into_iter().collect();
    let near = in_order(&places, |_, point| ends_within(*point, NEARBY * h));
    let near: BTreeMap<usize, (f64, f64)> = places.into_iter().zip(near).collect();
    let rate = |(ends, points): (f64, f64)| ((ends + 1.0) / (points / 20.0 + 1.0)).ln();
    let crowd: Vec<f64> = e.ends.iter().map(|end| ends_within(end.point, CROWD * h).0.ln_1p()).collect();
    let length: f64 = e.fragments.iter().map(|f| f.length).sum();
    let faces = |row: &usize| {
        let end = &e.ends[*row];
        let near = e.index.around(e.position[end.point], FACING_WIDTHS * (2.0 * end.radius + h));
        near.into_iter().filter_map(|(_, point)| e.end_at[point]).any(|other| {
            let u = unit(sub(e.position[e.ends[other].point], e.position[end.point]));
            e.ends[other].fragment != end.fragment
                && dot(courses[*row].directions[1], u) > FACING_COS
                && -dot(courses[other].directions[1], u) > FACING_COS
        })
    };
    let ends = e.ends.len() as f64;
    let facing = (0..e.ends.len()).filter(faces).count() as f64;
    let widths: Vec<f64> = e.radius.iter().map(|r| (r / h).ln()).collect();
    let per_length = (ends.max(1.0) * 100.0 * h / length.max(h)).ln();
    let facing = (0.02 + facing / ends.max(1.0)).ln();
    let (width, fragments) = (median(&widths).unwrap_or(0.0), (e.fragments.len() as f64).ln());
    let of = |c: &EndCandidate| {
        let [child, parent] = c.points(e).map(|point| near[&point]);
        [crowd[c.end], rate(child), rate(parent), child.1.ln(), per_length, facing, width, fragments]
    };
    candidates.iter().map(of).collect()
}

/// Bound of a margin of costs.
const MOST_MARGIN: f64 = 2.0;
/// Candidates to one vessel between its ends are rivals within so many spacings and a radius.
const SITE_SPACINGS: f64 = 2.5;
/// Other free ends count as nearer ones up to this share of the gap, and within a cone of at least this cosine.
const NEARER: f64 = 0.98;
const CONE_COS: f64 = 0.7;

fn site(e: &Extraction, point: usize) -> f64 {
    SITE_SPACINGS * e.spacing + e.radius_at(point)
}

/// The features of [`rivals`].
const RIVALS: [&str; 7] = ["cost_rank", "cost_margin", "cost_mutual", "site_rank", "site_margin", "pair_rank", "ends_in_cone"];

/// Of each candidate of one search what the others for the same places cost: how many branches cost less from the child; cost less that of the best other branch, in
/// [-2, 2]; whether both free ends prefer each other's branch; the fragments with a cheaper candidate to the same place; cost less that of the
/// best of them, in [-2, 2]; cheaper pairs of points between the same two fragments; and free ends of other fragments that are nearer and no further
/// off the course. Numbers are at most 8, and beyond the first 6.
fn rivals(
    e: &Extraction,
    courses: &[EndCourse],
    candidates: &[EndCandidate],
    pairs: &Pairs,
    costs: &[f64],
) -> Vec<[f64; RIVALS.len()]> {
    let costs: Vec<f64> = costs.iter().map(|c| steady(*c)).collect();
    let few = |count: usize| (count as f64).min(6.0);
    // Per free end the branches that it may be joined to, with the least cost of that, the cheapest first.
    let branches_from = |rows: &Vec<usize>| {
        let mut least: BTreeMap<usize, f64> = BTreeMap::new();
        for row in rows {
            let of_branch = least.entry(e.branch[candidates[*row].point]).or_insert(f64::INFINITY);
            *of_branch = of_branch.min(costs[*row]);
        }
        let mut in_order: Vec<(f64, usize)> = least.into_iter().map(|(branch, cost)| (cost, branch)).collect();
        in_order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        in_order
    };
    let branches: Vec<Vec<(f64, usize)>> = rows_by_end(e, candidates).iter().map(branches_from).collect();
    let prefers = |end: usize, branch: usize| branches[end].first().is_some_and(|(_, first)| *first == branch);
    let sites = PointIndex::new(candidates.iter().map(|c| e.position[c.point]).collect());
    let by_fragments = pairs.by_fragments(e);
    let mut cheapest = vec![f64::INFINITY; pairs.points.len()];
    for (pair, cost) in pairs.of.iter().zip(&costs) {
        cheapest[*pair] = cheapest[*pair].min(*cost);
    }
    let of = |(row, c): (usize, &EndCandidate)| {
        let (cost, [child, parent]) = (costs[row], c.fragments(e));
        let (own_branch, there) = (e.ends[c.end].branch, e.branch[c.point]);
        let from_here = &branches[c.end];
        let own = from_here.iter().find(|(_, branch)| *branch == there).map_or(cost, |(least, _)| *least);
        let cost_rank = from_here.iter().filter(|(least, _)| *least < own).count();
        let other = if cost_rank > 0 { from_here.first() } else { from_here.get(1) };
        let mutual = prefers(c.end, there) && e.end_at[c.point].is_some_and(|end| prefers(end, own_branch));
        let near = sites.around(e.position[c.point], site(e, c.point)).into_iter().map(|(_, other)| other);
        let rivals: Vec<usize> =
            near.filter(|o| e.fragment[candidates[*o].point] == parent && e.ends[candidates[*o].end].fragment != child).collect();
        let cheaper = rivals.iter().filter(|o| costs[**o] < cost).map(|o| e.ends[candidates[*o].end].fragment);
        let site_rank = cheaper.collect::<BTreeSet<usize>>().len();
        let best = rivals.iter().map(|o| costs[*o]).fold(f64::INFINITY, f64::min);
        let others = by_fragments[&unordered([child, parent])].iter().filter(|pair| **pair != pairs.of[row]);
        let margin = |rival: f64| (cost - rival).clamp(-MOST_MARGIN, MOST_MARGIN);
        [
            (cost_rank as f64).min(8.0),
            margin(other.map_or(own + MOST_MARGIN, |(least, _)| *least)),
            if mutual { 1.0 } else { 0.0 },
            few(site_rank),
            margin(best),
            few(others.filter(|pair| cheapest[**pair] < cost).count()),
            few(in_cone(e, &courses[c.end], c)),
        ]
    };
    candidates.iter().enumerate().map(of).collect()
}

/// Free ends of other fragments that are nearer than the candidate's point and no further off the child's course.
fn in_cone(e: &Extraction, course: &EndCourse, c: &EndCandidate) -> usize {
    let end = &e.ends[c.end];
    let across = sub(e.position[c.point], e.position[end.point]);
    let gap = norm_squared(across).sqrt();
    let along = course.directions[1];
    let least = steady((dot(across, along) / gap.max(f64::MIN_POSITIVE)).max(CONE_COS));
    let near = e.index.around(e.position[end.point], NEARER * gap).into_iter();
    near.filter(|(away, point)| {
        let to = sub(e.position[*point], e.position[end.point]);
        e.end_at[*point].is_some() && e.fragment[*point] != end.fragment && *away > 0.0 && steady(dot(to, along) / away) > least
    })
    .count()
}

/// How many features the second pass has of the first: the mean score of both directions and the own one; of the others at the child, and
/// of those at the parent, the best, the sum of probabilities and the margin; the sums of both fragments, the best way by a third fragment, and
/// the best and the sum of the other pairs of these two.
pub const SECOND_FEATURES: usize = 13;

/// A score where there is no other candidate, and the bound of all features.
const NO_SCORE: f64 = -8.0;
const MOST: f64 = 12.0;
const MOST_SUM: f64 = 3.0;
/// Pairs of fragments less probable than this lead nowhere.
const LEAST_STEP: f64 = 0.02;
const LEAST_TWO_STEPS: f64 = 1e-3;

/// The features of the second pass that come from the scores (log-odds) of the first: a row a candidate, a column one of [`SECOND_FEATURES`].
pub fn second_features(e: &Extraction, candidates: &[EndCandidate], pairs: &Pairs, scores: &[f64]) -> Array2<f64> {
    let score = pairs.mean(scores);
    let p: Vec<f64> = score.iter().map(|s| sigmoid(*s)).collect();
    let firsts: Vec<&EndCandidate> = pairs.first.iter().map(|row| &candidates[*row]).collect();
    let mut at: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    let by_fragments = pairs.by_fragments(e);
    let mut of_fragment = vec![0.0; e.fragments.len()];
    let mut steps: Vec<BTreeMap<usize, f64>> = vec![BTreeMap::new(); e.fragments.len()];
    for (pair, c) in firsts.iter().enumerate() {
        pairs.points[pair].iter().for_each(|point| at.entry(*point).or_default().push(pair));
        let [a, b] = c.fragments(e);
        of_fragment[a] += p[pair];
        of_fragment[b] += p[pair];
        if a != b && p[pair] > LEAST_STEP {
            for (from, to) in [(a, b), (b, a)] {
                let most = steps[from].entry(to).or_insert(0.0);
                *most = most.max(p[pair]);
            }
        }
    }
    let sites = PointIndex::new(firsts.iter().map(|c| e.position[c.point]).collect());
    let best_and_sum = |rivals: &[usize]| {
        let best = rivals.iter().map(|pair| score[*pair]).fold(NO_SCORE, f64::max);
        (best, rivals.iter().map(|pair| p[*pair]).sum::<f64>().min(MOST_SUM))
    };
    let mut out = Array2::zeros((candidates.len(), SECOND_FEATURES));
    for (row, c) in candidates.iter().enumerate() {
        let (pair, child) = (pairs.of[row], e.ends[c.end].point);
        // Of the two points of a pair the other one.
        let other_place = |pair: &usize, from: usize| pairs.points[*pair][usize::from(pairs.points[*pair][0] == from)];
        let elsewhere = |from: usize, to: usize| -> Vec<usize> {
            at[&from].iter().copied().filter(|pair| e.branch[other_place(pair, from)] != e.branch[to]).collect()
        };
        let at_child = best_and_sum(&elsewhere(child, c.point));
        let [own, parent] = c.fragments(e);
        let at_parent = if e.end_at[c.point].is_some() {
            best_and_sum(&elsewhere(c.point, child))
        } else {
            let near = sites.within(e.position[c.point], site(e, c.point)).into_iter().map(|(_, pair)| pair);
            let rivals = near.filter(|o| e.fragment[firsts[*o].point] == parent && e.ends[firsts[*o].end].point != child);
            best_and_sum(&rivals.collect::<Vec<usize>>())
        };
        let (few, many) = if steps[own].len() < steps[parent].len() { (own, parent) } else { (parent, own) };
        let two = |(via, p): (&usize, &f64)| steps[many].get(via).map(|q| p * q);
        let two_steps = if own == parent { 0.0 } else { steps[few].iter().filter_map(two).fold(0.0, f64::max) };
        let same = &by_fragments[&unordered([own, parent])];
        let others = same.iter().filter(|o| **o != pair);
        let mut features = vec![score[pair], scores[row]];
        features.extend([at_child, at_parent].iter().flat_map(|(best, sum)| [*best, *sum, score[pair] - best]));
        features.extend([own, parent].map(|fragment| of_fragment[fragment] - p[pair]));
        features.push((two_steps + LEAST_TWO_STEPS).ln());
        features.extend([others.clone().map(|o| score[*o]).fold(NO_SCORE, f64::max), others.map(|o| p[*o]).sum()]);
        for (column, x) in features.into_iter().enumerate() {
            out[[row, column]] = x.clamp(-MOST, MOST);
        }
    }
    out
}

/// Directions are fitted over so many spacings and a third of that in radii.
pub const SCALES: [f64; 4] = [3.0, 6.0, 12.0, 24.0];
/// A course is followed over the largest scale, so many spacings and so many radii more.
const MORE_SPACINGS: f64 = 2.0;
const MORE_RADII: f64 = 8.0;
/// Past a junction it follows the branch that runs on straightest, by the direction over so many points.
const LOOK: usize = 5;
/// Thinning bends the last stretch of a line, over so many radii; only the smallest scale sees it.
const BENT_RADII: f64 = 0.7;
/// The curvature is fitted over so many spacings and radii, with this ridge.
const CURVED_SPACINGS: f64 = 16.0;
const CURVED_RADII: f64 = 6.0;
const RIDGE: f64 = 0.02;

/// What is measured along the course of a free end. Lengths in m.
#[derive(Default)]
pub struct EndCourse {
    /// Unit vectors out of the vessel, by [`SCALES`].
    pub directions: [Point; 4],
    /// The unit vector out of the vessel at its end, by a parabola.
    pub tip_direction: Point,
    /// Half the second derivative of that parabola, 1/m.
    pub curvature: Point,
    /// Length to the first junction, or of the course.
    pub first_run: f64,
    /// Radius at the first junction, or at the end.
    pub junction_radius: f64,
    /// Mean radius of the last two points.
    pub tip_radius: f64,
    /// Geometric mean radius from the fourth to the sixteenth point.
    pub far_radius: f64,
    /// Length of the course.
    pub length: f64,
    /// Distance of the points from the line at the third scale, root mean square, in spacings.
    pub wiggle: f64,
}

impl EndCourse {
    /// The course of a free end of an extraction, by its row.
    pub fn new(extraction: &Extraction, row: usize) -> Self {
        let end = &extraction.ends[row];
        let h = extraction.spacing;
        let limit = (SCALES[3] + MORE_SPACINGS) * h + MORE_RADII * end.radius;
        let (points, junction) = inwards(extraction, end.point, end.branch, limit);
        let position: Vec<Point> = points.iter().map(|p| extraction.position[*p]).collect();
        let arc = arc_lengths(position.iter().copied());
        let smooth = if position.len() > 3 { slightly_smooth(&position) } else { position };
        let mut course = Self {
            first_run: junction.map_or(arc[arc.len() - 1], |at| arc[at]),
            junction_radius: junction.map_or(extraction.radius[end.point], |at| extraction.smooth.radius[points[at]]),
            tip_radius: points.iter().take(2).map(|p| extraction.radius[*p]).sum::<f64>() / points.len().min(2) as f64,
            far_radius: if points.len() > 4 {
                mean_log(&extraction.radius, &points[3..points.len().min(16)]).exp()
            } else {
                end.radius
            },
            length: arc[arc.len() - 1],
            ..Self::default()
        };
        for (scale, windows) in SCALES.iter().enumerate() {
            let upto = arc.iter().take_while(|s| **s <= windows * h + windows / 3.0 * end.radius).count();
            let from = arc.iter().take_while(|s| **s < BENT_RADII * end.radius).count();
            let from = if scale > 0 && upto > 8 && upto - from >= 2 { from } else { 0 };
            let upto = upto.max(2).min(smooth.len());
            let (direction, spread) = line(&smooth[from..upto], &arc[from..upto]);
            course.directions[scale] = direction;
            if scale == 2 {
                course.wiggle = spread / h;
            }
        }
        let upto = arc.iter().take_while(|s| **s <= CURVED_SPACINGS * h + CURVED_RADII * end.radius).count();
        course.tip_direction = course.directions[1];
        if upto >= 6 {
            let (slope, curvature) = parabola(&smooth[..upto], &arc[..upto]);
            course.tip_direction = unit(slope.map(|x| -x));
            course.curvature = curvature;
        }
        course
    }
}

/// The points from a free end inwards, at most so long, and the place of the first junction among them.
fn inwards(e: &Extraction, from: usize, branch: usize, limit: f64) -> (Vec<usize>, Option<usize>) {
    let (mut way, mut length, mut junction) = (vec![from], 0.0, None);
    let mut branch = branch;
    let mut seen = vec![branch];
    loop {
        let line = &e.lines[branch];
        for point in in_direction(line.clone(), line[0] == way[way.len() - 1]).into_iter().skip(1) {
            length += distance(e.position[way[way.len() - 1]], e.position[point]);
            way.push(point);
            if length >= limit {
                return (way, junction);
            }
        }
        let node = way[way.len() - 1];
        if e.degree[node] < 2 {
            return (way, junction);
        }
        if e.degree[node] > 2 && junction.is_none() {
            junction = Some(way.len() - 1);
        }
        let smooth = |p: usize| e.smooth.position[p];
        let back = unit(sub(smooth(node), smooth(way[way.len().saturating_sub(LOOK + 1)])));
        let headings = e.graph.headings(&e.lines, node).into_iter().filter(|heading| !seen.contains(&heading.branch));
        let ways = headings.map(|heading| {
            let wider = (e.smooth.radius[heading.walk(1)] / e.smooth.radius[node]).ln();
            (heading.branch, sub(smooth(heading.walk(LOOK)), smooth(node)), wider)
        });
        let Some(next) = straightest(back, ways) else { return (way, junction) };
        branch = next;
        seen.push(branch);
    }
}

/// The Gaussian average (1.5 points) of positions; those beyond the ends are the ends.
fn slightly_smooth(position: &[Point]) -> Vec<Point> {
    const SIGMA: f64 = 1.5;
    let last = position.len() as isize - 1;
    let weight: Vec<f64> = (-6..=6).map(|o: i32| (-0.5 * (f64::from(o) / SIGMA).powi(2)).exp()).collect();
    let total: f64 = weight.iter().sum();
    let at = |i: isize| {
        let mut sum = [0.0; 3];
        for (o, w) in (-6..=6).zip(&weight) {
            let p = position[(i + o).clamp(0, last) as usize];
            (0..3).for_each(|k| sum[k] += w * p[k]);
        }
        sum.map(|x| x / total)
    };
    (0..position.len() as isize).map(at).collect()
}

/// The direction of the least-squares line against the arc length, towards its beginning, and the root mean square distance from it.
fn line(points: &[Point], arc: &[f64]) -> (Point, f64) {
    let n = points.len() as f64;
    let middle = arc.iter().sum::<f64>() / n;
    let mean = centroid(points.iter().copied());
    let mut v = [0.0; 3];
    for (p, s) in points.iter().zip(arc) {
        (0..3).for_each(|k| v[k] -= (s - middle) * (p[k] - mean[k]));
    }
    let direction = unit(v);
    let square: f64 = arc.iter().map(|s| (s - middle).powi(2)).sum::<f64>().max(f64::MIN_POSITIVE);
    let off = |(p, s): (&Point, &f64)| norm_squared([0, 1, 2].map(|k| p[k] - mean[k] + (s - middle) * v[k] / square));
    (direction, (points.iter().zip(arc).map(off).sum::<f64>() / n).sqrt())
}

/// Slope at the beginning and half the second derivative of the parabola through points, by ridge regression.
fn parabola(points: &[Point], arc: &[f64]) -> (Point, Point) {
    let most = arc[arc.len() - 1].max(f64::MIN_POSITIVE);
    let rows = arc.iter().zip(points).map(|(s, p)| (1.0, [1.0, s / most, (s / most).powi(2)], sub(*p, points[0])));
    let (mut a, b) = normal_equations(rows);
    a[2][2] += RIDGE * points.len() as f64;
    let x = solve(a, b, 3);
    (x[1].map(|x| x / most), x[2].map(|x| x / (most * most)))
}
