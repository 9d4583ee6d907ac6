//! Pieces of the network: which are false, by how they fit and what they look like, and that a piece of an artery is there once.

use super::atlas::{Atlas, BIN, LABELS, NOWHERE, OTHER, STATES, arteries, row, row_mut};
use super::emission::{PoseFit, Search};
use super::{belief::Beliefs, nodes::Nodes};
use willis_core::support::geometry::{distance, dot, sub};

/// How many features a piece has.
pub const PIECE_FEATURES: usize = 11;
/// The most that a log ratio of a node counts.
const MOST_RATIO: f64 = 8.0;

/// The features of every piece: log length (mm); mean log ratio of position, direction and radius to no artery; mean relative log
/// radius; share of it on states that other pieces fill; mean probability of the best label; probability of the best bridge; whether it
/// has a junction; roughness; share of all length.
pub fn piece_features(case: &Search, fit: &PoseFit, names: &[f64]) -> Vec<[f64; PIECE_FEATURES]> {
    let Search { nodes, atlas, weight, .. } = case;
    let length: Vec<f64> = (0..nodes.len()).map(|n| (nodes.weight[n] * weight[n]).max(1e-6)).collect();
    let mut total = vec![1e-9; nodes.pieces];
    for (piece, length) in nodes.piece.iter().zip(&length) {
        total[*piece] += length;
    }
    let whole: f64 = total.iter().sum();
    // The names, given that it is an artery of the circle.
    let mut given = names.to_vec();
    for row in given.chunks_mut(STATES) {
        let sum = (1.0 - row[NOWHERE]).max(1e-9);
        row[NOWHERE] = 0.0;
        for p in row.iter_mut() {
            *p /= sum;
        }
    }
    let parts = [&fit.position, &fit.direction, &case.radius];
    let (filled, by_all) = occupancy(&nodes.piece, nodes.pieces, nodes, weight, &given);
    let mut features = vec![[0.0; PIECE_FEATURES]; nodes.pieces];
    for (n, piece) in nodes.piece.iter().enumerate() {
        let (own, given) = (row(&filled, *piece), row(&given, n));
        let [position, direction, radius] = parts.map(|e| {
            let e = row(e, n);
            let ratio: f64 = arteries().map(|s| given[s] * (e[s] - e[NOWHERE])).sum();
            ratio.clamp(-MOST_RATIO, MOST_RATIO)
        });
        let once = arteries().filter(|s| atlas.tables.once[*s]);
        let doubled = once.map(|s| given[s] * (by_all[s] - own[s]).clamp(0.0, 1.0)).sum();
        let best = label_probabilities(given, atlas)[..OTHER].iter().fold(0.0_f64, |a, b| a.max(*b));
        let means = [position, direction, radius, nodes.log_radius[n] - case.median, doubled, best];
        for (mean, value) in features[*piece][1..].iter_mut().zip(means) {
            *mean += value * length[n] / total[*piece];
        }
    }
    for bridge in case.used.iter().map(|b| &nodes.bridges[*b]) {
        for node in bridge.nodes {
            let best = &mut features[nodes.piece[node]][7];
            *best = best.max(bridge.probability);
        }
    }
    let mut bends = vec![(0.0, 1e-9); nodes.pieces];
    for n in 0..nodes.len() {
        let piece = nodes.piece[n];
        if nodes.degree(n) > 2 {
            features[piece][8] = 1.0;
        }
        if let [a, b] = nodes.neighbours[n][..] {
            let (u, v) = (sub(nodes.at[n], nodes.at[a]), sub(nodes.at[b], nodes.at[n]));
            let (long_u, long_v) = (distance(nodes.at[n], nodes.at[a]), distance(nodes.at[n], nodes.at[b]));
            if long_u > 0.2 && long_v > 0.2 {
                bends[piece].0 += 1.0 - dot(u, v) / long_u / long_v;
                bends[piece].1 += 1.0;
            }
        }
    }
    for (piece, row) in features.iter_mut().enumerate() {
        row[0] = total[piece].ln();
        row[9] = bends[piece].0 / bends[piece].1;
        row[10] = total[piece] / whole;
    }
    features
}

/// The probabilities of the labels, from those of the states.
pub fn label_probabilities(states: &[f64], atlas: &Atlas) -> [f64; LABELS] {
    let mut labels = [0.0; LABELS];
    for (state, p) in states.iter().enumerate() {
        labels[atlas.tables.label[state]] += p;
    }
    labels
}

/// The log penalty of a state that other branches fill.
const PENALTY: f64 = 2.0;

impl Search<'_> {
    /// The names by the log likelihoods of the nodes (nodes x states) with one of every artery, after some rounds in which pieces of arteries
    /// that are taken twice settle; and the log likelihoods that they are of.
    pub fn settled(&self, own: &[f64], rounds: usize) -> (Beliefs, Vec<f64>) {
        let (mut penalty, mut log_likelihood) = (Vec::new(), own.to_vec());
        for round in 0..rounds {
            let new = self.exclusion(&self.forest.beliefs(self.atlas, &log_likelihood).states);
            penalty = if round == 0 { new } else { penalty.iter().zip(&new).map(|(a, b)| 0.5 * (a + b)).collect() };
            log_likelihood = own.iter().zip(&penalty).map(|(e, p)| e + p).collect();
        }
        (self.forest.beliefs(self.atlas, &log_likelihood), log_likelihood)
    }

    /// The log penalties, nodes x states, given the probabilities of the states.
    fn exclusion(&self, names: &[f64]) -> Vec<f64> {
        let Search { nodes, atlas, weight, .. } = self;
        let (filled, all) = occupancy(&nodes.branch, nodes.branches, nodes, weight, names);
        let mut penalty = vec![0.0; nodes.len() * STATES];
        for (of_node, branch) in penalty.chunks_mut(STATES).zip(&nodes.branch) {
            let own = row(&filled, *branch);
            for state in (0..STATES).filter(|state| atlas.tables.once[*state]) {
                of_node[state] = -PENALTY * (all[state] - own[state]).clamp(0.0, 1.0);
            }
        }
        penalty
    }
}

/// How far each unit of nodes fills each state, 0 to 1: units x states; and the sum over the units.
fn occupancy(unit: &[usize], units: usize, nodes: &Nodes, weight: &[f64], names: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut filled = vec![0.0; units * STATES];
    for (n, names) in names.chunks(STATES).enumerate() {
        let length = nodes.weight[n] * weight[n] / BIN;
        row_mut(&mut filled, unit[n]).iter_mut().zip(names).for_each(|(o, p)| *o += p * length);
    }
    for o in &mut filled {
        *o = o.min(1.0);
    }
    let mut by_all = vec![0.0; STATES];
    filled.chunks(STATES).for_each(|row| by_all.iter_mut().zip(row).for_each(|(sum, o)| *sum += o));
    (filled, by_all)
}
