//! Finds the plausible topology of vascular centerlines by neurovascular resilience.
//!
//! Image pipelines extract centerlines that are broken, or joined in too many places. This crate builds the over-connected
//! graph of all connections that may exist, occludes its vessels at random, solves the blood flow of every sample,
//! takes the spanning forest of highest resilience and adds up a likelihood for every vessel. Source: Moriconi et al. 2019,
//! *Towards Quantifying Neurovascular Resilience* ("the paper").
//!
//! ```
//! # let folder = tempfile::tempdir()?;
//! # let out = folder.path().join("out");
//! use willis::{InferOptions, ReadOptions, SaveOptions};
//!
//! let input = willis::read("data/broken-circle-of-willis.swc".as_ref(), &ReadOptions::default())?;
//! let run = willis::infer(&input, &InferOptions::default())?;
//! println!("{} vessels are kept", run.kept().iter().filter(|kept| **kept).count());
//! run.save(&out, &SaveOptions::default())?;
//! # assert!(out.join("topology.vtp").is_file());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! These functions do exactly what the commands of the same names do, with the same defaults. Everything behind them is in
//! [`internals`], which promises nothing. Inside, everything is in SI units; lengths in files are in mm, pressures in mmHg.

pub mod error;
pub mod internals;

mod candidates;
mod circle_of_willis;
mod decision;
mod flow;
mod forest_posterior;
mod io;
mod modulation;
mod network;
mod output;
mod perturbation;
mod phantom;
mod pipeline;
mod report;
mod sampling;
mod simulation;
mod support;
#[cfg(feature = "training")]
mod training;

pub use candidates::{Attach, CandidateOptions, CandidateRadius};
pub use circle_of_willis::LabelScheme;
pub use decision::{Decision, Keep};
pub use error::{Error, Result};
pub use flow::FoundOutlets;
pub use io::ReadOptions;
pub use modulation::ModulationOptions;
pub use network::units::{LengthUnit, Scale};
pub use network::{Network, RadiusRule};
pub use perturbation::stenosis::Stenosis;
pub use pipeline::{
    ArterySource, BoundaryOptions, Contents, FlowOptions, InferOptions, Inference, Input, ModulationRun, Phenotype, Prepared,
    Preset, Prior, Progress, SaveOptions, Shard, Silent, SimulationRun, Step, candidates, classify, infer, infer_with, merge,
    modulate, modulate_with, prepare, read, simulate, simulate_with,
};
pub use sampling::{Likelihood, SamplingOptions, Solver, Uncertain, Weight};
pub use simulation::Change;
