//! How well each node fits each state of the atlas at a pose: position, direction and radius; and its probability of each by itself.
//!
//! The search of the pose asks for that probability with the whole weight on position and direction. Student's t of 8 degrees of freedom in
//! space is a power of 11/2, and that of directions one of 3/2: both need a square root and no logarithm. Tables lie state by state, so
//! that vector instructions serve several at once.

#![expect(clippy::inline_always, reason = "a kernel is compiled as a whole for each instruction set")]

use serde::{Deserialize, Serialize};

use super::algebra::{Matrix3, Symmetric, normalise, times, trace_of_product, transposed, turned};
use super::atlas::{Atlas, AtlasState, NOWHERE, STATES, row};
use super::{belief::NamingForest, nodes::Nodes};
use willis_core::support::geometry::{Point, sub};
use willis_core::support::simd::{InstructionSet, Kernel, Simd};

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
        times(&transposed(&self.turn), sub(y, self.shift).map(|x| x / scale))
    }
}

/// The weights of position, direction and radius in the sum of log likelihoods that name best: radii are noisy.
pub const ALL_PARTS: [f64; 3] = [0.7, 1.0, 0.7];
/// Nodes 1 mm apart are not independent: the share of its log likelihood that a node counts for.
pub const TEMPER: f64 = 0.3;
/// Degrees of freedom of Student's t for the position: outliers are no proof.
pub const POSITION_FREEDOM: f64 = 8.0;
/// Those for the log radius.
const RADIUS_FREEDOM: f64 = 4.0;

/// The log likelihood of the radius of each node in each state: nodes x states. It does not depend on the pose.
fn radius_fit(nodes: &Nodes, atlas: &Atlas, median_log_radius: f64) -> Vec<f64> {
    let mut fit = vec![0.0; nodes.len() * STATES];
    let student = |z: f64, spread: f64| -spread.ln() - 0.5 * (RADIUS_FREEDOM + 1.0) * (1.0 + z * z / RADIUS_FREEDOM).ln();
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

/// A case to be posed and named, with what does not depend on the pose.
pub struct Search<'a> {
    /// The nodes.
    pub nodes: &'a Nodes,
    /// The atlas.
    pub atlas: &'a Atlas,
    /// How probable it is that each node is part of the circle's arteries at all; its length counts that much.
    pub weight: &'a [f64],
    /// The bridges of the forest.
    pub used: &'a [usize],
    /// The median log radius.
    pub median: f64,
    /// The log likelihood of the radius of each node in each state: nodes x states.
    pub radius: Vec<f64>,
    /// The forest of names.
    pub forest: NamingForest,
}

impl<'a> Search<'a> {
    /// The search by nodes that count by some weights, with the bridges that are `used`, given the median log radius.
    pub fn new(nodes: &'a Nodes, atlas: &'a Atlas, weight: &'a [f64], used: &'a [usize], median: f64) -> Self {
        let (radius, forest) = (radius_fit(nodes, atlas, median), NamingForest::of(nodes, used));
        Self { nodes, atlas, weight, used, median, radius, forest }
    }

    /// The share of [`Search::emission`] with all parts that a node counts for: nodes x states.
    pub fn tempered(&self, fit: &PoseFit) -> Vec<f64> {
        self.emission(fit, ALL_PARTS).into_iter().map(|x| TEMPER * x).collect()
    }

    /// The log likelihood of all nodes in all states: nodes x states. Position, direction and radius have weights.
    pub fn emission(&self, fit: &PoseFit, [of_position, of_direction, of_radius]: [f64; 3]) -> Vec<f64> {
        let each = fit.position.iter().zip(&fit.direction).zip(&self.radius);
        each.map(|((position, direction), radius)| of_position * position + of_radius * radius + of_direction * direction)
            .collect()
    }

    /// How all nodes fit all states at a pose. `precisions` are those of the atlas, possibly widened ([`Atlas::widened`]).
    pub fn fit(&self, pose: &Pose, precisions: &[(Symmetric, f64)]) -> PoseFit {
        let (atlas, nodes) = (self.atlas, self.nodes);
        let [mut position, mut direction] = [(); 2].map(|()| vec![0.0; nodes.len() * STATES]);
        let constant = -1.5 * (2.0 * std::f64::consts::PI).ln();
        let rows = position.chunks_mut(STATES).zip(direction.chunks_mut(STATES));
        for (node, (position, direction)) in rows.enumerate() {
            let at = pose.apply(nodes.at[node]);
            let runs = turned(&pose.turn, &nodes.direction[node]);
            for (state, (precision, log_determinant)) in precisions.iter().enumerate() {
                let d = sub(at, atlas.data.pieces[state].mean);
                let square = quadratic(precision, d).max(0.0);
                position[state] =
                    -0.5 * log_determinant - 0.5 * (POSITION_FREEDOM + 3.0) * (1.0 + square / POSITION_FREEDOM).ln() + constant;
                let (inverse, log_determinant) = &atlas.direction[state];
                direction[state] = -0.5 * log_determinant - 1.5 * trace_of_product(&runs, inverse).ln();
            }
            position[NOWHERE] = atlas.log_other;
        }
        PoseFit { position, direction }
    }
}

/// How all nodes fit all states at a pose, but for their radius: log likelihoods, nodes x states. No direction fits no artery better than
/// another.
pub struct PoseFit {
    /// Of the positions.
    pub position: Vec<f64>,
    /// Of the directions.
    pub direction: Vec<f64>,
}

