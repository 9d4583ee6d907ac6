//! Test anatomy with a known answer: complete networks.

pub mod alastruey;
mod circle;
mod curve;
mod layout;

pub use circle::{INLET_MMHG, cerebral, circle_of_willis};
pub use curve::{Bow, course};
