//! The prior: how probable every bridge is before any flow, from its features, by weights fitted to cases with known answers.
//!
//! A fragment c hangs by bridge e with weight w_e = exp(β·x_e), or is a root with weight v_c = exp(γ·z_c); x and z are the
//! features of [`super::features`], and [`crate::forest_posterior`] makes probabilities of the weights. A later pass measures what the
//! posterior of the pass before says of the surroundings of a bridge ([`FEEDBACK_FEATURES`]) and weighs that too. At last the
//! probability of a link, summed over its two directions, is calibrated: P = σ(a + b l + c min(l, 0)), l = ln p/(1 - p).

pub mod belief;
pub mod closures;
pub mod decision_scores;
pub mod feature_table;
pub mod weights;
mod weights_file;

pub use belief::{Calibration, believe};
pub use closures::CLOSURE_FEATURES;
pub use weights::{Figures, Fold, Pass, Provenance, Weights};
