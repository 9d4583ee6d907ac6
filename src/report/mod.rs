//! What a run leaves behind: tables, matrices, topologies, pictures and the record of how it was made.

mod agreement;
pub mod cohort;
mod disk;
mod flow_record;
mod flow_tables;
mod json;
mod lock;
mod making;
mod modulation;
pub mod names;
mod ours;
pub mod outcome;
pub mod page;
mod part_file;
mod phenotype;
pub mod plots;
mod simulated;
pub mod staged;
pub mod summary;
mod tables;

pub use agreement::agreement;
pub use flow_record::{FlowRecord, MOST_COLLATERALS};
pub use json::{read_json, write_json, write_record};
pub use modulation::{ModulationOutcome, write_modulation};
pub use outcome::{Outcome, write_outcome};
pub use part_file::{read_part, write_part};
pub use phenotype::{Classified, classification_record, collateral_json, phenotype_json, write_collaterals, write_phenotype};
pub use simulated::{Simulated, write_simulated};
pub use staged::{StagedFile, StagedFolder};
pub use summary::{Provenance, Summary, candidate_parameters, outlets_found, word_of_keep};
