//! The lumen along each branch end at a cluster, and the tubes that may run from one end to another.

use super::branches::Branches;
use super::sections::{Section, axis_of, section};
use willis_core::support::geometry::{Point, area_of, distance, dot, norm, radius_of, sub, unit};
use willis_core::support::statistics::median;
use willis_io::masks::Field;

/// Sections of an end lie at these multiples of ρ along its course, across the direction over this multiple to either side.
const STATIONS: [f64; 6] = [1.0, 1.5, 2.0, 2.5, 3.0, 3.5];
const SPAN: f64 = 0.5;
/// They are so many radii wide to either side.
pub const HALF_WIDTH: f64 = 3.0;
/// Fewer sections than this do not make an axis.
const LEAST_SECTIONS: usize = 3;
/// Inner points of the tube between two ends.
pub const INNER: usize = 9;

/// The lumen near the core along a branch end.
pub struct LumenArm {
    /// The middle of its axis.
    pub middle: Point,
    /// The axis, away from the core.
    pub along: Point,
    /// Where the axis is nearest to the core.
    pub root: Point,
    /// The typical area of its sections, m².
    pub area: f64,
    /// The radius of a circle of that area, m.
    pub radius: f64,
    /// The typical elongation of its sections.
    pub elongation: f64,
    /// Depths along the course from the core outwards, m.
    pub depths: Vec<f64>,
    /// The middles of its sections.
    pub centres: Vec<Point>,
}

impl LumenArm {
    /// That of an end of a cluster.
    pub fn new(field: &Field, branches: &Branches, cluster: usize, end: usize) -> Self {
        let c = &branches.clusters[cluster];
        let rho = 1.5 * c.radius;
        let course = branches.walk(c.ends[end], 8.0 * rho);
        let length = course.length();
        let last = STATIONS[STATIONS.len() - 1] * rho;
        let shrunk = if length < 1.1 * last { (0.9 * length / last).min(1.0) } else { 1.0 };
        let radii = course.radii_between(0.6 * rho, 5.0 * rho);
        let typical = median(&radii).unwrap_or(branches.branches[c.ends[end].branch].radius).max(field.voxel());
        let sections: Vec<(Point, Section)> = STATIONS
            .iter()
            .map(|station| {
                let s = station * rho * shrunk;
                let direction = course.direction((s - SPAN * rho).max(0.0), (s + SPAN * rho).min(length));
                (course.at(s), section(field, course.at(s), direction, HALF_WIDTH * typical))
            })
            .collect();
        let there: Vec<&(Point, Section)> = sections.iter().filter(|(_, s)| s.area > 0.0).collect();
        let of = |f: &dyn Fn(&Section) -> f64| median(&there.iter().map(|(_, s)| f(s)).collect::<Vec<f64>>());
        let (centres, area, elongation) = if there.len() < LEAST_SECTIONS {
            (sections.iter().map(|(p, _)| *p).collect::<Vec<Point>>(), area_of(typical), 1.0)
        } else {
            let centre = |(p, s): &&(Point, Section)| {
                let share = (0.5 * typical / norm(s.shift).max(f64::MIN_POSITIVE)).min(1.0);
                [0, 1, 2].map(|k| p[k] + share * s.shift[k])
            };
            let area = of(&|s| s.area).unwrap_or(area_of(typical));
            (there.iter().map(centre).collect(), area, of(&Section::elongation).unwrap_or(1.0))
        };
        let (middle, along) = axis_of(&centres);
        let ahead = dot(sub(centres[0], middle), along);
        let reach = (2.0 * rho).min(0.9 * length);
        Self {
            root: [0, 1, 2].map(|k| middle[k] + ahead * along[k]),
            middle,
            along,
            area,
            radius: radius_of(area),
            elongation,
            depths: (0..7).map(|n| field.depth(course.at(reach * f64::from(n) / 8.0))).collect(),
            centres,
        }
    }
}

/// A curve from `p` to `q` that leaves p against `u` and arrives at q along `v`, both away from the core; with its tangents.
fn hermite([p, u]: [Point; 2], [q, v]: [Point; 2]) -> Vec<Point> {
    let l = distance(q, p);
    let at = |n: usize| {
        let s = n as f64 / (INNER + 1) as f64;
        let (s2, s3) = (s * s, s * s * s);
        let weights = [1.0 - 3.0 * s2 + 2.0 * s3, s - 2.0 * s2 + s3, 3.0 * s2 - 2.0 * s3, s3 - s2];
        [0, 1, 2].map(|k| weights[0] * p[k] - weights[1] * l * u[k] + weights[2] * q[k] + weights[3] * l * v[k])
    };
    (0..INNER + 2).map(at).collect()
}

/// A tube between two arms: inner points, tangents, radii.
pub struct LumenTube {
    /// Points.
    pub points: Vec<Point>,
    /// Unit vectors along it.
    pub tangents: Vec<Point>,
    /// Radii, m.
    pub radii: Vec<f64>,
    /// Points of a tube between the middles of the arms.
    pub far: Vec<Point>,
    /// Its length, m.
    pub length: f64,
}

impl LumenTube {
    /// That between two arms.
    pub fn new(a: &LumenArm, b: &LumenArm) -> Self {
        let curve = hermite([a.root, a.along], [b.root, b.along]);
        let far = hermite([a.middle, a.along], [b.middle, b.along]);
        let inner = 1..=INNER;
        Self {
            tangents: inner.clone().map(|n| unit(sub(curve[n + 1], curve[n - 1]))).collect(),
            radii: inner.clone().map(|n| a.radius + (b.radius - a.radius) * n as f64 / (INNER + 1) as f64).collect(),
            points: curve[inner.clone()].to_vec(),
            far: far[inner].to_vec(),
            length: curve.windows(2).map(|w| distance(w[1], w[0])).sum(),
        }
    }
}
