//! The resistor network of a vascular network: conductances, fixed pressures, terminal resistances, injected flows.

use super::{Boundary, Tube, boundary_conditions::Provisional};
use crate::error::{Error, Result};
use crate::network::{Condition, Network, walks::edges_at};

/// Pressures that differ by less than this share of the larger one count as equal.
const SAME: f64 = 1e-12;

/// Whether two pressures, Pa above a circuit's level, are equal up to rounding.
pub(crate) fn same_pressure(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME * a.max(b)
}

/// A resistor network in SI units. Kirchhoff's current law at every free node j, over its vessels e to nodes i:
/// Σ_e C_e (P_j - P_i) + g_j P_j = s_j.
///
/// After the rows of the vessels come those of the *terminals*: boundary conditions that hold in some samples only, each as a link from its node
/// to one outside, which is open in the samples in which the condition holds. It is a terminal resistance to the venous pressure, or a mark
/// that the node has the pressure outside.
#[derive(Debug, Clone, PartialEq)]
pub struct Circuit {
    /// The two nodes of each row.
    pub ends: Vec<[usize; 2]>,
    /// C = 1/R of each row, m³/(Pa s).
    pub conductance: Vec<f64>,
    /// The pressure of each node where it is fixed, Pa above [`Circuit::level`].
    pub fixed: Vec<Option<f64>>,
    /// g: conductance of each node's terminal resistance, m³/(Pa s).
    pub shunt: Vec<f64>,
    /// s: flow into each node from terminals and injections, m³/s at pressures above the level.
    pub source: Vec<f64>,
    /// The lowest pressure of any condition, Pa. Solving above it keeps every term of the elimination non-negative.
    pub level: f64,
    /// Per terminal whether it fixes the pressure of its node: its conductance then is 1, and counts for nothing.
    pub fixes: Vec<bool>,
}

impl Circuit {
    /// The circuit of a network with all its vessels.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance is zero, infinite or not a number.
    pub fn new(network: &Network, boundary: &Boundary, viscosity: f64) -> Result<Self> {
        Self::with(network, boundary, &Provisional::new(), &Tube::at_rest(network, viscosity))
    }

    /// The circuit of a network whose vessels are `tubes`, the occluded ones without conductance, and whose `provisional` conditions come and go.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance is infinite, not a number, or too small for a double.
    pub fn with(network: &Network, boundary: &Boundary, provisional: &Provisional, tubes: &[Tube]) -> Result<Self> {
        let conductance = conductances(network, tubes)?;
        let grounds = boundary.conditions.iter().filter_map(|(_, condition)| condition.ground());
        let level = grounds.fold(f64::INFINITY, f64::min);
        let level = if level.is_finite() { level } else { 0.0 };
        let nodes = network.node_count();
        let mut circuit = Self {
            ends: network.vessels().map(|(ends, _)| ends).collect(),
            conductance,
            fixed: vec![None; nodes],
            shunt: vec![0.0; nodes],
            source: vec![0.0; nodes],
            level,
            fixes: Vec::new(),
        };
        for (node, condition) in &boundary.conditions {
            let is_provisional = provisional.contains_key(node);
            match condition {
                Condition::Pressure(p) if is_provisional => circuit.link(*node, true, 1.0, p - level),
                Condition::Pressure(p) => circuit.fixed[*node] = Some(p - level),
                Condition::Resistance { resistance, venous } if is_provisional => {
                    circuit.link(*node, false, 1.0 / resistance, venous - level);
                }
                Condition::Resistance { resistance, venous } => {
                    (circuit.shunt[*node], circuit.source[*node]) = (1.0 / resistance, (venous - level) / resistance);
                }
                Condition::Flow(q) => circuit.source[*node] = *q,
            }
        }
        Ok(circuit)
    }

    /// Adds a terminal to a node outside at a pressure, of which there is one for each.
    fn link(&mut self, node: usize, fixes: bool, conductance: f64, pressure: f64) {
        let mut outside = self.ends[self.vessel_count()..].iter().map(|[_, outside]| *outside);
        let there = outside.find(|node| self.fixed[*node] == Some(pressure));
        let there = there.unwrap_or_else(|| {
            self.fixed.push(Some(pressure));
            self.shunt.push(0.0);
            self.source.push(0.0);
            self.fixed.len() - 1
        });
        self.ends.push([node, there]);
        self.conductance.push(conductance);
        self.fixes.push(fixes);
    }

