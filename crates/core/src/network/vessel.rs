//! A vessel between two nodes: geometry, origin, and the evidence for a candidate; and nodes, with the boundary conditions where blood enters
//! or leaves.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::units::{cubic_metres_per_second, ml_per_min, mmhg, mmhg_s_per_ml, pascal_seconds_per_cubic_metre, pascals};
use crate::support::{Point, lerp};

/// The odds that a free end, known neither as inlet nor as outlet, is a true end, where a candidate of weight w has the odds w: e⁻²,
/// between a value that leaves gaps open and one that closes every gap.
pub const END_ODDS: f64 = 0.135_335_283_236_612_7;

/// The evidence for a candidate vessel between two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// The calibrated probability that it is a true connection, in [0, 1].
    pub probability: f64,
    /// Per end, the probability that it is true and that the fragment at that end is the one that hangs on the other; the two add up to
    /// `probability`. Zero for both where it closes a loop within one fragment. Of a contact half of the probability that the partitions join it,
    /// which is not calibrated. `hangs` in files.
    #[serde(rename = "hangs")]
    pub attached: [f64; 2],
    /// Per end, the odds w/e⁻² that a vessel which breaks off there continues along this candidate instead of ending; zero where there
    /// is no free end. `continues` in files.
    #[serde(rename = "continues")]
    pub continuation_odds: [f64; 2],
}

impl Evidence {
    /// That of a probability without a direction: the same for both ends.
    pub fn undirected(probability: f64) -> Self {
        Self { probability, attached: [0.5 * probability; 2], continuation_odds: [Self::odds(probability); 2] }
    }

    /// The same evidence with its probability divided between the ends as these figures are; none of them negative.
    #[must_use]
    pub fn divided(self, between: [f64; 2]) -> Self {
        let whole = between[0] + between[1];
        let attached = if whole > 0.0 { between.map(|part| self.probability * (part / whole)) } else { [0.0; 2] };
        Self { attached, ..self }
    }

    /// The same evidence with another probability; what it says of each end follows in proportion.
    #[must_use]
    pub fn with_probability(self, probability: f64) -> Self {
        let ratio = if self.probability > 0.0 { probability / self.probability } else { 0.0 };
        let odds = Self::odds(probability);
        let attached = self.attached.map(|p| (ratio * p).min(1.0));
        let continuation_odds = self.continuation_odds.map(|x| if x > 0.0 { odds } else { 0.0 });
        Self { probability, attached, continuation_odds }
    }

    /// The odds of continuing by a candidate of weight w.
    pub fn odds_of_weight(weight: f64) -> f64 {
        (weight / END_ODDS).clamp(0.0, MOST_ODDS)
    }

    /// The odds of continuing by a candidate of this probability: w = p/(1 - p).
    pub fn odds(probability: f64) -> f64 {
        Self::odds_of_weight(probability / (1.0 - probability))
    }
}

/// The largest odds.
pub const MOST_ODDS: f64 = 1e12;

/// Whether the image showed the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Origin {
    /// Traced in the image.
    Observed,
    /// A possible connection.
    #[default]
    Candidate,
    /// A place where two observed vessels meet, which may be one vessel or two that touch.
    Contact,
}

impl Origin {
    /// The word in files.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["observed", "candidate", "contact"][self as usize]
    }
}

/// The wall of a vessel, as an input states it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Wall {
    /// The speed of a pulse wave without viscosity, m/s, positive.
    Speed(f64),
    /// Young's modulus E (Pa) and thickness h (m), both positive.
    Elastic {
        /// E, Pa.
        young: f64,
        /// h, m.
        thickness: f64,
    },
}

/// A point on a vessel's centerline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathPoint {
    /// Position, m.
    pub position: Point,
    /// Radius, m.
    pub radius: f64,
    /// The point's number in the input, where it has one.
    pub id: Option<u64>,
}

impl PathPoint {
    /// The point at a share, in [0, 1], of the way to another, without a number.
    #[must_use]
    pub fn towards(self, to: Self, share: f64) -> Self {
        let radius = self.radius + share * (to.radius - self.radius);
        Self { position: lerp(self.position, to.position, share), radius, id: None }
    }
}

