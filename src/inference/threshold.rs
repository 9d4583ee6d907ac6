//! Which likelihood is enough: the median of the paper, and other rules.

use crate::error::{Error, Result};
use crate::stats::{median, otsu, quantile};

use super::likelihood::Likelihood;

/// The rule that decides which uncertain vessels stay.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Keep {
    /// L above the median of the uncertain vessels with L > 0 (the paper).
    #[default]
    Median,
    /// L above this quantile of the same vessels, in [0, 1].
    Quantile(f64),
    /// L above this value, W/m³.
    Value(f64),
    /// L above Otsu's threshold of log L of the same vessels.
    Otsu,
    /// In the forest of at least this share of the samples, in [0, 1].
    Frequency(f64),
}

impl Keep {
    /// Checks the figure of the rule.
    ///
    /// # Errors
    ///
    /// Names the rule, its value and the range.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::Quantile(q) | Self::Frequency(q) if !(0.0..=1.0).contains(&q) => {
                Err(Error::parameter("--keep", q, "expected a number from 0 to 1"))
            }
            Self::Value(x) if !x.is_finite() => Err(Error::parameter("--keep value", x, "expected a finite number of W/m3")),
            _ => Ok(()),
        }
    }
}

/// The threshold of a rule: on L (W/m³), or on the frequency under [`Keep::Frequency`]. `None` when no uncertain
/// vessel has L > 0, and for Otsu when all are equal.
pub fn threshold(rule: Keep, result: &Likelihood) -> Option<f64> {
    let positive: Vec<f64> =
        result.likelihood.iter().zip(&result.uncertain).filter(|(l, u)| **u && **l > 0.0).map(|(l, _)| *l).collect();
    match rule {
        Keep::Median => median(&positive),
        Keep::Quantile(q) => quantile(&positive, q),
        Keep::Value(x) | Keep::Frequency(x) => Some(x),
        Keep::Otsu => otsu(&positive.iter().map(|l| l.ln()).collect::<Vec<_>>()).map(f64::exp),
    }
}
