//! The resistor network of a vascular network: conductances, fixed pressures, terminal resistances, injected flows.

use super::boundary::Boundary;
use super::tube::Tube;
use crate::error::{Error, Result};
use crate::network::{Condition, Network};

/// A resistor network in SI units. Kirchhoff's current law at every free node j, over its vessels e to nodes i:
/// Σ_e C_e (P_j - P_i) + g_j P_j = s_j.
#[derive(Debug, Clone, PartialEq)]
pub struct Circuit {
    /// The two nodes of each vessel.
    pub ends: Vec<[usize; 2]>,
    /// C = 1/R of each vessel, m³/(Pa s).
    pub conductance: Vec<f64>,
    /// The pressure of each node where it is fixed, Pa above [`Circuit::level`].
    pub fixed: Vec<Option<f64>>,
    /// g: conductance of each node's terminal resistance, m³/(Pa s).
    pub shunt: Vec<f64>,
    /// s: flow into each node from terminals and injections, m³/s at pressures above the level.
    pub source: Vec<f64>,
    /// Whether a flow is injected at some node.
    pub injects: bool,
    /// The lowest pressure of any condition, Pa. Solving above it keeps every term of the elimination non-negative.
    pub level: f64,
}

impl Circuit {
    /// The circuit of a network with all its vessels.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance is zero, infinite or not a number.
    pub fn new(network: &Network, boundary: &Boundary, viscosity: f64) -> Result<Self> {
        let tubes: Vec<Tube> = network.vessels().map(|(_, vessel)| Tube::of(vessel, viscosity)).collect();
        Self::of_tubes(network, boundary, &tubes)
    }

    /// The circuit of a network whose vessels are `tubes`, the occluded ones without conductance.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance is infinite, not a number, or too small for a double.
    pub fn of_tubes(network: &Network, boundary: &Boundary, tubes: &[Tube]) -> Result<Self> {
        let conductance = tubes.iter().enumerate().map(|(row, tube)| conductance(network, row, tube)).collect::<Result<_>>()?;
        let pressures = boundary.conditions.iter().filter_map(|(_, condition)| match condition {
            Condition::Pressure(p) => Some(*p),
            Condition::Resistance { venous, .. } => Some(*venous),
            Condition::Flow(_) => None,
        });
        let level = pressures.fold(f64::INFINITY, f64::min);
        let level = if level.is_finite() { level } else { 0.0 };
        let nodes = network.node_count();
        let mut circuit = Self {
            ends: network.vessels().map(|(ends, _)| ends).collect(),
            conductance,
            fixed: vec![None; nodes],
            shunt: vec![0.0; nodes],
            source: vec![0.0; nodes],
            injects: false,
            level,
        };
        for (node, condition) in &boundary.conditions {
            match condition {
                Condition::Pressure(p) => circuit.fixed[*node] = Some(p - level),
                Condition::Resistance { resistance, venous } => {
                    circuit.shunt[*node] = 1.0 / resistance;
                    circuit.source[*node] = (venous - level) / resistance;
                }
                Condition::Flow(q) => {
                    circuit.source[*node] = *q;
                    circuit.injects = true;
                }
            }
        }
        Ok(circuit)
    }

    /// How many nodes there are.
    pub fn node_count(&self) -> usize {
        self.fixed.len()
    }

    /// How many vessels there are.
    pub fn vessel_count(&self) -> usize {
        self.ends.len()
    }

    /// Whether the node itself fixes the pressure level of its component.
    pub fn grounds(&self, node: usize) -> bool {
        self.fixed[node].is_some() || self.shunt[node] > 0.0
    }
}

/// C = 1/R of the vessel in a row, m³/(Pa s).
///
/// # Errors
///
/// The conductance of an open vessel is infinite, not a number, or too small for a double.
pub fn conductance(network: &Network, row: usize, tube: &Tube) -> Result<f64> {
    let c = 1.0 / tube.resistance;
    let [a, b] = network.ends(row);
    if c.is_normal() || a == b || !tube.is_open() {
        return Ok(c);
    }
    let vessel = network.vessel(row);
    Err(Error::parameter(
        network.vessel_name(row),
        format!("of length {} m and radius {} m", vessel.length, vessel.radius),
        "expected a conductance that a double can hold",
    ))
}
