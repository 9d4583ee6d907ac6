//! The hemodynamic state of a network: what flows where, and how much energy it dissipates.

use std::f64::consts::PI;

use super::balance::{Balanced, carrying};
use super::{Boundary, Circuit, Tube, is_diffused, pressures::PressureSolver, resilience};
use crate::{error::Result, network::Network};

/// Density of blood, kg/m³.
pub const BLOOD_DENSITY: f64 = 1060.0;
/// Reynolds number above which flow in a tube need not be laminar, so that Poiseuille's law no longer holds.
pub const LAMINAR_LIMIT: f64 = 2000.0;

/// The flow in one vessel. Signed figures are positive from its first node to its second; all are zero in a vessel that
/// is not diffused.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VesselState {
    /// Pa s/m³; infinite for an occluded vessel.
    pub resistance: f64,
    /// Of the lumen, m³.
    pub volume: f64,
    /// Pressure at the first node less that at the second, Pa.
    pub drop: f64,
    /// Q, m³/s.
    pub flow: f64,
    /// Mean velocity Q/(πr²) where the vessel is narrowest, m/s.
    pub velocity: f64,
    /// Wall shear stress 4µ|Q|/(πr³) where the vessel is narrowest, Pa; ΔP r/(2l) for a uniform tube under Poiseuille's law.
    pub wall_shear: f64,
    /// Reynolds number 2 r |v| times density over viscosity, where the vessel is narrowest.
    pub reynolds: f64,
    /// ρ = ΔP·Q over the volume of the lumen, W/m³ (Moriconi et al. 2019).
    pub resilience: f64,
    /// Whether blood flows at all.
    pub diffused: bool,
}

/// The flow in a network.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Per node, Pa; `None` in floating components.
    pub pressure: Vec<Option<f64>>,
    /// Per vessel.
    pub vessels: Vec<VesselState>,
    /// ρ_G: Σ ρ over the number of open vessels, W/m³.
    pub network_resilience: f64,
    /// What flows in through the nodes with a boundary condition, m³/s.
    pub inflow: f64,
}

impl State {
    /// Solves a network whose vessels are `tubes`.
    ///
    /// # Errors
    ///
    /// A vessel whose conductance no double can hold, or a breakdown of the solver.
    pub fn solve(network: &Network, boundary: &Boundary, tubes: &[Tube], viscosity: f64) -> Result<Self> {
        let circuit = Circuit::with(network, boundary, &[], tubes)?;
        let above_level = PressureSolver::new(&circuit)?.above_level(|row| tubes[row].is_open())?;
        Ok(Self::at_pressures(&circuit, boundary, tubes, viscosity, &above_level))
    }

    /// The state of `tubes` between the nodes of a circuit at the pressures that a solver found, Pa above its level. Where flows do not
    /// balance at these to 1e-12, they are refined. The circuit's conditions are those that hold ([`Circuit::in_sample`]).
    pub fn at_pressures(circuit: &Circuit, boundary: &Boundary, tubes: &[Tube], viscosity: f64, above: &[Option<f64>]) -> Self {
        let conductance: Vec<f64> = tubes.iter().map(|tube| if tube.is_open() { 1.0 / tube.resistance } else { 0.0 }).collect();
        let Balanced { above_level, drop } = Balanced::of(circuit, &conductance, above);
        let through = |(row, drop): (usize, &f64)| if tubes[row].is_open() { (drop / tubes[row].resistance).abs() } else { 0.0 };
        let is_beyond_rounding = |row: usize| match circuit.ends[row].map(|node| above_level[node]) {
            [Some(a), Some(b)] => is_diffused(drop[row], a + circuit.level, b + circuit.level),
            _ => false,
        };
        let flow: Vec<f64> = drop.iter().enumerate().map(through).collect();
        let carries = carrying(circuit, &flow, (0..flow.len()).map(is_beyond_rounding).collect());
        let vessel = |(row, tube): (usize, &Tube)| {
            if carries[row] && tube.is_open() { VesselState::at(drop[row], tube, viscosity) } else { VesselState::at_rest(tube) }
        };
        let vessels: Vec<VesselState> = tubes.iter().enumerate().map(vessel).collect();
        let open = tubes.iter().filter(|tube| tube.is_open()).count();
        let total: f64 = vessels.iter().map(|v| v.resilience).sum();
        let mut out = vec![0.0; above_level.len()];
        for (vessel, [a, b]) in vessels.iter().zip(&circuit.ends) {
            out[*a] += vessel.flow;
            out[*b] -= vessel.flow;
        }
        let inflow = boundary.conditions.iter().map(|(node, _)| out[*node].max(0.0)).sum();
        let network_resilience = if open > 0 { total / open as f64 } else { 0.0 };
        Self { pressure: circuit.pressures(&above_level), vessels, network_resilience, inflow }
    }

    /// How many vessels carry blood.
    pub fn diffused(&self) -> usize {
        self.vessels.iter().filter(|vessel| vessel.diffused).count()
    }

    /// The vessels whose Reynolds number is above [`LAMINAR_LIMIT`], by row, with that number.
    pub fn beyond_laminar(&self) -> impl Iterator<Item = (usize, f64)> {
        let numbers = self.vessels.iter().map(|vessel| vessel.reynolds).enumerate();
        numbers.filter(|(_, reynolds)| *reynolds > LAMINAR_LIMIT)
    }
}

impl VesselState {
    /// A vessel in which nothing flows.
    fn at_rest(tube: &Tube) -> Self {
        Self { resistance: tube.resistance, volume: tube.volume, ..Self::default() }
    }

    /// A vessel along which the pressure drops so much, Pa.
    fn at(drop: f64, tube: &Tube, viscosity: f64) -> Self {
        let flow = drop / tube.resistance;
        let velocity = flow / (PI * tube.radius * tube.radius);
        Self {
            resistance: tube.resistance,
            volume: tube.volume,
            drop,
            flow,
            velocity,
            wall_shear: 4.0 * viscosity * flow.abs() / (PI * tube.radius.powi(3)),
            reynolds: 2.0 * tube.radius * velocity.abs() * BLOOD_DENSITY / viscosity,
            resilience: resilience(drop, flow, tube.volume),
            diffused: true,
        }
    }
}
