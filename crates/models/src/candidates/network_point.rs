//! Places in a network where a candidate may end.

/// A point of a network: a node, or a point along a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NetworkPoint {
    /// A node, by row.
    Node(usize),
    /// A point of a vessel's path.
    Along {
        /// The vessel's row.
        vessel: usize,
        /// The point's place in its path.
        point: usize,
    },
}
