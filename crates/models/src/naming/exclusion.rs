//! One of every artery: a piece of an artery that one branch fills already is improbable on another.

use super::atlas::Atlas;
use super::nodes::Nodes;
use super::states::{BIN, STATES};

/// The log penalty of a state that other branches fill.
const PENALTY: f64 = 2.0;

/// The log penalties, nodes x states, given the probabilities of the states; `weight` is the share of each node's length that counts.
pub fn exclusion(nodes: &Nodes, weight: &[f64], atlas: &Atlas, names: &[f64]) -> Vec<f64> {
    let (filled, all) = occupancy(&nodes.branch, nodes.branches, nodes, weight, names);
    let mut penalty = vec![0.0; nodes.len() * STATES];
    for (n, row) in penalty.chunks_mut(STATES).enumerate() {
        let own = &filled[nodes.branch[n] * STATES..(nodes.branch[n] + 1) * STATES];
        for state in (0..STATES).filter(|state| atlas.tables.once[*state]) {
            row[state] = -PENALTY * (all[state] - own[state]).clamp(0.0, 1.0);
        }
    }
    penalty
}

/// How far each unit of nodes fills each state, 0 to 1: units x states; and the sum over the units.
pub fn occupancy(unit: &[usize], units: usize, nodes: &Nodes, weight: &[f64], names: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let mut filled = vec![0.0; units * STATES];
    for (n, names) in names.chunks(STATES).enumerate() {
        let length = nodes.weight[n] * weight[n] / BIN;
        let row = &mut filled[unit[n] * STATES..(unit[n] + 1) * STATES];
        row.iter_mut().zip(names).for_each(|(o, p)| *o += p * length);
    }
    for o in &mut filled {
        *o = o.min(1.0);
    }
    let mut by_all = vec![0.0; STATES];
    filled.chunks(STATES).for_each(|row| by_all.iter_mut().zip(row).for_each(|(sum, o)| *sum += o));
    (filled, by_all)
}
