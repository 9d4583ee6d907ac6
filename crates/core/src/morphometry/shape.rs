//! Lengths, widths and bends of a vessel.
//!
//! A course is smoothed before its bends are measured: around each station a polynomial of fourth degree is fitted to the points within
//! the smoothing length, weighted by the line that each stands for and by (1 - u²)², u the distance in smoothing lengths. So a circle
//! keeps its curvature, which a running mean would take from it. Definitions: Bullitt et al. 2003, doi:10.1109/TMI.2003.816964.

use std::f64::consts::PI;

use super::VesselLine;
use crate::support::{Point, cross, distance, dot, norm, norm_squared, normal_equations::solve, sub, unit};

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

/// Lengths, widths and bends of a vessel, in SI units; no number where a network has no positions.
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
            least_radius: line.radii.iter().copied().fold(f64::NAN, f64::min),
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
    for (at, radii) in line.at.windows(2).zip(line.radii.windows(2)) {
        let (step, [a, b]) = (at[1] - at[0], [radii[0], radii[1]]);
        sum[0] += PI / 3.0 * step * (a * a + a * b + b * b);
        sum[1] += PI * (a + b) * step.hypot(a - b);
    }
    sum
}

/// Minus the slope of the radius along a line by least squares, each point weighted by the line it stands for.
fn taper(line: &VesselLine) -> f64 {
    let weights = shares(&line.at);
    let total: f64 = weights.iter().sum();
    let mean = |of: &[f64]| of.iter().zip(&weights).map(|(x, w)| x * w).sum::<f64>() / total;
    let [at, radius] = [mean(&line.at), mean(&line.radii)];
    let (mut both, mut square) = (0.0, 0.0);
    for ((s, r), w) in line.at.iter().zip(&line.radii).zip(&weights) {
        both += w * (s - at) * (r - radius);
        square += w * (s - at) * (s - at);
    }
    -both / square
}

/// The length of line that each point stands for: half of the step before it and half of the one after.
fn shares(at: &[f64]) -> Vec<f64> {
    let step = |i: usize| if i + 1 < at.len() { 0.5 * (at[i + 1] - at[i]) } else { 0.0 };
    (0..at.len()).map(|i| step(i) + if i > 0 { step(i - 1) } else { 0.0 }).collect()
}

/// How a smoothed course bends: means of the curvature, of the size of the torsion, and of the angles metric; and the number of inflections.
fn bends(line: &VesselLine, within: f64) -> ([f64; 3], usize) {
    let count = line.points.len();
    if count < 2 || !(line.length > 0.0 && within > 0.0) {
        return ([f64::NAN; 3], 0);
    }
    let weights = shares(&line.at);
    let stations = ((STATIONS * line.length / within).ceil() as usize).clamp(2, STATIONS as usize * count + 2);
    let (mut sums, mut inflections, mut normal) = ([0.0; 3], 0, None::<Point>);
    for station in 0..stations {
        let [velocity, second, third] =
            derivatives(line, &weights, line.length * (station as f64 + 0.5) / stations as f64, within);
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
fn derivatives(line: &VesselLine, weights: &[f64], at: f64, within: f64) -> [Point; 3] {
    let last = line.at.len() - 1;
    let (mut low, mut high) = (line.at.partition_point(|s| *s < at - within), line.at.partition_point(|s| *s <= at + within));
    // The nearest others, where too few points are within reach.
    while high - low < LEAST_POINTS.min(last + 1) {
        let [before, after] = [low.checked_sub(1).map(|i| at - line.at[i]), (high <= last).then(|| line.at[high] - at)];
        match (before, after) {
            (Some(before), Some(after)) if before < after => low -= 1,
            (Some(_), None) => low -= 1,
            _ => high += 1,
        }
    }
    let reach = within.max(1.000_001 * (at - line.at[low]).max(line.at[high - 1] - at));
    let terms = TERMS.min(high - low);
    let (mut normal, mut moments) = ([[0.0; TERMS]; TERMS], [[0.0; 3]; TERMS]);
    let origin = line.points[low];
    for ((at_point, point), share) in line.at[low..high].iter().zip(&line.points[low..high]).zip(&weights[low..high]) {
        let u = (at_point - at) / reach;
        let weight = share * (1.0 - u * u).max(1e-3).powi(2);
        let mut powers = [1.0; TERMS];
        for k in 1..TERMS {
            powers[k] = powers[k - 1] * u;
        }
        for ((row, moment), power) in normal.iter_mut().zip(&mut moments).zip(powers) {
            for (cell, other) in row.iter_mut().zip(powers) {
                *cell += weight * power * other;
            }
            for axis in 0..3 {
                moment[axis] += weight * power * (point[axis] - origin[axis]);
            }
        }
    }
    let solved = solve(normal, moments, terms);
    let of = |term: usize, factor: f64| {
        // Without a term it is zero.
        solved[term].map(|x| x * factor / reach.powi(term as i32))
    };
    [of(1, 1.0), of(2, 2.0), of(3, 6.0)]
}
