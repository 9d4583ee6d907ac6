//! What a sample is expected to cost by each solver and forest algorithm: the model that chooses between them.
//!
//! The constants are rough; where they are off on a machine, so is the point of change, not the result.

use crate::hemodynamics::conjugate_gradients::ConjugateGradients;

/// ns a join of star-mesh elimination takes, a sample.
const JOIN: f64 = 0.30;
/// Steps of conjugate gradients that a mesh of vessels takes, and ns a ray of the core takes in one, a sample.
const STEPS: f64 = 50.0;
const STEP_RAY: f64 = 0.5;
/// Joins of a forest program, per vessel, above which Kruskal's algorithm is faster.
const BOTTLENECK_JOINS_PER_VESSEL: usize = 40;
/// Nodes of a core above which its elimination is not even ordered: conjugate gradients are sure to be faster.
pub const SMALL_CORE: usize = 2000;

/// Joins of star-mesh elimination up to which it is expected to be faster than conjugate gradients.
pub fn lanes_limit(gradients: &ConjugateGradients) -> usize {
    let nanoseconds = JOIN * gradients.joins() as f64 + STEPS * STEP_RAY * gradients.rays() as f64;
    (nanoseconds / JOIN) as usize
}

/// The longest forest program that is worth its while.
pub fn forest_limit(vessels: usize) -> usize {
    BOTTLENECK_JOINS_PER_VESSEL * vessels
}
