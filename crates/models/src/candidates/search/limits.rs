//! Limits of the search: junctions of a thousand vessels and points crowded around every free end are no vessels.

use std::sync::atomic::{AtomicUsize, Ordering};

use super::point_index::PointIndex;
use willis_core::error::{Error, Result};
use willis_core::network::{Network, Origin};
use willis_core::support::geometry::Point;
use willis_core::support::in_order;

/// Vessels that may meet at one node.
const MOST_VESSELS: usize = 1000;
/// Points that may be looked at around all free ends together, some ten seconds of work.
const MOST_POINTS: usize = 300_000_000;

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
    spent: AtomicUsize,
}

impl SearchBudget {
    /// The budget of a search that will look at all points within a reach (m) of each of these places.
    ///
    /// # Errors
    ///
    /// They are too many; they are counted before any is looked at.
    pub fn new(index: &PointIndex, ends: &[(Point, f64)]) -> Result<Self> {
        let budget = Self { ends: ends.len(), spent: AtomicUsize::new(0) };
        if ends.len().saturating_mul(index.len()) > MOST_POINTS {
            in_order(ends, |_, (place, reach)| {
                if !budget.is_spent() {
                    budget.spend(index.count(*place, *reach));
                }
            });
        }
        budget.check().map(|()| budget)
    }

    /// Counts points that are looked at.
    pub fn spend(&self, points: usize) {
        self.spent.fetch_add(points, Ordering::Relaxed);
    }

    /// Whether too many points are looked at, so that the rest can be left.
    pub fn is_spent(&self) -> bool {
        self.spent.load(Ordering::Relaxed) > MOST_POINTS
    }

    /// Whether the points looked at are few enough.
    ///
    /// # Errors
    ///
    /// They are too many.
    pub fn check(&self) -> Result<()> {
        if !self.is_spent() {
            return Ok(());
        }
        Err(Error::parameter(
            "free ends",
            format!(
                "{}, with more than {MOST_POINTS} points within their reach, or {} each",
                self.ends,
                MOST_POINTS / self.ends.max(1)
            ),
            "candidates need vessels further apart than the points along them",
        ))
    }
}
