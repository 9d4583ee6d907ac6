//! Test anatomy with a known answer: complete networks, and uncertain extractions of them.

pub mod alastruey;
mod arterial;
mod breaks;
mod capillary;
mod circle;
mod curve;
mod damage;
mod extraction;
mod gaps;
mod kind;
mod lattice;
mod straight_vessels;
mod tree;
mod truth;

pub use arterial::arterial;
pub use breaks::Breaks;
pub use capillary::capillary;
pub use circle::{cerebral, circle_of_willis, without};
pub use extraction::break_up;
pub use gaps::{Gaps, over_connected, with_gaps};
pub use kind::{Kind, Recipe};
pub use straight_vessels::Large;
pub use tree::{Tree, branching_tree};
pub use truth::{BreakKind, Truth, landmarks};
