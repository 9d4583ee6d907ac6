//! Walks along edges: runs of vessels that follow each other at nodes where nothing else begins, and parts of a walk. Merges vessels that
//! follow each other without a junction, as candidates leave them behind that were rejected.

use std::borrow::Cow;

use petgraph::unionfind::UnionFind;

use super::{Network, Origin, PathPoint, Role, Vessel, units::as_stored};
use crate::support::{arc_lengths::in_direction, grouped, placed};

/// Nodes and the edges between them: vessels of a network, or links of centerlines.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Walk {
    /// The nodes in order, one more than there are edges.
    pub nodes: Vec<usize>,
    /// The edges in order.
    pub edges: Vec<usize>,
}

impl Walk {
    /// The walk from a node along an edge. It goes on at the nodes that `passes` admits where just two edges are, and not round a ring twice.
    /// `at` are the edges at every node, `ends` the nodes of an edge.
    pub fn along(
        node: usize,
        first: usize,
        at: &[Vec<usize>],
        ends: impl Fn(usize) -> [usize; 2],
        passes: impl Fn(usize) -> bool,
    ) -> Self {
        let mut walk = Self { nodes: vec![node], edges: Vec::new() };
        let (mut node, mut edge) = (node, first);
        loop {
            node = other(ends(edge), node);
            walk.nodes.push(node);
            walk.edges.push(edge);
            match at[node][..] {
                [a, b] if passes(node) => edge = if a == edge { b } else { a },
                _ => return walk,
            }
            if edge == first {
                return walk;
            }
        }
    }

    /// The nodes where it begins and ends.
    pub fn ends(&self) -> [usize; 2] {
        [self.nodes[0], self.nodes[self.edges.len()]]
    }

    /// The points of its vessels in a network, in its direction, each shared node once.
    pub fn points(&self, network: &Network) -> Vec<PathPoint> {
        let mut points = Vec::new();
        for (row, node) in self.edges.iter().zip(&self.nodes) {
            let path = in_direction(network.path_of(*row), network.ends(*row)[0] == *node);
            points.extend_from_slice(&path[usize::from(!points.is_empty())..]);
        }
        points
    }

    /// The part after its last node in `others`.
    #[must_use]
    pub fn after(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().rposition(|node| others.nodes.contains(node)).unwrap_or(0);
        Self { nodes: self.nodes[cut..].to_vec(), edges: self.edges[cut..].to_vec() }
    }

    /// The part before its first node in `others`.
    #[must_use]
    pub fn before(&self, others: &Self) -> Self {
        let cut = self.nodes.iter().position(|node| others.nodes.contains(node)).unwrap_or(self.nodes.len() - 1);
        Self { nodes: self.nodes[..=cut].to_vec(), edges: self.edges[..cut].to_vec() }
    }

    /// Its first vessels up to a length (m), at least one.
    #[must_use]
    pub fn start(&self, network: &Network, most: f64) -> Self {
        let mut length = 0.0;
        let enough = |row: &usize| {
            length += network.vessel(*row).length;
            length >= most
        };
        let cut = self.edges.iter().position(enough).map_or(self.edges.len(), |at| at + 1);
        Self { nodes: self.nodes[..=cut].to_vec(), edges: self.edges[..cut].to_vec() }
    }
}

/// The edges at each of so many nodes, an edge from a node to itself twice. Edges are given by number with their nodes.
pub fn edges_at(nodes: usize, edges: impl Iterator<Item = (usize, [usize; 2])>) -> Vec<Vec<usize>> {
    grouped(nodes, edges.flat_map(|(edge, ends)| ends.map(|node| (node, edge))))
}

/// The vessels at every node that `counts` admits, a vessel from a node to itself twice.
pub fn vessels_at(network: &Network, counts: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
    edges_at(network.node_count(), network.vessels().map(|(ends, _)| ends).enumerate().filter(|(row, _)| counts(*row)))
}

/// Every vessel in one run. A run goes on at the nodes that `passes` admits, where just two vessels of `at` have to be; it has the direction of
/// the first of its vessels. A ring of such nodes begins where its first vessel ends.
pub fn runs(network: &Network, at: &[Vec<usize>], passes: impl Fn(usize) -> bool) -> Vec<Walk> {
    let mut is_used = vec![false; network.vessel_count()];
    let along = |node: usize, first: usize| Walk::along(node, first, at, |row| network.ends(row), &passes);
    let mut found = Vec::new();
    for row in 0..network.vessel_count() {
        if is_used[row] {
            continue;
        }
        let back = along(network.ends(row)[1], row);
        let run = along(back.ends()[1], back.edges[back.edges.len() - 1]);
        run.edges.iter().for_each(|row| is_used[*row] = true);
        found.push(run);
    }
    found
}

/// Every edge in one run between nodes where not just two edges are, in the order of the nodes where they begin; then the rings without such a
/// node, from the first of their nodes on. `at` are the edges at every node, `ends` the nodes of an edge.
pub fn runs_by_node(at: &[Vec<usize>], ends: impl Fn(usize) -> [usize; 2]) -> Vec<Walk> {
    let mut is_used = vec![false; at.iter().flatten().max().map_or(0, |last| last + 1)];
    let mut found = Vec::new();
    for start in (0..at.len()).filter(|node| at[*node].len() != 2).chain(0..at.len()) {
        for first in &at[start] {
            if !is_used[*first] {
                let run = Walk::along(start, *first, at, &ends, |_| true);
                run.edges.iter().for_each(|edge| is_used[*edge] = true);
                found.push(run);
            }
        }
    }
    found
}

