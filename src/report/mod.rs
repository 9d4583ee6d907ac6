//! What a run leaves behind: tables, matrices, topologies, pictures and the record of how it was made.

mod agreement;
mod modulation;
pub mod outcome;
pub mod plots;
pub mod staged;
pub mod summary;
mod tables;

pub use agreement::agreement;
pub use modulation::{ModulationOutcome, write_modulation};
pub use outcome::{Outcome, write_outcome};
pub use staged::{StagedFile, StagedFolder};
pub use summary::{Provenance, Summary};
pub use tables::graph_columns;
