//! The rules that decide which vessels are kept: the median of the paper, and others.

use std::{fmt, mem::discriminant, str::FromStr};

use super::{BEST_FIRST, DOUBTFUL, PRICE, RECONNECT, WITHOUT_PIECE};
use crate::error::{Error, Result};
use crate::sampling::likelihood;
use crate::support::{median, otsu, quantile, suggestions::did_you_mean, ties::TIE};
use DecidingFigure::{Frequency, Likelihood, Probability};

/// The rule that decides which uncertain vessels stay; as text a word such as `median`, with a figure where it has one, as `quantile=0.8`.
/// [`Keep::HELP`] has them all.
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
    /// ([`super::most_probable_forest::best_first()`]).
    BestFirst(f64),
    /// As `best-first`, then contacts, and candidates of which little is sure, the most probable first, while they join two parts and are
    /// at least so probable, in [0, 1] ([`super::most_probable_forest::reconnected()`]).
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
    /// Its column in edges.csv, and its name with its symbol.
    pub fn names(self) -> [&'static str; 2] {
        match self {
            Self::Likelihood => ["likelihood", "likelihood L"],
            Self::Frequency => ["frequency"; 2],
            Self::Probability => ["probability", "probability P"],
        }
    }
}

/// What a rule does that has no threshold, with its figures, for a page to follow it: each has its law in `rules.js`.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FollowedRule {
    /// The most probable first, then what joins parts.
    BestFirst {
        /// The least probability of a candidate.
        first: f64,
        /// That of a contact that joins two parts; none where nothing is joined.
        joins: Option<f64>,
        /// That of a candidate that does.
        doubtful: Option<f64>,
    },
    /// The most probable forest.
    Forest {
        /// The price of a false connection.
        price: f64,
        /// The share of it that is asked where no piece hangs on the decision.
        without: f64,
    },
}

/// A rule without its law.
struct WrittenRule {
    /// Its word, and what stands for its figure.
    form: &'static str,
    make: fn(f64) -> Keep,
    /// The usual figure, not a number for a rule without one; or an example of a figure that has to be given.
    usual: std::result::Result<f64, &'static str>,
    /// The least figure and the largest.
    range: [f64; 2],
    weighs: DecidingFigure,
}

const SHARE: [f64; 2] = [0.0, 1.0];
const FINITE: [f64; 2] = [f64::MIN, f64::MAX];

/// All rules, in the order of messages.
static RULES: [WrittenRule; 9] = [
    WrittenRule { form: "probable[=PRICE]", make: Keep::Probable, usual: Ok(PRICE), range: [0.0, 1000.0], weighs: Probability },
    WrittenRule { form: "best-first[=P]", make: Keep::BestFirst, usual: Ok(BEST_FIRST), range: SHARE, weighs: Probability },
    WrittenRule { form: "reconnect[=P]", make: Keep::Reconnect, usual: Ok(RECONNECT), range: SHARE, weighs: Probability },
    WrittenRule { form: "median", make: |_| Keep::Median, usual: Ok(f64::NAN), range: SHARE, weighs: Likelihood },
    WrittenRule { form: "quantile=Q", make: Keep::Quantile, usual: Err("0.8"), range: SHARE, weighs: Likelihood },
    WrittenRule { form: "value=X", make: Keep::Value, usual: Err("1e5"), range: FINITE, weighs: Likelihood },
    WrittenRule { form: "otsu", make: |_| Keep::Otsu, usual: Ok(f64::NAN), range: SHARE, weighs: Likelihood },
    WrittenRule { form: "frequency=F", make: Keep::Frequency, usual: Err("0.1"), range: SHARE, weighs: Frequency },
    WrittenRule { form: "probability=P", make: Keep::Probability, usual: Err("0.5"), range: SHARE, weighs: Probability },
];

impl WrittenRule {
    fn word(&self) -> &'static str {
        self.form.split(['[', '=']).next().unwrap_or(self.form)
    }
}

impl fmt::Display for Keep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.number() {
            Some(figure) => write!(f, "{}={figure}", self.word()),
            None => f.write_str(self.word()),
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
        let (word, figure) = text.split_once('=').map_or((text, None), |(word, figure)| (word, Some(figure)));
        let known = RULES.iter().find(|rule| rule.word() == word);
        let unknown = || {
            let forms = RULES.each_ref().map(|rule| rule.form).join(", ");
            let (first, last) = forms.rsplit_once(", ").unwrap_or_default();
            let meant = if known.is_some() { String::new() } else { did_you_mean(word, RULES.iter().map(WrittenRule::word)) };
            refused(format!("{meant}expected {first} or {last}"))
        };
        let rule = known.ok_or_else(unknown)?;
        let figure = match (figure, rule.usual) {
            (None, Ok(usual)) => usual,
            (figure, Err(example)) if figure.unwrap_or_default().trim_end_matches('=').is_empty() => {
                return Err(refused(format!("needs a figure, as in {word}={example}")));
            }
            (Some(figure), _) if rule.form.contains('=') => {
                let percent = figure.strip_suffix('%').filter(|_| rule.range == SHARE);
                let x: f64 = percent.unwrap_or(figure).parse().map_err(|_| unknown())?;
                if rule.range == SHARE && (percent.is_some() || !(0.0..=1.0).contains(&x)) {
                    let share = (x * 1e4).round() / 1e6;
                    let hint = if (1.0..=100.0).contains(&x) { format!(", such as {word}={share}") } else { String::new() };
                    return Err(refused(format!("expected a number from 0 to 1{hint}")));
                }
                x
            }
            _ => return Err(unknown()),
        };
        let rule = (rule.make)(figure);
        rule.validate().map(|()| rule)
    }
}

