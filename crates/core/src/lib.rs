//! The method of [willis](https://docs.rs/willis): networks of vessels, blood flow, sampling, forward simulation, and the decision.
//!
//! An internal part of willis. Nothing here is stable: programs use the functions of the crate `willis`.

pub mod decision;
pub mod error;
pub mod flow;
pub mod forest_posterior;
pub mod modulation;
pub mod morphometry;
pub mod network;
pub mod perturbation;
pub mod sampling;
pub mod simulation;
pub mod support;
