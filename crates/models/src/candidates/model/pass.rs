//! The weights of one pass over the candidates, and the names of the features that it weighs.

use crate::candidates::features::FEATURES;
use crate::candidates::features::feedback::FEEDBACK_FEATURES;
use crate::candidates::features::root_features::ROOT_FEATURES;

/// One pass over the candidates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PassWeights {
    /// Per feature of a candidate, as [`PassWeights::candidate_features`] orders them.
    pub candidate: Vec<f64>,
    /// Per feature of a root, as [`ROOT_FEATURES`] orders them.
    pub root: Vec<f64>,
}

impl PassWeights {
    /// The names of a candidate's features in the pass of a number, counted from 0: feedback comes with the second.
    pub fn candidate_features(number: usize) -> impl Iterator<Item = &'static str> {
        FEATURES.iter().map(|(name, _)| *name).chain(FEEDBACK_FEATURES.iter().copied().filter(move |_| number > 0))
    }

    /// The names of a root's features.
    pub fn root_features() -> impl Iterator<Item = &'static str> {
        ROOT_FEATURES.iter().map(|(name, _)| *name)
    }
}
