//! Limits of the search: junctions of a thousand vessels and points crowded around every free end are no vessels.

use std::sync::atomic::{AtomicUsize, Ordering};

use willis_core::error::{Error, Result};
use willis_core::network::{Network, Origin};

/// Vessels that may meet at one node.
const MOST_VESSELS: usize = 1000;
/// Points that may be looked at around all free ends together, and for each one more.
const MOST_POINTS: usize = 100_000_000;
const MOST_POINTS_EACH: usize = 50_000;

/// Refuses nodes where more than a thousand observed vessels meet: work grows with the square of their number.
///
/// # Errors
///
/// Such a node, by its id.
pub fn check_junctions(network: &Network) -> Result<()> {
    let degrees = network.degrees(|vessel| vessel.origin == Origin::Observed);
    match degrees.iter().enumerate().find(|(_, degree)| **degree > MOST_VESSELS) {
        None => Ok(()),
        Some((node, degree)) => Err(Error::parameter(
            format!("node {}", network.node(node).id),
            format!("where {degree} vessels meet"),
            format!("candidates need junctions of at most {MOST_VESSELS}"),
        )),
    }
}

/// How many points may still be looked at around free ends, by all threads together.
pub struct SearchBudget {
    ends: usize,
    most: usize,
    spent: AtomicUsize,
}

impl SearchBudget {
    /// The budget of so many free ends.
    pub fn new(ends: usize) -> Self {
        Self { ends, most: MOST_POINTS + MOST_POINTS_EACH.saturating_mul(ends), spent: AtomicUsize::new(0) }
    }

    /// Counts points that were looked at.
    pub fn spend(&self, points: usize) {
        self.spent.fetch_add(points, Ordering::Relaxed);
    }

    /// Whether too many points were looked at, so that the rest can be left.
    pub fn is_spent(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > self.most
    }

    /// Whether the points looked at were few enough.
    ///
    /// # Errors
    ///
    /// They were too many.
    pub fn check(&self) -> Result<()> {
        if !self.is_spent() {
            return Ok(());
        }
        let each = self.most / self.ends.max(1);
        Err(Error::parameter(
            "free ends",
            format!("{}, with more than {each} points within the reach of each", self.ends),
            "candidates need vessels further apart than the points along them",
        ))
    }
}
