//! The phenotype of the Circle of Willis: which of its segments are present, from the connections in a network.

mod arteries;
mod circle;
mod collaterals;
mod frequencies;
mod hypoplasia;
mod labels;
mod landmark_names;
mod landmarks;
mod posterior;
mod segments_by_labels;
mod segments_by_landmarks;
mod shortest_path;
mod sides;
pub mod supply;
mod variant;

pub use arteries::{Artery, AtlasArtery, BodySide, Direction, FEEDERS, FENESTRATED, IN_ATLAS, RING, TERRITORIES};
pub use circle::{Circle, LANDMARK_NOTE_ENDING};
pub use collaterals::{Collateral, collaterals};
pub use frequencies::{VariantFrequencies, present_segments};
pub use hypoplasia::{LEAST_DIAMETER, hypoplastic, segment_diameters};
pub use labels::{LabelScheme, are_topcow_classes, artery_of_label, split_where_labels_change};
pub use landmarks::{Landmark, identify_landmarks, in_axes_of};
pub use posterior::{DecidingCandidate, Informant, Posterior};
pub use supply::{Destination, Spread, Supply, supplies};
pub use variant::{Completeness, Variant, present_vessels};
