//! The shortest path between two sets of nodes over some of the vessels.

use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use willis_core::network::Network;
use willis_core::network::paths::ShortestPaths;
use willis_core::network::walks::Walk;

/// A set of nodes as flags by row.
pub(crate) type Marks = Vec<bool>;

/// The flags of a set of nodes.
pub(crate) fn marks(network: &Network, nodes: impl IntoIterator<Item = usize>) -> Marks {
    let mut marks = vec![false; network.node_count()];
    for node in nodes {
        marks[node] = true;
    }
    marks
}

/// The shortest path by length from any node of `from` to any of `to` over the vessels that `is_open` selects, through nodes of `avoid` only
/// at its ends. A node of both sets is a path without vessels. Paths longer than `most` (m) do not count.
pub(crate) fn shortest(
    network: &Network,
    [from, to, avoid]: [&Marks; 3],
    is_open: impl Fn(usize) -> bool,
    most: f64,
) -> Option<Walk> {
    let sources: Vec<usize> = (0..from.len()).filter(|node| from[*node]).collect();
    let vessels = |node: usize| {
        let passable = from[node] || !avoid[node];
        let edges = network.graph().edges(NodeIndex::new(node)).filter(move |_| passable);
        edges.map(|e| (e.id().index(), e.target().index(), e.weight().length.max(0.0))).filter(|(vessel, ..)| is_open(*vessel))
    };
    let mut paths = ShortestPaths::new(network.node_count());
    let mut end = None;
    paths.search(&sources, most, vessels, |_, node| {
        end = Some(node).filter(|node| to[*node]);
        end.is_none()
    });
    end.map(|end| paths.path_to(end))
}