/// The other of the two nodes of an edge.
pub fn other([a, b]: [usize; 2], node: usize) -> usize {
    if a == node { b } else { a }
}

/// The node at the other end of a vessel.
pub fn other_end(network: &Network, row: usize, node: usize) -> usize {
    other(network.ends(row), node)
}

/// A network in which vessels are merged, and what its rows were.
#[derive(Debug, Clone)]
pub struct Merged<'a> {
    /// The network.
    pub network: Cow<'a, Network>,
    /// Per node the row that it had.
    pub nodes: Vec<usize>,
    /// Per vessel the rows of its parts, from its first node to its second.
    pub parts: Vec<Vec<usize>>,
}

/// Merges the two vessels at every node that `may_go` admits, where nothing but these two is there and both are alike: observed, with
/// one label, one wall and one prior. A condition, a role, a name or the border of an image keeps a node; no vessel comes to run from a
/// node to itself.
///
/// A merged vessel has the points of its parts, the sum of their lengths, and the radius r = (l / Σ lᵢ/rᵢ⁴)^¼, with which it resists as they
/// do in a row; resistances that they state add up.
pub fn merge(network: Cow<'_, Network>, may_go: impl Fn(usize) -> bool) -> Merged<'_> {
    // No copy and no list of what may be a million nodes, where none of them can go.
    let at = if (0..network.node_count()).any(&may_go) { vessels_at(&network, |_| true) } else { Vec::new() };
    // The runs of vessels while they grow: per vessel one of its run, the ends of each run by its last vessel of that kind.
    let mut grown = UnionFind::<usize>::new(network.vessel_count());
    let mut ends: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
    // Joins the runs of two vessels at the node that they share, unless the whole would begin and end at one node.
    let mut join = |node: usize, pair: [usize; 2]| {
        let [a, b] = pair.map(|row| grown.find_mut(row));
        let far = [a, b].map(|run| other(ends[run], node));
        let joins = a != b && far[0] != far[1];
        if joins {
            grown.union(a, b);
            ends[grown.find_mut(a)] = far;
        }
        joins
    };
    let mut is_gone = vec![false; network.node_count()];
    for node in 0..at.len() {
        let [a, b] = at[node][..] else { continue };
        let alike = || are_alike(network.vessel(a), network.vessel(b));
        is_gone[node] = a != b && may_go(node) && is_plain(&network, node) && alike() && join(node, [a, b]);
    }
    if !is_gone.contains(&true) {
        let parts = (0..network.vessel_count()).map(|row| vec![row]).collect();
        return Merged { nodes: (0..network.node_count()).collect(), parts, network };
    }
    let runs = runs(&network, &at, |node| is_gone[node]);
    let mut made = Network { frame: network.frame, ..Network::new() };
    let nodes: Vec<usize> = (0..is_gone.len()).filter(|node| !is_gone[*node]).collect();
    let row_of = placed(is_gone.len(), nodes.iter().copied());
    for row in &nodes {
        made.add_node_of(&network, *row);
    }
    for run in &runs {
        let ends = run.ends().map(|node| row_of[node]);
        match run.edges[..] {
            [row] => made.add_vessel_of(&network, row, ends),
            _ => made.add_vessel(ends, in_a_row(&network, run)),
        };
    }
    let network = Cow::Owned(made);
    Merged { network, nodes, parts: runs.into_iter().map(|run| run.edges).collect() }
}

/// Whether nothing is known of a node but its place.
fn is_plain(network: &Network, node: usize) -> bool {
    let node = network.node(node);
    let is_inner = node.role.is_none_or(|role| role == Role::Inner) && node.condition.is_none() && node.windkessel.is_none();
    is_inner && node.label.is_empty() && !node.at_border && !node.is_source
}

/// Whether two vessels differ in nothing but where they run.
fn are_alike(a: &Vessel, b: &Vessel) -> bool {
    let plain = |v: &Vessel| v.origin == Origin::Observed && v.evidence.is_none() && !v.path.is_empty();
    let same = a.label == b.label && a.wall == b.wall && a.prior == b.prior && a.certain == b.certain && a.kept == b.kept;
    plain(a) && plain(b) && same && a.resistance.is_some() == b.resistance.is_some()
}

/// The vessel that the parts of a run are.
fn in_a_row(network: &Network, run: &Walk) -> Vessel {
    let vessels = || run.edges.iter().map(|row| network.vessel(*row));
    let length: f64 = vessels().map(|vessel| vessel.length).sum();
    let narrowness: f64 = vessels().map(|vessel| vessel.length / vessel.radius.powi(4)).sum();
    let radius = as_stored((length / narrowness).powf(0.25));
    let resistance = vessels().map(|vessel| vessel.resistance).sum::<Option<f64>>();
    Vessel { length: as_stored(length), radius, resistance, path: run.points(network), ..network.vessel(run.edges[0]).clone() }
}
