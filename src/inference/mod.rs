//! From an over-connected graph to its likelihood matrix and its plausible topology.

mod answer;
mod bottleneck;
mod census;
mod cost;
mod driver;
mod dyadic;
mod ends;
mod forest;
mod group;
mod likelihood;
mod params;
mod part;
mod patterns;
mod probable;
mod reduced;
mod reduced_lanes;
mod reduced_single;
mod sampler;
mod tally;
mod threshold;
mod ties;
mod topologies;
mod whole;

pub use answer::{Answer, Topology, UNDECIDED_BAND, UNDECIDED_Z, decide};
pub use bottleneck::{Bottleneck, Offer, Taken};
pub use driver::{FIRST_STABLE, Progress, Sampling, infer};
pub use dyadic::{Dyadic, Summed};
pub use ends::Known;
pub use forest::{Forest, key};
pub use likelihood::{Likelihood, Snapshot, Sums};
pub use params::{Params, Solver, Uncertain, Weight};
pub use part::Part;
pub use probable::{ExpectedErrors, ROOT_FACTOR, expected_errors, has_evidence, knows_fragments, probabilities, probable};
pub use sampler::{Method, Sampler, Workspace};
pub use threshold::{Keep, threshold};
pub use topologies::{Draw, Topologies};
