//! The shape of a branch at each of its points: tangent, kinks, and which side is the wider one.

use super::smoothing::SmoothPoints;
use willis_core::support::geometry::{Point, sub, unit};
use willis_core::support::ties::steady;

/// Tangents and kinks are taken over so many radii to either side, within so many points ...
const NEAR: (f64, [f64; 2]) = (1.5, [2.0, 12.0]);
/// ... and what the two sides are as a whole over so many.
const SIDE: (f64, [f64; 2]) = (4.0, [5.0, 14.0]);

/// How a branch runs at a point; all zero at its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BranchShape {
    /// Unit tangent towards the last node of the branch.
    pub tangent: Point,
    /// The unit direction onwards minus the unit direction from behind, in [0, 2]: it points to the inside of the bend. Taken
    /// over 1.5 radii, 2 to 12 points.
    pub kink: Point,
    /// The same over 4 radii, 5 to 14 points.
    pub far_kink: Point,
    /// ln of the mean radius on the side of the branch's first node over that on the other, in [-1, 1]: over 4 radii, without
    /// the points next to this one.
    pub narrowing: f64,
}

/// The shape of the branches at each point; `radius` as measured, m.
pub fn branch_shapes(lines: &[Vec<usize>], smooth: &SmoothPoints, radius: &[f64], spacing: f64) -> Vec<BranchShape> {
    let mut out = vec![BranchShape::default(); radius.len()];
    for line in lines {
        for (at, point) in line.iter().enumerate().take(line.len() - 1).skip(1) {
            let ends = |(radii, points): (f64, [f64; 2])| {
                let steps = steps(radii, points, smooth.radius[*point], spacing);
                [at.saturating_sub(steps), (at + steps).min(line.len() - 1)]
            };
            let directions = |[first, last]: [usize; 2]| {
                let p = smooth.position[*point];
                [unit(sub(p, smooth.position[line[first]])), unit(sub(smooth.position[line[last]], p))]
            };
            let ([from, onwards], side) = (directions(ends(NEAR)), ends(SIDE));
            let [far_from, far_onwards] = directions(side);
            let mean = |part: &[usize]| part.iter().map(|p| radius[*p].ln()).sum::<f64>() / part.len() as f64;
            // A side of one point has but that one.
            let behind = mean(&line[side[0]..(at - 1).max(side[0] + 1)]);
            let ahead = mean(&line[(at + 2).min(side[1])..=side[1]]);
            out[*point] = BranchShape {
                tangent: unit([0, 1, 2].map(|axis| from[axis] + onwards[axis])),
                kink: sub(onwards, from),
                far_kink: sub(far_onwards, far_from),
                narrowing: (behind - ahead).clamp(-1.0, 1.0),
            };
        }
    }
    out
}

/// So many radii in points, within bounds.
pub fn steps(radii: f64, points: [f64; 2], radius: f64, spacing: f64) -> usize {
    steady(radii * radius / spacing).round_ties_even().clamp(points[0], points[1]) as usize
}
