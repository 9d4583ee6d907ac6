//! Test anatomy with a known answer: complete networks.

pub mod alastruey;
mod circle;
mod curve;
mod kind;
mod layout;
mod tree;

pub use circle::{INLET_MMHG, cerebral, circle_of_willis};
pub use curve::{Bow, course};
pub use kind::Kind;
pub use tree::{Tree, branching_tree};
