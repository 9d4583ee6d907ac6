//! Neurovascular resilience: the energy that flow dissipates per unit volume of a vessel.

#![expect(clippy::inline_always, reason = "compiled into the caller's instruction set")]

use std::f64::consts::PI;

use crate::support::simd::{Lanes, Scalar, Simd};

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

/// Whether the drop of a vessel is more than rounding beside the pressures at its ends.
#[inline(always)]
fn is_flow<S: Simd>(simd: S, drop: S::f64s, rounding: [S::f64s; 2]) -> S::m64s {
    simd.greater_than_f64s(simd.abs_f64s(drop), simd.max_f64s(rounding[0], rounding[1]))
}

/// The drop (Pa) that is only rounding beside a pressure (Pa).
#[inline(always)]
fn rounding<S: Simd>(simd: S, pressure: S::f64s) -> S::f64s {
    simd.mul_f64s(simd.splat_f64s(DROP_CUT), simd.abs_f64s(pressure))
}

/// ρ = `factor`·x² of a vessel in a group of samples, at most [`MOST_RESILIENCE`], and zero where the vessel is not diffused. x is the flow
/// where a `conductance` is given, else the drop between the pressures at its ends, Pa above `level`.
// Without closures, which are not sure to be compiled into the caller's instruction set.
#[inline(always)]
pub fn diffused_resilience<S: Simd, const B: usize>(
    simd: S,
    [a, b]: [&Lanes<B>; 2],
    level: f64,
    conductance: Option<f64>,
    factor: f64,
) -> Lanes<B> {
    let [factor, most, zero, level] = [factor, MOST_RESILIENCE, 0.0, level].map(|x| simd.splat_f64s(x));
    let mut out = Lanes::ZERO;
    let ends = a.vectors::<S>().iter().zip(b.vectors::<S>());
    for (out, (a, b)) in out.vectors_mut::<S>().iter_mut().zip(ends) {
        let drop = simd.sub_f64s(*a, *b);
        let x = match conductance {
            Some(conductance) => simd.mul_f64s(simd.splat_f64s(conductance), drop),
            None => drop,
        };
        let rho = simd.min_f64s(simd.mul_f64s(simd.mul_f64s(x, x), factor), most);
        let beside = [rounding(simd, simd.add_f64s(*a, level)), rounding(simd, simd.add_f64s(*b, level))];
        *out = simd.select_f64s(is_flow(simd, drop, beside), rho, zero);
    }
    out
}

/// Whether a vessel between pressures `a` and `b` (Pa) with drop `drop` carries flow at all, beyond rounding.
pub fn is_diffused(drop: f64, a: f64, b: f64) -> bool {
    let simd = Scalar::new();
    is_flow(simd, drop, [rounding(simd, a), rounding(simd, b)])
}
