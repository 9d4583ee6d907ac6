//! The rules that decide which vessels are kept: the median of the paper, and others.

use crate::error::{Error, Result};
use crate::sampling::likelihood::Likelihood;
use crate::support::statistics::{median, otsu, quantile};

/// The rule that decides which uncertain vessels stay.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
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
    /// At least so probable by the evidence, in [0, 1].
    Probability(f64),
    /// In the most probable forest of fragments ([`super::most_probable_forest::probable()`]), the probabilities of staying alone times this root
    /// factor, from 0 to 1000: the smaller, the fewer fragments stay alone.
    Probable(f64),
}

/// The largest root factor.
const MOST_ROOT_FACTOR: f64 = 1000.0;

impl Keep {
    /// Checks the figure of the rule.
    ///
    /// # Errors
    ///
    /// Names the rule, its value and the range.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::Quantile(q) | Self::Frequency(q) | Self::Probability(q) if !(0.0..=1.0).contains(&q) => {
                Err(Error::parameter("--keep", q, "expected a number from 0 to 1"))
            }
            Self::Value(x) if !x.is_finite() => Err(Error::parameter("--keep value", x, "expected a finite number of W/m3")),
            Self::Probable(x) if !(0.0..=MOST_ROOT_FACTOR).contains(&x) => {
                Err(Error::parameter("--keep probable", x, format!("expected a number from 0 to {MOST_ROOT_FACTOR}")))
            }
            _ => Ok(()),
        }
    }

    /// Whether the evidence decides, not the samples.
    pub fn asks_evidence(self) -> bool {
        matches!(self, Self::Probability(_) | Self::Probable(_))
    }
}

/// The threshold of a rule: on L (W/m³), or on the figure that the rule names. `None` for [`Keep::Probable`], which has none, when no
/// uncertain vessel has L > 0, and for Otsu when all are equal.
pub fn threshold(rule: Keep, result: &Likelihood) -> Option<f64> {
    let positive: Vec<f64> =
        result.likelihood.iter().zip(&result.uncertain).filter(|(l, u)| **u && **l > 0.0).map(|(l, _)| *l).collect();
    match rule {
        Keep::Median => median(&positive),
        Keep::Quantile(q) => quantile(&positive, q),
        Keep::Value(x) | Keep::Frequency(x) | Keep::Probability(x) => Some(x),
        Keep::Probable(_) => None,
        Keep::Otsu => otsu(&positive.iter().map(|l| l.ln()).collect::<Vec<_>>()).map(f64::exp),
    }
}
