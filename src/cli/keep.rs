//! `--keep`: the rule that decides which uncertain vessels stay.

use willis::error::{Error, Result};
use willis::internals::decision::{Keep, ROOT_FACTOR};
use willis::internals::support::suggestions::did_you_mean;

const ACCEPTED: &str = "expected probable[=ROOT_FACTOR], median, quantile=Q, value=X, otsu, frequency=F or probability=P";
/// Rules that need a figure, with one such.
const WITH_FIGURE: [(&str, &str); 4] = [("quantile", "0.8"), ("value", "1e5"), ("frequency", "0.1"), ("probability", "0.5")];

/// The rule of a text.
pub fn parse_rule(text: &str) -> Result<Keep> {
    let refused = |accepted: String| Error::parameter("--keep", format!("\"{text}\""), accepted);
    let unknown = || {
        let word = text.split('=').next().unwrap_or_default();
        let rules = ["probable", "median", "otsu"].into_iter().chain(WITH_FIGURE.map(|(rule, _)| rule));
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
        None if text == "median" => Keep::Median,
        None if text == "otsu" => Keep::Otsu,
        None if text == "probable" => Keep::Probable(ROOT_FACTOR),
        Some(("probable", f)) => Keep::Probable(number(f)?),
        Some(("quantile", q)) => Keep::Quantile(share(q)?),
        Some(("value", x)) => Keep::Value(number(x)?),
        Some(("frequency", f)) => Keep::Frequency(share(f)?),
        Some(("probability", p)) => Keep::Probability(share(p)?),
        _ => return Err(unknown()),
    };
    rule.validate()?;
    Ok(rule)
}
