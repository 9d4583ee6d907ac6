//! Graphs of any size for the choice of the solver: points joined to their nearest neighbours, and trees with candidates.

use std::collections::BTreeSet;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use willis::geometry::distance;
use willis::network::{Condition, Network, Node, Origin, Role, Vessel};

/// A kind of graph.
#[derive(Clone, Copy)]
pub enum Family {
    /// Random points, each joined to its four nearest; ten terminals, three of them inlets. Fills in as a three-dimensional mesh does.
    Nearest,
    /// A tree through random points, its ends joined to their three nearest ends; ten terminals.
    Tree,
    /// The same with a terminal at every end, one in four an inlet.
    OpenTree,
}

impl Family {
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Tree, Self::OpenTree];

    pub fn name(self) -> &'static str {
        match self {
            Self::Nearest => "nearest",
            Self::Tree => "tree",
            Self::OpenTree => "open-tree",
        }
    }

    /// The graph on so many nodes.
    pub fn graph(self, nodes: usize) -> Network {
        let mut rng = ChaCha8Rng::seed_from_u64(nodes as u64);
        let mut uniform = || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let points: Vec<[f64; 3]> = (0..nodes).map(|_| std::array::from_fn(|_| 0.1 * uniform())).collect();
        let all: Vec<usize> = (0..nodes).collect();
        let (links, terminals) = match self {
            Self::Nearest => (nearest(&points, &all, 4), all.iter().copied().step_by(nodes.div_ceil(10)).collect()),
            Self::Tree | Self::OpenTree => {
                let tree = tree(&points);
                let mut degree = vec![0; nodes];
                tree.iter().flatten().for_each(|node| degree[*node] += 1);
                let ends: Vec<usize> = all.into_iter().filter(|node| degree[*node] == 1).collect();
                let links = tree.into_iter().chain(nearest(&points, &ends, 3)).collect();
                let step = if matches!(self, Self::Tree) { ends.len().div_ceil(10) } else { 1 };
                (links, ends.into_iter().step_by(step).collect::<Vec<usize>>())
            }
        };
        network(&points, &links, &terminals, uniform)
    }
}

/// Links between each of `among` and its `k` nearest of them.
fn nearest(points: &[[f64; 3]], among: &[usize], k: usize) -> BTreeSet<[usize; 2]> {
    let mut links = BTreeSet::new();
    for from in among {
        let mut others: Vec<usize> = among.iter().copied().filter(|to| to != from).collect();
        let away = |node: &usize| distance(points[*node], points[*from]);
        others.select_nth_unstable_by(k - 1, |a, b| away(a).total_cmp(&away(b)));
        links.extend(others.iter().take(k).map(|to| [*from.min(to), *from.max(to)]));
    }
    links
}

/// Each point joined to the nearest of those before it that has fewer than three vessels.
fn tree(points: &[[f64; 3]]) -> BTreeSet<[usize; 2]> {
    let (mut links, mut degree) = (BTreeSet::new(), vec![0; points.len()]);
    for to in 1..points.len() {
        let from = (0..to)
            .filter(|from| degree[*from] < 3)
            .min_by(|a, b| distance(points[*a], points[to]).total_cmp(&distance(points[*b], points[to])));
        if let Some(from) = from {
            degree[from] += 1;
            degree[to] += 1;
            links.insert([from, to]);
        }
    }
    links
}

fn network(points: &[[f64; 3]], links: &BTreeSet<[usize; 2]>, terminals: &[usize], mut uniform: impl FnMut() -> f64) -> Network {
    let mut network = Network::new();
    for (i, point) in points.iter().enumerate() {
        network.add_node(Node { id: i.to_string(), position: Some(*point), ..Node::default() });
    }
    for (i, node) in terminals.iter().enumerate() {
        let (node, inlet) = (network.node_mut(*node), i % 4 == 0);
        node.role = Some(if inlet { Role::Inlet } else { Role::Outlet });
        node.condition = Some(Condition::Pressure(if inlet { 1e4 + i as f64 } else { 0.0 }));
    }
    for [a, b] in links {
        let radius = 1e-3 * (0.2 + uniform());
        network.add_vessel(
            [*a, *b],
            Vessel {
                length: distance(points[*a], points[*b]),
                radius,
                resistance: None,
                label: String::new(),
                origin: Origin::Candidate,
                prior: 1.0,
                certain: false,
                evidence: None,
                kept: None,
                path: Vec::new(),
            },
        );
    }
    network
}
