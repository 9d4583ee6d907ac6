//! The order of the nodes in the picture of the likelihood matrix: by the inlet that feeds them, and by fragment where none does.

use std::cmp::Reverse;

use super::figures::NodeBlock;
use willis_core::flow::Boundary;
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::network::{Network, Origin, Role, fragments};

/// The blocks of all nodes: those nearest to each inlet along the observed vessels, then the fragments without an inlet, then all
/// nodes without an observed vessel in one. The largest of each kind comes first.
///
/// Within a block a node follows the one before it on the way from the inlet, or from the fragment's first node, smaller branches
/// first, so that the two ends of an observed vessel stand side by side where they can.
pub fn node_blocks(network: &Network, boundary: &Boundary) -> Vec<NodeBlock> {
    let count = network.node_count();
    let observed = network.vessels().enumerate().filter(|(_, (_, vessel))| vessel.origin == Origin::Observed);
    let at_node = lengths_at(count, observed.map(|(row, (ends, vessel))| (row, ends, vessel.length)));
    let name = |node: usize| {
        let node = network.node(node);
        if node.label.is_empty() { &node.id } else { &node.label }
    };
    let mut paths = ShortestPaths::new(count);
    let mut trees = |sources: &[usize]| {
        let mut visited = Vec::new();
        let around = |node: usize| at_node[node].iter().copied();
        paths.search(sources, f64::INFINITY, around, |_, node| {
            visited.push(node);
            true
        });
        let before = visited.iter().map(|node| paths.previous(*node).map(|(node, _)| node)).collect::<Vec<_>>();
        orders(sources, &visited, &before, count)
    };
    let inlets: Vec<usize> = (0..count).filter(|node| boundary.roles[*node] == Role::Inlet).collect();
    let mut fed = trees(&inlets);
    // Of every fragment without an inlet the first node; nodes without an observed vessel are none.
    let parts = fragments(network, |_, vessel| vessel.origin == Origin::Observed);
    let mut seen = vec![false; parts.count];
    for inlet in &inlets {
        seen[parts.of_node[*inlet]] = true;
    }
    let unfed: Vec<usize> = (0..count).filter(|node| !std::mem::replace(&mut seen[parts.of_node[*node]], true)).collect();
    let (alone, first): (Vec<usize>, Vec<usize>) = unfed.into_iter().partition(|node| at_node[*node].is_empty());
    let mut fragments = trees(&first);
    fed.sort_by_key(|nodes| Reverse(nodes.len()));
    fragments.sort_by_key(|nodes| Reverse(nodes.len()));
    let fed = fed.into_iter().map(|nodes| NodeBlock { name: format!("inlet {}", name(nodes[0])), nodes });
    let fragments = fragments.into_iter().map(|nodes| NodeBlock { name: format!("fragment of {}", name(nodes[0])), nodes });
    let alone = (!alone.is_empty()).then(|| NodeBlock { name: "no vessel".to_owned(), nodes: alone });
    fed.chain(fragments).chain(alone).collect()
}

/// The nodes of the tree of each source in the order of a walk that takes smaller branches first. `before` is the node before each visited one.
pub fn orders(sources: &[usize], visited: &[usize], before: &[Option<usize>], count: usize) -> Vec<Vec<usize>> {
    let mut size = vec![1_usize; count];
    let mut after = vec![Vec::new(); count];
    for (node, before) in visited.iter().zip(before).rev() {
        if let Some(before) = before {
            size[*before] += size[*node];
            after[*before].push(*node);
        }
    }
    let walk = |source: &usize| {
        let (mut order, mut open) = (Vec::new(), vec![*source]);
        while let Some(node) = open.pop() {
            order.push(node);
            let mut next = after[node].clone();
            next.sort_by_key(|node| (Reverse(size[*node]), Reverse(*node)));
            open.extend(next);
        }
        order
    };
    sources.iter().map(walk).collect()
}
