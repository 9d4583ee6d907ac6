//! Resistance modulation: how pressures, flows and resilience respond when the resistances of the vessels vary at random
//! within classes of growing size (Moriconi et al. 2019).

pub mod hypertension;
mod instances;
mod options;
mod run;

pub use hypertension::{BINS, Hypertension, HypertensionByClass};
pub use instances::{Instances, hypertension_force};
pub use options::{Class, ModulationOptions, Reading};
pub use run::{Modulation, modulate};
