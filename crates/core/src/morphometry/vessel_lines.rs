//! Vessels between junctions as lines: pieces of a network that meet two by two are one vessel.

use crate::network::walks::{Walk, runs, vessels_at};
use crate::network::{Network, Vessel};
use crate::support::{Point, arc_lengths::in_direction, distance, lerp};

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
    /// Its points, m; none where the network has no positions.
    pub points: Vec<Point>,
    /// The radius at each point, m.
    pub radii: Vec<f64>,
    /// Per point the length of the line up to it, m: so long as the pieces say that they are.
    pub at: Vec<f64>,
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
        self.at.reverse();
        self.at.iter_mut().for_each(|at| *at = self.length - *at);
    }

    /// The place on the line at a length from its beginning, or from its end, m.
    pub fn place(&self, length: f64, from_end: bool) -> Option<Point> {
        let wanted = if from_end { self.length - length } else { length };
        // A vessel of no length has one point.
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
        for (at, radii) in self.at.windows(2).zip(self.radii.windows(2)) {
            let [low, high] = [at[0].max(from), at[1].min(to)];
            if low < high {
                let radius = |s: f64| radii[0] + (radii[1] - radii[0]) * (s - at[0]) / (at[1] - at[0]);
                sum += (high - low) * radius(f64::midpoint(low, high));
                length += high - low;
            }
        }
        if length > 0.0 { sum / length } else { self.radii.first().copied().unwrap_or(f64::NAN) }
    }

    fn of(network: &Network, run: Walk) -> Self {
        let (label, ends) = (network.vessel(run.edges[0]).label.clone(), run.ends());
        let mut line = Self { ends, pieces: run.edges, label, length: 0.0, points: vec![], radii: vec![], at: vec![] };
        for (piece, node) in run.nodes[..line.pieces.len()].iter().enumerate() {
            line.add(network, line.pieces[piece], *node);
        }
        // Room for points that it has not is given back: of a million short lines that is as much as the points take.
        line.pieces.shrink_to_fit();
        line.points.shrink_to_fit();
        line.radii.shrink_to_fit();
        line.at.shrink_to_fit();
        line
    }

    /// Adds the points of a piece from `node` on.
    fn add(&mut self, network: &Network, row: usize, node: usize) {
        let (ends, vessel) = (network.ends(row), network.vessel(row));
        let piece = in_direction(points_of(network, ends, vessel), ends[0] == node);
        let steps: Vec<f64> = piece.windows(2).map(|pair| distance(pair[0].0, pair[1].0)).collect();
        let drawn: f64 = steps.iter().sum();
        let scale = if drawn > 0.0 { vessel.length / drawn } else { 0.0 };
        let mut so_far = self.length;
        for (i, (point, radius)) in piece.into_iter().enumerate() {
            so_far += if i > 0 { scale * steps[i - 1] } else { 0.0 };
            if self.points.last() != Some(&point) {
                self.points.push(point);
                self.radii.push(radius);
                self.at.push(so_far);
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

/// The points of a piece with their radii, its nodes included; none without positions.
fn points_of(network: &Network, ends: [usize; 2], vessel: &Vessel) -> Vec<(Point, f64)> {
    let [Some(a), Some(b)] = ends.map(|node| network.node(node).position) else { return Vec::new() };
    let radius = |last: bool| {
        let at = if last { vessel.path.last() } else { vessel.path.first() };
        at.map_or(vessel.radius, |point| point.radius)
    };
    let inner = vessel.path.iter().map(|point| (point.position, point.radius));
    std::iter::once((a, radius(false))).chain(inner).chain([(b, radius(true))]).collect()
}
