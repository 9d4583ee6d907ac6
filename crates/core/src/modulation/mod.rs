//! Resistance modulation: how pressures, flows and resilience respond when the resistances of the vessels vary at random
//! within classes of growing size (Moriconi et al. 2019).

pub mod hypertension;
mod run;

pub use hypertension::{BINS, Hypertension, HypertensionByClass};
pub use run::{Class, Instances, Modulation, ModulationOptions, Reading, hypertension_force, modulate};
