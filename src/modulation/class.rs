//! A class of resistance modulation, and what a modulation by u does to a vessel.

use std::fmt;

use rand::{Rng, RngExt};

use crate::flow::Factors;

/// The range of the modulation u, drawn uniformly in [low, high).
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
        let alone = |resistance| Factors { resistance, ..Factors::ONE };
        match self {
            Self::Increment => alone(1.0 + u),
            Self::Conductance => alone(1.0 / (1.0 - u)),
            Self::Literal => alone(1.0 - u),
            Self::Geometry => {
                let (radius, length) = (1.0 - u, 1.0 + class.draw(rng));
                Factors { resistance: length / radius.powi(4), volume: radius * radius * length, radius, length }
            }
        }
    }
}
