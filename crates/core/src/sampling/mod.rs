//! Samples an over-connected graph: which vessels are open, flow, resilience, spanning forest, and the likelihood summed over all samples.

mod batch_forest;
pub mod block_sums;
mod choose_solver;
mod dyadic_sums;
pub mod expected_forest;
pub mod forest;
mod full_graph;
pub mod likelihood;
pub mod options;
mod partial_run;
pub mod patterns;
mod reduced_graph;
mod reduced_graph_kernel;
pub mod reference;
mod run;
mod sampler;
mod ties;

pub use batch_forest::{ForestProgram, InForest};
pub use choose_solver::Method;
pub use dyadic_sums::{DyadicSums, Summed};
pub use forest::{Coins, Forest};
pub use likelihood::{Likelihood, Snapshot, Sums};
pub use options::{FoundConditions, SamplingOptions, Solver, Uncertain, Weight};
pub use partial_run::PartialRun;
pub use run::{FIRST_STABLE, Progress, Sampling, infer};
pub use sampler::Sampler;
