//! Vessels between junctions as lines: pieces of a network that meet two by two are one vessel. Lengths, widths and bends of each.
//!
//! A course is smoothed before its bends are measured: around each station a polynomial of fourth degree is fitted to the line within
//! the smoothing length, all of it and not only its points, weighted by (1 - u²)², u the distance in smoothing lengths. So a circle
//! keeps its curvature, which a running mean would take from it. Definitions: Bullitt et al. 2003, doi:10.1109/TMI.2003.816964.

use std::f64::consts::PI;

use crate::network::walks::{Walk, runs, vessels_at};
use crate::network::{Network, Vessel};
use crate::support::normal_equations::{normal_equations, solve};
use crate::support::{
    Point, arc_lengths::arc_lengths, arc_lengths::in_direction, cross, distance, dot, lerp, norm, norm_squared, sub, unit,
};

/// A vessel between two junctions or ends, as a line of points.
#[derive(Debug, Clone, PartialEq)]
pub struct VesselLine {
    /// The rows of its two nodes.
    pub ends: [usize; 2],
    /// The rows of its pieces in the network, in order.
    pub pieces: Vec<usize>,
    /// Its name.
    pub label: String,
    /// The sum of the lengths of its pieces, m.
    pub length: f64,
    /// Its points, m; none where one of its nodes has no position.
    pub points: Vec<Point>,
    /// Per point, or per end of a piece where there are none, the radius before it and behind it, m: two where pieces of different widths meet.
    pub radii: Vec<[f64; 2]>,
    /// For the same the length of the line up to there, m: so long as the pieces say that they are.
    pub at: Vec<f64>,
}

/// What lies between two points of a line.
pub(super) struct Stretch {
    /// The lengths of the line up to its two ends, m.
    pub at: [f64; 2],
    /// The radii there, m.
    pub radii: [f64; 2],
}

/// A stretch at an end whose radius is that of the end, in radii.
const END_RADII: f64 = 4.0;

impl VesselLine {
    /// The same line from its last point to its first.
    pub fn turn(&mut self) {
        self.ends.reverse();
        self.pieces.reverse();
        self.points.reverse();
        self.radii.reverse();
        self.radii.iter_mut().for_each(|radii| radii.reverse());
        self.at.reverse();
        self.at.iter_mut().for_each(|at| *at = self.length - *at);
    }

    /// The stretches between its points, in order.
    pub(super) fn stretches(&self) -> impl Iterator<Item = Stretch> {
        let pairs = self.at.windows(2).zip(self.radii.windows(2));
        pairs.map(|(at, radii)| Stretch { at: [at[0], at[1]], radii: [radii[0][1], radii[1][0]] })
    }

    /// The place on the line at a length from its beginning, or from its end, m.
    pub fn place(&self, length: f64, from_end: bool) -> Option<Point> {
        let wanted = if from_end { self.length - length } else { length };
        let last = self.points.len().checked_sub(1)?;
        let next = self.at.partition_point(|at| *at < wanted).max(1).min(last);
        let [a, b] = [next.saturating_sub(1), next];
        let step = self.at[b] - self.at[a];
        let share = if step > 0.0 { ((wanted - self.at[a]) / step).clamp(0.0, 1.0) } else { 0.0 };
        Some(lerp(self.points[a], self.points[b], share))
    }

    /// The mean radius over its length, m.
    pub fn radius(&self) -> f64 {
        self.radius_between(0.0, self.length)
    }

    /// The mean radius over the first or last four radii, m.
    pub fn end_radius(&self, last: bool) -> f64 {
        let stretch = (END_RADII * self.radius()).min(self.length);
        if last { self.radius_between(self.length - stretch, self.length) } else { self.radius_between(0.0, stretch) }
    }

