//! Finds the plausible topology of vascular centerlines by neurovascular resilience.
//!
//! Image pipelines extract centerlines that are broken, or joined in too many places. This crate builds the over-connected
//! graph of all connections that may exist, occludes its vessels at random, solves the blood flow of every sample,
//! takes the spanning forest of highest resilience and adds up a likelihood for every vessel. Source: Moriconi et al. 2019,
//! *Towards Quantifying Neurovascular Resilience* ("the paper").

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
mod report;
mod sampling;
mod simulation;
mod support;
#[cfg(feature = "training")]
mod training;
