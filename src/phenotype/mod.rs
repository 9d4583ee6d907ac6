//! The phenotype of the Circle of Willis: which of its segments are there, by what is connected to what.

mod artery;
mod by_labels;
mod by_points;
mod calibre;
mod circle;
mod collateral;
mod counted;
mod divide;
mod labels;
mod landmarks;
mod naming;
mod place;
mod posterior;
mod sides;
mod variant;
mod ways;

pub use artery::{Artery, FENESTRATED, RING, Side};
pub use circle::{Circle, MM_AWAY};
pub use collateral::{Collateral, Courses, FEEDERS, TERRITORIES, collaterals};
pub use counted::counted;
pub use divide::divide;
pub use labels::{Scheme, artery, is_none};
pub use landmarks::{Landmark, identify};
pub use naming::Completeness;
pub use posterior::{Deciding, Posterior};
pub use variant::Variant;
