//! Perturbations of a network: which vessels are open, and how they are changed.

pub mod enumeration;
pub mod occlusion;
pub mod stenosis;

pub use enumeration::Enumeration;
pub use occlusion::Occlusion;
pub use stenosis::Stenosis;
