//! Test anatomy with a known answer: complete networks, and uncertain extractions of them.

pub mod alastruey;
mod arterial;
mod breaks;
mod capillary;
mod circle;
mod curve;
mod damage;
mod draft;
mod extraction;
mod gaps;
mod kind;
mod landmarks;
mod large;
mod lattice;
mod layout;
mod part;
mod spurious;
mod tree;
mod truth;

pub use arterial::arterial;
pub use breaks::Breaks;
pub use capillary::capillary;
pub use circle::{cerebral, circle_of_willis};
pub use curve::{Bow, course};
pub use extraction::break_up;
pub use gaps::{Gaps, over_connected, with_gaps};
pub use kind::{Kind, Recipe};
pub use landmarks::landmarks;
pub use large::{EDGES, Large};
pub use part::without;
pub use tree::{Tree, branching_tree};
pub use truth::{Break, BreakKind, Truth};
