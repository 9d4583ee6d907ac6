//! The parameters of a resistance modulation.

use super::class::{Class, Reading};
use crate::error::{Error, Result};
use crate::flow::poiseuille::{BLOOD_VISCOSITY, check_viscosity};

/// Classes at the most.
const MOST_CLASSES: usize = 12;
/// Instances of a class at the most: all their figures are held in memory.
const MOST_SAMPLES: u64 = 1 << 24;

/// How resistances are modulated.
#[derive(Debug, Clone, PartialEq)]
pub struct ModulationOptions {
    /// The classes, 1 to 12 different ones.
    pub classes: Vec<Class>,
    /// Instances of each class, 1 to 2²⁴.
    pub samples: u64,
    /// The seed.
    pub seed: u64,
    /// What a modulation means.
    pub reading: Reading,
    /// Per vessel whether it is modulated; all are when this is `None`.
    pub vessels: Option<Vec<bool>>,
    /// Blood viscosity µ, Pa s, positive.
    pub viscosity: f64,
}

impl Default for ModulationOptions {
    fn default() -> Self {
        Self {
            classes: Class::PAPER.to_vec(),
            samples: 1000,
            seed: 0,
            reading: Reading::default(),
            vessels: None,
            viscosity: BLOOD_VISCOSITY,
        }
    }
}

impl ModulationOptions {
    /// Checks every field but `vessels`.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let count = self.classes.len();
        if count == 0 || count > MOST_CLASSES {
            return Err(Error::parameter("classes", format!("of {count}"), format!("expected 1 to {MOST_CLASSES} classes")));
        }
        for (at, class) in self.classes.iter().enumerate() {
            let refused = |why: &str| Error::parameter("classes", class, why);
            if class.low >= class.high {
                return Err(refused("the class ends before it begins; expected LOW:HIGH with 0 <= low < high < 1"));
            }
            if !(class.low >= 0.0 && class.high < 1.0) {
                return Err(refused("expected LOW:HIGH with 0 <= low < high < 1"));
            }
            if self.classes[..at].contains(class) {
                return Err(refused("given twice; expected each class once"));
            }
        }
        if self.samples == 0 || self.samples > MOST_SAMPLES {
            return Err(Error::parameter("samples", self.samples, "expected a number from 1 to 2^24"));
        }
        check_viscosity(self.viscosity)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_out_of_its_range_is_refused_by_name() {
        let class = |low, high| ModulationOptions { classes: vec![Class { low, high }], ..ModulationOptions::default() };
        let twice = vec![Class { low: 0.0, high: 0.2 }; 2];
        let cases = [
            (class(0.5, 0.2), "0.5:0.2: the class ends before it begins"),
            (class(0.2, 0.2), "0.2:0.2: the class ends before it begins"),
            (class(-0.1, 0.2), "-0.1:0.2: expected LOW:HIGH with 0 <= low < high < 1"),
            (class(0.5, 1.0), "0.5:1: expected"),
            (class(f64::NAN, 0.5), "NaN:0.5: expected"),
            (ModulationOptions { classes: Vec::new(), ..ModulationOptions::default() }, "classes of 0"),
            (ModulationOptions { classes: twice, ..ModulationOptions::default() }, "0:0.2: given twice"),
            (ModulationOptions { samples: 0, ..ModulationOptions::default() }, "samples 0"),
            (ModulationOptions { samples: 1 << 25, ..ModulationOptions::default() }, "samples 33554432"),
            (ModulationOptions { viscosity: 0.0, ..ModulationOptions::default() }, "viscosity 0"),
        ];
        for (params, words) in cases {
            let said = params.validate().expect_err("refused").to_string();
            assert!(said.contains(words), "{said}");
        }
        assert!(ModulationOptions::default().validate().is_ok());
    }
}
