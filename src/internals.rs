//! Everything behind the front door, for this project's own command line, tests, benches and experiments.
//!
//! Nothing here is stable: names, fields and behaviour may change in any version. Programs that use willis call the functions at the
//! root of the crate.

/// See `src/candidates`.
pub mod candidates {
    pub use crate::candidates::*;
}
/// See `src/circle_of_willis`.
pub mod circle_of_willis {
    pub use crate::circle_of_willis::*;
}
/// See `src/contacts`.
pub mod contacts {
    pub use crate::contacts::*;
}
/// See `src/decision`.
pub mod decision {
    pub use crate::decision::*;
}
/// See `src/flow`.
pub mod flow {
    pub use crate::flow::*;
}
/// See `src/forest_posterior`.
pub mod forest_posterior {
    pub use crate::forest_posterior::*;
}
/// See `src/io`.
pub mod io {
    pub use crate::io::*;
}
/// See `src/masks`.
pub mod masks {
    pub use crate::masks::*;
}
/// See `src/modulation`.
pub mod modulation {
    pub use crate::modulation::*;
}
/// See `src/naming`.
pub mod naming {
    pub use crate::naming::*;
}
/// See `src/network`.
pub mod network {
    pub use crate::network::*;
}
/// See `src/output`.
pub mod output {
    pub use crate::output::*;
}
/// See `src/perturbation`.
pub mod perturbation {
    pub use crate::perturbation::*;
}
/// See `src/phantom`.
pub mod phantom {
    pub use crate::phantom::*;
}
/// See `src/pipeline`.
pub mod pipeline {
    pub use crate::pipeline::*;
}
/// See `src/report`.
pub mod report {
    pub use crate::report::*;
}
/// See `src/sampling`.
pub mod sampling {
    pub use crate::sampling::*;
}
/// See `src/simulation`.
pub mod simulation {
    pub use crate::simulation::*;
}
/// See `src/support`.
pub mod support {
    pub use crate::support::*;
}
/// See `src/training`.
#[cfg(feature = "training")]
pub mod training {
    pub use crate::training::*;
}
