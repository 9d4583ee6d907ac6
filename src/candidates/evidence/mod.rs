//! Evidence: which bridges may be, and the dimensionless features that say how probable each is before any flow.
//!
//! Every length is divided by a local diameter, the spacing of the points or another length of the same extraction, so that
//! one set of weights serves thin trees and wide circles, in any unit. A feature is a function of a [`Span`] (a bridge with
//! its surroundings) and a row of [`FEATURES`]: that is all it takes to add or drop one.

pub mod direction;
mod extraction;
mod frame;
pub mod gap;
mod meeting;
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

use ndarray::Array2;

pub use extraction::{Extraction, Fragment};
pub use frame::Frame;
pub use meeting::Meetings;
pub use root::{ROOT_FEATURES, RootFeature, root_features};
pub use search::{Bridge, Search, search};
pub use smooth::SmoothPoints;
pub use span::{Span, spans};
pub use tangent::Course;

/// A feature of a bridge.
pub type Feature = fn(&Span) -> f64;

/// The features of a bridge, by the names that weights have in a file.
pub const FEATURES: &[(&str, Feature)] = &[
    ("ln_gap", gap::log_gap),
    ("gap", gap::gap),
    ("ln_voxels", gap::log_gap_in_spacings),
    ("wall", gap::log_gap_to_wall),
    ("bend_child", direction::bend_child),
    ("bend_child_z", direction::bend_child_in_errors),
    ("bend_far", direction::bend_far),
    ("bend_parent", direction::bend_parent),
    ("bend_parent_z", direction::bend_parent_in_errors),
    ("parallel", direction::turn),
    ("is_end", parent::at_free_end),
    ("t_sin", direction::sine_at_parent),
    ("abs_log_r", radius::radius_step),
    ("too_wide", radius::too_wide),
    ("kink", direction::kink_towards),
    ("near_tip", surroundings::near_free_end),
    ("near_junction", surroundings::near_junction),
    ("rank", surroundings::rank),
    ("margin", surroundings::margin),
    ("mutual", surroundings::mutual),
    ("blocked", surroundings::blocked),
    ("slim_parent", parent::parent_slenderness),
    ("share_parent", parent::parent_share),
    ("fed_parent", parent::parent_fed),
    ("thick_end", radius::widest_end),
    ("inner_taper", radius::taper),
    ("confluence", direction::with_the_flow),
    ("size", radius::relative_size),
    ("loop_ratio", gap::log_detour),
];

/// The features of bridges: a row a bridge, a column a feature of [`FEATURES`].
///
/// Rank, margin and mutual choice are among the bridges given, so these should be all of a search.
pub fn features(extraction: &Extraction, bridges: &[Bridge]) -> Array2<f64> {
    let spans = spans(extraction, bridges);
    Array2::from_shape_fn((spans.len(), FEATURES.len()), |(row, column)| FEATURES[column].1(&spans[row]))
}
