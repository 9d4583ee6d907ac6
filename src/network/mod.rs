//! The vascular network: junctions and free ends as nodes, vessels as edges, observed or candidate.

mod contract;
mod evidence;
mod fragments;
mod locate;
mod naming;
mod stored;

pub use contract::{Contraction, RadiusRule, contract};
pub use evidence::Evidence;
pub use fragments::{Fragments, cycles, fragments};
pub use locate::{Called, Located, locate, nearest, parse_position};
pub use naming::vessels_called;

use petgraph::graph::{EdgeIndex, NodeIndex, UnGraph};
use serde::{Deserialize, Serialize};

use crate::geometry::Point;
use crate::units::{cubic_metres_per_second, ml_per_min, mmhg, mmhg_s_per_ml, pascal_seconds_per_cubic_metre, pascals};

/// A junction, a free end or a landmark.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Node {
    /// The id in the input (GraphML id, SWC index, CSV `node`), unique in the network.
    pub id: String,
    /// Ids of points of the input that were made one with this node.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<String>,
    /// Position, m; absent in a graph without coordinates.
    pub position: Option<Point>,
    /// Radius of the lumen here, m.
    pub radius: Option<f64>,
    /// The anatomical name; empty when the input has none.
    pub label: String,
    /// The role that the input states.
    pub role: Option<Role>,
    /// The boundary condition that the input states.
    pub condition: Option<Condition>,
    /// What speaks for leaving the fragment of this node alone, where the evidence says so: the posterior probability that it
    /// hangs on no other, times the price of that (`candidates::prior::alone`).
    pub alone: Option<f64>,
}

/// What a node is to the flow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Role {
    /// Blood enters here.
    Inlet,
    /// Blood leaves here.
    Outlet,
    /// No condition: Kirchhoff's current law holds.
    Inner,
}

impl Role {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inlet => "inlet",
            Self::Outlet => "outlet",
            Self::Inner => "inner",
        }
    }
}

/// The pressure of an inlet when none is stated, mmHg.
pub const INLET_PRESSURE_MMHG: f64 = 100.0;

/// A boundary condition at a node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Condition {
    /// A fixed pressure, Pa; 0 is ground.
    Pressure(f64),
    /// A terminal resistance, Pa s/m³, to a venous pressure, Pa.
    Resistance {
        /// Pa s/m³, positive.
        resistance: f64,
        /// Pa.
        venous: f64,
    },
    /// A fixed flow into the network, m³/s.
    Flow(f64),
}

impl Condition {
    /// The condition that a file in mmHg and mL hands back.
    #[must_use]
    pub fn as_stored(self) -> Self {
        match self {
            Self::Pressure(p) => Self::Pressure(pascals(mmhg(p))),
            Self::Resistance { resistance, venous } => Self::Resistance {
                resistance: pascal_seconds_per_cubic_metre(mmhg_s_per_ml(resistance)),
                venous: pascals(mmhg(venous)),
            },
            Self::Flow(flow) => Self::Flow(cubic_metres_per_second(ml_per_min(flow))),
        }
    }
}

/// Whether the image showed the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Origin {
    /// Traced in the image.
    Observed,
    /// A possible connection.
    #[default]
    Candidate,
}

impl Origin {
    /// The word in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Observed => "observed",
            Self::Candidate => "candidate",
        }
    }
}

/// A point on a vessel's centerline.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PathPoint {
    /// Position, m.
    pub position: Point,
    /// Radius, m.
    pub radius: f64,
    /// The point's number in the input, where it has one.
    pub id: Option<u64>,
}

/// A vessel between two nodes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Vessel {
    /// Length along the centerline, m.
    pub length: f64,
    /// Radius that stands for the whole vessel, m.
    pub radius: f64,
    /// Resistance, Pa s/m³, where the input states one instead of leaving it to Poiseuille's law.
    pub resistance: Option<f64>,
    /// The anatomical name; empty when the input has none.
    pub label: String,
    /// Observed or candidate.
    pub origin: Origin,
    /// The anatomical prior A in [0, 1].
    pub prior: f64,
    /// Never occluded, whatever is on trial.
    pub certain: bool,
    /// What the evidence says of a candidate.
    pub evidence: Option<Evidence>,
    /// Whether an earlier run kept the vessel, where the input says so.
    pub kept: Option<bool>,
    /// The centerline from the first node to the second; empty when only the nodes are known.
    pub path: Vec<PathPoint>,
}

