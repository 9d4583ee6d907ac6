//! Perturbations of a network: which vessels are open, and how they are changed.

pub mod occlusion;

pub use occlusion::Occlusion;
