//! A node of the network and what it is to the flow.

use serde::{Deserialize, Serialize};

use super::Condition;
use crate::geometry::Point;

/// A junction, a free end or a landmark.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Node {
    /// The id in the input (GraphML id, SWC index, CSV `node`), unique in the network.
    pub id: String,
    /// Ids of points of the input that were made one with this node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<String>,
    /// Position, m; absent in a graph without coordinates.
    pub position: Option<Point>,
    /// Radius of the lumen here, m.
    pub radius: Option<f64>,
    /// The anatomical name; empty when the input has none.
    pub label: String,
    /// The role that the input states.
    pub role: Option<Role>,
    /// The boundary condition that the input states.
    pub condition: Option<Condition>,
    /// What speaks for leaving the fragment of this node alone, where the evidence says so: the posterior probability that it
    /// hangs on no other, times the price of that (`candidates::prior::alone`).
    pub alone: Option<f64>,
}

/// What a node is to the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// Blood enters here.
    Inlet,
    /// Blood leaves here.
    Outlet,
    /// No condition: Kirchhoff's current law holds.
    Inner,
}

impl Role {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inlet => "inlet",
            Self::Outlet => "outlet",
            Self::Inner => "inner",
        }
    }

    /// The role of a node with a fixed flow into the network.
    pub fn of_flow(flow: f64) -> Self {
        if flow > 0.0 { Self::Inlet } else { Self::Outlet }
    }
}