/// Points at an end over which its radius is averaged.
const END_POINTS: usize = 10;

impl Vessel {
    /// A vessel of a length and radius (m) about which nothing else is known.
    pub fn new(length: f64, radius: f64, origin: Origin) -> Self {
        Self {
            length,
            radius,
            resistance: None,
            label: String::new(),
            origin,
            prior: 1.0,
            certain: false,
            evidence: None,
            kept: None,
            path: Vec::new(),
        }
    }

    /// The mean radius (m) over the last points at an end, the second one when `last`; the vessel's own without a path.
    pub fn end_radius(&self, last: bool) -> f64 {
        let n = self.path.len().min(END_POINTS);
        let points = if last { &self.path[self.path.len() - n..] } else { &self.path[..n] };
        if n == 0 { self.radius } else { points.iter().map(|p| p.radius).sum::<f64>() / n as f64 }
    }
}

/// Nodes and vessels, in the order of the input. Parallel vessels and self-loops are allowed.
#[derive(Debug, Clone, Default)]
pub struct Network {
    graph: UnGraph<Node, Vessel>,
}

impl Network {
    /// An empty network.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a node and returns its row.
    pub fn add_node(&mut self, node: Node) -> usize {
        self.graph.add_node(node).index()
    }

    /// Adds a vessel between two nodes and returns its row.
    ///
    /// # Panics
    ///
    /// When a node does not exist.
    pub fn add_vessel(&mut self, ends: [usize; 2], vessel: Vessel) -> usize {
        self.graph.add_edge(NodeIndex::new(ends[0]), NodeIndex::new(ends[1]), vessel).index()
    }

    /// The nodes and the vessels with their ends, by row, for a network that is made of this one.
    pub fn into_parts(self) -> (impl ExactSizeIterator<Item = Node>, impl ExactSizeIterator<Item = ([usize; 2], Vessel)>) {
        let (nodes, edges) = self.graph.into_nodes_edges();
        let vessel = |e: petgraph::graph::Edge<Vessel>| ([e.source().index(), e.target().index()], e.weight);
        (nodes.into_iter().map(|n| n.weight), edges.into_iter().map(vessel))
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
        &mut self.graph[NodeIndex::new(row)]
    }

    /// The vessel of a row.
    pub fn vessel(&self, row: usize) -> &Vessel {
        &self.graph[EdgeIndex::new(row)]
    }

    /// The vessel of a row, to change it.
    pub fn vessel_mut(&mut self, row: usize) -> &mut Vessel {
        &mut self.graph[EdgeIndex::new(row)]
    }

    /// The two nodes of a vessel.
    pub fn ends(&self, row: usize) -> [usize; 2] {
        let edge = &self.graph.raw_edges()[row];
        [edge.source().index(), edge.target().index()]
    }

    /// All nodes by row.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = &Node> {
        self.graph.raw_nodes().iter().map(|n| &n.weight)
    }

    /// All vessels by row, with their nodes.
    pub fn vessels(&self) -> impl ExactSizeIterator<Item = ([usize; 2], &Vessel)> {
        self.graph.raw_edges().iter().map(|e| ([e.source().index(), e.target().index()], &e.weight))
    }

    /// The graph underneath, for algorithms of petgraph.
    pub fn graph(&self) -> &UnGraph<Node, Vessel> {
        &self.graph
    }

    /// Per node the number of vessel ends of the vessels that `counts` admits; a self-loop counts twice.
    pub fn degrees(&self, counts: impl Fn(&Vessel) -> bool) -> Vec<usize> {
        let mut degree = vec![0; self.node_count()];
        for (ends, vessel) in self.vessels() {
            if counts(vessel) {
                degree[ends[0]] += 1;
                degree[ends[1]] += 1;
            }
        }
        degree
    }

    /// What to call a vessel in a message: its label, or its row and nodes.
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
        let mut part = Self::new();
        for node in self.nodes() {
            part.add_node(node.clone());
        }
        let rows: Vec<usize> = (0..self.vessel_count()).filter(|row| keep(*row)).collect();
        for row in &rows {
            part.add_vessel(self.ends(*row), self.vessel(*row).clone());
        }
        (part, rows)
    }

    /// Whether every node has a position.
    pub fn has_positions(&self) -> bool {
        self.nodes().all(|n| n.position.is_some())
    }
}
