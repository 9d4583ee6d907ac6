//! How the branches run at each point: tangent, kink, and the side that blood comes from.

use super::roads::Roads;
use super::smooth::SmoothPoints;
use super::steady::steady;
use crate::geometry::{Point, sub, unit};

/// Tangents are taken over so many radii to either side, within 2 to 12 points.
const SPAN_RADII: f64 = 1.5;
const SPAN_POINTS: [f64; 2] = [2.0, 12.0];

/// How a branch runs at a point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Course {
    /// Unit tangent, along the flow where an inlet of the fragment says it, else in either sense.
    pub tangent: Point,
    /// The unit direction onwards minus the unit direction from behind, in [0, 2]: it points to the inside of the bend.
    /// Zero at ends and junctions.
    pub kink: Point,
    /// Whether the tangent is along the flow.
    pub flow_known: bool,
}

/// The course of each point, blood coming from the inlets by the shortest paths.
///
/// A junction has the direction from its neighbour upstream, without known flow the one along its own branch.
pub fn courses(
    lines: &[Vec<usize>],
    branch: &[usize],
    degree: &[usize],
    smooth: &SmoothPoints,
    roads: &Roads,
    inlets: &[usize],
    spacing: f64,
) -> Vec<Course> {
    let from_inlet = roads.to_nearest(inlets);
    let mut out = vec![Course::default(); branch.len()];
    for line in lines {
        for (at, point) in line.iter().enumerate().take(line.len() - 1).skip(1) {
            let span = steady(SPAN_RADII * smooth.radius[*point] / spacing).round_ties_even();
            let span = span.clamp(SPAN_POINTS[0], SPAN_POINTS[1]) as usize;
            let p = smooth.position[*point];
            let mut from = unit(sub(p, smooth.position[line[at.saturating_sub(span)]]));
            let mut onwards = unit(sub(smooth.position[line[(at + span).min(line.len() - 1)]], p));
            let [by_first, by_last] = roads.ways(&from_inlet, *point);
            if steady(by_last) < steady(by_first) {
                (from, onwards) = (onwards.map(|x| -x), from.map(|x| -x));
            }
            out[*point] = Course {
                tangent: unit([0, 1, 2].map(|axis| from[axis] + onwards[axis])),
                kink: sub(onwards, from),
                flow_known: by_first.min(by_last).is_finite(),
            };
        }
    }
    for node in (0..from_inlet.len()).filter(|node| degree[*node] > 0) {
        let fed = from_inlet[node].is_finite() && from_inlet[node] > 0.0;
        let along = |road: &(usize, usize)| steady(from_inlet[road.1] + roads.length[road.0]);
        let upstream = roads.around(node).iter().filter(|_| fed).min_by(|a, b| along(a).total_cmp(&along(b)));
        let line = &lines[upstream.map_or(branch[node], |road| road.0)];
        let neighbour = if line[0] == node { line[1] } else { line[line.len() - 2] };
        let tangent = unit(sub(smooth.position[node], smooth.position[neighbour]));
        out[node] = Course { tangent, kink: [0.0; 3], flow_known: fed };
    }
    out
}
