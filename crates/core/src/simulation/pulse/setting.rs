//! What the pulse of a network is computed from: what drives it, and what it meets beside the steady flow.

use num_complex::Complex64;

use super::terminal::TerminalImpedance;
use super::vessels::Walled;
use super::womersley::Fluid;
use crate::network::waveform::Quantity;

/// What drives a node at every harmonic but 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The node.
    pub node: usize,
    /// Whether its pressure or the flow into it is prescribed.
    pub quantity: Quantity,
    /// c_0 to c_H, Pa or m³/s; c_0 is left to the steady flow.
    pub coefficients: Vec<Complex64>,
}

/// What the pulse meets beside the steady flow.
#[derive(Debug, Clone, Copy)]
pub struct Setting<'a> {
    /// Blood and how it meets friction.
    pub fluid: &'a Fluid,
    /// T, s.
    pub period: f64,
    /// H.
    pub harmonics: usize,
    /// The vessels, by row.
    pub vessels: &'a [Walled],
    /// What drives nodes.
    pub drives: &'a [Drive],
    /// By node, what is behind a terminal resistance.
    pub terminals: &'a [Option<TerminalImpedance>],
}
