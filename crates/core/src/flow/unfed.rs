//! Parts of a network that no blood enters: which they are, and whether they stay.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Boundary;
use crate::error::{Error, Result};
use crate::network::{Network, Role, fragments};
use crate::support::numbered::placed;

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
        };
        Some((part, held, vessels))
    }
}
