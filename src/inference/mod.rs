//! From an over-connected graph to its likelihood matrix and its plausible topology.

mod answer;
mod driver;
mod forest;
mod likelihood;
mod sample;
mod threshold;

pub use answer::{Answer, Topology, UNDECIDED_Z, decide};
pub use driver::{Params, Progress, Solver, infer, infer_until_stable};
pub use forest::{Forest, key};
pub use likelihood::{DyadicSum, Likelihood, Snapshot, Sums};
pub use sample::{Sampler, Uncertain, Weight, Workspace};
pub use threshold::{Keep, threshold};
