//! A class of resistance modulation, and what a modulation by u does to a vessel.

use std::fmt;

use rand::{Rng, RngExt};

use crate::hemodynamics::Tube;

/// The range of the modulation u, drawn uniformly in [low, high).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Class {
    /// At least 0.
    pub low: f64,
    /// Above `low` and below 1.
    pub high: f64,
}

/// What a modulation by u means. The paper names the classes and leaves this open.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
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

/// By what the figures of a vessel are multiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Factors {
    /// Of the resistance, whether it is stated or Poiseuille's.
    pub resistance: f64,
    /// Of the radius.
    pub radius: f64,
    /// Of the length.
    pub length: f64,
}

impl Class {
    /// The classes of the paper.
    pub const PAPER: [Self; 3] = [Self { low: 0.0, high: 0.2 }, Self { low: 0.2, high: 0.3 }, Self { low: 0.3, high: 0.5 }];

    /// One modulation u.
    fn draw(self, rng: &mut impl Rng) -> f64 {
        rng.random_range(self.low..self.high)
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.low, self.high)
    }
}

impl Reading {
    /// The word on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Increment => "increment",
            Self::Conductance => "conductance",
            Self::Literal => "literal",
            Self::Geometry => "geometry",
        }
    }

    /// Draws the modulation of one vessel.
    pub fn draw(self, class: Class, rng: &mut impl Rng) -> Factors {
        let u = class.draw(rng);
        let alone = |resistance| Factors { resistance, radius: 1.0, length: 1.0 };
        match self {
            Self::Increment => alone(1.0 + u),
            Self::Conductance => alone(1.0 / (1.0 - u)),
            Self::Literal => alone(1.0 - u),
            Self::Geometry => {
                let (radius, length) = (1.0 - u, 1.0 + class.draw(rng));
                Factors { resistance: length / radius.powi(4), radius, length }
            }
        }
    }
}

impl Factors {
    /// A vessel left as it is.
    pub const ONE: Self = Self { resistance: 1.0, radius: 1.0, length: 1.0 };

    /// The modulated vessel.
    pub fn of(&self, tube: &Tube) -> Tube {
        Tube {
            resistance: tube.resistance * self.resistance,
            volume: tube.volume * (self.radius * self.radius * self.length),
            radius: tube.radius * self.radius,
        }
    }
}
