//! The free ends of an extraction: where each is, how wide, which way it points and how surely.

use super::free_ends::{FIT_RADII, FIT_SPACINGS, outwards};
use crate::candidates::features::smoothing::steady;
use crate::support::geometry::Point;

/// The direction is fitted over so many points at most.
const FIT_POINTS: f64 = 40.0;

/// A free end.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its point, a node.
    pub point: usize,
    /// Its branch.
    pub branch: usize,
    /// Its fragment.
    pub fragment: usize,
    /// Unit vector out of the vessel, fitted over the larger of 6 spacings and 3 radii; zero where the vessel gives none.
    pub direction: Point,
    /// The same over twice that length.
    pub far_direction: Point,
    /// Geometric mean of the radii over the fit, m.
    pub radius: f64,
    /// How much better blood divides at the fragment's junctions if it comes from this end, in [-1.5, 1.5]: positive where the
    /// fragment hangs on it. 0 without a junction.
    pub orientation: f64,
}

/// The free ends in node order, without their orientation.
pub fn frames(
    lines: &[Vec<usize>],
    fragment: &[usize],
    degree: &[usize],
    position: &[Point],
    radius: &[f64],
    spacing: f64,
) -> Vec<Frame> {
    let mut ends: Vec<Frame> = Vec::new();
    for (row, line) in lines.iter().enumerate() {
        let mut inwards = line.clone();
        for _ in 0..2 {
            let point = inwards[0];
            if degree[point] == 1 {
                let path: Vec<(Point, f64)> = inwards.iter().map(|p| (position[*p], radius[*p].ln())).collect();
                let mut frame = fitted(&path, spacing);
                (frame.point, frame.branch, frame.fragment) = (point, row, fragment[point]);
                ends.push(frame);
            }
            inwards.reverse();
        }
    }
    ends.sort_by_key(|end| end.point);
    ends
}

/// The frame of a path that begins with a free end: positions and logarithms of radii.
fn fitted(path: &[(Point, f64)], spacing: f64) -> Frame {
    let mean = |part: &[(Point, f64)]| part.iter().map(|(_, log)| log).sum::<f64>() / part.len() as f64;
    let upto = |n: usize| &path[..n.min(path.len())];
    let first = mean(upto(FIT_SPACINGS as usize)).exp();
    let n = steady(FIT_RADII * first / spacing).round_ties_even().clamp(FIT_SPACINGS, FIT_POINTS) as usize;
    let near: Vec<Point> = upto(n).iter().map(|(p, _)| *p).collect();
    let far: Vec<Point> = upto(2 * n).iter().map(|(p, _)| *p).collect();
    Frame {
        point: 0,
        branch: 0,
        fragment: 0,
        direction: outwards(&near),
        far_direction: outwards(&far),
        radius: mean(upto(n)).exp(),
        orientation: 0.0,
    }
}
