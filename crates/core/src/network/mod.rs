//! The vascular network: junctions and free ends as nodes, vessels as edges, observed or candidate.

pub mod centerlines;
pub mod edits;
pub mod find_by_name;
pub mod path_places;
pub mod paths;
pub mod quantity;
pub mod units;
mod validate;
mod vessel;
pub mod walks;
pub mod waveform;

pub use centerlines::{Centerlines, Labels, RadiusRule, WELD_TOLERANCE, contract, is_radius};
pub use edits::{Edit, GraphEditor};
pub use find_by_name::{FoundBy, NearestNode, REACH, locate, nearest_node, parse_position, vessels_called};
pub use paths::{LengthsAt, ShortestPaths, dependents, if_parted, lengths_at, weakest_of_loops};
use units::as_stored;
pub use units::{Frame, LengthUnit, Scale, metres, millimetres};
pub use vessel::{
    Condition, ConditionFrom, END_ODDS, Evidence, INLET_PRESSURE, MOST_ODDS, Node, Origin, PathPoint, Role, Vessel, Wall,
    Windkessel,
};
pub use walks::{Merged, merge};

use std::{borrow::Cow, sync::Arc};

use petgraph::graph::{EdgeIndex, NodeIndex, UnGraph};
use petgraph::unionfind::UnionFind;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};

use crate::support::{Point, counted, lerp, marked, ties::steady};

/// Nodes and vessels, in the order of the input. Parallel vessels and self-loops are allowed. A copy, or a part, shares those that it does not
/// change.
#[derive(Debug, Clone, Default)]
pub struct Network {
    /// Which way the axes of its positions point.
    pub frame: Frame,
    graph: UnGraph<Arc<Node>, Arc<Vessel>>,
}

impl Network {
    /// An empty network.
    pub fn new() -> Self {
        Self::default()
    }

    /// A network of some nodes, and of vessels between the rows of two of them.
    ///
    /// # Panics
    ///
    /// When a node of a vessel does not exist.
    pub fn of(frame: Frame, nodes: Vec<Node>, vessels: Vec<([usize; 2], Vessel)>) -> Self {
        let mut network = Self { frame, ..Self::default() };
        for node in nodes {
            network.add_node(node);
        }
        for (ends, vessel) in vessels {
            network.add_vessel(ends, vessel);
        }
        network
    }

    /// The middle point of the path of a vessel, or the middle between its two nodes where no point lies between them, m.
    pub fn middle_of(&self, ends: [usize; 2], vessel: &Vessel) -> Point {
        let [a, b] = ends.map(|node| self.node(node).position.unwrap_or_default());
        let inner = vessel.path.get(vessel.path.len() / 2).filter(|_| vessel.path.len() > 2);
        inner.map_or(lerp(a, b, 0.5), |point| point.position)
    }

    /// The path of a vessel, or the straight line between its two nodes where it has none; a node without a position is taken to the origin.
    pub fn path_of(&self, row: usize) -> Vec<PathPoint> {
        self.vessel(row).path_between(self.ends(row).map(|node| self.node(node).position.unwrap_or_default()))
    }

    /// Adds a node and returns its row.
    pub fn add_node(&mut self, node: Node) -> usize {
        self.graph.add_node(Arc::new(node)).index()
    }

    /// Adds a vessel between two nodes and returns its row.
    ///
    /// # Panics
    ///
    /// When a node does not exist.
    pub fn add_vessel(&mut self, ends: [usize; 2], vessel: Vessel) -> usize {
        self.graph.add_edge(NodeIndex::new(ends[0]), NodeIndex::new(ends[1]), Arc::new(vessel)).index()
    }

    /// Adds a node of another network and returns its row here.
    fn add_node_of(&mut self, other: &Self, row: usize) -> usize {
        self.graph.add_node(other.graph[NodeIndex::new(row)].clone()).index()
    }

    /// Adds a vessel of another network between two nodes and returns its row here.
    fn add_vessel_of(&mut self, other: &Self, row: usize, ends: [usize; 2]) -> usize {
        self.graph.add_edge(NodeIndex::new(ends[0]), NodeIndex::new(ends[1]), other.graph[EdgeIndex::new(row)].clone()).index()
    }

