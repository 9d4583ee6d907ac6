//! Joins on automatic skeletons: candidates judged one by one, each knowing its rivals.
//!
//! Where a segmentation was thinned, vessels that touch are fused, and the fragments of the skeleton are no longer pieces of one forest: true
//! gaps lie within a fragment and close loops of fragments. So each candidate has a probability of its own, from boosted trees over what a
//! tracing shows and more ([`features`]), in two passes: the second sees how probable the first made the other candidates for the same places.
//! Where there is an image a third pass sees what it shows between the ends ([`image`]).

pub mod course;
pub mod features;
pub mod image;
pub mod in_image;
pub mod model;
pub mod rivals;
pub mod search;
pub mod table;

pub use table::{JoinTable, ShapeScores};
