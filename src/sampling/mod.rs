//! From an over-connected graph to its likelihood matrix and its plausible topology.

mod dyadic_sums;
pub mod forest;
mod forest_lanes;
pub mod likelihood;
pub mod options;
mod partial_run;
pub mod patterns;
mod reduced_graph;
mod reduced_graph_lanes;
mod reduced_graph_single;
mod run;
mod sampler;
mod sums;
mod ties;
mod whole_graph;
mod whole_graph_lanes;

pub use dyadic_sums::{DyadicSums, Summed};
pub use forest::{Forest, key};
pub use forest_lanes::{Bottleneck, Taken};
pub use likelihood::{Likelihood, Snapshot, Sums};
pub use options::{SamplingOptions, Solver, Uncertain, Weight};
pub use partial_run::PartialRun;
pub use run::{FIRST_STABLE, Progress, Sampling, infer};
pub use sampler::{Method, Sampler};