    /// The nodes and the vessels with their ends, by row, to build another network from.
    pub fn into_parts(self) -> (impl ExactSizeIterator<Item = Node>, impl ExactSizeIterator<Item = ([usize; 2], Vessel)>) {
        let (nodes, edges) = self.graph.into_nodes_edges();
        let ends = |e: &petgraph::graph::Edge<_>| [e.source().index(), e.target().index()];
        let vessel = move |e: petgraph::graph::Edge<Arc<Vessel>>| (ends(&e), Arc::unwrap_or_clone(e.weight));
        (nodes.into_iter().map(|n| Arc::unwrap_or_clone(n.weight)), edges.into_iter().map(vessel))
    }

    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.graph.node_count()
    }

    /// How many vessels there are.
    pub fn vessel_count(&self) -> usize {
        self.graph.edge_count()
    }

    /// The node of a row.
    pub fn node(&self, row: usize) -> &Node {
        &self.graph[NodeIndex::new(row)]
    }

    /// The node of a row, to change it.
    pub fn node_mut(&mut self, row: usize) -> &mut Node {
        Arc::make_mut(&mut self.graph[NodeIndex::new(row)])
    }

    /// The vessel of a row.
    pub fn vessel(&self, row: usize) -> &Vessel {
        &self.graph[EdgeIndex::new(row)]
    }

    /// The vessel of a row, to change it.
    pub fn vessel_mut(&mut self, row: usize) -> &mut Vessel {
        Arc::make_mut(&mut self.graph[EdgeIndex::new(row)])
    }

    /// Makes every length one that survives being written in millimetres.
    pub fn store(&mut self) {
        for row in 0..self.vessel_count() {
            let vessel = self.vessel_mut(row);
            vessel.length = as_stored(vessel.length);
            vessel.radius = as_stored(vessel.radius);
            for point in &mut vessel.path {
                point.radius = as_stored(point.radius);
                point.position = point.position.map(as_stored);
            }
        }
        for row in 0..self.node_count() {
            let node = self.node_mut(row);
            node.radius = node.radius.map(as_stored);
            node.position = node.position.map(|p| p.map(as_stored));
        }
    }

    /// The two nodes of a vessel.
    pub fn ends(&self, row: usize) -> [usize; 2] {
        let edge = &self.graph.raw_edges()[row];
        [edge.source().index(), edge.target().index()]
    }

    /// All nodes by row.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = &Node> {
        self.graph.raw_nodes().iter().map(|n| &*n.weight)
    }

    /// All vessels by row, with their nodes.
    pub fn vessels(&self) -> impl ExactSizeIterator<Item = ([usize; 2], &Vessel)> {
        self.graph.raw_edges().iter().map(|e| ([e.source().index(), e.target().index()], &*e.weight))
    }

    /// The vessels at a node, without a look at the others; a self-loop once.
    pub fn vessels_of(&self, node: usize) -> impl Iterator<Item = &Vessel> {
        self.graph.edges(NodeIndex::new(node)).map(|edge| &**edge.weight())
    }

    /// The graph underneath, for algorithms of petgraph.
    pub fn graph(&self) -> &UnGraph<Arc<Node>, Arc<Vessel>> {
        &self.graph
    }

    /// Per node the number of vessel ends of the vessels that `counts` admits; a self-loop counts twice.
    pub fn degrees(&self, counts: impl Fn(&Vessel) -> bool) -> Vec<usize> {
        counted(self.node_count(), self.vessels().filter(|(_, vessel)| counts(vessel)).flat_map(|(ends, _)| ends))
    }

    /// The name of a vessel in messages: its row and nodes, and its label.
    pub fn vessel_name(&self, row: usize) -> String {
        let [a, b] = self.ends(row);
        let between = format!("vessel {row} ({} - {})", self.node(a).id, self.node(b).id);
        match self.vessel(row).label.as_str() {
            "" => between,
            label => format!("{between} \"{label}\""),
        }
    }

    /// The same nodes with the vessels that `keep` admits, and the rows they had.
    pub fn subgraph(&self, keep: impl Fn(usize) -> bool) -> (Self, Vec<usize>) {
        let rows: Vec<usize> = (0..self.vessel_count()).filter(|row| keep(*row)).collect();
        let mut part = Self { frame: self.frame, graph: UnGraph::with_capacity(self.node_count(), rows.len()) };
        for row in 0..self.node_count() {
            part.add_node_of(self, row);
        }
        for row in &rows {
            part.add_vessel_of(self, *row, self.ends(*row));
        }
        (part, rows)
    }

    /// The nodes that `stays` admits with the vessels between them, and the rows that both had.
    pub fn part(&self, stays: impl Fn(usize) -> bool) -> (Self, Vec<usize>, Vec<usize>) {
        self.parts(1, |node| stays(node).then_some(0)).pop().unwrap_or_default()
    }

    /// As [`Network::part`] for `count` parts in one pass; `of` gives the part of a node.
    pub fn parts(&self, count: usize, of: impl Fn(usize) -> Option<usize>) -> Vec<(Self, Vec<usize>, Vec<usize>)> {
        let mut parts = vec![(Self { frame: self.frame, ..Self::default() }, Vec::new(), Vec::new()); count];
        let mut place = vec![None; self.node_count()];
        for (node, place) in place.iter_mut().enumerate() {
            *place = of(node).map(|part| {
                let (network, nodes, _) = &mut parts[part];
                nodes.push(node);
                (part, network.add_node_of(self, node))
            });
        }
        for row in 0..self.vessel_count() {
            let [a, b] = self.ends(row).map(|node| place[node]);
            if let (Some((part, a)), Some((other, b))) = (a, b)
                && part == other
            {
                let (network, _, vessels) = &mut parts[part];
                network.add_vessel_of(self, row, [a, b]);
                vessels.push(row);
            }
        }
        parts
    }

    /// The same network in another frame; as it is where one of the two is not known.
    pub fn in_frame(&self, to: Frame) -> Cow<'_, Self> {
        if self.frame == to || !self.frame.is_known() || !to.is_known() {
            return Cow::Borrowed(self);
        }
        let mut turned = Self { frame: to, ..self.clone() };
        for row in 0..turned.node_count() {
            let node = turned.node_mut(row);
            node.position = node.position.map(|at| self.frame.turn(to, at));
        }
        for row in 0..turned.vessel_count() {
            for point in &mut turned.vessel_mut(row).path {
                point.position = self.frame.turn(to, point.position);
            }
        }
        Cow::Owned(turned)
    }

    /// Gives back the room for more nodes and vessels, of which a reader leaves up to as much again as there are.
    pub fn shrink_to_fit(&mut self) {
        self.graph.shrink_to_fit();
    }

    /// The places of all nodes, and of the points of all vessels, m.
    pub fn places(&self) -> impl Iterator<Item = Point> {
        let points = self.vessels().flat_map(|(_, vessel)| vessel.path.iter().map(|point| point.position));
        points.chain(self.nodes().filter_map(|node| node.position))
    }

    /// Whether every node has a position.
    pub fn has_positions(&self) -> bool {
        self.nodes().all(|n| n.position.is_some())
    }
}

