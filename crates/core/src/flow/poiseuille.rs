//! Poiseuille's law: the resistance of a straight rigid tube to laminar flow.

use std::f64::consts::PI;

use crate::error::{Result, require};
use crate::network::{Network, Vessel, units::centipoise};

/// Dynamic viscosity of whole blood in large vessels, Pa s (3.5 cP).
pub const BLOOD_VISCOSITY: f64 = 3.5e-3;

/// Refuses a viscosity (Pa s) that is not positive.
///
/// # Errors
///
/// Names the option, the value and what is accepted.
pub fn check_viscosity(viscosity: f64) -> Result<()> {
    let is_positive = viscosity.is_normal() && viscosity > 0.0;
    require(is_positive, "viscosity", centipoise(viscosity), "expected a positive number of cP")
}

/// R = 8µl/(πr⁴), Pa s/m³, of a tube of length `length` (m) and radius `radius` (m) at `viscosity` (Pa s).
pub fn resistance(length: f64, radius: f64, viscosity: f64) -> f64 {
    8.0 * viscosity * length / (PI * radius.powi(4))
}

/// A vessel as the flow meets it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tube {
    /// Pa s/m³; infinite for an occluded vessel.
    pub resistance: f64,
    /// Of the lumen, m³.
    pub volume: f64,
    /// Of the lumen where it is narrowest, m.
    pub radius: f64,
}

/// By what the figures of a vessel are multiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// The resistance, whether it is stated or Poiseuille's.
    pub resistance: f64,
    /// The volume of the lumen.
    pub volume: f64,
    /// The radius where the vessel is narrowest.
    pub radius: f64,
    /// The length.
    pub length: f64,
}

impl Factors {
    /// A vessel left as it is.
    pub const ONE: Self = Self { resistance: 1.0, volume: 1.0, radius: 1.0, length: 1.0 };
}

impl Tube {
    /// Every vessel of a network at rest; `viscosity` in Pa s.
    pub fn at_rest(network: &Network, viscosity: f64) -> Vec<Self> {
        network.vessels().map(|(_, vessel)| Self::of(vessel, viscosity)).collect()
    }

    /// A vessel at rest: the resistance that it states, or that of Poiseuille's law.
    pub fn of(vessel: &Vessel, viscosity: f64) -> Self {
        Self {
            resistance: vessel.resistance.unwrap_or_else(|| resistance(vessel.length, vessel.radius, viscosity)),
            volume: vessel.volume(),
            radius: vessel.radius,
        }
    }

    /// The vessel with its figures multiplied.
    #[must_use]
    pub fn times(&self, by: &Factors) -> Self {
        Self { resistance: self.resistance * by.resistance, volume: self.volume * by.volume, radius: self.radius * by.radius }
    }

    /// Whether blood can pass.
    pub fn is_open(&self) -> bool {
        self.resistance < f64::INFINITY
    }
}
