//! The model: the probability of every candidate before any flow, from its features, by weights fitted to cases whose connections are known.
//!
//! Candidate e attaches fragment c with weight w_e = exp(β·x_e), or c is a root with weight v_c = exp(γ·z_c); x and z are the
//! features of [`super::features`], and `forest_posterior` makes probabilities of the weights. A later pass measures what the
//! posterior of the pass before says of the surroundings of a candidate ([`FEEDBACK_FEATURES`](super::features::FEEDBACK_FEATURES)) and
//! weighs that too. Last, the probability of a pair of points, summed over its two directions, is calibrated:
//! P = σ(a + b l + c min(l, 0) + d m + e s + f m s), l = ln p/(1 - p), m and s of the whole extraction ([`weights::input_features`]).

pub mod feature_table;
mod likely_inlets;
pub mod loop_closures;
pub mod pass;
pub mod posterior;
pub mod usual;
pub mod weights;
pub(crate) mod weights_file;

pub use loop_closures::CLOSURE_FEATURES;
pub use pass::PassWeights;
pub use posterior::posterior;
pub use usual::Usual;
pub use weights::{Fold, HeldOutScores, Weights};
pub use willis_core::support::calibration::Calibration;
