//! Blood flow in a network of rigid vessels: Poiseuille's law, boundary conditions, Kirchhoff's current law.

pub mod boundary;
pub mod cholesky;
pub mod circuit;
pub mod conjugate_gradients;
mod dead_end;
pub mod floating;
pub mod peel;
pub mod poiseuille;
pub mod reduction;
pub mod residual;
pub mod star_mesh;
pub mod steady;
mod tube;

pub use boundary::{Boundary, FoundOutlets, Given};
pub use circuit::Circuit;
pub use star_mesh::StarMesh;
pub use tube::{Factors, Tube};
