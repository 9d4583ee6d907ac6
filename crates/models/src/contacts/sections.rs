//! The lumen: cross-sections, which are the part of a plane inside the mask that a place belongs to, the lumen along each branch end at a cluster, and
//! the tubes that may run from one end to another.

use faer::{Mat, Side};

use super::branches::{BranchEnd, Branches, Cluster};
use willis_core::support::geometry::{Point, area_of, centroid, cross, distance, dot, lerp, norm, radius_of, sub, unit};
use willis_core::support::statistics::median;
use willis_core::support::ties::{near_zero, steady};
use willis_io::masks::Field;

/// Samples across a section.
const PIXELS: usize = 19;
/// The part that counts begins no further from the centre than this share of the half-width.
const NEAREST: f64 = 0.35;
/// A second middle lies further from the first than so many depths of the first.
const APART: f64 = 1.2;
/// Places between two middles where the depth is looked at.
const BETWEEN: usize = 9;

/// A cross-section. Lengths in m.
#[derive(Debug, Clone, Copy, Default)]
pub struct Section {
    /// Its area, m²; zero where the plane misses the lumen.
    pub area: f64,
    /// From the place asked about to the centre of the area.
    pub shift: Point,
    /// The root of its larger second moment over that of the smaller; 1 without an area.
    pub elongation: f64,
    /// The greatest depth further off than the greatest of all, over that one.
    pub second: f64,
    /// The least depth between these two over the lesser; 1 without a second.
    pub saddle: f64,
}

/// Two unit vectors across a direction.
pub fn across(direction: Point) -> [Point; 2] {
    let t = unit(direction);
    let mut axis = [0.0; 3];
    let least = (0..3).min_by(|a, b| near_zero(t[*a].abs()).total_cmp(&near_zero(t[*b].abs()))).unwrap_or(0);
    axis[least] = 1.0;
    let u = unit(cross(t, axis));
    [u, cross(t, u)]
}

/// The section through a place, across a direction, within half a width of it.
pub fn section(field: &Field, place: Point, direction: Point, half: f64) -> Section {
    let [u, v] = across(direction);
    let grid = |n: usize| 2.0 * n as f64 / (PIXELS - 1) as f64 - 1.0;
    let at = |a: usize, b: usize| {
        let (s, t) = (half * grid(a), half * grid(b));
        [0, 1, 2].map(|k| place[k] + s * u[k] + t * v[k])
    };
    // Depths are looked up where the part that counts comes by, which is a small share of the plane.
    let mut depth = vec![f64::NAN; PIXELS * PIXELS];
    let is_inside = |depth: &mut [f64], n: usize| {
        if depth[n].is_nan() {
            depth[n] = field.signed(at(n / PIXELS, n % PIXELS));
        }
        depth[n] > 0.0
    };
    let off = |n: usize| grid(n / PIXELS).powi(2) + grid(n % PIXELS).powi(2);
    let mut near: Vec<usize> = (0..depth.len()).filter(|n| off(*n) < NEAREST * NEAREST).collect();
    near.sort_by(|a, b| off(*a).total_cmp(&off(*b)));
    let Some(start) = near.into_iter().find(|n| is_inside(&mut depth, *n)) else {
        return Section { elongation: 1.0, saddle: 1.0, ..Section::default() };
    };
    let mut own = vec![false; depth.len()];
    own[start] = true;
    let mut open = vec![start];
    while let Some(n) = open.pop() {
        let (a, b) = (n / PIXELS, n % PIXELS);
        for x in a.saturating_sub(1)..=(a + 1).min(PIXELS - 1) {
            for y in b.saturating_sub(1)..=(b + 1).min(PIXELS - 1) {
                let next = x * PIXELS + y;
                if !own[next] && is_inside(&mut depth, next) {
                    own[next] = true;
                    open.push(next);
                }
            }
        }
    }
    let inside: Vec<usize> = (0..own.len()).filter(|n| own[*n]).collect();
    let count = inside.len() as f64;
    let mean = |f: &dyn Fn(usize) -> f64| inside.iter().map(|n| f(*n)).sum::<f64>() / count;
    let pixel = 2.0 / (PIXELS - 1) as f64;
    let (mu, mv) = (mean(&|n| grid(n / PIXELS)), mean(&|n| grid(n % PIXELS)));
    let own_spread = pixel * pixel / 12.0;
    let suu = mean(&|n| (grid(n / PIXELS) - mu).powi(2)) + own_spread;
    let svv = mean(&|n| (grid(n % PIXELS) - mv).powi(2)) + own_spread;
    let suv = mean(&|n| (grid(n / PIXELS) - mu) * (grid(n % PIXELS) - mv));
    let (half_trace, root) = (0.5 * (suu + svv), (0.25 * (suu - svv).powi(2) + suv * suv).sqrt());
    let axes = [half_trace + root, (half_trace - root).max(own_spread / 4.0)].map(|moment| moment.sqrt() * half);
    let deepest = |among: &dyn Fn(usize) -> bool| {
        inside.iter().copied().filter(|n| among(*n)).max_by(|a, b| depth[*a].total_cmp(&depth[*b]).then(b.cmp(a)))
    };
    let first = deepest(&|_| true).unwrap_or(start);
    let place_of = |n: usize| at(n / PIXELS, n % PIXELS);
    let limit = steady(APART * depth[first].max(field.voxel()));
    let (mut second, mut saddle) = (0.0, 1.0);
    if let Some(other) = deepest(&|n| steady(distance(place_of(n), place_of(first))) > limit) {
        let steps = (0..BETWEEN).map(|n| n as f64 / (BETWEEN - 1) as f64);
        let low = steps.map(|s| field.depth(lerp(place_of(first), place_of(other), s))).fold(f64::INFINITY, f64::min);
        second = depth[other] / (depth[first] + 0.1 * field.voxel());
        saddle = low / depth[other].max(f64::MIN_POSITIVE);
    }
    Section {
        area: count * (pixel * half).powi(2),
        shift: [0, 1, 2].map(|k| half * (mu * u[k] + mv * v[k])),
        elongation: axes[0] / axes[1],
        second,
        saddle,
    }
}

