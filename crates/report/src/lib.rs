//! The files of a run: tables, matrices, topologies, pictures, pages and the record of how it was made.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod cohort;
pub mod figures;
mod inference;
pub mod modulation;
mod morphometry;
pub mod page;
mod phenotype;
mod run_record;
mod simulation;

pub use inference::{
    Outcome, SolverRecord, agreement, few_perfused, infer_record, questions, review_columns, topology_columns, vessel_columns,
};
pub use modulation::ModulationRun;
pub use morphometry::{
    MeasuredSubject, TwiceRead, difference_columns, kappa_of, named_figures, reader_columns, write_comparison_page,
};
pub use page::{ImagePlace, Segmentation};
pub use phenotype::{
    CircleFigures, NamedFigures, Segments, accuracy_columns, by_artery, collateral_columns, collateral_json, phenotype_json,
    supply_columns, supply_json, write_classified, write_phenotype,
};
pub use run_record::{Provenance, RunRecord};
pub use simulation::{MOST_COLLATERALS, SimulationRun, end_name, pulse_vessel_columns};
