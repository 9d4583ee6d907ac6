//! Evidence: which bridges may be, and the dimensionless features that say how probable each is before any flow.
//!
//! Every length is divided by a local diameter, the spacing of the points or another length of the same extraction, so that
//! one set of weights serves thin trees and wide circles, in any unit. A feature is a function of a [`Span`] (a bridge with
//! its surroundings) and a row of [`FEATURES`]: that is all it takes to add or drop one.

mod around;
pub mod direction;
mod extraction;
mod feedback;
mod fragment;
mod frame;
pub mod gap;
mod meeting;
mod orientation;
pub mod parent;
pub mod radius;
mod roads;
mod root;
mod search;
mod smooth;
mod span;
mod steady;
pub mod surroundings;
mod tangent;
mod ways;

use ndarray::Array2;

pub use extraction::Extraction;
pub use feedback::{FEEDBACK_FEATURES, Feedback};
pub use fragment::Fragment;
pub use frame::Frame;
pub use meeting::Meetings;
pub use root::{ROOT_FEATURES, RootFeature, root_features};
pub use search::{FoundBridge, Search, search};
pub use smooth::SmoothPoints;
pub use span::{Span, spans};
pub use tangent::Course;

/// A feature of a bridge.
pub type Feature = fn(&Span) -> f64;

/// The features of a bridge, by the names that weights have in a file.
pub const FEATURES: &[(&str, Feature)] = &[
    ("is_end", parent::at_free_end),
    ("gap", gap::gap),
    ("bend_child_sq", direction::bend_child_squared),
    ("bend_child", direction::bend_child),
    ("gap_end", gap::gap_at_free_end),
    ("bend_parent_sq", direction::bend_parent_squared),
    ("wall_branch", gap::wall_on_the_way),
    ("gap_branch", gap::gap_on_the_way),
    ("kink", direction::kink_towards),
    ("ratio_branch", radius::branch_ratio),
    ("bend_far", direction::bend_far),
    ("ratio_end_sq", radius::radius_step_squared),
    ("wall", gap::log_gap_to_wall),
    ("resolution_branch", gap::log_width_on_the_way),
    ("ratio_branch_sq", radius::branch_ratio_squared),
    ("turn", direction::worst_bend),
    ("bend_gap", direction::bend_child_over_gap),
    ("margin", surroundings::margin),
    ("blocked", surroundings::blocked),
    ("bend_parent", direction::bend_parent),
    ("ratio_end", radius::radius_step),
    ("rank", surroundings::rank),
    ("share_parent", parent::parent_share),
    ("orientation", direction::orientation),
    ("fed_parent", parent::parent_fed),
    ("near_tip", surroundings::near_free_end),
    ("touch_branch", gap::touches_wall),
    ("mutual", surroundings::mutual),
    ("wall_over_3", gap::wall_far_beyond_reach),
    ("wall_over_1_5", gap::wall_beyond_reach),
    ("kink_wide", direction::far_kink_from),
    ("kink_excess", direction::kink_excess),
    ("near_junction", surroundings::near_junction),
];

/// The features of bridges: a row a bridge, a column a feature of [`FEATURES`].
///
/// Rank, margin and mutual choice are among the bridges given, so these should be all of a search. What the posterior of these
/// features says of the other bridges is in [`Feedback`].
pub fn features(extraction: &Extraction, bridges: &[FoundBridge]) -> Array2<f64> {
    let spans = spans(extraction, bridges);
    Array2::from_shape_fn((spans.len(), FEATURES.len()), |(row, column)| FEATURES[column].1(&spans[row]))
}
