//! What the large phantoms have in common: their options, and straight vessels between nodes.

use super::{check_length, check_range, widen_nodes};
use willis_core::error::Result;
use willis_core::network::{Network, Origin, PathPoint, Vessel};
use willis_core::support::geometry::{distance, lerp};

/// The least and the greatest number of vessels of a large phantom.
pub const EDGES: [usize; 2] = [100, 10_000_000];

/// The options of a large phantom.
#[derive(Debug, Clone, PartialEq)]
pub struct Large {
    /// How many vessels, 100 to 10 000 000.
    pub edges: usize,
    /// The seed of the anatomy.
    pub seed: u64,
    /// Distance between centerline points, m, positive; `None` leaves each vessel its two nodes only.
    pub spacing: Option<f64>,
}

impl Large {
    /// Refuses a field out of its range.
    ///
    /// # Errors
    ///
    /// Names the field, its value and its range.
    pub fn validate(&self) -> Result<()> {
        check_range("edges", self.edges, EDGES[0], EDGES[1])?;
        self.spacing.map_or(Ok(()), |spacing| check_length("spacing", spacing))
    }

    /// Adds a straight vessel of a radius (m) between two nodes, with centerline points when there is a spacing. Its nodes become at
    /// least as wide as the vessel.
    pub(crate) fn add_vessel(&self, network: &mut Network, ends: [usize; 2], radius: f64) {
        let [a, b] = ends.map(|end| network.node(end).position.unwrap_or_default());
        let length = distance(a, b);
        let path = self.spacing.map_or_else(Vec::new, |spacing| {
            let steps = (length / spacing).round().max(1.0) as usize;
            let share = |step: usize| step as f64 / steps as f64;
            let point = |step| if step == steps { b } else { lerp(a, b, share(step)) };
            (0..=steps).map(|step| PathPoint { position: point(step), radius, id: None }).collect()
        });
        widen_nodes(network, ends, radius);
        network.add_vessel(ends, Vessel { path, ..Vessel::new(length, radius, Origin::Observed) });
    }
}
