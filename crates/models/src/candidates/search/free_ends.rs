//! The free ends of an extraction: where each is, how wide, and which way it points.

use willis_core::network::Vessel;
use willis_core::support::arc_lengths::in_direction;
use willis_core::support::geometry::{Point, sub, unit};
use willis_core::support::ties::steady;

/// The direction is fitted over so many points at least, so many radii, and so many points at most.
const FIT_SPACINGS: f64 = 6.0;
const FIT_RADII: f64 = 3.0;
const FIT_POINTS: f64 = 40.0;

/// A free end.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeEnd {
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
    /// Geometric mean of the radii over the fit, m: the width that the evidence measures with.
    pub radius: f64,
    /// [`Vessel::end_radius`], m: the width of candidates that are built without evidence.
    pub mean_radius: f64,
    /// How much better blood divides at the fragment's junctions if it comes from this end, in [-1.5, 1.5]: positive where the
    /// fragment is fed through this end. 0 without a junction.
    pub orientation: f64,
}

/// The free ends in node order, without their orientation. `vessels` are those of the first `lines`.
pub fn free_ends(
    lines: &[Vec<usize>],
    vessels: &[&Vessel],
    [fragment, degree]: [&[usize]; 2],
    position: &[Point],
    radius: &[f64],
    spacing: f64,
) -> Vec<FreeEnd> {
    let mut ends: Vec<FreeEnd> = Vec::new();
    for (branch, (line, vessel)) in lines.iter().zip(vessels).enumerate() {
        for last in [false, true] {
            let inwards = in_direction(line.clone(), !last);
            let point = inwards[0];
            if degree[point] != 1 {
                continue;
            }
            let mean = |points: &[usize]| (points.iter().map(|p| radius[*p].ln()).sum::<f64>() / points.len() as f64).exp();
            let upto = |n: usize| &inwards[..n.min(inwards.len())];
            let direction = |n: usize| outwards(&upto(n).iter().map(|p| position[*p]).collect::<Vec<_>>());
            let first = mean(upto(FIT_SPACINGS as usize));
            let n = steady(FIT_RADII * first / spacing).round_ties_even().clamp(FIT_SPACINGS, FIT_POINTS) as usize;
            ends.push(FreeEnd {
                point,
                branch,
                fragment: fragment[point],
                direction: direction(n),
                far_direction: direction(2 * n),
                radius: mean(upto(n)),
                mean_radius: vessel.end_radius(last),
                orientation: 0.0,
            });
        }
    }
    ends.sort_by_key(|end| end.point);
    ends
}

/// The direction of the least-squares line through points taken as equally spaced, towards the first.
fn outwards(points: &[Point]) -> Point {
    let middle = 0.5 * (points.len() as f64 - 1.0);
    let mut v = [0.0; 3];
    for (i, p) in points.iter().enumerate() {
        let from_first = sub(*p, points[0]);
        for axis in 0..3 {
            v[axis] += (middle - i as f64) * from_first[axis];
        }
    }
    unit(v)
}
