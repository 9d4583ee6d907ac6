//! Floating components: parts of a sampled circuit that no boundary condition grounds. They are found by structure, never by small pivots.

use super::boundary_conditions::Boundary;
use super::circuit::Circuit;
use crate::error::{Error, Result};
use crate::network::{Condition, Fragments, Network, fragments};
use crate::support::numbered::grouped;

/// Per node whether its component over the open vessels is grounded by a fixed pressure or a terminal resistance.
pub fn grounded(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Vec<bool> {
    let open = circuit.ends.iter().enumerate().filter(|(vessel, _)| open(*vessel));
    let parts = Fragments::over(circuit.node_count(), open.map(|(_, ends)| *ends));
    parts.holding((0..circuit.node_count()).filter(|node| circuit.grounds(*node)))
}

/// The nodes whose injected flow has nowhere to go in some samples of a block, with those samples as bits; bit i of
/// `masks[e]` says whether vessel e is open in sample i. Empty for a circuit without injections.
pub fn stranded(circuit: &Circuit, masks: &[u64], samples: usize) -> Vec<(usize, u64)> {
    if !circuit.injects {
        return Vec::new();
    }
    let injected = (0..circuit.node_count()).filter(|n| circuit.source[*n] != 0.0 && !circuit.grounds(*n));
    let mut out: Vec<(usize, u64)> = injected.map(|n| (n, 0)).collect();
    for sample in 0..samples {
        let grounded = grounded(circuit, |vessel| masks[vessel] >> sample & 1 == 1);
        for (node, bits) in &mut out {
            *bits |= u64::from(!grounded[*node]) << sample;
        }
    }
    out
}

/// Per connected part whether blood can flow through it: conditions of two different kinds or pressures.
pub fn parts_that_carry(parts: &Fragments, boundary: &Boundary) -> Vec<bool> {
    let conditions = grouped(parts.count, boundary.conditions.iter().map(|(node, of)| (parts.of_node[*node], *of)));
    let carries = |conditions: &Vec<Condition>| {
        let grounds: Vec<f64> = conditions.iter().filter_map(Condition::ground).collect();
        let injected = conditions.len() > grounds.len();
        grounds.first().is_some_and(|first| injected || grounds.iter().any(|p| p != first))
    };
    conditions.iter().map(carries).collect()
}

/// Refuses boundary conditions between which no blood can flow.
///
/// # Errors
///
/// No connected part of the network has an inlet and an outlet at different pressures, or a flow and an outlet.
pub fn drives_flow(network: &Network, boundary: &Boundary) -> Result<()> {
    if parts_that_carry(&fragments(network, |_, _| true), boundary).contains(&true) {
        return Ok(());
    }
    Err(Error::parameter(
        "boundary conditions",
        "drive no flow",
        "expected an inlet and an outlet at different pressures (or a flow and an outlet) in one connected part of the network",
    ))
}
