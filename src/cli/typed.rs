//! Options that are quantities: a length, a viscosity, a resolution, each as a person types it.

use willis::error::{Error, Result};
use willis::quantity::Dimension;

/// A length given as an option, m.
pub fn length(option: &str, text: Option<&String>) -> Result<Option<f64>> {
    let parse = |text: &String| {
        let length =
            Dimension::Length.parse(text).map_err(|accepted| Error::parameter(option, format!("\"{text}\""), accepted))?;
        if length > 0.0 { Ok(length) } else { Err(Error::parameter(option, format!("\"{text}\""), "expected a positive length")) }
    };
    text.map(parse).transpose()
}

/// Viscosity, Pa s, from `--viscosity`.
pub fn viscosity(text: &str) -> Result<f64> {
    Dimension::Viscosity.parse(text).map_err(|accepted| Error::parameter("--viscosity", format!("\"{text}\""), accepted))
}

/// Refuses a resolution that no picture can have.
pub fn check_dpi(dpi: u32) -> Result<()> {
    if (36..=1200).contains(&dpi) { Ok(()) } else { Err(Error::parameter("--dpi", dpi, "expected a number from 36 to 1200")) }
}
