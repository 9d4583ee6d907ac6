//! Neurovascular resilience: the energy that flow dissipates per unit volume of a vessel.

use std::f64::consts::PI;

use crate::support::simd::{Scalar, Simd};

/// Pressure drops below this share of the larger pressure are rounding, not flow.
pub const DROP_CUT: f64 = 1e-12;
/// Resiliences are cut off here, so that the keys by which they are sorted stay finite as doubles.
pub const MOST_RESILIENCE: f64 = f64::MAX / 8.0;

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

/// The drop (Pa) that is no more than rounding beside a pressure (Pa) at one end of a vessel.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
pub fn rounding_drop<S: Simd>(simd: S, pressure: S::f64s) -> S::f64s {
    simd.mul_f64s(simd.splat_f64s(DROP_CUT), simd.abs_f64s(pressure))
}

/// Whether vessels are diffused: their drop is more than what is only `rounding` beside the pressures
/// at their ends, the larger [`rounding_drop`] of the two.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
pub fn diffused<S: Simd>(simd: S, drop: S::f64s, rounding: S::f64s) -> S::m64s {
    simd.greater_than_f64s(simd.abs_f64s(drop), rounding)
}

/// ρ = `factor`·x² of vessels, at most [`MOST_RESILIENCE`], and zero where they are not diffused. x is the drop, or the flow, whichever
/// the factor belongs to.
#[expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]
#[inline(always)]
pub fn diffused_resilience<S: Simd>(simd: S, factor: f64, x: S::f64s, drop: S::f64s, rounding: S::f64s) -> S::f64s {
    let rho = simd.mul_f64s(simd.mul_f64s(x, x), simd.splat_f64s(factor));
    let rho = simd.min_f64s(rho, simd.splat_f64s(MOST_RESILIENCE));
    simd.select_f64s(diffused(simd, drop, rounding), rho, simd.splat_f64s(0.0))
}

/// Whether a vessel between pressures `a` and `b` (Pa) with drop `drop` carries flow at all, beyond rounding.
pub fn is_diffused(drop: f64, a: f64, b: f64) -> bool {
    let simd = Scalar::new();
    diffused(simd, drop, simd.max_f64s(rounding_drop(simd, a), rounding_drop(simd, b)))
}
