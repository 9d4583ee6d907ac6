//! What the pulse of a network is computed from: what drives it, and what it meets beside the steady flow. Vessels are their lumen in
//! stretches of one radius, cut in the middle, with and without perturbations; behind an outlet is a Windkessel of three elements, or a
//! resistance.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::womersley::{Fluid, TubeSegment};
use crate::flow::{Boundary, Tube, WallLaw, poiseuille::resistance};
use crate::network::{Condition, Network, Windkessel, waveform::Quantity};
use crate::simulation::{Change, Perturbation};
use crate::{error::Result, perturbation::StretchPlace, support::grouped};

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

/// A vessel with its wall.
#[derive(Debug, Clone, PartialEq)]
pub struct Walled {
    /// From the first node to the middle, and from there to the second; empty where the vessel is closed.
    pub halves: [Vec<TubeSegment>; 2],
    /// The radius where it is narrowest, m.
    pub narrowest: f64,
    /// The volume of the lumen, m³.
    pub volume: f64,
}

impl Walled {
    /// Whether blood can pass.
    pub fn is_open(&self) -> bool {
        !self.halves[0].is_empty()
    }
}

/// The vessels of a network with all `changes`, whose figures at rest are `tubes`.
///
/// The law of the wall holds for a narrowed lumen as for any other of its radius. A stated resistance is spread over the length.
///
/// # Errors
///
/// A wall that [`WallLaw::compliance`] refuses.
pub fn walled(network: &Network, tubes: &[Tube], changes: &[Perturbation], law: &WallLaw, fluid: &Fluid) -> Result<Vec<Walled>> {
    let changes = grouped(network.vessel_count(), changes.iter().map(|p| (p.vessel, &p.change)));
    let vessel = |row: usize| {
        let (vessel, tube) = (network.vessel(row), &tubes[row]);
        let (narrowest, volume) = (tube.radius, tube.volume);
        if !tube.is_open() {
            return Ok(Walled { halves: Default::default(), narrowest, volume });
        }
        let stated = vessel.resistance.map(|r| r / vessel.length - resistance(1.0, vessel.radius, fluid.viscosity));
        let segment = |length: f64, open: f64| {
            let radius = vessel.radius * open;
            let compliance = law.compliance(radius, vessel.wall, fluid.density, &network.vessel_name(row))?;
            Ok::<_, crate::error::Error>(TubeSegment { length, radius, compliance, excess: stated.unwrap_or(0.0) / open.powi(4) })
        };
        let longer = changes[row].iter().find_map(|c| if let Change::Tortuosity(factor) = c { Some(*factor) } else { None });
        let length = vessel.length * longer.unwrap_or(1.0);
        let stenosis = changes[row].iter().find_map(|c| if let Change::Stenosis(s) = c { Some(s) } else { None });
        let segments = match stenosis {
            None => vec![segment(length, 1.0)?],
            Some(stenosis) => {
                let stretch = stenosis.stretch.unwrap_or(length).min(length);
                let rest = length - stretch;
                let before = match stenosis.place {
                    StretchPlace::Start => 0.0,
                    StretchPlace::Middle => rest / 2.0,
                    StretchPlace::End => rest,
                };
                let all = [segment(before, 1.0)?, segment(stretch, stenosis.open_diameter)?, segment(rest - before, 1.0)?];
                all.into_iter().filter(|segment| segment.length > 0.0).collect()
            }
        };
        Ok(Walled { halves: halves(&segments, length / 2.0), narrowest, volume })
    };
    (0..network.vessel_count()).map(vessel).collect()
}

/// Segments, cut at a length from their beginning.
fn halves(segments: &[TubeSegment], at: f64) -> [Vec<TubeSegment>; 2] {
    let (mut first, mut last, mut left) = (Vec::new(), Vec::new(), at);
    for segment in segments {
        let here = segment.length.min(left);
        left -= here;
        for (part, length) in [(&mut first, here), (&mut last, segment.length - here)] {
            if length > 0.0 {
                part.push(TubeSegment { length, ..*segment });
            }
        }
    }
    [first, last]
}

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
