//! The rules that decide which vessels are kept: the median of the paper, and others.

use std::fmt;
use std::str::FromStr;

use super::best_first::{BEST_FIRST, RECONNECT};
use super::most_probable_forest::PRICE;
use crate::error::{Error, Result};
use crate::sampling::likelihood::Likelihood;
use crate::support::statistics::{median, otsu, quantile};
use crate::support::suggestions::did_you_mean;
use crate::support::ties::TIE;

/// The rule that decides which uncertain vessels stay; as text `median`, `quantile=0.8`, `value=1e5`, `otsu`, `frequency=0.1`,
/// `probability=0.5`, `probable` or `probable=0.5`, `best-first` or `best-first=0.4`,
/// `reconnect` or `reconnect=0`.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Keep {
    /// L above the median of the uncertain vessels with L > 0 (the paper). What equals a threshold on L but for [rounding](crate::support::ties::TIE)
    /// is not above it, here and below.
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
    /// In the most probable forest of fragments, and more probable than this price, from 0 to 1000, times the probability that what hangs
    /// there is nothing ([`super::most_probable_forest::probable()`]): the smaller, the fewer fragments stay alone.
    Probable(f64),
    /// The most probable candidates first, those more probable than this, in [0, 1], each free end once
    /// ([`super::best_first::best_first()`]).
    BestFirst(f64),
    /// As `best-first`, then contacts, and candidates of which little is sure, the most probable first, while they join two parts and are
    /// at least so probable, in [0, 1] ([`super::best_first::reconnected()`]).
    Reconnect(f64),
}

/// The figure of a vessel by which a rule decides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DecidingFigure {
    /// The likelihood L.
    Likelihood,
    /// The share of the samples whose forest has the vessel.
    Frequency,
    /// The probability by the evidence.
    Probability,
}

impl DecidingFigure {
    /// Its column in edges.csv.
    pub fn column(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood",
            Self::Frequency => "frequency",
            Self::Probability => "probability",
        }
    }

    /// Its name with its symbol.
    pub fn name(self) -> &'static str {
        match self {
            Self::Likelihood => "likelihood L",
            Self::Frequency => "frequency",
            Self::Probability => "probability P",
        }
    }
}

/// The largest price.
const MOST_PRICE: f64 = 1000.0;

const ACCEPTED: &str =
    "expected probable[=PRICE], best-first[=P], reconnect[=P], median, quantile=Q, value=X, otsu, frequency=F or probability=P";
/// Rules that need a figure, with one such.
const WITH_FIGURE: [(&str, &str); 4] = [("quantile", "0.8"), ("value", "1e5"), ("frequency", "0.1"), ("probability", "0.5")];

impl fmt::Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Median => f.write_str("median"),
            Self::Quantile(q) => write!(f, "quantile={q}"),
            Self::Value(x) => write!(f, "value={x}"),
            Self::Otsu => f.write_str("otsu"),
            Self::Frequency(x) => write!(f, "frequency={x}"),
            Self::Probability(p) => write!(f, "probability={p}"),
            Self::Probable(factor) => write!(f, "probable={factor}"),
            Self::BestFirst(p) => write!(f, "best-first={p}"),
            Self::Reconnect(p) => write!(f, "reconnect={p}"),
        }
    }
}

impl From<Keep> for String {
    fn from(rule: Keep) -> Self {
        rule.to_string()
    }
}

impl TryFrom<String> for Keep {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl FromStr for Keep {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let refused = |accepted: String| Error::parameter("keep", format!("\"{text}\""), accepted);
        let unknown = || {
            let word = text.split('=').next().unwrap_or_default();
            let rules =
                ["probable", "best-first", "reconnect", "median", "otsu"].into_iter().chain(WITH_FIGURE.map(|(rule, _)| rule));
            let meant = if rules.clone().any(|rule| rule == word) { String::new() } else { did_you_mean(word, rules) };
            refused(format!("{meant}{ACCEPTED}"))
        };
        if let Some((rule, figure)) = WITH_FIGURE.iter().find(|(rule, _)| text.trim_end_matches('=') == *rule) {
            return Err(refused(format!("needs a figure, as in {rule}={figure}")));
        }
        let number = |figure: &str| figure.parse::<f64>().map_err(|_| unknown());
        let share = |figure: &str| {
            let (digits, is_percent) = figure.strip_suffix('%').map_or((figure, false), |digits| (digits, true));
            let x = number(digits)?;
            if !is_percent && (0.0..=1.0).contains(&x) {
                return Ok(x);
            }
            let rule = text.trim_end_matches(figure);
            let meant = if (1.0..=100.0).contains(&x) { format!(", such as {rule}{}", x / 100.0) } else { String::new() };
            Err(refused(format!("expected a number from 0 to 1{meant}")))
        };
        let rule = match text.split_once('=') {
            None if text == "median" => Self::Median,
            None if text == "otsu" => Self::Otsu,
            None if text == "probable" => Self::Probable(PRICE),
            None if text == "best-first" => Self::BestFirst(BEST_FIRST),
            None if text == "reconnect" => Self::Reconnect(RECONNECT),
            Some(("reconnect", p)) => Self::Reconnect(share(p)?),
            Some(("best-first", p)) => Self::BestFirst(share(p)?),
            Some(("probable", factor)) => Self::Probable(number(factor)?),
            Some(("quantile", q)) => Self::Quantile(share(q)?),
            Some(("value", x)) => Self::Value(number(x)?),
            Some(("frequency", f)) => Self::Frequency(share(f)?),
            Some(("probability", p)) => Self::Probability(share(p)?),
            _ => return Err(unknown()),
        };
        rule.validate()?;
        Ok(rule)
    }
}

