//! Options that are figures: a count, a probability, a length, a viscosity, each as a person types it.

use crate::error::{Error, Result};
use crate::internals::network::quantity::Dimension;
use crate::internals::network::units::millimetres;

/// The largest number up to which a figure with an exponent stands for every whole number.
const WHOLE: f64 = 9_007_199_254_740_992.0;

/// A whole number, which may be typed as 1e6.
pub fn whole<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    let by_exponent = |x: &f64| x.fract() == 0.0 && (0.0..=WHOLE).contains(x);
    let number = text.parse().ok().or_else(|| text.parse().ok().filter(by_exponent).map(|x| x as u64));
    let too_large = "is too large".to_owned();
    number.ok_or("expected a whole number, such as 1000 or 1e6")?.try_into().map_err(|_| too_large)
}

/// A probability, as a number from 0 to 1.
pub fn probability(text: &str) -> Result<f64, String> {
    let percent = text.strip_suffix('%').and_then(|digits| digits.trim().parse::<f64>().ok());
    let example = percent.map_or(0.5, |percent| percent / 100.0);
    text.parse().map_err(|_| format!("expected a number from 0 to 1, such as {example}"))
}

/// A voxel spacing, mm; none where it is that which is stated for the input.
pub type Spacing = Option<f64>;

/// A spacing in mm, as a number or a length, or `auto`.
pub fn spacing(text: &str) -> Result<Spacing, String> {
    if text == "auto" {
        return Ok(None);
    }
    text.parse().or_else(|_| Dimension::Length.parse(text).map(millimetres)).map(Some)
}

/// A parser of a figure with its unit, SI, for an option of this name.
pub fn figure(option: &'static str, dimension: Dimension) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
    move |text| dimension.parse(text).map_err(|accepted| Error::parameter(option, format!("\"{text}\""), accepted))
}

/// A parser of a positive length, m, for an option of this name.
pub fn length(option: &'static str) -> impl Fn(&str) -> Result<f64> + Clone + Send + Sync + 'static {
    let parse = figure(option, Dimension::Length);
    move |text| match parse(text)? {
        length if length > 0.0 => Ok(length),
        _ => Err(Error::parameter(option, format!("\"{text}\""), "expected a positive length")),
    }
}

/// Viscosity, Pa s, from `--viscosity`.
pub fn viscosity(text: &str) -> Result<f64> {
    figure("viscosity", Dimension::Viscosity)(text)
}
