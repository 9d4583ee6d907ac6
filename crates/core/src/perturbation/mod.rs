//! Structural perturbation: which vessels are open, drawn at random or enumerated.

pub mod enumeration;
mod occlusion;
pub mod stenosis;

pub use enumeration::Enumeration;
pub use occlusion::Occlusion;
pub use stenosis::{Stenosis, StretchPlace};