    /// The mean radius over a stretch of it, m; that at its beginning for a stretch of no length.
    pub fn radius_between(&self, from: f64, to: f64) -> f64 {
        let (mut sum, mut length) = (0.0, 0.0);
        for Stretch { at, radii } in self.stretches() {
            let [low, high] = [at[0].max(from), at[1].min(to)];
            if low < high {
                let radius = |s: f64| radii[0] + (radii[1] - radii[0]) * (s - at[0]) / (at[1] - at[0]);
                sum += (high - low) * radius(f64::midpoint(low, high));
                length += high - low;
            }
        }
        if length > 0.0 { sum / length } else { self.radii.first().map_or(f64::NAN, |radii| radii[1]) }
    }

    fn of(network: &Network, run: Walk) -> Self {
        let (label, ends) = (network.vessel(run.edges[0]).label.clone(), run.ends());
        let mut line = Self { ends, pieces: run.edges, label, length: 0.0, points: vec![], radii: vec![], at: vec![] };
        let is_placed = run.nodes.iter().all(|node| network.node(*node).position.is_some());
        for (piece, node) in run.nodes[..line.pieces.len()].iter().enumerate() {
            line.add(network, line.pieces[piece], *node, is_placed);
        }
        if !is_placed {
            line.points.clear();
        }
        // Room for points that it has not is given back: of a million short lines that is as much as the points take.
        line.pieces.shrink_to_fit();
        line.points.shrink_to_fit();
        line.radii.shrink_to_fit();
        line.at.shrink_to_fit();
        line
    }

    /// Adds the points of a piece from `node` on; where not all are placed, only its length and its radius count.
    fn add(&mut self, network: &Network, row: usize, node: usize, is_placed: bool) {
        let (ends, vessel) = (network.ends(row), network.vessel(row));
        let piece = if is_placed { points_of(network, ends, vessel) } else { vec![([0.0; 3], vessel.radius); 2] };
        let piece = in_direction(piece, ends[0] == node);
        let drawn: f64 = piece.windows(2).map(|pair| distance(pair[0].0, pair[1].0)).sum();
        let mut so_far = self.length;
        for (i, (point, radius)) in piece.iter().enumerate() {
            let step = match i.checked_sub(1) {
                Some(before) if drawn > 0.0 => vessel.length / drawn * distance(piece[before].0, *point),
                // Where nothing is drawn all of the length lies before the last point.
                Some(_) if i + 1 == piece.len() => vessel.length,
                _ => 0.0,
            };
            so_far += step;
            if self.points.last() != Some(point) || step > 0.0 {
                self.points.push(*point);
                self.radii.push([*radius; 2]);
                self.at.push(so_far);
            } else if let Some(radii) = self.radii.last_mut().filter(|_| i == 0) {
                radii[1] = *radius;
            }
        }
        self.length += vessel.length;
    }
}

/// The vessels of a network as lines; none goes on beyond a node that `stops` it.
pub fn vessel_lines(network: &Network, stops: impl Fn(usize) -> bool) -> Vec<VesselLine> {
    let at = vessels_at(network, |_| true);
    let passes = |node: usize| match *at[node] {
        [a, b] => a != b && network.vessel(a).label == network.vessel(b).label && !stops(node),
        _ => false,
    };
    runs(network, &at, passes).into_iter().map(|run| VesselLine::of(network, run)).collect()
}

/// The points of a piece with their radii, its nodes included.
fn points_of(network: &Network, ends: [usize; 2], vessel: &Vessel) -> Vec<(Point, f64)> {
    let [a, b] = ends.map(|node| network.node(node).position.unwrap_or_default());
    let radius = |last: bool| {
        let at = if last { vessel.path.last() } else { vessel.path.first() };
        at.map_or(vessel.radius, |point| point.radius)
    };
    let inner = vessel.path.iter().map(|point| (point.position, point.radius));
    std::iter::once((a, radius(false))).chain(inner).chain([(b, radius(true))]).collect()
}

