//! Merges vessels that follow each other without a junction, as candidates leave them behind that were rejected.

use std::borrow::Cow;

use petgraph::unionfind::UnionFind;

use super::walks::{Walk, other, runs, vessels_at};
use super::{Network, Origin, Role, Vessel, units::as_stored};
use crate::support::placed;

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
