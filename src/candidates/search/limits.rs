//! What no vessels are: hubs of a thousand, and points so crowded that every free end has all of them within reach.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::error::{Error, Result};
use crate::network::{Network, Origin};

/// Vessels that may meet at one node.
const MOST_VESSELS: usize = 1000;
/// Points that may be looked at around all free ends together, and for each one more.
const MOST_LOOKS: usize = 100_000_000;
const MOST_LOOKS_EACH: usize = 50_000;

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

/// How many points may still be looked at around free ends, whatever the threads.
pub struct Looks {
    ends: usize,
    most: usize,
    done: AtomicUsize,
}

impl Looks {
    /// For so many free ends.
    pub fn around(ends: usize) -> Self {
        Self { ends, most: MOST_LOOKS + MOST_LOOKS_EACH.saturating_mul(ends), done: AtomicUsize::new(0) }
    }

    /// Counts points; false when there were too many, so that the rest can be left.
    pub fn add(&self, points: usize) -> bool {
        self.done.fetch_add(points, Ordering::Relaxed) <= self.most.saturating_sub(points)
    }

    /// Whether the points looked at were few enough.
    ///
    /// # Errors
    ///
    /// They were too many.
    pub fn check(&self) -> Result<()> {
        if self.done.load(Ordering::Relaxed) <= self.most {
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
