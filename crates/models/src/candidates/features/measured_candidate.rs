//! A candidate with what its features are computed from: its two ends, its gap, and its rivals.

use super::extraction::Extraction;
use crate::candidates::search::free_ends::FreeEnd;
use crate::candidates::search::{EndCandidate, rows_by_end};
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, cross, distance, dot, norm_squared, sub, unit};
use willis_core::support::ties::{compare, steady};

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
    add_detours(extraction, candidates, &mut out);
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

/// The detours of the candidates within a fragment.
fn add_detours(extraction: &Extraction, candidates: &[EndCandidate], out: &mut [MeasuredCandidate]) {
    let mut paths = ShortestPaths::new(extraction.graph.nodes());
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
}
