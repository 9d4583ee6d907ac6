//! Tools for every other module: boosted trees, random streams, vector instructions, statistics, comparisons of groups, geometry, lengths along lines, elimination orders, suggestions,
//! lists by number, text that may be shown, endings of names, limits of the system.

pub mod arc_lengths;
pub mod boosted_trees;
pub mod calibration;
pub mod comparison;
pub mod elimination;
pub mod endings;
pub mod gamma;
pub mod geometry;
pub mod kappa;
pub mod limits;
pub mod model_provenance;
pub mod normal_equations;
pub mod numbered;
pub mod parallel;
pub mod printable;
pub mod random;
pub mod simd;
pub mod statistics;
pub mod suggestions;
pub mod ties;
pub mod toml_text;

pub use parallel::{in_chunks, in_order};
pub use statistics::Distribution;
