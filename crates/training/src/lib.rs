//! Fits the evidence model to cases: extractions whose true connections are known, read from folders.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod boosting;
mod cases;
pub mod contact_truth;
pub mod contacts;
pub mod example;
pub mod fit;
pub mod joins;
pub mod known_connections;
pub mod minimise;
pub mod names;

pub use cases::{Cases, read_cases};
pub use contacts::{ContactExample, calibrate_contacts};
pub use example::{CandidateExample, Case, CaseScores, Example, Model, TreeExample};
pub use example::{Folds, average_precision, calibration_error, cross_validate, fold_of};
pub use fit::{FittedPass, Objective, TrainParams, case_weights, fit, goes_without_inlets};
pub use joins::JoinExample;
pub use known_connections::Match;
pub use minimise::calibrate;
pub use willis_models::contacts::model::{ContactModel, ContactScores};
