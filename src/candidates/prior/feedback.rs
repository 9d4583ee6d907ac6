//! The features of a bridge that only the posterior of an earlier pass can tell; none as yet.

use ndarray::Array2;

use crate::candidates::evidence::{Bridge, Extraction};
use crate::posterior::{Forests, Marginals};

/// The names of the features, in the order of their columns.
pub const FEEDBACK_FEATURES: &[&str] = &[];

/// What the features need of an extraction and the bridges between its fragments.
pub struct Feedback {
    bridges: usize,
}

impl Feedback {
    /// Prepares the features of bridges between fragments.
    pub fn new(_: &Extraction, bridges: &[Bridge]) -> Self {
        Self { bridges: bridges.len() }
    }

    /// A row a bridge, a column a feature of [`FEEDBACK_FEATURES`], from the posterior of the pass before.
    pub fn features(&self, _: &Forests, _: &Marginals) -> Array2<f64> {
        Array2::zeros((self.bridges, FEEDBACK_FEATURES.len()))
    }
}