/// The usual smoothing length in radii of the vessel: its course is not known finer than it is wide.
pub const SMOOTHING: f64 = 6.0;
/// Stations within a smoothing length.
const STATIONS: f64 = 8.0;
/// A course that turns by less than this within a smoothing length, rad, has no normal.
const STRAIGHT: f64 = 0.25;
/// Coefficients of the polynomial.
const TERMS: usize = 5;
/// So many points are fitted at least, where there are so many.
const LEAST_POINTS: usize = 7;
/// The line is fitted in parts of at most one in so many of the reach.
const PARTS: f64 = 4.0;
/// The two places of Gauss on a part: its middle, less and more 1/√12 of it.
const GAUSS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];
/// A point so near to the one before it, in smoothing lengths, says nothing about the course.
const SAME_PLACE: f64 = 1e-3;

/// Over which length a course is smoothed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Smoothing {
    /// So many radii of each vessel.
    Radii(f64),
    /// So many m.
    Length(f64),
}

impl Default for Smoothing {
    fn default() -> Self {
        Self::Radii(SMOOTHING)
    }
}

/// Lengths, widths and bends of a vessel, in SI units; no number for a chord and bends without positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselShape {
    /// Between its two ends, m.
    pub chord: f64,
    /// The mean over its length, m.
    pub radius: f64,
    /// The least, m.
    pub least_radius: f64,
    /// How much narrower it gets per length, by least squares.
    pub taper: f64,
    /// Of cones between its points, m³.
    pub volume: f64,
    /// The lateral surface of those cones, m².
    pub surface: f64,
    /// The distance metric: length over chord.
    pub distance_metric: f64,
    /// The inflection count metric: so many inflections and one, times the distance metric.
    pub inflection_count_metric: f64,
    /// The sum of angles metric in the limit of dense points, the mean of sqrt(κ² + τ²), rad/m.
    pub sum_of_angles_metric: f64,
    /// The mean curvature, 1/m.
    pub curvature: f64,
    /// The mean size of the torsion, 1/m; zero where the course is straight.
    pub torsion: f64,
}

impl VesselShape {
    /// Measures a line.
    pub fn of(line: &VesselLine, smoothing: Smoothing) -> Self {
        let radius = line.radius();
        let [volume, surface] = cones(line);
        let chord = match (line.points.first(), line.points.last()) {
            (Some(a), Some(b)) => distance(*a, *b),
            _ => f64::NAN,
        };
        let distance_metric = if chord > 0.0 { line.length / chord } else { f64::NAN };
        let within = match smoothing {
            Smoothing::Radii(radii) => radii * radius,
            Smoothing::Length(length) => length,
        };
        let ([curvature, torsion, sum_of_angles_metric], inflections) = bends(line, within);
        Self {
            chord,
            radius,
            least_radius: line.radii.iter().flatten().copied().fold(f64::NAN, f64::min),
            taper: taper(line),
            volume,
            surface,
            distance_metric,
            inflection_count_metric: (inflections + 1) as f64 * distance_metric,
            sum_of_angles_metric,
            curvature,
            torsion,
        }
    }
}

/// The volume and the lateral surface of the cones between the points of a line.
pub(super) fn cones(line: &VesselLine) -> [f64; 2] {
    let mut sum = [0.0; 2];
    for Stretch { at, radii: [a, b] } in line.stretches() {
        let step = at[1] - at[0];
        sum[0] += PI / 3.0 * step * (a * a + a * b + b * b);
        sum[1] += PI * (a + b) * step.hypot(a - b);
    }
    sum
}

/// Minus the slope of the radius along a line by least squares, where it is a straight line from point to point.
fn taper(line: &VesselLine) -> f64 {
    let (radius, middle) = (line.radius(), 0.5 * line.length);
    let (mut both, mut square) = (0.0, 0.0);
    for Stretch { at, radii } in line.stretches() {
        let [s, r] = [at.map(|s| s - middle), radii.map(|r| r - radius)];
        // Simpson's rule is right for products of two straight lines.
        let integral =
            |a: [f64; 2], b: [f64; 2]| (at[1] - at[0]) / 6.0 * (a[0] * b[0] + a[1] * b[1] + (a[0] + a[1]) * (b[0] + b[1]));
        both += integral(s, r);
        square += integral(s, s);
    }
    // Of no taper the sign is none.
    (0.0 - both) / square
}

