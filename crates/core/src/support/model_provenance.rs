//! Where a fitted model comes from.

use serde::{Deserialize, Serialize};

/// Where a fitted model comes from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ModelProvenance {
    /// How many cases it was fitted to.
    pub cases: usize,
    /// Of how many subjects.
    pub subjects: usize,
    /// Program and command.
    pub made_by: String,
    /// Subjects that were held out, where this is the model of a fold.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_out: Vec<String>,
}

impl ModelProvenance {
    /// That of a model fitted to so many cases of so many subjects.
    pub fn of(cases: usize, subjects: usize) -> Self {
        Self { cases, subjects, ..Self::default() }
    }
}
