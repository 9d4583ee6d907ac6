//! Blood flow in a network of rigid vessels: Poiseuille's law, boundary conditions, Kirchhoff's current law.

pub mod batch;
pub mod boundary_conditions;
pub mod circuit;
pub mod dead_ends;
pub mod drops;
pub mod floating_components;
pub mod peeling;
pub mod poiseuille;
pub mod pressures;
pub mod resilience;
pub mod state;
pub mod wall;

pub use batch::solver::BatchSolver;
pub use boundary_conditions::{Boundary, FoundOutlets, Given};
pub use circuit::Circuit;
pub use floating_components::{Unfed, drives_flow, grounded, parts_that_carry, stranded};
pub use poiseuille::{BLOOD_VISCOSITY, Factors, Tube, check_viscosity};
pub use resilience::{MOST_RESILIENCE, is_diffused, resilience, resilience_per_square_drop, resilience_per_square_flow};
pub use wall::{Thickness, WallLaw};
