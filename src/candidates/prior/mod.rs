//! The prior: how probable every bridge is before any flow, from its features, by weights fitted to cases with known answers.
//!
//! A fragment c hangs by bridge e with weight w_e = exp(β·x_e), or is a root with weight v_c = exp(γ·z_c); x and z are the
//! features of [`super::evidence`], and [`crate::posterior`] makes probabilities of the weights. A later pass measures what the
//! posterior of the pass before says of the surroundings of a bridge ([`FEEDBACK_FEATURES`]) and weighs that too. At last the
//! probability of a link, summed over its two directions, is calibrated: P = σ(a + b l + c min(l, 0)), l = ln p/(1 - p).

mod alone;
mod answer;
mod belief;
mod calibration;
mod case;
mod closure;
mod figures;
mod fit;
mod folds;
mod hangs;
mod logistic;
mod minimise;
mod objective;
mod platt;
mod rows;
mod weights;
mod weights_file;

pub use crate::candidates::evidence::FEEDBACK_FEATURES;
pub use answer::{Answer, Link, LinkSide, Right};
pub use belief::{Belief, believe};
pub use calibration::Calibration;
pub use case::{Case, Example};
pub use closure::{CLOSURE_FEATURES, Closure, closures};
pub use figures::{Told, average_precision, calibration_error, figures, told};
pub use fit::{Step, TrainParams, fit, goes_without_inlets, train};
pub use folds::{CrossValidation, check_folds, cross_validate, fold_of};
pub use minimise::{Minimum, minimise};
pub use objective::{Objective, case_weights};
pub use platt::calibrate;
pub use rows::Rows;
pub use weights::{Figures, Fold, Pass, Provenance, Weights};
