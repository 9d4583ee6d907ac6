//! The options of candidates: how many, how far, where they may end and how wide they are.

use serde::{Deserialize, Serialize};

use willis_core::error::{Error, Result};
use willis_core::network::RadiusRule;
use willis_core::network::units::millimetres;

/// Where a candidate may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Attach {
    /// On the centerline of any vessel, split there, or on a free end.
    #[default]
    Centerline,
    /// On free ends only.
    Ends,
}

/// How a candidate's radius comes from the radii at its two ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateRadius {
    /// The smaller one.
    #[default]
    Min,
    /// Their mean.
    Mean,
}

/// How candidates are built.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CandidateOptions {
    /// How many of the nearest branches and free ends each free end is joined to, at least 1; by default 6, and with evidence 5 branches and
    /// four free ends beside them.
    pub k: Option<usize>,
    /// The longest candidate, m, positive; without it 20 point spacings + 5 end diameters limit the reach, twice as far straight ahead of an end on
    /// masks and skeletons.
    #[serde(rename = "max_gap_m")]
    pub max_gap: Option<f64>,
    /// Where a candidate may end.
    pub attach: Attach,
    /// How a candidate's radius comes from those at its ends.
    #[serde(rename = "candidate_radius")]
    pub radius: CandidateRadius,
    /// The largest radius of a candidate, m, positive.
    #[serde(rename = "max_candidate_radius_m")]
    pub max_radius: Option<f64>,
    /// The radius rule of the observed vessels, for the parts of a vessel that is split.
    pub radius_rule: RadiusRule,
}

/// [`CandidateOptions::k`] without evidence, where none is given.
pub const NEAREST: usize = 6;

impl CandidateOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        if self.k == Some(0) {
            return Err(Error::parameter("k", 0, "expected at least 1"));
        }
        for (name, value) in [("max_gap", self.max_gap), ("max_candidate_radius", self.max_radius)] {
            if let Some(m) = value.filter(|m| !m.is_finite() || *m <= 0.0) {
                return Err(Error::parameter(name, millimetres(m), "expected a positive length"));
            }
        }
        Ok(())
    }
}