impl Keep {
    /// What the rules keep, for a help.
    pub const HELP: &str = "probable[=PRICE] (of the most probable forest what is at least as probable as PRICE, 1.5, times the \
        probability that what hangs there is nothing, and what closes a loop from P = PRICE/5 on; a smaller price leaves fewer fragments \
        alone), best-first[=P] (the most probable candidates above P, 0.4, each free end once), reconnect[=P] (best-first, then contacts \
        from P, 0, and candidates from 0.1 on, which P may raise, that join two parts), probability=P, median (of L, as in the paper), \
        quantile=Q, value=X (W/m3), otsu, frequency=F";

    /// Checks the figure of the rule.
    ///
    /// # Errors
    ///
    /// Names the rule, its value and the range.
    pub fn validate(self) -> Result<()> {
        let (rule, Some(x)) = (self.written(), self.number()) else { return Ok(()) };
        let [least, most] = rule.range;
        let (name, accepted) = match rule.range {
            _ if (least..=most).contains(&x) => return Ok(()),
            SHARE => ("keep".to_owned(), "expected a number from 0 to 1".to_owned()),
            FINITE => (format!("keep {}", rule.word()), "expected a finite number of W/m3".to_owned()),
            _ => (format!("keep {}", rule.word()), format!("expected a number from {least} to {most}")),
        };
        Err(Error::parameter(name, x, accepted))
    }

    fn written(self) -> &'static WrittenRule {
        let is_it = |rule: &&WrittenRule| discriminant(&(rule.make)(f64::NAN)) == discriminant(&self);
        RULES.iter().find(is_it).expect("a rule that is read comes from the table, and a test has them all")
    }

    /// Its word.
    pub(super) fn word(self) -> &'static str {
        self.written().word()
    }

    /// Its figure, where it has one.
    fn number(self) -> Option<f64> {
        match self {
            Self::Median | Self::Otsu => None,
            Self::Quantile(x)
            | Self::Value(x)
            | Self::Frequency(x)
            | Self::Probability(x)
            | Self::Probable(x)
            | Self::BestFirst(x)
            | Self::Reconnect(x) => Some(x),
        }
    }

    /// The figure of a vessel that is weighed.
    pub fn figure(self) -> DecidingFigure {
        self.written().weighs
    }

    /// Whether the evidence decides, not the samples.
    pub fn asks_evidence(self) -> bool {
        self.figure() == Probability
    }

    /// What it does where a vessel is not kept for its own figure alone, which passes a threshold or does not.
    pub fn followed(self) -> Option<FollowedRule> {
        use FollowedRule::{BestFirst, Forest};
        match self {
            Self::BestFirst(p) => Some(BestFirst { first: p, joins: None, doubtful: None }),
            Self::Reconnect(p) => Some(BestFirst { first: BEST_FIRST, joins: Some(p), doubtful: Some(p.max(DOUBTFUL)) }),
            Self::Probable(price) => Some(Forest { price, without: WITHOUT_PIECE }),
            Self::Median | Self::Quantile(_) | Self::Value(_) | Self::Otsu | Self::Frequency(_) | Self::Probability(_) => None,
        }
    }

    /// Whether candidates are taken one by one, the most probable first.
    pub fn is_one_by_one(self) -> bool {
        matches!(self.followed(), Some(FollowedRule::BestFirst { .. }))
    }

    /// Whether the threshold is given, and not itself made of the likelihoods.
    pub fn is_fixed(self) -> bool {
        self.asks_evidence() || threshold(self, &likelihood::Likelihood::default()).is_some()
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
        match self.followed() {
            Some(FollowedRule::BestFirst { first, .. }) => Some(first),
            Some(FollowedRule::Forest { .. }) => Some(0.5),
            None => self.number().filter(|_| self.asks_evidence()),
        }
    }
}

/// The threshold of a rule: on L (W/m³), or on the figure that the rule names. `None` for [`Keep::Probable`], which has none, when no
/// uncertain vessel has L > 0, and for Otsu when all are equal.
pub fn threshold(rule: Keep, result: &likelihood::Likelihood) -> Option<f64> {
    let positive: Vec<f64> =
        result.likelihood.iter().zip(&result.uncertain).filter(|(l, u)| **u && **l > 0.0).map(|(l, _)| *l).collect();
    match rule {
        Keep::Median => median(&positive),
        Keep::Quantile(q) => quantile(&positive, q),
        Keep::Otsu => otsu(&positive.iter().map(|l| l.ln()).collect::<Vec<_>>(), TIE).map(f64::exp),
        Keep::Probable(_) => None,
        Keep::Value(_) | Keep::Frequency(_) | Keep::Probability(_) | Keep::BestFirst(_) | Keep::Reconnect(_) => rule.number(),
    }
}
