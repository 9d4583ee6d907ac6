//! The landmarks that a person would set on an extraction: where the arteries that it shows come in and go out.

use super::Truth;
use crate::geometry::Point;
use crate::network::Network;

/// The labelled free ends of a complete network, but for vessels that its extraction lost: label and true position, m, in node order.
pub fn landmarks<'a>(network: &'a Network, truth: &Truth) -> Vec<(&'a str, Point)> {
    let degree = network.degrees(|_| true);
    let mut found: Vec<(usize, &str, Point)> = Vec::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let shown = !vessel.label.is_empty() && !truth.lost.contains(&row);
        for node in ends.into_iter().filter(|node| shown && degree[*node] == 1) {
            found.extend(network.node(node).position.map(|position| (node, vessel.label.as_str(), position)));
        }
    }
    found.sort_by_key(|(node, ..)| *node);
    found.into_iter().map(|(_, label, position)| (label, position)).collect()
}
