//! What a pulse meets behind an outlet: a Windkessel of three elements, or a resistance.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::vessels::Walled;
use super::womersley::Fluid;
use crate::flow::Boundary;
use crate::network::{Condition, Network, Windkessel};

/// R1 in series with R2 beside C: Z = R1 + R2/(1 + iωR2C).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TerminalImpedance {
    /// R1, Pa s/m³.
    pub proximal: f64,
    /// R2, Pa s/m³.
    pub distal: f64,
    /// C, m³/Pa.
    pub compliance: f64,
}

impl TerminalImpedance {
    /// 1/Z at the angular frequency ω, m³/(Pa s).
    pub fn admittance(&self, frequency: f64) -> Complex64 {
        let behind = Complex64::new(1.0, frequency * self.distal * self.compliance).inv() * self.distal;
        (behind + self.proximal).inv()
    }
}

/// By node what is behind its terminal resistance R. What `stated` leaves open: R1 is the wave impedance of the vessels there,
/// 1/Σ A/(ρc₀), at most R, so that fast waves pass without reflection; C is `time_constant` (s) over R, or nothing, so that R alone
/// is there.
pub fn terminals(
    network: &Network,
    boundary: &Boundary,
    stated: &[Windkessel],
    vessels: &[Walled],
    fluid: &Fluid,
    time_constant: Option<f64>,
) -> Vec<Option<TerminalImpedance>> {
    let mut matched = vec![0.0; network.node_count()];
    for ((ends, _), vessel) in network.vessels().zip(vessels) {
        for (node, segment) in ends.into_iter().zip([vessel.halves[0].first(), vessel.halves[1].last()]) {
            let admittance = segment.map(|s| PI * s.radius * s.radius / (fluid.density * s.wave_speed(fluid)));
            matched[node] += admittance.unwrap_or(0.0);
        }
    }
    let mut out = vec![None; network.node_count()];
    for (node, condition) in &boundary.conditions {
        let Condition::Resistance { resistance, .. } = condition else { continue };
        let compliance = stated[*node].compliance.or(time_constant.map(|time| time / resistance));
        let proximal = stated[*node].proximal.unwrap_or(if compliance.is_some() { 1.0 / matched[*node] } else { *resistance });
        let proximal = proximal.min(*resistance);
        out[*node] = Some(TerminalImpedance { proximal, distal: resistance - proximal, compliance: compliance.unwrap_or(0.0) });
    }
    out
}