/// The variances of places around their mean, and their directions, the least first.
pub fn principal(places: &[Point], mean: Point) -> [(f64, Point); 3] {
    let covariance = Mat::from_fn(3, 3, |i, j| {
        places.iter().map(|p| (p[i] - mean[i]) * (p[j] - mean[j])).sum::<f64>() / places.len().max(1) as f64
    });
    let Ok(found) = covariance.self_adjoint_eigen(Side::Lower) else {
        // Only what is no number has no directions.
        return [(0.0, [1.0, 0.0, 0.0]), (0.0, [0.0, 1.0, 0.0]), (0.0, [0.0, 0.0, 1.0])];
    };
    let (values, vectors) = (found.S(), found.U());
    [0, 1, 2].map(|k| (values[k], [vectors[(0, k)], vectors[(1, k)], vectors[(2, k)]]))
}

/// Sections of an end lie at these multiples of ρ along its course, across the direction over this multiple to either side.
const STATIONS: [f64; 6] = [1.0, 1.5, 2.0, 2.5, 3.0, 3.5];
const SPAN: f64 = 0.5;
/// They are so many radii wide to either side.
pub const HALF_WIDTH: f64 = 3.0;
/// Fewer sections than this do not make an axis.
const LEAST_SECTIONS: usize = 3;
/// Inner points of the tube between two ends.
pub const INNER: usize = 9;
/// Points on a ring around one of them.
pub const AROUND: usize = 8;

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
    pub fn new(field: &Field, branches: &Branches, cluster: &Cluster, end: BranchEnd) -> Self {
        let rho = 1.5 * cluster.radius;
        let course = branches.walk(end, 8.0 * rho);
        let length = course.length();
        let last = STATIONS[STATIONS.len() - 1] * rho;
        let shrunk = if length < 1.1 * last { (0.9 * length / last).min(1.0) } else { 1.0 };
        let radii = course.radii_between(0.6 * rho, 5.0 * rho);
        let typical = median(&radii).unwrap_or(branches.branches[end.branch].radius).max(field.voxel());
        let at = |station: &f64| {
            let s = station * rho * shrunk;
            let direction = course.direction((s - SPAN * rho).max(0.0), (s + SPAN * rho).min(length));
            (course.at(s), section(field, course.at(s), direction, HALF_WIDTH * typical))
        };
        let sections: Vec<(Point, Section)> = STATIONS.iter().map(at).collect();
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
            (there.iter().map(centre).collect(), area, of(&|s| s.elongation).unwrap_or(1.0))
        };
        // The axis: the mean of the centres, and their first principal direction, the way from the first to the last.
        let middle = centroid(centres.iter().copied());
        let [.., (_, axis)] = principal(&centres, middle);
        let onwards = sub(centres[centres.len() - 1], centres[0]);
        let along = if dot(axis, onwards) < 0.0 { axis.map(|x| -x) } else { axis };
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
    /// Points around one of the inner points, on a circle of a radius (m) across the tube.
    pub fn ring(&self, n: usize, radius: f64) -> [Point; AROUND] {
        let (p, [u, v]) = (self.points[n], across(self.tangents[n]));
        std::array::from_fn(|k| {
            let (s, c) = (k as f64 * std::f64::consts::TAU / AROUND as f64).sin_cos();
            [0, 1, 2].map(|x| p[x] + radius * (c * u[x] + s * v[x]))
        })
    }

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
