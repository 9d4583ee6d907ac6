//! The phenotype of the Circle of Willis: which of its segments are present, from the connections in a network.

mod arteries;
mod circle;
mod labels;
mod landmarks;
mod posterior;
mod segments_by_labels;
mod segments_by_landmarks;
pub mod supply;

pub use arteries::{Artery, AtlasArtery, BodySide, Completeness, FEEDERS, FENESTRATED, IN_ATLAS, RING, TERRITORIES};
pub use arteries::{Variant, present_vessels};
pub use circle::{Circle, LANDMARK_NOTE_ENDING, LEAST_DIAMETER, hypoplastic, segment_diameters};
pub use labels::{LabelScheme, are_topcow_classes, artery_of_label, split_where_labels_change};
pub use landmarks::{Landmark, identify_landmarks, in_axes_of};
pub use posterior::{DecidingCandidate, Posterior, VariantFrequencies, present_segments};
pub use supply::{Collateral, Destination, Spread, Supply, collaterals, supplies};
