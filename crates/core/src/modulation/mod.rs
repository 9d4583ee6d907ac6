//! Resistance modulation: how pressures, flows and resilience respond when the resistances of the vessels vary at random
//! within classes of growing size (Moriconi et al. 2019).

pub mod hypertension;
mod options;
mod run;

pub use hypertension::{BINS, Hypertension, HypertensionByClass};
pub use options::{Class, ModulationOptions, Reading};
pub use run::{Instances, Modulation, hypertension_force, modulate};
