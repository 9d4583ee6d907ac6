//! The shortest path between two sets of nodes over some of the vessels.

use petgraph::graph::NodeIndex;
use petgraph::visit::EdgeRef;

use willis_core::network::Network;
use willis_core::network::paths::ShortestPaths;

/// A path through a network.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Path {
    /// Its nodes from the first to the last.
    pub nodes: Vec<usize>,
    /// The vessels between them.
    pub vessels: Vec<usize>,
}

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
) -> Option<Path> {
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
    end.map(|end| {
        let (nodes, vessels) = paths.path_to(end);
        Path { nodes, vessels }
    })
}

impl Path {
    /// The part after its last node in `others`.
    pub fn after(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().rposition(|node| others.nodes.contains(node)).unwrap_or(0);
        Self { nodes: self.nodes[cut..].to_vec(), vessels: self.vessels[cut..].to_vec() }
    }

    /// The part before its first node in `others`.
    pub fn before(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().position(|node| others.nodes.contains(node)).unwrap_or(self.nodes.len() - 1);
        Self { nodes: self.nodes[..=cut].to_vec(), vessels: self.vessels[..cut].to_vec() }
    }

    /// Its first vessels up to a length (m), at least one.
    pub fn start(&self, network: &Network, most: f64) -> Self {
        let mut length = 0.0;
        let enough = |vessel: &usize| {
            length += network.vessel(*vessel).length;
            length >= most
        };
        let cut = self.vessels.iter().position(enough).map_or(self.vessels.len(), |at| at + 1);
        Self { nodes: self.nodes[..=cut].to_vec(), vessels: self.vessels[..cut].to_vec() }
    }
}
