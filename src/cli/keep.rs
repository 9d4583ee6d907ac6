//! `--keep`: the rule that decides which vessels on trial stay.

use willis::error::{Error, Result};
use willis::inference::{Keep, ROOT_FACTOR};
use willis::suggestion::did_you_mean;

const ACCEPTED: &str = "expected probable[=ROOT_FACTOR], median, quantile=Q, value=X, otsu, frequency=F or probability=P";

/// The rule of a text.
pub fn parse_rule(text: &str) -> Result<Keep> {
    let refused = || {
        let word = text.split('=').next().unwrap_or_default();
        let meant = did_you_mean(word, ["probable", "median", "quantile", "value", "otsu", "frequency", "probability"]);
        Error::parameter("--keep", format!("\"{text}\""), format!("{meant}{ACCEPTED}"))
    };
    let number = |text: &str| text.parse::<f64>().map_err(|_| refused());
    let rule = match text.split_once('=') {
        None if text == "median" => Keep::Median,
        None if text == "otsu" => Keep::Otsu,
        None if text == "probable" => Keep::Probable(ROOT_FACTOR),
        Some(("probable", f)) => Keep::Probable(number(f)?),
        Some(("quantile", q)) => Keep::Quantile(number(q)?),
        Some(("value", x)) => Keep::Value(number(x)?),
        Some(("frequency", f)) => Keep::Frequency(number(f)?),
        Some(("probability", p)) => Keep::Probability(number(p)?),
        _ => return Err(refused()),
    };
    rule.validate()?;
    Ok(rule)
}
