//! The phenotype of the Circle of Willis: which of its segments are there, by what is connected to what.

mod artery;
mod labels;

pub use artery::{Artery, FENESTRATED, RING, Side};
pub use labels::{Scheme, artery, is_none};
