//! Evidence: the dimensionless features that say how probable each candidate is before any flow.
//!
//! Every length is divided by a local diameter, the spacing of the points or another length of the same extraction, so that
//! one set of weights serves thin trees and wide circles, in any unit. A feature is a function of a `MeasuredCandidate` and a row of
//! [`FEATURES`]: that is all it takes to add or drop one.

pub(crate) mod branch_graph;
pub mod candidate_features;
pub(crate) mod extraction;
pub(crate) mod feedback;
pub(crate) mod fragment;
pub(crate) mod measured_candidate;
mod orientation;
pub(crate) mod root_features;
pub(crate) mod smoothing;
mod tangent;

pub use candidate_features::{FEATURES, Feature};
pub use extraction::Extraction;
pub use feedback::{FEEDBACK_FEATURES, Feedback};
pub use measured_candidate::measured;
pub use root_features::{ROOT_FEATURES, root_features};

use ndarray::Array2;

use super::search::EndCandidate;

/// The features of candidates: a row a candidate, a column a feature of [`FEATURES`].
///
/// Rank, margin and mutual choice compare the candidates given, so these should be all of a search. [`Feedback`] measures what the
/// posterior of these features says of the other candidates.
pub fn features(extraction: &Extraction, candidates: &[EndCandidate]) -> Array2<f64> {
    let measured = measured(extraction, candidates);
    Array2::from_shape_fn((measured.len(), FEATURES.len()), |(row, column)| FEATURES[column].1(&measured[row]))
}
