//! The options of a simulation: conditions, viscosity, and how the flow pulsates.

use serde::{Deserialize, Serialize};

use super::boundary_options::BoundaryOptions;
use willis_core::error::{Error, Result};
use willis_core::flow::poiseuille::{BLOOD_VISCOSITY, check_viscosity};
use willis_core::flow::state::BLOOD_DENSITY;
use willis_core::flow::{Unfed, WallLaw};
use willis_core::network::Windkessel;
use willis_core::simulation::pulse::Friction;

/// How [`simulate`](crate::simulate) works.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlowOptions {
    /// Where blood enters and leaves.
    pub boundary: BoundaryOptions,
    /// Blood viscosity µ, Pa s, positive.
    #[serde(rename = "viscosity_Pa_s")]
    pub viscosity: f64,
    /// Whether to follow the blood: who feeds what, and when it arrives.
    pub transport: bool,
    /// Whether to close each vessel in turn.
    pub occlude_each: bool,
    /// How the flow pulsates; `None` leaves it steady.
    pub pulse: Option<PulseOptions>,
    /// What becomes of vessels that no inlet feeds.
    pub unfed: Unfed,
}

impl Default for FlowOptions {
    fn default() -> Self {
        let boundary = BoundaryOptions::default();
        Self { boundary, viscosity: BLOOD_VISCOSITY, transport: false, occlude_each: false, pulse: None, unfed: Unfed::Keep }
    }
}

impl FlowOptions {
    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check_viscosity(self.viscosity)?;
        self.pulse.as_ref().map_or(Ok(()), PulseOptions::validate)
    }
}

/// How the flow pulsates. The default is what `willis simulate --pulse` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PulseOptions {
    /// What drives the inlets: a table of one period for all of them (`FILE`) or for one (`NODE=FILE`), or in the place of a file
    /// `carotid`, `vertebral` or `typical`, shapes of the flow whose mean is the steady flow there. Without any: `typical`.
    pub waveforms: Vec<String>,
    /// The period T, s, positive; by default what the tables mean.
    #[serde(rename = "period_s")]
    pub period: Option<f64>,
    /// The mean of every waveform that is a table: a pressure is shifted to it, a flow scaled to it.
    pub mean: Option<PulseMean>,
    /// How many harmonics are solved, 1 to 1000.
    pub harmonics: usize,
    /// The law of the walls; by default what the vessels state, or Olufsen's law where none does.
    pub wall: Option<WallLaw>,
    /// φ of a Kelvin-Voigt wall, s; 0 of an elastic one.
    #[serde(rename = "wall_viscosity_s")]
    pub wall_viscosity: f64,
    /// RC of outlets with a terminal resistance that state no compliance, s, positive; `None` leaves them resistances.
    #[serde(rename = "time_constant_s")]
    pub time_constant: Option<f64>,
    /// The profile by which the flow meets friction.
    pub friction: Friction,
    /// Density of blood ρ, kg/m³, positive.
    #[serde(rename = "density_kg_per_m3")]
    pub density: f64,
    /// At how many even times of the period waveforms are written, 10 to 10000.
    pub times: usize,
}

/// What the mean of a waveform becomes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum PulseMean {
    /// Pa.
    #[serde(rename = "pressure_Pa")]
    Pressure(f64),
    /// m³/s.
    #[serde(rename = "flow_m3_per_s")]
    Flow(f64),
}

impl Default for PulseOptions {
    fn default() -> Self {
        Self {
            waveforms: Vec::new(),
            period: None,
            mean: None,
            harmonics: 40,
            wall: None,
            wall_viscosity: 0.0,
            time_constant: Some(Windkessel::TIME_CONSTANT),
            friction: Friction::default(),
            density: BLOOD_DENSITY,
            times: 100,
        }
    }
}

impl PulseOptions {
    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let positive = |name: &'static str, value: Option<f64>, unit: &str| match value {
            Some(x) if !(x.is_finite() && x > 0.0) => {
                Err(Error::parameter(name, x, format!("expected a positive number of {unit}")))
            }
            _ => Ok(()),
        };
        positive("period", self.period, "s")?;
        positive("windkessel", self.time_constant, "s")?;
        positive("density", Some(self.density), "kg/m3")?;
        if !(self.wall_viscosity.is_finite() && self.wall_viscosity >= 0.0) {
            return Err(Error::parameter("wall_viscosity", self.wall_viscosity, "expected zero or a positive number of s"));
        }
        if !(1..=1000).contains(&self.harmonics) {
            return Err(Error::parameter("harmonics", self.harmonics, "expected a number from 1 to 1000"));
        }
        if !(10..=10_000).contains(&self.times) {
            return Err(Error::parameter("times", self.times, "expected a number from 10 to 10000"));
        }
        Ok(())
    }
}
