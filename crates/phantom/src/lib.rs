//! Test anatomy with a known answer: complete networks, uncertain extractions of them, and masks.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

mod anatomy;
mod capillary;
pub mod circle;
pub mod curve;
mod damage;
mod extraction;
mod interruptions;
mod mask;
mod tree;
mod truth;
mod tube;

use willis_core::error::{Error, Result};
use willis_core::network::{Condition, Network, Node, Origin, PathPoint, RadiusRule, Role, Vessel};
use willis_core::support::{Point, distance, lerp};

pub use anatomy::{Anatomy, Recipe};
pub use capillary::capillary;
pub use circle::{cerebral, circle_of_willis, without};
pub use damage::Breaks;
pub use extraction::{Gaps, break_up, over_connected, with_gaps};
pub use mask::{MOST_VOXELS, Scan, draw_mask, draw_scan};
pub use tree::{BranchingTree, arterial, branching_tree};
pub use truth::{BreakKind, Contact, MaskBreak, MaskTruth, Truth, landmarks};
pub use tube::DrawnTube;

/// Adds an inner node whose id is the next number.
fn add_node(network: &mut Network, position: Point, radius: Option<f64>) -> usize {
    let id = (network.node_count() + 1).to_string();
    network.add_node(Node { id, position: Some(position), radius, role: Some(Role::Inner), ..Node::default() })
}

/// Adds a vessel of constant radius and known length along points.
fn add_curved_vessel(network: &mut Network, ends: [usize; 2], points: Vec<Point>, length: f64, radius: f64, label: &str) {
    let path = points.into_iter().map(|position| PathPoint { position, radius, id: None }).collect();
    let along = Vessel::along(path, RadiusRule::Mean);
    network.add_vessel(ends, Vessel { length, radius, label: label.to_owned(), ..along });
}

/// Gives the nodes of a vessel at least its radius.
fn widen_nodes(network: &mut Network, nodes: [usize; 2], radius: f64) {
    for node in nodes {
        let current = &mut network.node_mut(node).radius;
        *current = Some(current.map_or(radius, |current| current.max(radius)));
    }
}

/// Gives a node a role and its condition.
fn state(network: &mut Network, row: usize, role: Role, condition: Condition) {
    let node = network.node_mut(row);
    (node.role, node.condition) = (Some(role), Some(condition));
}

/// Refuses a network with a node that has no position.
fn check_positions(network: &Network) -> Result<()> {
    let refused = |node: &Node| Err(Error::parameter("node", &node.id, "has no position; expected one for every node"));
    network.nodes().find(|node| node.position.is_none()).map_or(Ok(()), refused)
}

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
    /// Adds a straight vessel of a radius (m) between two nodes, with centerline points when there is a spacing. Its nodes become at
    /// least as wide as the vessel.
    fn add_vessel(&self, network: &mut Network, ends: [usize; 2], radius: f64) {
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