/// How a smoothed course bends: means of the curvature, of the size of the torsion, and of the angles metric; and the number of inflections.
fn bends(line: &VesselLine, within: f64) -> ([f64; 3], usize) {
    let mut points: Vec<Point> = line.points.clone();
    points.dedup_by(|next, last| distance(*last, *next) <= SAME_PLACE * within);
    if points.len() < 2 || !(line.length > 0.0 && within > 0.0) {
        return ([f64::NAN; 3], 0);
    }
    let at = arc_lengths(points.iter().copied());
    let length = at[at.len() - 1];
    let stations = ((STATIONS * length / within).ceil() as usize).clamp(2, STATIONS as usize * points.len() + 2);
    let (mut sums, mut inflections, mut normal) = ([0.0; 3], 0, None::<Point>);
    for station in 0..stations {
        let middle = length * (station as f64 + 0.5) / stations as f64;
        let [velocity, second, third] = derivatives(&at, &points, middle, within);
        let turning = cross(velocity, second);
        let speed = norm(velocity);
        let curvature = norm(turning) / speed.powi(3);
        let mut torsion = 0.0;
        if curvature * within >= STRAIGHT {
            torsion = dot(turning, third) / norm_squared(turning);
            let along = dot(second, velocity) / (speed * speed);
            let new = unit(sub(second, velocity.map(|x| along * x)));
            inflections += usize::from(normal.is_some_and(|old| norm_squared(sub(new, old)) > 1.0));
            normal = Some(new);
        }
        for (sum, x) in sums.iter_mut().zip([curvature, torsion.abs(), curvature.hypot(torsion)]) {
            *sum += x / stations as f64;
        }
    }
    (sums, inflections)
}

/// The first three derivatives of the smoothed course at a length along it, by that length.
fn derivatives(lengths: &[f64], points: &[Point], at: f64, within: f64) -> [Point; 3] {
    let last = lengths.len() - 1;
    let (mut low, mut high) = (lengths.partition_point(|s| *s < at - within), lengths.partition_point(|s| *s <= at + within));
    // The nearest others, where too few points are within reach.
    while high - low < LEAST_POINTS.min(last + 1) {
        let [before, after] = [low.checked_sub(1).map(|i| at - lengths[i]), (high <= last).then(|| lengths[high] - at)];
        let is_before = before.is_some_and(|before| after.is_none_or(|after| before < after));
        if is_before { low -= 1 } else { high += 1 }
    }
    let reach = within.max(1.000_001 * (at - lengths[low]).max(lengths[high - 1] - at));
    let terms = TERMS.min(high - low);
    // Each step from point to point, as far as it lies within reach, in parts that are short beside it; of each part the two places of Gauss.
    let rows = (low.max(1) - 1..high.min(last)).flat_map(|i| {
        let step = lengths[i + 1] - lengths[i];
        let [from, to] = [lengths[i].max(at - reach), lengths[i + 1].min(at + reach)];
        let parts = (PARTS * (to - from) / reach).ceil().max(1.0);
        let part = (to - from) / parts;
        let places = (0..2 * parts as usize).map(move |k| from + part * ((k / 2) as f64 + GAUSS[k % 2]));
        places.map(move |s| {
            let u = (s - at) / reach;
            let mut powers = [1.0; TERMS];
            for k in 1..TERMS {
                powers[k] = powers[k - 1] * u;
            }
            let place = lerp(points[i], points[i + 1], (s - lengths[i]) / step);
            (part * (1.0 - u * u).powi(2), powers, sub(place, points[low]))
        })
    });
    let (normal, moments) = normal_equations(rows);
    let solved = solve(normal, moments, terms);
    let of = |term: usize, factor: f64| {
        // Without a term it is zero.
        solved[term].map(|x| x * factor / reach.powi(term as i32))
    };
    [of(1, 1.0), of(2, 2.0), of(3, 6.0)]
}
