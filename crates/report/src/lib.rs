//! The files of a run: tables, matrices, topologies, pictures, pages and the record of how it was made.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

mod accuracy;
pub mod bids_table;
mod circle_figures;
pub mod cohort;
pub mod figures;
mod inference;
pub mod modulation;
mod morphometry;
pub mod node_blocks;
pub mod page;
mod phenotype;
mod readers;
mod run_record;
mod simulation;
mod supply;

pub use accuracy::{Segments, accuracy_columns};
pub use circle_figures::{CircleFigures, NamedFigures, by_artery};
pub use inference::{
    Outcome, SolverRecord, agreement, few_perfused, questions, review_columns, topology_columns, vessel_columns, write_outcome,
    write_tables,
};
pub use modulation::ModulationRun;
pub use morphometry::{MeasuredSubject, named_figures};
pub use page::{ImagePlace, Segmentation};
pub use phenotype::{collateral_columns, collateral_json, phenotype_json, write_classified, write_phenotype};
pub use readers::{ReadBy, TwiceRead, difference_columns, kappa_of, reader_columns};
pub use run_record::{Provenance, RunRecord, infer_record};
pub use simulation::pulse::pulse_vessel_columns;
pub use simulation::transport::end_name;
pub use simulation::{MOST_COLLATERALS, SimulationRun};
pub use supply::{supply_columns, supply_json};
