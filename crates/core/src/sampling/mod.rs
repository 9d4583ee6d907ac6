//! Samples an over-connected graph: which vessels are open, flow, resilience, spanning forest, and the likelihood summed over all samples.

mod batch_forest;
mod choose_solver;
pub mod coins;
pub mod forest;
mod graph_of_network;
pub mod likelihood;
pub mod options;
pub mod reference;
mod run;
mod sampled_graph;
mod ties;

pub use batch_forest::{ForestProgram, InForest, wider};
pub use choose_solver::Method;
pub use coins::Coins;
pub use forest::Kruskal;
pub use likelihood::{DyadicSums, Likelihood, PartialRun, Snapshot, Sums};
pub use options::{FoundConditions, SamplingOptions, Solver, Uncertain, Weight};
pub use run::{FIRST_STABLE, Progress, Sampling, infer};