/// dᵀ S d.
fn quadratic(s: &Symmetric, d: Point) -> f64 {
    d[0] * d[0] * s[0]
        + d[1] * d[1] * s[1]
        + d[2] * d[2] * s[2]
        + 2.0 * (d[0] * d[1] * s[3] + d[0] * d[2] * s[4] + d[1] * d[2] * s[5])
}

/// What does not depend on the pose, for some nodes and some states, [`NOWHERE`] the last of them.
pub struct Single<'a> {
    nodes: &'a Nodes,
    atlas: &'a Atlas,
    subset: &'a [usize],
    states: &'a [AtlasState],
    /// The weight of each state of each node by its radius and its prior: nodes x states.
    weight: Vec<f64>,
    /// The direction matrices, each entry over the states.
    along: [Vec<f64>; 6],
    instructions: InstructionSet,
}

/// The positions of states, widened.
pub struct StatePlaces {
    mean: [Vec<f64>; 3],
    precision: [Vec<f64>; 6],
    /// What the determinants say.
    scale: Vec<f64>,
}

impl<'a> Single<'a> {
    /// For the nodes of a subset in some states; the radius counts with a weight.
    pub fn new(case: &Search<'a>, [subset, states]: [&'a [usize]; 2], radius_weight: f64) -> Self {
        let (nodes, atlas) = (case.nodes, case.atlas);
        let mut weight = Vec::with_capacity(subset.len() * states.len());
        for node in subset {
            let radius = row(&case.radius, *node);
            weight.extend(states.iter().map(|state| (radius_weight * radius[*state]).exp() * atlas.prior[*state]));
        }
        let along = std::array::from_fn(|k| arteries(states).map(|state| atlas.direction[state].0[k]).collect());
        Self { nodes, atlas, subset, states, weight, along, instructions: InstructionSet::detect() }
    }

    /// The positions of the states at some precisions of the atlas.
    pub fn places(&self, precisions: &[(Symmetric, f64)]) -> StatePlaces {
        let states = || arteries(self.states);
        let normal = (2.0 * std::f64::consts::PI).powf(-1.5);
        StatePlaces {
            mean: std::array::from_fn(|k| states().map(|state| self.atlas.data.pieces[state].mean[k]).collect()),
            precision: std::array::from_fn(|k| states().map(|state| precisions[state].0[k]).collect()),
            scale: states().map(|s| normal * (-0.5 * (precisions[s].1 + self.atlas.direction[s].1)).exp()).collect(),
        }
    }

    /// The probabilities of the states (nodes x states) at a pose, and the sum over the nodes of the logarithms of what they were divided by.
    pub fn probabilities(&self, pose: &Pose, places: &StatePlaces) -> (Vec<f64>, f64) {
        let other = self.atlas.log_other.exp();
        let mut log = 0.0;
        let mut all = vec![0.0; self.weight.len()];
        let rows = all.chunks_mut(self.states.len()).zip(self.weight.chunks(self.states.len()));
        for (node, (row, weight)) in self.subset.iter().zip(rows) {
            let direction = turned(&pose.turn, &self.nodes.direction[*node]);
            let last = row.len() - 1;
            let (arteries, nowhere) = row.split_at_mut(last);
            let at = pose.apply(self.nodes.at[*node]);
            self.instructions.run(Fit { at, direction, weight: &weight[..last], places, along: &self.along, out: arteries });
            nowhere[0] = weight[last] * other;
            log += normalise(row).ln();
        }
        (all, log)
    }
}

fn arteries(states: &[AtlasState]) -> impl Iterator<Item = AtlasState> + '_ {
    states.iter().copied().filter(|state| *state != NOWHERE)
}

/// The weights of the states of one node.
struct Fit<'a> {
    at: Point,
    direction: Symmetric,
    weight: &'a [f64],
    places: &'a StatePlaces,
    along: &'a [Vec<f64>; 6],
    out: &'a mut [f64],
}

impl Kernel for Fit<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let n = self.out.len();
        let StatePlaces { mean, precision, scale } = self.places;
        let [x, y, z] = [0, 1, 2].map(|k| &mean[k][..n]);
        let [a, b, c, d, e, f] = [0, 1, 2, 3, 4, 5].map(|k| &precision[k][..n]);
        let [t, u, v, p, q, r] = [0, 1, 2, 3, 4, 5].map(|k| &self.along[k][..n]);
        let (weight, scale, at, s) = (&self.weight[..n], &scale[..n], self.at, self.direction);
        for i in 0..n {
            let [dx, dy, dz] = [at[0] - x[i], at[1] - y[i], at[2] - z[i]];
            let cross = dx * dy * d[i] + dx * dz * e[i] + dy * dz * f[i];
            let square = dx * dx * a[i] + dy * dy * b[i] + dz * dz * c[i] + 2.0 * cross;
            let place = 1.0 + square.max(0.0) / POSITION_FREEDOM;
            let diagonal = s[0] * t[i] + s[1] * u[i] + s[2] * v[i];
            let trace = diagonal + 2.0 * (s[3] * p[i] + s[4] * q[i] + s[5] * r[i]);
            let squared = place * place;
            self.out[i] = weight[i] * scale[i] / (squared * squared * place * trace * (place * trace).sqrt());
        }
    }
}
