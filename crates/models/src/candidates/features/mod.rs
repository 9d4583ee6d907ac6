//! Evidence: the dimensionless features that say how probable each candidate is before any flow.
//!
//! Every length is divided by a local diameter, the spacing of the points or another length of the same extraction, so that
//! one set of weights serves thin trees and wide circles, in any unit. A feature is a function of a `MeasuredCandidate` and a row of
//! [`FEATURES`]: that is all it takes to add or drop one.

pub(crate) mod branch_graph;
pub mod candidate_features;
pub(crate) mod extraction;
pub(crate) mod feedback;
mod fragment;
pub(crate) mod measured_candidate;
mod orientation;
pub(crate) mod root_features;
pub(crate) mod smoothing;
mod tangent;

pub use extraction::Extraction;
pub use feedback::{FEEDBACK_FEATURES, Feedback};
pub use measured_candidate::measured;
pub use root_features::{ROOT_FEATURES, root_features};

use ndarray::Array2;

use super::search::EndCandidate;
use measured_candidate::MeasuredCandidate;

/// A feature of a candidate.
pub type Feature = fn(&MeasuredCandidate) -> f64;

/// The features of a candidate, by the names that weights have in a file.
pub const FEATURES: &[(&str, Feature)] = &[
    ("is_end", candidate_features::at_free_end),
    ("gap", candidate_features::gap),
    ("bend_child_sq", candidate_features::bend_child_squared),
    ("bend_child", candidate_features::bend_child),
    ("gap_end", candidate_features::gap_at_free_end),
    ("bend_parent_sq", candidate_features::bend_parent_squared),
    ("wall_branch", candidate_features::wall_between_ends),
    ("gap_branch", candidate_features::gap_between_ends),
    ("kink", candidate_features::kink_towards),
    ("ratio_branch", candidate_features::branch_ratio),
    ("bend_far", candidate_features::bend_far),
    ("ratio_end_sq", candidate_features::radius_step_squared),
    ("wall", candidate_features::log_gap_to_wall),
    ("resolution_branch", candidate_features::log_width_between_ends),
    ("ratio_branch_sq", candidate_features::branch_ratio_squared),
    ("turn", candidate_features::worst_bend),
    ("bend_gap", candidate_features::bend_child_over_gap),
    ("margin", candidate_features::margin),
    ("blocked", candidate_features::blocked),
    ("bend_parent", candidate_features::bend_parent),
    ("ratio_end", candidate_features::radius_step),
    ("rank", candidate_features::rank),
    ("share_parent", candidate_features::parent_share),
    ("orientation", candidate_features::orientation),
    ("fed_parent", candidate_features::parent_fed),
    ("near_tip", candidate_features::near_free_end),
    ("touch_branch", candidate_features::touches_wall),
    ("mutual", candidate_features::mutual),
    ("wall_over_3", candidate_features::wall_far_beyond_reach),
    ("wall_over_1_5", candidate_features::wall_beyond_reach),
    ("kink_wide", candidate_features::far_kink_from),
    ("kink_excess", candidate_features::kink_excess),
    ("near_junction", candidate_features::near_junction),
];

/// The features of candidates: a row a candidate, a column a feature of [`FEATURES`].
///
/// Rank, margin and mutual choice compare the candidates given, so these should be all of a search. [`Feedback`] measures what the
/// posterior of these features says of the other candidates.
pub fn features(extraction: &Extraction, candidates: &[EndCandidate]) -> Array2<f64> {
    let measured = measured(extraction, candidates);
    Array2::from_shape_fn((measured.len(), FEATURES.len()), |(row, column)| FEATURES[column].1(&measured[row]))
}
