//! A network as data, exactly as it is in memory: rows of nodes and vessels in SI units.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::Network;
use super::node::Node;
use super::vessel::Vessel;

/// The rows of a network; those of the vessels with their two nodes.
#[derive(Serialize, Deserialize)]
struct Rows<N, V> {
    nodes: Vec<N>,
    vessels: Vec<([usize; 2], V)>,
}

impl Serialize for Network {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows: Rows<&Node, &Vessel> = Rows { nodes: self.nodes().collect(), vessels: self.vessels().collect() };
        rows.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Network {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows: Rows<Node, Vessel> = Rows::deserialize(deserializer)?;
        let mut network = Self::new();
        for node in rows.nodes {
            network.add_node(node);
        }
        for (ends, vessel) in rows.vessels {
            if ends.iter().any(|node| *node >= network.node_count()) {
                return Err(D::Error::custom(format!(
                    "a vessel between nodes {} and {}, which are not all there",
                    ends[0], ends[1]
                )));
            }
            network.add_vessel(ends, vessel);
        }
        Ok(network)
    }
}
