//! Vessels divided where their label changes along them.

use std::collections::HashMap;

use crate::centerline::Centerlines;
use crate::network::{Network, Node, PathPoint, RadiusRule, Vessel};

/// The network with every vessel divided where the labels of its centerline change: a junction that lost a branch (M1 behind the
/// carotid where there is no A1) is no node, and the name of the longest part is that of the whole otherwise.
///
/// `lines` are the centerlines, welded, that the network was contracted from, whatever their unit. The nodes keep their rows, those
/// between two parts follow; parts stand in the place of their vessel.
pub fn divide(network: &Network, lines: &Centerlines, rule: RadiusRule) -> Network {
    let mut name_of = HashMap::new();
    for (row, link) in lines.links.iter().enumerate() {
        let [a, b] = link.map(|point| lines.ids[point as usize]);
        name_of.insert((a.min(b), a.max(b)), lines.labels.of(row));
    }
    let name = |pair: &[PathPoint]| {
        let (a, b) = (pair[0].id?, pair[1].id?);
        name_of.get(&(a.min(b), a.max(b))).copied()
    };
    let mut divided = Network::new();
    for node in network.nodes() {
        divided.add_node(node.clone());
    }
    for (ends, vessel) in network.vessels() {
        let names: Option<Vec<&str>> = vessel.path.windows(2).map(name).collect();
        let names = names.unwrap_or_default();
        let cuts: Vec<usize> = (1..names.len()).filter(|at| names[*at] != names[at - 1]).collect();
        if cuts.is_empty() {
            divided.add_vessel(ends, vessel.clone());
            continue;
        }
        let (mut from, mut node) = (0, ends[0]);
        for cut in cuts.into_iter().chain([names.len()]) {
            let point = &vessel.path[cut];
            let next = if cut == names.len() {
                ends[1]
            } else {
                let id = point.id.map_or_else(String::new, |id| id.to_string());
                let at = Node { id, position: Some(point.position), radius: Some(point.radius), ..Node::default() };
                divided.add_node(at)
            };
            let part = Vessel::along(vessel.path[from..=cut].to_vec(), rule);
            divided.add_vessel([node, next], Vessel { label: names[from].to_owned(), ..part });
            (from, node) = (cut, next);
        }
    }
    divided
}
