//! How far a wall gives: C' = dA/dP of a tube from the law of its wall.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::network::{Wall, millimetres};

/// The law of the walls. Radius and stiffness hold at the mean pressure.
///
/// A thin wall that keeps its volume (Poisson's ratio 1/2) has P = (4/3)(Eh/r)(√(A/A₀) - 1), so C' = (3/2) A r/(Eh), and the wave speed
/// c₀² = (2/3)(Eh/r)/ρ = A/(ρC').
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WallLaw {
    /// Eh/r = k₁ e^{k₂ r} + k₃ (Olufsen 1999).
    Olufsen {
        /// k₁, Pa.
        k1: f64,
        /// k₂, 1/m.
        k2: f64,
        /// k₃, Pa.
        k3: f64,
    },
    /// One Eh for every vessel, Pa m.
    Stiffness(f64),
    /// Young's modulus E, Pa, and a thickness h.
    Elastic {
        /// E, Pa.
        young: f64,
        /// h.
        thickness: Thickness,
    },
    /// One wave speed c₀ for every vessel, m/s: C' = A/(ρc₀²) (Bramwell and Hill 1922).
    Speed(f64),
    /// What each vessel states itself.
    Stated,
    /// Walls that give nothing: C' = 0.
    Rigid,
}

/// The thickness of walls.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Thickness {
    /// The same everywhere, m.
    Length(f64),
    /// A share of the radius.
    OfRadius(f64),
}

impl WallLaw {
    /// Olufsen's values, 2·10⁷ g/(s² cm), -22.53 /cm and 8.65·10⁵ g/(s² cm), in SI.
    pub const OLUFSEN: Self = Self::Olufsen { k1: 2.0e6, k2: -2253.0, k3: 8.65e4 };

    /// C' (m²/Pa) of a tube of a radius (m) that may state its own wall, in blood of a density (kg/m³); `name` says which vessel it is.
    ///
    /// # Errors
    ///
    /// A law that is not positive here, or a wall that is not stated.
    pub fn compliance(&self, radius: f64, stated: Option<Wall>, density: f64, name: &str) -> Result<f64> {
        let area = PI * radius * radius;
        let by_speed = |speed: f64| (speed, area / (density * speed * speed), "wave speed (m/s)");
        let by_stiffness = |stiffness: f64| (stiffness, 1.5 * area * radius / stiffness, "Eh (Pa m)");
        let (figure, compliance, what) = match (self, stated) {
            (Self::Rigid, _) => return Ok(0.0),
            (Self::Olufsen { k1, k2, k3 }, _) => by_stiffness(radius * (k1 * (k2 * radius).exp() + k3)),
            (Self::Stiffness(stiffness), _) => by_stiffness(*stiffness),
            (Self::Elastic { young, thickness }, _) => by_stiffness(match thickness {
                Thickness::Length(length) => young * length,
                Thickness::OfRadius(share) => young * share * radius,
            }),
            (Self::Speed(speed), _) => by_speed(*speed),
            (Self::Stated, Some(Wall::Speed(speed))) => by_speed(speed),
            (Self::Stated, Some(Wall::Elastic { young, thickness })) => by_stiffness(young * thickness),
            (Self::Stated, None) => {
                let accepted = "expected pwv_m_per_s, or young_MPa and wall_mm, on every edge";
                return Err(Error::parameter("wall", "graph", format!("{name} states no wall; {accepted}")));
            }
        };
        if figure > 0.0 && figure.is_finite() && compliance.is_finite() {
            return Ok(compliance);
        }
        let found = format!("{figure} at {name} of radius {} mm", millimetres(radius));
        Err(Error::parameter("wall", format!("law gives {what} {found}"), "expected a positive one"))
    }
}
