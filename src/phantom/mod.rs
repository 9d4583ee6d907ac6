//! Test anatomy with a known answer: complete networks, and uncertain extractions of them.

pub mod alastruey;
mod breaks;
mod circle;
mod curve;
mod damage;
mod draft;
mod extraction;
mod kind;
mod landmarks;
mod layout;
mod part;
mod spurious;
mod tree;
mod truth;

pub use breaks::Breaks;
pub use circle::{INLET_MMHG, cerebral, circle_of_willis};
pub use curve::{Bow, course};
pub use extraction::break_up;
pub use kind::Kind;
pub use landmarks::{landmarks, write_landmarks};
pub use part::without;
pub use tree::{Tree, branching_tree};
pub use truth::{Break, BreakKind, Truth};
