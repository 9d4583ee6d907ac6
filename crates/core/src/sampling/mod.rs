//! Samples an over-connected graph: which vessels are open, flow, resilience, spanning forest, and the likelihood summed over all samples.

mod batch_forest;
mod block;
mod choose_solver;
pub mod coins;
mod dyadic_sums;
pub mod expected_forest;
pub mod forest;
mod full_graph;
pub mod likelihood;
pub mod options;
mod partial_run;
pub mod patterns;
pub mod per_sample;
mod reduced_graph;
pub mod reference;
mod run;
mod sampled_graph;
mod sampler;
mod ties;

pub use batch_forest::{ForestProgram, InForest, wider};
pub use choose_solver::Method;
pub use coins::Coins;
pub use dyadic_sums::{DyadicSums, Summed};
pub use forest::Kruskal;
pub use likelihood::{Likelihood, Snapshot, Sums};
pub use options::{FoundConditions, SamplingOptions, Solver, Uncertain, Weight};
pub use partial_run::PartialRun;
pub use run::{FIRST_STABLE, Progress, Sampling, infer};
pub use sampler::Sampler;
