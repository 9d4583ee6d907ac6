//! Where blood may enter a fragment: by which of its free ends it would divide best at the junctions.

use super::branch_graph::{BranchGraph, Heading};
use super::smoothing::SmoothPoints;
use super::tangent::steps;
use crate::candidates::search::free_ends::FreeEnd;
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{dot, sub, unit};
use willis_core::support::ties::steady;

/// The branches at a junction are followed over so many of its radii, within so many points.
const ARM_RADII: f64 = 3.0;
const ARM_POINTS: [f64; 2] = [4.0, 12.0];
/// The orientation is the mean over so many junctions, the nearest along the vessels.
const JUNCTIONS: usize = 12;
/// Bound of the orientation.
const MOST: f64 = 1.5;

/// A branch at a junction.
struct JunctionArm {
    branch: usize,
    /// The node at its other end.
    other: usize,
    /// J of this branch less the largest J of the others; J, if blood came by this branch, is the least cosine between the
    /// direction it came in and those it leaves by.
    preference: f64,
}

/// Sets the orientation of each free end: the mean, in [-1.5, 1.5], over the twelve junctions nearest along the vessels (and those as
/// near as the twelfth) of how much better blood divides there if it comes from this end; 0 without a junction.
pub fn set_orientations(ends: &mut [FreeEnd], graph: &BranchGraph, lines: &[Vec<usize>], smooth: &SmoothPoints, spacing: f64) {
    let of_node = |node: usize| {
        let headings = graph.headings(lines, node);
        if headings.len() > 2 { arms(node, &headings, smooth, spacing) } else { Vec::new() }
    };
    let arms: Vec<Vec<JunctionArm>> = (0..graph.nodes()).map(of_node).collect();
    let mut paths = ShortestPaths::new(graph.nodes());
    for end in ends {
        let (mut sum, mut count, mut last) = (0.0, 0, 0.0);
        graph.search(&[end.point], f64::INFINITY, &mut paths, |length, node| {
            let away = steady(length[node] / spacing);
            let by = |arm: &JunctionArm| (steady((length[arm.other] + graph.length[arm.branch]) / spacing), arm.preference);
            let order = |a: &JunctionArm, b: &JunctionArm| by(a).0.total_cmp(&by(b).0).then(by(a).1.total_cmp(&by(b).1));
            if count >= JUNCTIONS && away > last {
                return false;
            }
            if let Some(arm) = arms[node].iter().min_by(|a, b| order(a, b)) {
                (sum, count, last) = (sum + arm.preference, count + 1, away);
            }
            true
        });
        end.orientation = if count > 0 { (sum / count as f64).clamp(-MOST, MOST) } else { 0.0 };
    }
}

fn arms(junction: usize, headings: &[Heading], smooth: &SmoothPoints, spacing: f64) -> Vec<JunctionArm> {
    let steps = steps(ARM_RADII, ARM_POINTS, smooth.radius[junction], spacing);
    let position = |point: usize| smooth.position[point];
    let directions: Vec<_> =
        headings.iter().map(|heading| unit(sub(position(heading.walk(steps)), position(junction)))).collect();
    let others = |own: usize| (0..headings.len()).filter(move |other| *other != own);
    let forwards: Vec<f64> = (0..headings.len())
        .map(|own| others(own).map(|other| -dot(directions[own], directions[other])).fold(f64::INFINITY, f64::min))
        .collect();
    let arm = |(own, heading): (usize, &Heading)| JunctionArm {
        branch: heading.branch,
        other: heading.walk(usize::MAX / 2),
        preference: forwards[own] - others(own).map(|other| forwards[other]).fold(f64::NEG_INFINITY, f64::max),
    };
    headings.iter().enumerate().map(arm).collect()
}
