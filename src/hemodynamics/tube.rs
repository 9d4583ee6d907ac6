//! What a vessel is to the flow: a resistance, and the lumen in which it dissipates energy.

use std::f64::consts::PI;

use super::poiseuille::resistance;
use crate::network::Vessel;

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

impl Tube {
    /// A vessel at rest: the resistance that it states, or that of Poiseuille's law.
    pub fn of(vessel: &Vessel, viscosity: f64) -> Self {
        Self {
            resistance: vessel.resistance.unwrap_or_else(|| resistance(vessel.length, vessel.radius, viscosity)),
            volume: PI * vessel.radius * vessel.radius * vessel.length,
            radius: vessel.radius,
        }
    }

    /// Whether blood can pass.
    pub fn is_open(&self) -> bool {
        self.resistance < f64::INFINITY
    }
}
