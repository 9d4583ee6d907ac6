//! The probability of each state of each node by itself, while the pose is searched: what
//! [`emission`](super::emission::emission) would give with the whole weight on position and direction.
//!
//! Student's t of 8 degrees of freedom in space is a power of 11/2, and that of directions one of 3/2: both need a square root and no
//! logarithm. Tables lie state by state, so that vector instructions serve several at once.

#![expect(clippy::inline_always, reason = "a kernel is compiled as a whole for each instruction set")]

use super::algebra::{Symmetric, normalise, turned};
use super::atlas::Atlas;
use super::emission::{POSITION_FREEDOM, Pose};
use super::nodes::Nodes;
use super::states::{AtlasState, NOWHERE, STATES};
use willis_core::support::geometry::Point;
use willis_core::support::simd::{InstructionSet, Kernel, Simd};

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
    /// For the nodes of a subset in some states; `radius` comes from [`super::emission::radius_fit`] and counts with a weight.
    pub fn new(
        nodes: &'a Nodes,
        atlas: &'a Atlas,
        [subset, states]: [&'a [usize]; 2],
        radius: &[f64],
        radius_weight: f64,
    ) -> Self {
        let of = |node: &usize| &radius[node * STATES..(node + 1) * STATES];
        let weight = |row: &[f64], state: AtlasState| (radius_weight * row[state]).exp() * atlas.prior[state];
        let weight =
            subset.iter().flat_map(|node| states.iter().map(move |state| (of(node), *state))).map(|(row, s)| weight(row, s));
        let weight = weight.collect();
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
