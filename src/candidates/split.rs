//! Splitting observed vessels where a candidate meets them.

use std::collections::{BTreeMap, BTreeSet};

use super::NetworkPoint;
use crate::network::{Network, Node, PathPoint, RadiusRule, Vessel};

/// Per vessel the points at which to split it.
pub type Cuts = BTreeMap<usize, BTreeSet<usize>>;

/// The network with its vessels split, and the new node at every cut.
///
/// A new node takes the number of its point as id; where the point has none, or the id is taken, it is called after the
/// vessel's row and the point.
pub fn split(network: &Network, cuts: &Cuts, rule: RadiusRule) -> (Network, BTreeMap<NetworkPoint, usize>) {
    let mut graph = Network::new();
    for node in network.nodes() {
        graph.add_node(node.clone());
    }
    let mut taken: BTreeSet<String> = network.nodes().map(|n| n.id.clone()).collect();
    let mut node_at = BTreeMap::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let Some(points) = cuts.get(&row) else {
            graph.add_vessel(ends, vessel.clone());
            continue;
        };
        let (mut from, mut start) = (ends[0], 0);
        for point in points {
            let node = graph.add_node(cut_node(vessel, row, *point, &mut taken));
            node_at.insert(NetworkPoint::Along { vessel: row, point: *point }, node);
            graph.add_vessel([from, node], part(vessel, &vessel.path[start..=*point], rule));
            (from, start) = (node, *point);
        }
        graph.add_vessel([from, ends[1]], part(vessel, &vessel.path[start..], rule));
    }
    (graph, node_at)
}

fn cut_node(vessel: &Vessel, row: usize, point: usize, taken: &mut BTreeSet<String>) -> Node {
    let at = &vessel.path[point];
    let mut id = at.id.map_or_else(|| format!("{row}:{point}"), |id| id.to_string());
    while !taken.insert(id.clone()) {
        id = format!("{row}:{id}");
    }
    Node { id, position: Some(at.position), radius: Some(at.radius), ..Node::default() }
}

fn part(vessel: &Vessel, path: &[PathPoint], rule: RadiusRule) -> Vessel {
    Vessel { label: vessel.label.clone(), prior: vessel.prior, certain: vessel.certain, ..Vessel::along(path.to_vec(), rule) }
}
