//! Fits the atlas: poses of the whole tracings and distributions of the states in turn, with mirror images; then what follows what.

use std::collections::BTreeMap;

use super::cases::{LabelledCase, LabelledNodes};
use willis_core::support::geometry::{Point, centroid, sub, weighted_centroid};
use willis_models::circle_of_willis::{Artery, BodySide};
use willis_models::naming::algebra::{outer, rotation, turned};
use willis_models::naming::atlas::{
    Atlas, AtlasData, AtlasPiece, AtlasState, BA, NOWHERE, OTHER, STATES, StatePair, StateTables, StatesOfArms, all_states,
    first_state, label_of,
};
use willis_models::naming::emission::{Pose, Search};
use willis_models::naming::pose::Pulls;

/// Rounds of distributions and poses.
const ROUNDS: usize = 5;
/// Steps of a pose in a round.
const POSE_STEPS: usize = 3;
/// So many nodes of a tracing count as one.
const DEPENDENT: f64 = 8.0;
/// Pseudo-counts of a variance, and that variance in mm².
const PSEUDO: f64 = 3.0;
const PSEUDO_VARIANCE: f64 = 9.0;
/// A whole tracing counts for as many neighbours as the broken ones, of which there may be many, divided by this.
const BROKEN: f64 = 3.0;
/// A state of fewer nodes has no distribution of its own.
const LEAST_NODES: usize = 6;
/// The share of no direction at all.
const NO_DIRECTION: f64 = 0.05;
/// Half the distance of the carotid bifurcations, mm.
const HALF_WIDTH: f64 = 11.0;

/// A whole tracing in the making of the atlas.
struct Posed<'a> {
    truth: &'a LabelledNodes,
    pose: Pose,
    median: f64,
    /// The states as probabilities, for the step of a pose.
    known: Vec<f64>,
}

/// What an observation of a state adds.
#[derive(Clone, Copy)]
struct Observed {
    at: Point,
    direction: [f64; 6],
    log_radius: f64,
    weight: f64,
}

/// The atlas of some cases: places from the whole ones, neighbours from all.
pub fn fit_atlas(cases: &[&LabelledCase]) -> Atlas {
    let tables = StateTables::default();
    let mut posed: Vec<Posed> = cases.iter().filter(|case| case.is_whole).map(|case| first_pose(&case.truth)).collect();
    let mut data = AtlasData { other_radius: radius_of_others(cases), ..count(cases, &tables) };
    for round in 0..ROUNDS {
        data.pieces = distributions(&posed, &tables);
        if round + 1 == ROUNDS {
            break;
        }
        let atlas = Atlas::new(data.clone());
        let pulls = Pulls::of(&atlas, &all_states(), &atlas.position);
        for one in &mut posed {
            let nodes = &one.truth.nodes;
            let (weight, all) = (vec![1.0; nodes.len()], (0..nodes.len()).collect::<Vec<_>>());
            let search = Search::new(nodes, &atlas, &weight, &[], one.median);
            for _ in 0..POSE_STEPS {
                one.pose = search.step(&all, &one.pose, &pulls, &one.known, false);
            }
        }
    }
    let mean_of = |one: &Posed| {
        let nodes = &one.truth.nodes;
        weighted_centroid((0..nodes.len()).map(|n| (one.pose.apply(nodes.at[n]), nodes.weight[n]))).unwrap_or_default()
    };
    data.centroid = centroid(posed.iter().map(mean_of));
    // Mirror images were counted too, so that the middle lies in the middle.
    data.centroid[0] = 0.0;
    Atlas::new(data)
}

/// The middle of the carotid bifurcations comes to lie at zero; the frame is that of the file.
fn first_pose(truth: &LabelledNodes) -> Posed<'_> {
    let nodes = &truth.nodes;
    let tip = |side: BodySide| {
        let state = first_state(label_of(Artery::Ica(side)));
        let own: Vec<Point> = (0..nodes.len()).filter(|n| truth.state[*n] == state).map(|n| nodes.at[n]).collect();
        (!own.is_empty()).then(|| centroid(own))
    };
    let middle = match BodySide::BOTH.map(tip) {
        [Some(a), Some(b)] => [0, 1, 2].map(|k| 0.5 * (a[k] + b[k])),
        [Some(a), None] => [a[0] + HALF_WIDTH, a[1], a[2]],
        [None, Some(b)] => [b[0] - HALF_WIDTH, b[1], b[2]],
        [None, None] => {
            let ba: Vec<usize> = (0..nodes.len()).filter(|n| truth.label[*n] == BA).collect();
            ba.first().map_or([0.0; 3], |n| nodes.at[*n])
        }
    };
    let mut known = vec![0.0; nodes.len() * STATES];
    for (n, state) in truth.state.iter().enumerate().filter(|(_, state)| **state != NOWHERE) {
        known[n * STATES + state] = 1.0;
    }
    let pose = Pose { turn: rotation([0.0; 3]), shift: middle.map(|x| -x), log_scale: 0.0 };
    Posed { truth, pose, median: nodes.median_log_radius(|_| 1.0), known }
}

