//! The options of a resistance modulation: its classes, and what a modulation by u does to a vessel.

use std::fmt;

use rand::{Rng, RngExt};

use crate::error::{Error, Result};
use crate::flow::{BLOOD_VISCOSITY, Factors, Unfed, check_viscosity};

/// The largest number of classes.
const MOST_CLASSES: usize = 12;
/// The largest number of instances of a class: memory holds the figures of all of them.
const MOST_SAMPLES: u64 = 1 << 24;

/// A class of modulation: u is drawn uniformly in [low, high).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// At least 0.
    pub low: f64,
    /// Above `low` and below 1.
    pub high: f64,
}

/// What a modulation by u means. The paper names the classes and leaves this open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reading {
    /// The resistance grows: R (1 + u).
    #[default]
    Increment,
    /// The conductance shrinks: R / (1 - u).
    Conductance,
    /// The resistance shrinks: R (1 - u).
    Literal,
    /// The lumen shrinks and the vessel grows longer, by two independent draws: radius r (1 - u1), length l (1 + u2), so
    /// that the resistance is R (1 + u2)/(1 - u1)⁴ and the volume V (1 - u1)² (1 + u2).
    Geometry,
}

/// How resistances are modulated.
#[derive(Debug, Clone, PartialEq)]
pub struct ModulationOptions {
    /// The classes: 1 to 12 of them, no two alike.
    pub classes: Vec<Class>,
    /// Instances of each class, 1 to 2²⁴.
    pub samples: u64,
    /// The seed.
    pub seed: u64,
    /// What a modulation means.
    pub reading: Reading,
    /// For each vessel whether it is modulated; `None` modulates all.
    pub vessels: Option<Vec<bool>>,
    /// Blood viscosity µ, Pa s, positive.
    pub viscosity: f64,
    /// What becomes of vessels that no inlet feeds, where an input is modulated.
    pub unfed: Unfed,
}

impl Class {
    /// The classes of the paper.
    pub const PAPER: [Self; 3] = [Self { low: 0.0, high: 0.2 }, Self { low: 0.2, high: 0.3 }, Self { low: 0.3, high: 0.5 }];
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.low, self.high)
    }
}

impl Reading {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        ["increment", "conductance", "literal", "geometry"][self as usize]
    }

    /// Draws the modulation of one vessel.
    pub fn draw(self, class: Class, rng: &mut impl Rng) -> Factors {
        let mut draw = || rng.random_range(class.low..class.high);
        let u = draw();
        let of_resistance = |resistance| Factors { resistance, ..Factors::ONE };
        match self {
            Self::Increment => of_resistance(1.0 + u),
            Self::Conductance => of_resistance(1.0 / (1.0 - u)),
            Self::Literal => of_resistance(1.0 - u),
            Self::Geometry => {
                let (radius, length) = (1.0 - u, 1.0 + draw());
                Factors { resistance: length / radius.powi(4), volume: radius * radius * length, radius, length }
            }
        }
    }
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
            unfed: Unfed::Keep,
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
