//! What holds at a node where blood enters or leaves.

use serde::{Deserialize, Serialize};

use crate::units::{cubic_metres_per_second, ml_per_min, mmhg, mmhg_s_per_ml, pascal_seconds_per_cubic_metre, pascals};

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

    /// The pressure (Pa) that it ties the node to; none of a flow.
    pub fn ground(&self) -> Option<f64> {
        match self {
            Self::Pressure(p) => Some(*p),
            Self::Resistance { venous, .. } => Some(*venous),
            Self::Flow(_) => None,
        }
    }

    /// The condition that a file in mmHg and mL hands back.
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
