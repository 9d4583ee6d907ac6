//! Figures of many digits in JSON.

use serde::Deserialize;

/// A double written as a string: `str::parse` rounds correctly, parsers of JSON numbers need not.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(try_from = "String")]
pub struct Figure(pub f64);

impl TryFrom<String> for Figure {
    type Error = std::num::ParseFloatError;

    fn try_from(digits: String) -> Result<Self, Self::Error> {
        digits.parse().map(Self)
    }
}
