//! How well each node fits each state of the atlas at a pose: position, direction and radius.

use serde::{Deserialize, Serialize};

use super::algebra::{Matrix3, Symmetric, times, trace_of_product, turned};
use super::atlas::Atlas;
use super::nodes::Nodes;
use super::states::{NOWHERE, STATES};
use willis_core::support::geometry::{Point, sub};

/// How a case lies in the atlas: y = e^scale R x + t, in mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// R.
    pub turn: Matrix3,
    /// t, mm.
    pub shift: Point,
    /// The logarithm of the scale.
    pub log_scale: f64,
}

impl Pose {
    /// A position in the atlas.
    pub fn apply(&self, x: Point) -> Point {
        let y = times(&self.turn, x);
        let scale = self.log_scale.exp();
        [0, 1, 2].map(|k| scale * y[k] + self.shift[k])
    }

    /// The position in the case of a position in the atlas.
    pub fn undo(&self, y: Point) -> Point {
        let scale = self.log_scale.exp();
        super::algebra::transposed_times(&self.turn, sub(y, self.shift).map(|x| x / scale))
    }
}

/// The weights of position, direction and radius in the sum of log likelihoods.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// Of the position.
    pub position: f64,
    /// Of the direction.
    pub direction: f64,
    /// Of the radius.
    pub radius: f64,
}

impl Parts {
    /// All, in the proportions that name best: radii are noisy.
    pub const ALL: Self = Self { position: 0.7, direction: 1.0, radius: 0.7 };
    /// For the search of the pose, in which radii count less.
    pub const SEARCH: Self = Self { position: 1.0, direction: 1.0, radius: 0.5 };
    /// For the refinement of the pose.
    pub const REFINE: Self = Self { position: 1.0, direction: 1.0, radius: 1.0 };
}

/// Nodes 1 mm apart are not independent: the share of its log likelihood that a node counts for.
pub const TEMPER: f64 = 0.3;
/// Degrees of freedom of Student's t for the position: outliers are no proof.
pub const POSITION_FREEDOM: f64 = 8.0;
/// Those for the log radius.
const RADIUS_FREEDOM: f64 = 4.0;

/// The log likelihood of the radius of each node in each state: nodes x states. It does not depend on the pose.
pub fn radius_fit(nodes: &Nodes, atlas: &Atlas, median_log_radius: f64) -> Vec<f64> {
    let mut fit = vec![0.0; nodes.len() * STATES];
    let student = |z: f64, spread: f64| -spread.ln() - 0.5 * (RADIUS_FREEDOM + 1.0) * (z * z / RADIUS_FREEDOM).ln_1p();
    for (log_radius, row) in nodes.log_radius.iter().zip(fit.chunks_mut(STATES)) {
        let relative = log_radius - median_log_radius;
        for (piece, to) in atlas.data.pieces.iter().zip(row.iter_mut()) {
            *to = student((relative - piece.log_radius) / piece.radius_spread, piece.radius_spread);
        }
        let [mean, spread] = atlas.data.other_radius;
        row[NOWHERE] = student((relative - mean) / spread, spread);
    }
    fit
}

/// The share of [`emission`] with all parts that a node counts for: nodes x states.
pub fn tempered(nodes: &Nodes, atlas: &Atlas, pose: &Pose, precisions: &[(Symmetric, f64)], radius: &[f64]) -> Vec<f64> {
    emission(nodes, atlas, pose, precisions, Parts::ALL, radius).into_iter().map(|x| TEMPER * x).collect()
}

/// The log likelihood of all nodes in all states at a pose: nodes x states. `precisions` are those of the atlas,
/// possibly widened ([`Atlas::widened`]); `radius` comes from [`radius_fit`].
pub fn emission(
    nodes: &Nodes,
    atlas: &Atlas,
    pose: &Pose,
    precisions: &[(Symmetric, f64)],
    parts: Parts,
    radius: &[f64],
) -> Vec<f64> {
    let mut fit = vec![0.0; nodes.len() * STATES];
    let constant = -1.5 * (2.0 * std::f64::consts::PI).ln();
    for (node, row) in fit.chunks_mut(STATES).enumerate() {
        let at = pose.apply(nodes.at[node]);
        let direction = turned(&pose.turn, &nodes.direction[node]);
        let radius = &radius[node * STATES..(node + 1) * STATES];
        for (state, to) in row.iter_mut().enumerate() {
            if state == NOWHERE {
                *to = parts.position * atlas.log_other + parts.radius * radius[NOWHERE];
                continue;
            }
            let (precision, log_determinant) = &precisions[state];
            let d = sub(at, atlas.data.pieces[state].mean);
            let square = quadratic(precision, d).max(0.0);
            let position =
                -0.5 * log_determinant - 0.5 * (POSITION_FREEDOM + 3.0) * (square / POSITION_FREEDOM).ln_1p() + constant;
            let mut sum = parts.position * position + parts.radius * radius[state];
            if parts.direction > 0.0 {
                let (inverse, log_determinant) = &atlas.direction[state];
                let along = -0.5 * log_determinant - 1.5 * trace_of_product(&direction, inverse).ln();
                sum += parts.direction * along;
            }
            *to = sum;
        }
    }
    fit
}

/// dᵀ S d.
fn quadratic(s: &Symmetric, d: Point) -> f64 {
    d[0] * d[0] * s[0]
        + d[1] * d[1] * s[1]
        + d[2] * d[2] * s[2]
        + 2.0 * (d[0] * d[1] * s[3] + d[0] * d[2] * s[4] + d[1] * d[2] * s[5])
}
