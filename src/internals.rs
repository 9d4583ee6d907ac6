//! Everything behind the front door, for this project's own command line, tests, benches and experiments.
//!
//! Nothing here is stable: names, fields and behaviour may change in any version. Programs that use willis call the functions at the
//! root of the crate.

/// See `src/pipeline`.
pub mod pipeline {
    pub use crate::pipeline::*;
}
pub use willis_core::{
    decision, flow, forest_posterior, modulation, morphometry, network, perturbation, sampling, simulation, support,
};
pub use willis_io::{formats, masks, output};
pub use willis_models::{candidates, circle_of_willis, contacts, naming};
pub use willis_phantom as phantom;
pub use willis_report as report;
#[cfg(any(feature = "train", feature = "experiments"))]
pub use willis_training as training;
