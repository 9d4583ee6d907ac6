//! Poiseuille's law: the resistance of a straight rigid tube to laminar flow.

use std::f64::consts::PI;

use crate::error::{Error, Result};
use crate::units::centipoise;

/// Dynamic viscosity of whole blood in large vessels, Pa s (3.5 cP).
pub const BLOOD_VISCOSITY: f64 = 3.5e-3;

/// Refuses a viscosity (Pa s) that is not positive.
///
/// # Errors
///
/// Names the option, the value and what is accepted.
pub fn check_viscosity(viscosity: f64) -> Result<()> {
    if viscosity.is_normal() && viscosity > 0.0 {
        return Ok(());
    }
    Err(Error::parameter("--viscosity", centipoise(viscosity), "expected a positive number of cP"))
}

/// R = 8µl/(πr⁴), Pa s/m³, of a tube of length `length` (m) and radius `radius` (m) at `viscosity` (Pa s).
pub fn resistance(length: f64, radius: f64, viscosity: f64) -> f64 {
    8.0 * viscosity * length / (PI * radius.powi(4))
}
