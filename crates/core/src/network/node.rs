//! Nodes, and the boundary conditions where blood enters or leaves.

use serde::{Deserialize, Serialize};

use super::units::{cubic_metres_per_second, ml_per_min, mmhg, mmhg_s_per_ml, pascal_seconds_per_cubic_metre, pascals};
use crate::support::Point;

/// The pressure of an inlet when none is stated, Pa: 100 mmHg.
pub const INLET_PRESSURE: f64 = pascals(100.0);

/// A boundary condition at a node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Condition {
    /// A fixed pressure, Pa; 0 is ground.
    Pressure(f64),
    /// A terminal resistance, Pa s/m³, to a venous pressure, Pa.
    Resistance {
        /// Pa s/m³, positive.
        resistance: f64,
        /// Pa.
        venous: f64,
    },
    /// A fixed flow into the network, m³/s.
    Flow(f64),
}

impl Condition {
    /// An inlet when no pressure is stated.
    pub const INLET: Self = Self::Pressure(INLET_PRESSURE);
    /// An outlet when nothing is stated.
    pub const GROUND: Self = Self::Pressure(0.0);

    /// The pressure (Pa) to which it ties the node; none for a flow.
    pub fn ground(&self) -> Option<f64> {
        match self {
            Self::Pressure(p) => Some(*p),
            Self::Resistance { venous, .. } => Some(*venous),
            Self::Flow(_) => None,
        }
    }

    /// The pressure (Pa) that it fixes.
    pub fn pressure(&self) -> Option<f64> {
        if let Self::Pressure(p) = self { Some(*p) } else { None }
    }

    /// The condition after it was written to a file in mmHg and mL and read again.
    #[must_use]
    pub fn as_stored(self) -> Self {
        match self {
            Self::Pressure(p) => Self::Pressure(pascals(mmhg(p))),
            Self::Resistance { resistance, venous } => Self::Resistance {
                resistance: pascal_seconds_per_cubic_metre(mmhg_s_per_ml(resistance)),
                venous: pascals(mmhg(venous)),
            },
            Self::Flow(flow) => Self::Flow(cubic_metres_per_second(ml_per_min(flow))),
        }
    }
}

/// How a terminal resistance R takes a pulse: R1 in series with R2 = R - R1 beside a compliance C (a Windkessel of three elements).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Windkessel {
    /// R1, Pa s/m³, from 0 to R; where it is not stated, the wave impedance of the vessels there.
    pub proximal: Option<f64>,
    /// C, m³/Pa, positive; where it is not stated, a time constant over R.
    pub compliance: Option<f64>,
}

impl Windkessel {
    /// RC of outlets that state no compliance, s: 0.687 to 0.697 at each of eleven in Alastruey et al. 2007.
    pub const TIME_CONSTANT: f64 = 0.69;

    /// What a node states of it: nothing where nothing is stated.
    pub fn stated(self) -> Option<Box<Self>> {
        (self != Self::default()).then(|| Box::new(self))
    }
}

/// A junction, a free end or a landmark.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Node {
    /// The id in the input (GraphML id, SWC index, CSV `node`), unique in the network.
    pub id: String,
    /// Ids of points of the input that were merged with this node.
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
    /// The parts of a Windkessel that the input states beside a terminal resistance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub windkessel: Option<Box<Windkessel>>,
    /// Whether an earlier run found that condition, so that it holds only while this is a free end.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub found: bool,
    /// Whether a vessel leaves the image here, so that it is no end of a gap.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_border: bool,
    /// Whether the input states, by the direction of its lines, that blood comes from here.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_source: bool,
    /// The score of leaving the fragment of this node a root, where there is evidence: the posterior probability that it is attached to
    /// no other, times a factor (`candidates::model::posterior::root_scores`). `alone` in files.
    #[serde(rename = "alone")]
    pub root_score: Option<f64>,
}

impl Node {
    /// The parts of a Windkessel that the input states; few nodes have any.
    pub fn windkessel(&self) -> Windkessel {
        self.windkessel.as_deref().copied().unwrap_or_default()
    }
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
        ["inlet", "outlet", "inner"][self as usize]
    }

    /// The role of a node with a fixed flow into the network.
    pub fn of_flow(flow: f64) -> Self {
        if flow > 0.0 { Self::Inlet } else { Self::Outlet }
    }
}
