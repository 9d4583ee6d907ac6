//! Fits the evidence model to cases: extractions whose true connections are known, read from folders.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod boosting;
mod cases;
pub mod contact_truth;
pub mod contacts;
pub mod cross_validation;
pub mod example;
pub mod fit;
pub mod joins;
pub mod known_connections;
pub mod logistic;
pub mod minimise;
pub mod names;
pub mod objective;
pub mod scores;
mod truth_file;

pub use cases::{Cases, read_cases};
pub use contacts::{ContactExample, calibrate_contacts};
pub use cross_validation::{check_folds, cross_validate, fold_of};
pub use example::{CandidateExample, Case, Example, Model, TreeExample};
pub use fit::{FittedPass, TrainParams, fit, goes_without_inlets};
pub use joins::JoinExample;
pub use known_connections::Match;
pub use logistic::calibrate;
pub use objective::{Objective, case_weights};
pub use scores::{CaseScores, average_precision, calibration_error};
pub use willis_models::contacts::model::{ContactModel, ContactScores};