impl Keep {
    /// Checks the figure of the rule.
    ///
    /// # Errors
    ///
    /// Names the rule, its value and the range.
    pub fn validate(self) -> Result<()> {
        match self {
            Self::Quantile(q) | Self::Frequency(q) | Self::Probability(q) | Self::BestFirst(q) | Self::Reconnect(q)
                if !(0.0..=1.0).contains(&q) =>
            {
                Err(Error::parameter("keep", q, "expected a number from 0 to 1"))
            }
            Self::Value(x) if !x.is_finite() => Err(Error::parameter("keep value", x, "expected a finite number of W/m3")),
            Self::Probable(x) if !(0.0..=MOST_PRICE).contains(&x) => {
                Err(Error::parameter("keep probable", x, format!("expected a number from 0 to {MOST_PRICE}")))
            }
            _ => Ok(()),
        }
    }

    /// The figure of a vessel that is weighed.
    pub fn figure(self) -> DecidingFigure {
        match self {
            Self::Median | Self::Quantile(_) | Self::Value(_) | Self::Otsu => DecidingFigure::Likelihood,
            Self::Frequency(_) => DecidingFigure::Frequency,
            Self::Probability(_) | Self::Probable(_) | Self::BestFirst(_) | Self::Reconnect(_) => DecidingFigure::Probability,
        }
    }

    /// Whether the evidence decides, not the samples.
    pub fn asks_evidence(self) -> bool {
        self.figure() == DecidingFigure::Probability
    }

    /// Whether candidates are taken one by one, the most probable first.
    pub fn is_one_by_one(self) -> bool {
        matches!(self, Self::BestFirst(_) | Self::Reconnect(_))
    }

    /// Whether a vessel is kept for its own figure alone, which passes a threshold or does not.
    pub fn has_threshold(self) -> bool {
        !(self.is_one_by_one() || matches!(self, Self::Probable(_)))
    }

    /// Whether the threshold is given, and not itself made of the likelihoods.
    pub fn is_fixed(self) -> bool {
        !matches!(self, Self::Median | Self::Quantile(_) | Self::Otsu)
    }

    /// What is kept, in words. `cut`: the threshold on L with its unit, `None` where there is none.
    pub fn says(self, cut: Option<String>) -> String {
        match self {
            Self::Frequency(f) => format!("frequency >= {f}"),
            Self::Probability(p) => format!("probability >= {p}"),
            Self::Reconnect(0.0) => "most probable first, then what joins parts".to_owned(),
            Self::Reconnect(p) => format!("most probable first, then what joins parts, from {p} on"),
            Self::BestFirst(p) => format!("most probable first, above {p}"),
            Self::Probable(price) => format!("the most probable forest, price {price}"),
            _ => cut.map_or_else(|| "no uncertain vessel has L > 0".to_owned(), |cut| format!("L > {cut}")),
        }
    }

    /// The probability near which a vessel is undecided, where the evidence decides.
    pub fn turning_point(self) -> Option<f64> {
        match self {
            Self::Probability(least) | Self::BestFirst(least) => Some(least),
            Self::Probable(_) => Some(0.5),
            Self::Reconnect(_) => Some(BEST_FIRST),
            _ => None,
        }
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
        Keep::Value(x) | Keep::Frequency(x) | Keep::Probability(x) | Keep::BestFirst(x) | Keep::Reconnect(x) => Some(x),
        Keep::Probable(_) => None,
        Keep::Otsu => otsu(&positive.iter().map(|l| l.ln()).collect::<Vec<_>>(), TIE).map(f64::exp),
    }
}
