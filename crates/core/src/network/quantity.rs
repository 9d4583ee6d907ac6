//! Reads quantities with a unit, such as `12mm`, `100 mmHg` or `3.5cP`; a bare number has the customary unit.

use super::metres;
use super::units::{
    cubic_metres_per_pascal, cubic_metres_per_second, megapascals, pascal_seconds, pascal_seconds_per_cubic_metre, pascals,
};
use crate::support::suggestions::did_you_mean;

type Unit = (&'static str, fn(f64) -> f64);

/// What a quantity measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Dimension {
    /// m; bare numbers are mm.
    Length,
    /// Pa; bare numbers are mmHg.
    Pressure,
    /// m³/s; bare numbers are mL/min.
    Flow,
    /// Pa s/m³; bare numbers are mmHg·s/mL.
    Resistance,
    /// Pa s; bare numbers are cP.
    Viscosity,
    /// s.
    Time,
    /// m/s.
    Speed,
    /// kg/m³.
    Density,
    /// m³/Pa; bare numbers are mL/mmHg.
    Compliance,
    /// Of a wall, modulus times thickness: Pa m.
    Stiffness,
    /// Pa; bare numbers are MPa.
    Modulus,
}

impl Dimension {
    /// The accepted units, the customary one first, with what makes a number of them an SI value.
    fn units(self) -> &'static [Unit] {
        match self {
            Self::Length => &[("mm", metres), ("um", |x| x / 1e6), ("µm", |x| x / 1e6), ("cm", |x| x / 1e2), ("m", |x| x)],
            Self::Pressure => {
                &[("mmHg", pascals), ("Pa", |x| x), ("kPa", |x| x * 1e3), ("dyn/cm2", |x| x / 10.0), ("cmH2O", |x| x * 98.0665)]
            }
            Self::Flow => &[("mL/min", cubic_metres_per_second), ("mL/s", |x| x / 1e6), ("L/min", |x| x / 6e4), ("m3/s", |x| x)],
            Self::Resistance => &[
                ("mmHg.s/mL", pascal_seconds_per_cubic_metre),
                ("mmHg·s/mL", pascal_seconds_per_cubic_metre),
                ("mmHg*s/mL", pascal_seconds_per_cubic_metre),
                ("Pa.s/m3", |x| x),
                ("Pa·s/m3", |x| x),
            ],
            Self::Viscosity => &[("cP", pascal_seconds), ("mPa.s", pascal_seconds), ("Pa.s", |x| x)],
            Self::Time => &[("s", |x| x), ("ms", |x| x / 1e3)],
            Self::Speed => &[("m/s", |x| x), ("cm/s", |x| x / 1e2)],
            Self::Density => &[("kg/m3", |x| x), ("g/cm3", |x| x * 1e3), ("g/mL", |x| x * 1e3)],
            Self::Compliance => &[("mL/mmHg", cubic_metres_per_pascal), ("m3/Pa", |x| x)],
            Self::Stiffness => &[("N/m", |x| x), ("Pa.m", |x| x), ("dyn/cm", |x| x / 1e3)],
            Self::Modulus => &[("MPa", megapascals), ("kPa", |x| x * 1e3), ("Pa", |x| x), ("dyn/cm2", |x| x / 10.0)],
        }
    }

    /// The accepted form, for messages.
    pub fn accepted(self) -> String {
        let names: Vec<&str> = self.units().iter().map(|(name, _)| *name).collect();
        format!("expected a number with a unit, one of {} (none means {})", names.join(", "), names[0])
    }

    /// The SI value of a quantity such as `12`, `1.2e1mm` or `12 mm`; the error says what is accepted.
    ///
    /// # Errors
    ///
    /// Not a finite number, or a unit of another dimension.
    pub fn parse(self, text: &str) -> Result<f64, String> {
        let (number, unit) = parts(text).ok_or_else(|| self.accepted())?;
        self.convert(number, unit)
    }

    /// The SI value of a number in a unit; without a unit it is the customary one.
    ///
    /// # Errors
    ///
    /// A number that is not finite, or a unit of another dimension: says what is accepted.
    pub fn convert(self, number: f64, unit: &str) -> Result<f64, String> {
        let names = || self.units().iter().map(|(name, _)| *name);
        let name = if unit.is_empty() { self.units()[0].0 } else { unit };
        let unknown = || did_you_mean(unit, names()) + &self.accepted();
        let (_, to_si) = self.units().iter().find(|(n, _)| *n == name).ok_or_else(unknown)?;
        Some(to_si(number)).filter(|si| si.is_finite()).ok_or_else(|| self.accepted())
    }

    /// `did you mean "mmHg"? ` for a number with a misspelt unit of this dimension; otherwise empty.
    pub fn near(self, text: &str) -> String {
        parts(text).map_or(String::new(), |(_, unit)| did_you_mean(unit, self.units().iter().map(|(name, _)| *name)))
    }

    /// Whether the text is a number followed by a unit of this dimension.
    pub fn has_unit_in(self, text: &str) -> bool {
        parts(text).is_some_and(|(_, unit)| self.units().iter().any(|(name, _)| *name == unit))
    }
}

/// The longest leading number, and the unit after it.
fn parts(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let cuts = text.char_indices().map(|(at, _)| at).skip(1).chain([text.len()]);
    let (number, at) = cuts.filter_map(|at| Some((text[..at].trim_end().parse::<f64>().ok()?, at))).last()?;
    let starts_well = text.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    starts_well.then(|| (number, text[at..].trim()))
}
