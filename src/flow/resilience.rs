//! Neurovascular resilience: the energy that flow dissipates per unit volume of a vessel.

use std::f64::consts::PI;

/// Pressure drops below this share of the larger pressure are rounding, not flow.
pub const DROP_CUT: f64 = 1e-12;

/// ρ = ΔP·Q / (π r² l), W/m³, of a vessel with pressure drop ΔP (Pa), flow Q (m³/s) and a lumen of volume π r² l (m³).
///
/// For Poiseuille flow this is τ²/(2µ), τ the wall shear stress ΔP r / (2 l) (Moriconi et al. 2019).
pub fn resilience(drop: f64, flow: f64, volume: f64) -> f64 {
    drop * flow / volume
}

/// ρ/ΔP², W/(m³ Pa²): with Q = C ΔP the resilience is this figure of the vessel times the square of its drop.
pub fn resilience_per_square_drop(conductance: f64, volume: f64) -> f64 {
    resilience(1.0, conductance, volume)
}

/// ρ/Q² = 8µ/(π²r⁶), W s²/m⁹, of a vessel that obeys Poiseuille's law: the length cancels, so that vessels in series with
/// one radius have one resilience.
pub fn resilience_per_square_flow(viscosity: f64, radius: f64) -> f64 {
    8.0 * viscosity / (PI * PI * radius.powi(6))
}

/// Whether a vessel between pressures `a` and `b` (Pa) with drop `drop` carries flow at all, beyond rounding.
pub fn is_diffused(drop: f64, a: f64, b: f64) -> bool {
    drop.abs() > DROP_CUT * a.abs().max(b.abs())
}
