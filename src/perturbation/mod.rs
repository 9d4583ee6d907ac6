//! Structural perturbation: which vessels are open, drawn at random or enumerated.

pub mod enumeration;
pub mod occlusion;

pub use enumeration::Enumeration;
pub use occlusion::Occlusion;
