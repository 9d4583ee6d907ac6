//! Womersley's theory of one tube: what a length of it resists, and what its wall takes up, at one frequency.
//!
//! Per length, at the angular frequency ω (Womersley 1955; as a line of impedances Olufsen 1999, Alastruey et al. 2007):
//! Z' = iωρ/(A (1 - F10)) = 8µ/(πr⁴)/G and Y' = iωC'/(1 + iωφ), with C' = dA/dP and φ of a Kelvin-Voigt wall. Signals are Re c e^{iωt}.

use std::f64::consts::PI;

use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// The profile by which flow meets friction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Friction {
    /// Womersley's: it follows from the frequency.
    #[default]
    Womersley,
    /// A parabola at every frequency, as most one-dimensional codes have it: Z' = 8µ/(πr⁴) + iωρ/A.
    Parabolic,
}

/// What flows, and how walls creep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fluid {
    /// µ, Pa s.
    pub viscosity: f64,
    /// ρ, kg/m³.
    pub density: f64,
    /// The profile of the flow.
    pub friction: Friction,
    /// φ of the wall, s; 0 of an elastic one.
    pub wall_viscosity: f64,
}

/// A tube of one radius.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TubeSegment {
    /// l, m.
    pub length: f64,
    /// r, m.
    pub radius: f64,
    /// C' = dA/dP, m²/Pa; 0 of a rigid wall.
    pub compliance: f64,
    /// What a stated resistance has more than Poiseuille's, Pa s/m⁴; it adds to Z' at every frequency.
    pub excess: f64,
}

/// G = (1 - F10)/(iα²/8) at the Womersley number α = r √(ωρ/µ); 1 at rest.
///
/// G = s₁s₂ with the continued fraction sₙ = 1/(1 + iα² sₙ₊₁/(4n(n+1))) of Bessel functions' ratios, from its end: without
/// cancellation at any α. From n = 1.5 α + 12 on, further terms change no digit.
pub fn viscous(alpha: f64) -> Complex64 {
    let square = Complex64::new(0.0, alpha * alpha);
    let mut s = Complex64::ONE;
    for n in (2..=(1.5 * alpha) as u32 + 12).rev() {
        s = (Complex64::ONE + square * s / f64::from(4 * n * (n + 1))).inv();
    }
    s * (Complex64::ONE + square * s / 8.0).inv()
}

/// The Womersley number α = r √(ωρ/µ).
pub fn womersley_number(fluid: &Fluid, frequency: f64, radius: f64) -> f64 {
    radius * (frequency * fluid.density / fluid.viscosity).sqrt()
}

impl TubeSegment {
    /// Poiseuille's resistance per length, Pa s/m⁴.
    pub fn poiseuille(radius: f64, viscosity: f64) -> f64 {
        8.0 * viscosity / (PI * radius.powi(4))
    }

    /// Whether two segments differ in nothing but their length.
    pub fn is_like(&self, other: &Self) -> bool {
        Self { length: other.length, ..*self } == *other
    }

    /// Z' (Pa s/m⁴) and Y' (m²/(Pa s)) at the angular frequency ω, 1/s.
    pub fn line(&self, fluid: &Fluid, frequency: f64) -> (Complex64, Complex64) {
        let friction = Self::poiseuille(self.radius, fluid.viscosity);
        let z = match fluid.friction {
            Friction::Womersley => viscous(womersley_number(fluid, frequency, self.radius)).inv() * friction,
            Friction::Parabolic => Complex64::new(friction, frequency * fluid.density / (PI * self.radius * self.radius)),
        };
        let wall = Complex64::new(0.0, frequency * self.compliance) / Complex64::new(1.0, frequency * fluid.wall_viscosity);
        (z + self.excess, wall)
    }

    /// c₀ = √(A/(ρC')), the speed of a wave without viscosity, m/s; infinite in a rigid tube.
    pub fn wave_speed(&self, fluid: &Fluid) -> f64 {
        (PI * self.radius * self.radius / (fluid.density * self.compliance)).sqrt()
    }

    /// ω/Im γ, the speed at which a wave of the angular frequency ω moves, m/s; γ = √(Z'Y').
    pub fn phase_speed(&self, fluid: &Fluid, frequency: f64) -> f64 {
        let (z, y) = self.line(fluid, frequency);
        frequency / (z * y).sqrt().im
    }

    /// The wall shear stress (Pa) of a flow amplitude q (m³/s): (r/2) Z' F10 q with F10 = 1 - (iα²/8) G; 4µq/(πr³) at rest.
    pub fn wall_shear(radius: f64, fluid: &Fluid, frequency: f64, q: Complex64) -> Complex64 {
        let friction = q * (radius / 2.0 * Self::poiseuille(radius, fluid.viscosity));
        match fluid.friction {
            Friction::Parabolic => friction,
            Friction::Womersley => {
                let alpha = womersley_number(fluid, frequency, radius);
                let g = viscous(alpha);
                friction * (g.inv() - Complex64::new(0.0, alpha * alpha / 8.0))
            }
        }
    }
}
