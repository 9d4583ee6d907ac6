//! Floating components: parts of a sampled circuit that no boundary condition grounds, found by structure, never by small pivots. And the
//! parts of a network that no blood enters: which they are, and whether they stay.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::{Boundary, Circuit};
use crate::error::{Error, Result, require};
use crate::network::{Condition, Fragments, Network, Role, fragments};
use crate::support::{grouped, placed};

/// Per node whether its component over the open vessels is grounded by a fixed pressure or a terminal resistance.
pub fn grounded(circuit: &Circuit, open: impl Fn(usize) -> bool) -> Vec<bool> {
    let open = circuit.ends.iter().enumerate().filter(|(vessel, _)| open(*vessel));
    let parts = Fragments::over(circuit.node_count(), open.map(|(_, ends)| *ends));
    parts.holding((0..circuit.node_count()).filter(|node| circuit.grounds(*node)))
}

/// The nodes whose injected flow has nowhere to go in some samples of a block, with those samples as bits; bit i of
/// `masks[e]` says whether vessel e is open in sample i. Empty for a circuit without injections.
pub fn stranded(circuit: &Circuit, masks: &[u64], samples: usize) -> Vec<(usize, u64)> {
    let mut out: Vec<(usize, u64)> = circuit.injected().map(|node| (node, 0)).collect();
    if out.is_empty() {
        return out;
    }
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
    let accepted =
        "expected an inlet and an outlet at different pressures (or a flow and an outlet) in one connected part of the network";
    let carries = parts_that_carry(&fragments(network, |_, _| true), boundary).contains(&true);
    require(carries, "boundary conditions", "drive no flow", accepted)
}

/// What becomes of vessels to which no inlet leads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unfed {
    /// They are left out.
    Drop,
    /// They stay, without flow.
    Keep,
}

impl FromStr for Unfed {
    type Err = Error;

    fn from_str(word: &str) -> Result<Self> {
        match word {
            "drop" => Ok(Self::Drop),
            "keep" => Ok(Self::Keep),
            _ => Err(Error::parameter("unfed", format!("\"{word}\""), "expected drop or keep")),
        }
    }
}

/// Per node whether vessels lead to it from a node where blood enters.
pub fn fed(network: &Network, enters: impl Fn(usize) -> bool) -> Vec<bool> {
    fragments(network, |_, _| true).holding((0..network.node_count()).filter(|node| enters(*node)))
}

impl Boundary {
    /// The parts of a network that an inlet feeds, the conditions that hold in them, and the rows that their vessels had; `None` where it feeds all vessels.
    pub fn fed_part(&self, network: &Network) -> Option<(Network, Self, Vec<usize>)> {
        let is_fed = fed(network, |node| self.roles[node] == Role::Inlet);
        if network.vessels().all(|([a, _], _)| is_fed[a]) {
            return None;
        }
        let (part, nodes, vessels) = network.part(|node| is_fed[node]);
        let row_of = placed(network.node_count(), nodes.iter().copied());
        let of = |found: &[usize]| found.iter().map(|node| row_of[*node]).filter(|row| *row != usize::MAX).collect();
        let conditions = self.conditions.iter().map(|(node, condition)| (row_of[*node], *condition));
        let held = Self {
            conditions: conditions.filter(|(row, _)| *row != usize::MAX).collect(),
            roles: nodes.iter().map(|node| self.roles[*node]).collect(),
            found_inlets: of(&self.found_inlets),
            found_outlets: of(&self.found_outlets),
            named_outlets: of(&self.named_outlets),
        };
        Some((part, held, vessels))
    }
}