/// A vessel between two nodes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Vessel {
    /// Length along the centerline, m.
    pub length: f64,
    /// The single radius of the vessel, m.
    pub radius: f64,
    /// Resistance, Pa s/m³, where the input states one instead of leaving it to Poiseuille's law.
    pub resistance: Option<f64>,
    /// The anatomical name; empty when the input has none.
    pub label: String,
    /// Observed or candidate.
    pub origin: Origin,
    /// The anatomical prior A in [0, 1].
    pub prior: f64,
    /// Never occluded, whatever is uncertain.
    pub certain: bool,
    /// The evidence for a candidate; few vessels have any.
    pub evidence: Option<Box<Evidence>>,
    /// Whether an earlier run kept the vessel, if the input states it.
    pub kept: Option<bool>,
    /// The wall, where the input states it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wall: Option<Wall>,
    /// The centerline from the first node to the second; empty when only the nodes are known.
    pub path: Vec<PathPoint>,
}

/// How many points at an end its radius is averaged over.
const END_POINTS: usize = 10;

impl Vessel {
    /// A vessel with a length and radius (m), and nothing else.
    pub fn new(length: f64, radius: f64, origin: Origin) -> Self {
        Self { length, radius, origin, prior: 1.0, ..Self::default() }
    }

    /// Whether it is there without a question: observed, or certain.
    pub fn is_given(&self) -> bool {
        self.origin == Origin::Observed || self.certain
    }

    /// The path, or the straight line between two places (m) where it has none.
    pub fn path_between(&self, ends: [Point; 2]) -> Vec<PathPoint> {
        if self.path.len() > 1 {
            return self.path.clone();
        }
        ends.map(|position| PathPoint { position, radius: self.radius, id: None }).to_vec()
    }

    /// The evidence for a candidate.
    pub fn evidence(&self) -> Option<Evidence> {
        self.evidence.as_deref().copied()
    }

    /// The volume of the lumen, π r² l, m³.
    pub fn volume(&self) -> f64 {
        PI * self.radius * self.radius * self.length
    }

    /// The mean radius (m) over the last points at an end, the second one when `last`; the vessel's own without a path.
    pub fn end_radius(&self, last: bool) -> f64 {
        let n = self.path.len().min(END_POINTS);
        let points = if last { &self.path[self.path.len() - n..] } else { &self.path[..n] };
        if n == 0 { self.radius } else { points.iter().map(|p| p.radius).sum::<f64>() / n as f64 }
    }
}

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

    /// 1/R of a terminal resistance, m³/(Pa s).
    pub fn conductance(&self) -> Option<f64> {
        if let Self::Resistance { resistance, .. } = self { Some(1.0 / resistance) } else { None }
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
    /// Where that condition is from.
    #[serde(default, skip_serializing_if = "is_default")]
    pub condition_from: ConditionFrom,
    /// Whether a vessel leaves the image here, so that it is no end of a gap.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_border: bool,
    /// Whether the input states, by the direction of its lines, that blood comes from here.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_source: bool,
    /// The score of leaving the fragment of this node a root, where there is evidence: the posterior probability that it is attached to
    /// no other, times a factor (`candidates::model::root_scores`). `alone` in files.
    #[serde(rename = "alone")]
    pub root_score: Option<f64>,
}

impl Node {
    /// A node at a point of a centerline.
    pub fn at(id: String, point: PathPoint) -> Self {
        Self { id, position: Some(point.position), radius: Some(point.radius), ..Self::default() }
    }

    /// The parts of a Windkessel that the input states; few nodes have any.
    pub fn windkessel(&self) -> Windkessel {
        self.windkessel.as_deref().copied().unwrap_or_default()
    }
}

/// Where the condition of a node is from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ConditionFrom {
    /// Somebody states it.
    #[default]
    Statement,
    /// A run found it at a free end, so that it holds only while this is one.
    FreeEnd,
    /// A run worked it out for an outlet that a landmark names: it holds as if it were stated, and is a share of the total of those found.
    Landmark,
}

impl ConditionFrom {
    /// The word in the attribute `found` of files.
    pub fn name(self) -> &'static str {
        // In the order of the variants.
        ["false", "true", "landmark"][self as usize]
    }
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
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
        // In the order of the variants.
        ["inlet", "outlet", "inner"][self as usize]
    }

    /// The role of a node with a fixed flow into the network.
    pub fn of_flow(flow: f64) -> Self {
        if flow > 0.0 { Self::Inlet } else { Self::Outlet }
    }
}
