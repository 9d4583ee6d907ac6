//! Pressures of many samples side by side: star-mesh elimination, conjugate gradients, and the reduction of large circuits.

pub mod conductances;
pub mod conjugate_gradients;
pub mod reduction;
pub mod solver;
pub mod star_mesh;
