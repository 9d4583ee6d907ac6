//! What the evidence says of a candidate: how probable it is before any flow.

/// The evidence for a candidate vessel between two nodes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// The calibrated probability that it is a true connection, in [0, 1].
    pub probability: f64,
    /// Per end, the posterior probability that the fragment at that end hangs on the fragment at the other by this bridge, or
    /// by one of nearly the same place there, in [0, 1]; zero for both where it closes a loop within one fragment.
    pub hangs: [f64; 2],
}

impl Evidence {
    /// That of a probability without a direction: each fragment as readily hangs on the other.
    pub fn undirected(probability: f64) -> Self {
        Self { probability, hangs: [0.5 * probability; 2] }
    }
}
