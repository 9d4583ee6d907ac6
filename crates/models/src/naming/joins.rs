//! What names say of candidates: by how much they multiply the odds that a candidate is a true connection.

use super::atlas::Atlas;
use super::belief::{Beliefs, ratio};
use super::nodes::Nodes;
use super::states::STATES;

/// No factor is larger, nor smaller than one over it: names are only one witness.
const MOST: f64 = 100.0;

/// The factor of each bridge: the probability of the names at its ends if a vessel passes between them, over that if they have nothing to
/// do with each other. A false piece says nothing.
pub fn factors(nodes: &Nodes, atlas: &Atlas, beliefs: &Beliefs, false_pieces: &[f64]) -> Vec<f64> {
    let states = |n: usize| &beliefs.states[n * STATES..(n + 1) * STATES];
    let each = nodes.bridges.iter().zip(&beliefs.bridge_ratio).map(|(bridge, known)| {
        let [a, b] = bridge.nodes;
        let ratio = known.unwrap_or_else(|| ratio(&atlas.gaps[bridge.length_class()], states(a), states(b)));
        let is_true = (1.0 - false_pieces[nodes.piece[a]]) * (1.0 - false_pieces[nodes.piece[b]]);
        (is_true * ratio + 1.0 - is_true).clamp(1.0 / MOST, MOST)
    });
    each.collect()
}

/// A probability whose odds are multiplied by the factor that names give them.
pub fn probability_with(probability: f64, factor: f64) -> f64 {
    let odds = probability / (1.0 - probability).max(1e-12) * factor;
    odds / (1.0 + odds)
}
