//! What a sample is expected to cost by each solver and forest algorithm: the model that chooses between them.
//!
//! The constants are fitted to measurements (`benches/crossover.csv`); where they are off on another machine, so is the
//! point of change, not the result.

use crate::hemodynamics::StarMesh;
use crate::hemodynamics::cholesky::Cholesky;
use crate::hemodynamics::conjugate_gradients::ConjugateGradients;

/// ns a join of star-mesh elimination takes, a sample.
const JOIN: f64 = 0.30;
/// ns an entry of the Cholesky factor takes to make and to use, a sample.
const FACTOR_ENTRY: f64 = 17.0;
/// ns a vessel takes in the sparse path more than in the lanes, a sample.
const SPARSE_VESSEL: f64 = 19.0;
/// Steps of conjugate gradients that a mesh of vessels takes, and ns a ray of the core takes in one, a sample.
const STEPS: f64 = 50.0;
const STEP_RAY: f64 = 0.5;
/// Joins of a forest program, per vessel, above which Kruskal's algorithm is faster.
const BOTTLENECK_JOINS_PER_VESSEL: usize = 40;
/// Joins below which the sparse solver is not even considered.
pub const SURELY_LANES: usize = 200_000;
/// Joins above which the lanes are not considered: ordering alone would take seconds.
pub const SURELY_SPARSE: usize = 8_000_000;

/// ns of a solution by star-mesh elimination.
pub fn lanes(program: &StarMesh) -> f64 {
    JOIN * program.updates() as f64
}

/// Joins of star-mesh elimination up to which it is expected to be faster than conjugate gradients.
pub fn lanes_limit(gradients: &ConjugateGradients) -> usize {
    let nanoseconds = JOIN * gradients.joins() as f64 + STEPS * STEP_RAY * gradients.rays() as f64;
    (nanoseconds / JOIN) as usize
}

/// ns of a solution by sparse factorisation, more than what both solvers take.
pub fn sparse(factor: &Cholesky, vessels: usize) -> f64 {
    FACTOR_ENTRY * factor.factor_entries() as f64 + SPARSE_VESSEL * vessels as f64
}

/// The longest forest program that is worth its while.
pub fn forest_limit(vessels: usize) -> usize {
    BOTTLENECK_JOINS_PER_VESSEL * vessels
}
