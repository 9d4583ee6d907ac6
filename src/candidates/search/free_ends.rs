//! The free ends of the observed vessels: where they are, how wide, which way they point, and how far and where they may reach.

use crate::network::{Network, Origin, PathPoint};
use crate::support::geometry::{Point, distance, sub, unit};
use crate::support::statistics::median;

/// The direction is fitted over so many point spacings at least ...
pub(crate) const FIT_SPACINGS: f64 = 6.0;
/// ... and over so many end radii.
pub(crate) const FIT_RADII: f64 = 3.0;
/// Reach in point spacings and in end radii: independent of any unit.
const REACH_SPACINGS: f64 = 20.0;
const REACH_RADII: f64 = 10.0;
/// A branch is met where d (1.3 - cos) is least: d the distance, cos that of the bend.
pub(crate) const BEND: f64 = 1.3;
/// A meeting point so many spacings from a free end of its branch is moved there.
pub(crate) const SNAP_SPACINGS: f64 = 3.0;

/// A free end.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeEnd {
    /// Its node.
    pub node: usize,
    /// The vessel that ends there.
    pub vessel: usize,
    /// Position, m.
    pub position: Point,
    /// Mean radius over its last points, m.
    pub radius: f64,
    /// Unit vector out of the vessel; zero where the vessel gives none.
    pub direction: Point,
}

/// The free ends of the observed vessels, in node order.
pub fn free_ends(network: &Network, spacing: f64) -> Vec<FreeEnd> {
    let degree = network.degrees(|v| v.origin == Origin::Observed);
    let mut ends = Vec::new();
    for (vessel, (nodes, v)) in network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed) {
        for (last, node) in nodes.into_iter().enumerate().filter(|(_, n)| degree[*n] == 1) {
            let Some(position) = network.node(node).position else { continue };
            let mut path = v.path.clone();
            if last == 1 {
                path.reverse();
            }
            let radius = v.end_radius(last == 1);
            let points: Vec<Point> = if path.len() > 1 {
                near_points(&path, (FIT_SPACINGS * spacing).max(FIT_RADII * radius))
            } else {
                let other = network.node(nodes[1 - last]).position;
                [Some(position), other].into_iter().flatten().collect()
            };
            ends.push(FreeEnd { node, vessel, position, radius, direction: outwards(&points) });
        }
    }
    ends.sort_by_key(|e| e.node);
    ends
}

/// The median distance between consecutive points of the observed vessels, m; zero without vessels.
pub fn point_spacing(network: &Network) -> f64 {
    let mut gaps = Vec::new();
    for (_, v) in network.vessels().filter(|(_, v)| v.origin == Origin::Observed) {
        gaps.extend(v.path.windows(2).map(|p| distance(p[0].position, p[1].position)));
        if v.path.len() < 2 {
            gaps.push(v.length);
        }
    }
    median(&gaps).unwrap_or(0.0)
}

/// The points of a path up to an arc length, two at least.
fn near_points(path: &[PathPoint], reach: f64) -> Vec<Point> {
    let mut points = vec![path[0].position];
    let mut arc = 0.0;
    for pair in path.windows(2) {
        arc += distance(pair[0].position, pair[1].position);
        if points.len() >= 2 && arc > reach {
            break;
        }
        points.push(pair[1].position);
    }
    points
}

/// How far (m) an end of a radius (m) may reach.
pub(crate) fn reach(spacing: f64, radius: f64) -> f64 {
    REACH_SPACINGS * spacing + REACH_RADII * radius
}

/// The direction of the least-squares line through points taken as equally spaced, towards the first.
pub(crate) fn outwards(points: &[Point]) -> Point {
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
