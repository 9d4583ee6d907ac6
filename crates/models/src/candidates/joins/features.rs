//! The features of a candidate on an automatic skeleton: those of a tracing, and more of courses, rivals and surroundings.
//!
//! d is the gap, h the spacing, r the radius of a free end. All are dimensionless.

use std::collections::{BTreeMap, BTreeSet};

use ndarray::Array2;

use super::course::EndCourse;
use super::rivals::{Rivals, rivals};
use crate::candidates::features::candidate_features::{log_detour, slenderness};
use crate::candidates::features::fragment::Fragment;
use crate::candidates::features::measured_candidate::{MeasuredCandidate, angle, measured};
use crate::candidates::features::{Extraction, FEATURES, Feature};
use crate::candidates::search::EndCandidate;
use willis_core::support::geometry::{Point, dot, norm_squared, sub, unit};
use willis_core::support::in_order;
use willis_core::support::statistics::median;

/// A candidate with everything that its features are computed from.
pub struct Join<'a> {
    /// Its gap, bends and nearest rivals.
    pub measured: MeasuredCandidate<'a>,
    /// The course of the child.
    pub child: &'a EndCourse,
    /// The course of the parent's free end, where it is met there.
    pub parent: Option<&'a EndCourse>,
    /// Other candidates for the same places.
    pub rivals: Rivals,
    /// What lies around.
    pub around: Surroundings,
}

/// A feature of a candidate on a skeleton.
pub type JoinFeature = fn(&Join) -> f64;

/// Features of tracings that say nothing of a skeleton, or depend on what a user clicked.
const LEFT_OUT: [&str; 2] = ["fed_parent", "share_parent"];

/// The features that only skeletons have, by name.
pub const MORE_FEATURES: &[(&str, JoinFeature)] = &[
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
    ("run_parent", |j| j.parent.map_or(0.0, |p| (p.first_run / parent_width(j) + 0.1).ln())),
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
    ("detour", |j| log_detour(&j.measured)),
    ("wiggle_child", |j| j.child.wiggle.min(3.0)),
    ("wiggle_parent", |j| j.parent.map_or(0.0, |p| p.wiggle.min(3.0))),
    ("course_child", |j| (j.child.length / j.measured.width() + 0.2).ln()),
    ("course_parent", |j| j.parent.map_or(0.0, |p| (p.length / parent_width(j) + 0.2).ln())),
    ("cost_rank", |j| (j.rivals.rank as f64).min(8.0)),
    ("cost_margin", |j| j.rivals.margin),
    ("cost_mutual", |j| if j.rivals.mutual { 1.0 } else { 0.0 }),
    ("site_rank", |j| (j.rivals.site_rank as f64).min(6.0)),
    ("site_margin", |j| j.rivals.site_margin),
    ("pair_rank", |j| (j.rivals.pair_rank as f64).min(6.0)),
    ("ends_in_cone", |j| (j.rivals.in_cone as f64).min(6.0)),
    ("crowd", |j| j.around.crowd),
    ("ends_around_child", |j| j.around.ends[0]),
    ("ends_around_parent", |j| j.around.ends[1]),
    ("points_around", |j| j.around.points),
    ("ends_per_length", |j| j.around.extraction[0]),
    ("ends_facing", |j| j.around.extraction[1]),
    ("usual_width", |j| j.around.extraction[2]),
    ("fragments", |j| j.around.extraction[3]),
];

/// The features of a tracing that a skeleton has too.
fn shared_features() -> impl Iterator<Item = &'static (&'static str, Feature)> {
    FEATURES.iter().filter(|(name, _)| !LEFT_OUT.contains(name))
}

/// The names of all features, in the order of their columns.
pub fn join_feature_names() -> Vec<&'static str> {
    shared_features().map(|(name, _)| *name).chain(MORE_FEATURES.iter().map(|(name, _)| *name)).collect()
}

/// The features of the candidates of one search: a row a candidate, a column a feature of [`join_feature_names`].
pub fn join_features(extraction: &Extraction, courses: &[EndCourse], candidates: &[EndCandidate]) -> Array2<f64> {
    let measured = measured(extraction, candidates);
    let costs: Vec<f64> = measured.iter().zip(candidates).map(|(m, c)| cost(m, courses, extraction, c)).collect();
    let rivals = rivals(extraction, courses, candidates, &costs);
    let around = surroundings(extraction, courses, candidates);
    let joins: Vec<Join> = measured
        .into_iter()
        .zip(candidates)
        .zip(rivals.into_iter().zip(around))
        .map(|((measured, candidate), (rivals, around))| Join {
            measured,
            child: &courses[candidate.end],
            parent: extraction.end_at[candidate.point].map(|end| &courses[end]),
            rivals,
            around,
        })
        .collect();
    let own: Vec<Feature> = shared_features().map(|(_, feature)| *feature).collect();
    let rows = in_order(&joins, |_, j| {
        own.iter().map(|f| f(&j.measured)).chain(MORE_FEATURES.iter().map(|(_, f)| f(j))).collect::<Vec<f64>>()
    });
    let columns = own.len() + MORE_FEATURES.len();
    Array2::from_shape_fn((rows.len(), columns), |(row, column)| rows[row][column])
}

/// What a candidate costs by length and bends, as a logarithm: by this candidates compete before any model.
fn cost(m: &MeasuredCandidate, courses: &[EndCourse], extraction: &Extraction, candidate: &EndCandidate) -> f64 {
    let least =
        |course: &EndCourse, across: Point| (0..3).map(|k| angle(course.directions[k], across)).fold(f64::INFINITY, f64::min);
    let parent = extraction.end_at[candidate.point].map_or(0.6, |end| least(&courses[end], reversed(m.across)));
    (m.gap + 0.5 * extraction.spacing).ln() - extraction.spacing.ln()
        + 0.9 * least(&courses[candidate.end], m.across)
        + 0.6 * parent
}

fn reversed(a: Point) -> Point {
    a.map(|x| -x)
}

fn h(j: &Join) -> f64 {
    j.measured.extraction.spacing
}

fn parent_width(j: &Join) -> f64 {
    2.0 * j.measured.parent_radius + h(j)
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
        let sideways = unit([0, 1, 2].map(|k| direction[k] - along * u[k]));
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

/// What lies around a candidate, and what the whole extraction is like.
#[derive(Clone, Copy)]
pub struct Surroundings {
    /// ln(1 + free ends within 12 spacings of the child).
    crowd: f64,
    /// ln of free ends per twenty points within 25 spacings of the child and of the parent.
    ends: [f64; 2],
    /// ln of the points within 25 spacings of the child.
    points: f64,
    /// ln of free ends per hundred spacings of length, ln of the share of free ends that face another, the median of ln r/h, ln of the
    /// number of fragments.
    extraction: [f64; 4],
}

fn surroundings(e: &Extraction, courses: &[EndCourse], candidates: &[EndCandidate]) -> Vec<Surroundings> {
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
    let whole = of_extraction(e, courses);
    let of = |c: &EndCandidate| {
        let [child, parent] = c.points(e).map(|point| near[&point]);
        Surroundings { crowd: crowd[c.end], ends: [rate(child), rate(parent)], points: child.1.ln(), extraction: whole }
    };
    candidates.iter().map(of).collect()
}

fn of_extraction(e: &Extraction, courses: &[EndCourse]) -> [f64; 4] {
    let h = e.spacing;
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
    [
        (ends.max(1.0) * 100.0 * h / length.max(h)).ln(),
        (0.02 + facing / ends.max(1.0)).ln(),
        median(&widths).unwrap_or(0.0),
        (e.fragments.len() as f64).ln(),
    ]
}
