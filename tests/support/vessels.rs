//! Makes a vessel, or a network of stated vessels, for the tests.

use willis::internals::network::{Network, Node, Origin, Vessel};

/// An observed vessel of a length and radius in mm.
pub fn tube(length_mm: f64, radius_mm: f64) -> Vessel {
    Vessel::new(length_mm / 1e3, radius_mm / 1e3, Origin::Observed)
}

/// A network whose nodes are called by their rows.
pub fn network(nodes: usize, vessels: impl IntoIterator<Item = ([usize; 2], Vessel)>) -> Network {
    let mut network = Network::new();
    for row in 0..nodes {
        network.add_node(Node { id: row.to_string(), ..Node::default() });
    }
    for (ends, vessel) in vessels {
        network.add_vessel(ends, vessel);
    }
    network
}
