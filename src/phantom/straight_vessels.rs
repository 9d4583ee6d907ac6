//! What the large phantoms have in common: how many vessels, from which seed, and straight vessels between nodes.

use crate::error::{Error, Result};
use crate::network::{Network, Node, Origin, PathPoint, Vessel};
use crate::support::geometry::{distance, lerp};

/// The least and the greatest number of vessels of a large phantom.
pub const EDGES: [usize; 2] = [100, 10_000_000];

/// The size of a large phantom.
#[derive(Debug, Clone, PartialEq)]
pub struct Large {
    /// Vessels, 100 to 10 000 000.
    pub edges: usize,
    /// The seed of the anatomy.
    pub seed: u64,
    /// Distance of centerline points, m, positive; none for vessels known by their two nodes alone.
    pub spacing: Option<f64>,
}

impl Large {
    /// Refuses a field out of its range.
    ///
    /// # Errors
    ///
    /// Names the field, its value and its range.
    pub fn validate(&self) -> Result<()> {
        let [least, most] = EDGES;
        if !(least..=most).contains(&self.edges) {
            return Err(Error::parameter("edges", self.edges, format!("expected {least} to {most}")));
        }
        match self.spacing.filter(|m| !(m.is_finite() && *m > 0.0)) {
            Some(spacing) => Err(Error::parameter("spacing", spacing, "expected a positive length, m")),
            None => Ok(()),
        }
    }

    /// Adds a straight vessel between two nodes, m, with points in it where a spacing is asked for.
    ///
    /// A node without radius takes that of the vessel, any other the wider of the two.
    pub(crate) fn add_vessel(&self, network: &mut Network, ends: [usize; 2], radius: f64) {
        let [a, b] = ends.map(|end| network.node(end).position.unwrap_or_default());
        let length = distance(a, b);
        let path = self.spacing.map_or_else(Vec::new, |spacing| {
            let steps = (length / spacing).round().max(1.0) as usize;
            let share = |step: usize| step as f64 / steps as f64;
            let point = |step| if step == steps { b } else { lerp(a, b, share(step)) };
            (0..=steps).map(|step| PathPoint { position: point(step), radius, id: None }).collect()
        });
        for end in ends {
            let lumen = &mut network.node_mut(end).radius;
            *lumen = Some(lumen.map_or(radius, |standing| standing.max(radius)));
        }
        network.add_vessel(ends, Vessel { path, ..Vessel::new(length, radius, Origin::Observed) });
    }
}

/// A node of the next number as its id.
pub(crate) fn add_node(network: &mut Network, node: Node) -> usize {
    let id = (network.node_count() + 1).to_string();
    network.add_node(Node { id, ..node })
}
