//! What the evidence says of a candidate: how probable it is before any flow.

use serde::{Deserialize, Serialize};

/// The odds by which a free end that nobody knows for an inlet or outlet ends where it is, where a bridge of weight w has the odds
/// w: e⁻², between a price that leaves gaps open and one that bridges every end.
pub const END_ODDS: f64 = 0.135_335_283_236_612_7;

/// The evidence for a candidate vessel between two nodes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// The calibrated probability that it is a true connection, in [0, 1].
    pub probability: f64,
    /// Per end, the posterior probability that the fragment at that end hangs on the fragment at the other by this bridge, or
    /// by one of nearly the same place there, in [0, 1]; zero for both where it closes a loop within one fragment.
    pub hangs: [f64; 2],
    /// Per end, the odds w/e⁻² by which a vessel that breaks off there continues along this candidate, against ending there; zero
    /// where no free end is.
    pub continues: [f64; 2],
}

impl Evidence {
    /// That of a probability without a direction: each fragment as readily hangs on the other, each end as readily continues.
    pub fn undirected(probability: f64) -> Self {
        Self { probability, hangs: [0.5 * probability; 2], continues: [Self::odds(probability); 2] }
    }

    /// The odds of continuing by a candidate of weight w.
    pub fn odds_of_weight(weight: f64) -> f64 {
        (weight / END_ODDS).clamp(0.0, MOST_ODDS)
    }

    /// The odds of continuing by a candidate of such a probability among all that may be: w = p/(1 - p).
    pub fn odds(probability: f64) -> f64 {
        Self::odds_of_weight(probability / (1.0 - probability))
    }
}

/// Beyond these odds nothing is left to chance.
const MOST_ODDS: f64 = 1e12;