    /// The circuit of one sample, whose terminals that hold are conditions of their nodes; the others are gone. `open` says it of every row.
    #[must_use]
    pub fn in_sample(&self, open: impl Fn(usize) -> bool) -> Self {
        let vessels = self.vessel_count();
        let mut circuit = self.clone();
        for (row, fixes) in (vessels..).zip(circuit.fixes.drain(..)).filter(|(row, _)| open(*row)) {
            let [node, outside] = self.ends[row];
            let outside = self.fixed[outside];
            if fixes {
                circuit.fixed[node] = outside;
            } else {
                circuit.shunt[node] = self.conductance[row];
                circuit.source[node] = self.conductance[row] * outside.unwrap_or(0.0);
            }
        }
        circuit.ends.truncate(vessels);
        circuit.conductance.truncate(vessels);
        circuit
    }

    /// How many nodes there are, those outside included.
    pub fn node_count(&self) -> usize {
        self.fixed.len()
    }

    /// How many vessels there are.
    pub fn vessel_count(&self) -> usize {
        self.ends.len() - self.fixes.len()
    }

    /// How many vessels and terminals there are.
    pub fn row_count(&self) -> usize {
        self.ends.len()
    }

    /// Per node the rows that lead from it to another one.
    pub fn rows_at_nodes(&self) -> Vec<Vec<usize>> {
        edges_at(self.node_count(), self.ends.iter().copied().enumerate().filter(|(_, [a, b])| a != b))
    }

    /// Per row whether it is open in every sample, given that of every vessel.
    pub fn certain_rows(&self, certain: &[bool]) -> Vec<bool> {
        certain.iter().copied().chain(self.fixes.iter().map(|_| false)).collect()
    }

    /// The rows of the terminals that fix the pressure of their node, with the two nodes of each.
    pub fn fixing(&self) -> impl Iterator<Item = (usize, [usize; 2])> {
        let terminals = (self.vessel_count()..).zip(&self.fixes);
        terminals.filter(|(_, fixes)| **fixes).map(|(row, _)| (row, self.ends[row]))
    }

    /// The nodes at which a flow is injected.
    pub fn injected(&self) -> impl Iterator<Item = usize> {
        (0..self.node_count()).filter(|node| self.source[*node] != 0.0 && !self.grounds(*node))
    }

    /// The conductance of a row in the first sample of a block, zero where bit 0 of its mask is not set.
    pub fn if_open(&self, masks: &[u64]) -> impl Fn(usize) -> f64 {
        |vessel| if masks[vessel] & 1 == 1 { self.conductance[vessel] } else { 0.0 }
    }

    /// Whether the node itself fixes the pressure level of its component.
    pub fn grounds(&self, node: usize) -> bool {
        self.fixed[node].is_some() || self.shunt[node] > 0.0
    }

    /// The pressure to which the node is tied, by itself or through its terminal resistance, Pa above the level.
    pub fn ground(&self, node: usize) -> Option<f64> {
        self.fixed[node].or_else(|| (self.shunt[node] > 0.0).then(|| self.source[node] / self.shunt[node]))
    }

    /// The pressures that its conditions hold, Pa above the level, in order; such as differ by rounding are one.
    pub fn levels(&self) -> Vec<f64> {
        let mut levels: Vec<f64> = (0..self.node_count()).filter_map(|node| self.ground(node)).collect();
        levels.sort_unstable_by(f64::total_cmp);
        levels.dedup_by(|b, a| same_pressure(*a, *b));
        levels
    }

    /// Whether nothing but vessels leads to the node.
    pub fn is_inner(&self, node: usize) -> bool {
        self.fixed[node].is_none() && self.shunt[node] == 0.0 && self.source[node] == 0.0
    }

    /// The pressures (Pa) of nodes from those above the level.
    pub fn pressures(&self, above_level: &[Option<f64>]) -> Vec<Option<f64>> {
        above_level.iter().map(|p| p.map(|p| p + self.level)).collect()
    }
}

/// C = 1/R of each vessel, m³/(Pa s), zero of an occluded one.
///
/// # Errors
///
/// The conductance of an open vessel is infinite, not a number, or too small for a double.
pub fn conductances(network: &Network, tubes: &[Tube]) -> Result<Vec<f64>> {
    let conductance = |(row, tube): (usize, &Tube)| {
        let (c, [a, b]) = (1.0 / tube.resistance, network.ends(row));
        let holds = c.is_normal() || a == b || !tube.is_open();
        if holds { Ok(c) } else { Err(beyond_doubles(network, row, "conductance")) }
    };
    tubes.iter().enumerate().map(conductance).collect()
}

/// The error for a vessel so large or small that no double can hold its `quantity`.
pub fn beyond_doubles(network: &Network, row: usize, quantity: &str) -> Error {
    let vessel = network.vessel(row);
    let size = format!("of length {:e} m and radius {:e} m", vessel.length, vessel.radius);
    Error::parameter(network.vessel_name(row), size, format!("expected a {quantity} that a double can hold"))
}
