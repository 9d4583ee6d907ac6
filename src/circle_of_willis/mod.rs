//! The phenotype of the Circle of Willis: which of its segments are there, by what is connected to what.

mod arteries;
mod circle;
mod collaterals;
mod labels;
mod landmarks;
mod posterior;
mod segments_by_labels;
mod segments_by_landmarks;
mod shortest_path;
mod variant;

pub use arteries::{Artery, FENESTRATED, RING, Side};
pub use circle::{Circle, MM_AWAY};
pub use collaterals::{Collateral, FEEDERS, TERRITORIES, collaterals};
pub use labels::{Scheme, artery, divide};
pub use landmarks::{Landmark, identify};
pub use posterior::{Deciding, Posterior};
pub use variant::{Completeness, Variant, counted};