/// The distribution of each state over the tracings and their mirror images.
fn distributions(posed: &[Posed], tables: &StateTables) -> Vec<AtlasPiece> {
    let mut by_state: Vec<Vec<Observed>> = vec![Vec::new(); STATES];
    for one in posed {
        let nodes = &one.truth.nodes;
        for n in 0..nodes.len() {
            let (at, d) = (one.pose.apply(nodes.at[n]), turned(&one.pose.turn, &nodes.direction[n]));
            let state = one.truth.state[n];
            let (log_radius, weight) = (nodes.log_radius[n] - one.median, nodes.weight[n]);
            by_state[state].push(Observed { at, direction: d, log_radius, weight });
            let mirror = tables.mirrored[state];
            let flipped = [d[0], d[1], d[2], -d[3], -d[4], d[5]];
            by_state[mirror].push(Observed { at: [-at[0], at[1], at[2]], direction: flipped, log_radius, weight });
        }
    }
    let mut pieces: Vec<AtlasPiece> = Vec::with_capacity(NOWHERE);
    for (state, seen) in by_state.iter().enumerate().take(NOWHERE) {
        let before = (state > 0 && tables.label[state] == tables.label[state - 1]).then(|| pieces[state - 1]);
        pieces.push(distribution(seen, before));
    }
    // The spread of the radius is that of the whole artery.
    for label in 0..OTHER {
        let states: Vec<AtlasState> = (0..NOWHERE).filter(|state| tables.label[*state] == label).collect();
        let (mut sum, mut count) = (0.0, 0);
        for (state, observed) in states.iter().flat_map(|state| by_state[*state].iter().map(move |o| (*state, o))) {
            sum += (observed.log_radius - pieces[state].log_radius).powi(2);
            count += 1;
        }
        for state in states.iter().filter(|_| count > 5) {
            pieces[*state].radius_spread = (sum / f64::from(count) + 0.01).sqrt();
        }
    }
    pieces
}

fn distribution(seen: &[Observed], before: Option<AtlasPiece>) -> AtlasPiece {
    let total: f64 = seen.iter().map(|o| o.weight).sum();
    let third = [1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, 0.0, 0.0, 0.0];
    if seen.len() < LEAST_NODES || total <= 0.0 {
        let (mean, log_radius) = before.map_or(([0.0; 3], 0.0), |piece| (piece.mean, piece.log_radius));
        let covariance = [100.0, 100.0, 100.0, 0.0, 0.0, 0.0];
        return AtlasPiece { mean, covariance, direction: third, log_radius, radius_spread: 0.5 };
    }
    let average = |of: &dyn Fn(&Observed) -> f64| seen.iter().map(|o| o.weight * of(o)).sum::<f64>() / total;
    let mean = [0, 1, 2].map(|k| average(&|o| o.at[k]));
    let mut covariance = [0.0; 6];
    let mut direction = [0.0; 6];
    for o in seen {
        covariance.iter_mut().zip(outer(sub(o.at, mean))).for_each(|(sum, x)| *sum += o.weight / total * x);
        direction.iter_mut().zip(&o.direction).for_each(|(sum, d)| *sum += o.weight / total * d);
    }
    let effective = seen.len() as f64 / DEPENDENT;
    for (k, c) in covariance.iter_mut().enumerate() {
        let pseudo = if k < 3 { PSEUDO * PSEUDO_VARIANCE } else { 0.0 };
        *c = (*c * effective + pseudo) / (effective + PSEUDO);
    }
    for (k, d) in direction.iter_mut().enumerate() {
        *d = (*d + if k < 3 { NO_DIRECTION } else { 0.0 }) / (1.0 + NO_DIRECTION);
    }
    AtlasPiece { mean, covariance, direction, log_radius: average(&|o| o.log_radius), radius_spread: 0.5 }
}

/// How often states were side by side, with mirror images.
fn count(cases: &[&LabelledCase], tables: &StateTables) -> AtlasData {
    let mut length = vec![0.0; STATES];
    let mut neighbours: [BTreeMap<StatePair, f64>; 2] = [BTreeMap::new(), BTreeMap::new()];
    let mut bifurcations: BTreeMap<StatesOfArms, f64> = BTreeMap::new();
    let whole = cases.iter().filter(|case| case.is_whole).count().max(1) as f64;
    let of_whole = ((cases.len() as f64 - whole) / (BROKEN * whole)).round().max(1.0);
    for case in cases {
        let LabelledNodes { nodes, state, .. } = &case.truth;
        let times = if case.is_whole { of_whole } else { 1.0 };
        for (n, s) in state.iter().enumerate() {
            length[*s] += times * nodes.weight[n];
            length[tables.mirrored[*s]] += times * nodes.weight[n];
        }
        for [a, b] in &nodes.links {
            let kind = usize::from(nodes.degree(*a) > 2 || nodes.degree(*b) > 2);
            for pair in tables.alike(state[*a], state[*b]) {
                *neighbours[kind].entry(pair).or_insert(0.0) += times;
            }
        }
        for n in (0..nodes.len()).filter(|n| nodes.degree(*n) == 3) {
            let mut arms = [0, 1, 2].map(|k| state[nodes.neighbours[n][k]]);
            arms.sort_unstable();
            for seen in [(arms, state[n]), tables.mirrored_bifurcation((arms, state[n]))] {
                *bifurcations.entry(seen).or_insert(0.0) += times;
            }
        }
    }
    AtlasData { length, neighbours, bifurcations: bifurcations.into_iter().collect(), ..AtlasData::default() }
}

/// Mean and spread of the relative log radius of false pieces.
fn radius_of_others(cases: &[&LabelledCase]) -> [f64; 2] {
    let mut values = Vec::new();
    for case in cases.iter().filter(|case| !case.is_whole) {
        let LabelledNodes { nodes, state, .. } = &case.truth;
        let median = nodes.median_log_radius(|_| 1.0);
        values.extend((0..nodes.len()).filter(|n| state[*n] == NOWHERE).map(|n| nodes.log_radius[n] - median));
    }
    if values.len() <= 20 {
        return [-0.8, 0.5];
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    [mean, (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt() + 0.1]
}
