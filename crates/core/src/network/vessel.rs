//! A vessel between two nodes: geometry, origin, and the evidence for a candidate.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

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