/// The connected parts of a network, numbered in the order of their first node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fragments {
    /// Per node the number of its part.
    pub of_node: Vec<usize>,
    /// How many parts there are.
    pub count: usize,
}

impl Fragments {
    /// The parts of so many nodes over some links.
    pub fn over(nodes: usize, links: impl Iterator<Item = [usize; 2]>) -> Self {
        let mut parts = UnionFind::<usize>::new(nodes);
        for [a, b] in links {
            parts.union(a, b);
        }
        let (mut number, mut count) = (vec![usize::MAX; nodes], 0);
        let part = |node: usize| {
            let slot = &mut number[parts.find(node)];
            if *slot == usize::MAX {
                *slot = count;
                count += 1;
            }
            *slot
        };
        Self { of_node: (0..nodes).map(part).collect(), count }
    }

    /// Per node whether one of some nodes is in its part.
    pub fn holding(&self, nodes: impl Iterator<Item = usize>) -> Vec<bool> {
        let holds = marked(self.count, nodes.map(|node| self.of_node[node]));
        self.of_node.iter().map(|part| holds[*part]).collect()
    }
}

/// A part shorter than so many of its widths may be a speck of a mask, and no vessel.
const SHORT_WIDTHS: f64 = 3.0;

/// Whether a part of this length and width (m) may be a speck: how it is described decides nothing.
pub fn may_be_speck(length: f64, width: f64) -> bool {
    steady(length / width) < SHORT_WIDTHS
}

/// The connected parts over the vessels that `counts` admits; a node without vessel is a part of its own.
pub fn fragments(network: &Network, counts: impl Fn(usize, &Vessel) -> bool) -> Fragments {
    let counted = network.vessels().enumerate().filter(|(row, (_, vessel))| counts(*row, vessel));
    Fragments::over(network.node_count(), counted.map(|(_, (ends, _))| ends))
}

/// The number of independent cycles, E - N + parts, self-loops and parallel vessels included.
pub fn cycles(network: &Network) -> usize {
    network.vessel_count() + fragments(network, |_, _| true).count - network.node_count()
}

/// A network as serde writes it: rows of nodes, and of vessels with their two nodes, in SI units.
#[derive(Serialize, Deserialize)]
struct NetworkRows<N, V> {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    frame: Option<Frame>,
    nodes: Vec<N>,
    vessels: Vec<([usize; 2], V)>,
}

impl Serialize for Network {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (frame, nodes) = (Some(self.frame).filter(|frame| frame.is_known()), self.nodes().collect());
        NetworkRows::<&Node, &Vessel> { frame, nodes, vessels: self.vessels().collect() }.serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Network {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let rows: NetworkRows<Node, Vessel> = NetworkRows::deserialize(deserializer)?;
        if let Some(([a, b], _)) = rows.vessels.iter().find(|([a, b], _)| *a.max(b) >= rows.nodes.len()) {
            return Err(D::Error::custom(format!("a vessel between nodes {a} and {b}, which do not both exist")));
        }
        Ok(Self::of(rows.frame.unwrap_or_default(), rows.nodes, rows.vessels))
    }
}
