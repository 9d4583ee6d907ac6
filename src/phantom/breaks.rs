//! How badly an extraction fares: the parameters of the damage.

use crate::error::{Error, Result};
use crate::network::units::metres;

/// What goes wrong between a complete network and its extraction. The defaults are an extraction of middling quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Breaks {
    /// The seed; the same seed gives the same extraction.
    pub seed: u64,
    /// Distance of centerline points, m, positive.
    pub spacing: f64,
    /// Probability that a junction loses the stretch next to it of its thinnest vessel, 0 to 1.
    pub junction_gaps: f64,
    /// Probability that such a junction loses its second thinnest too, 0 to 1.
    pub double_gaps: f64,
    /// Expected gaps midway per 100 diameters of vessel, so that thin vessels break more often; 0 to 100.
    pub vessel_gaps: f64,
    /// Missing stretch in diameters of its vessel: uniform between these two, 0 to 100 and in order.
    ///
    /// To this come one point distance plus an exponential with mean half of one, and at a junction a uniform share
    /// of the widest vessel's radius.
    pub gap_diameters: [f64; 2],
    /// Probability that a missing stretch is twice as long, 0 to 1.
    pub long_gaps: f64,
    /// Probability that a vessel with a free end is missing altogether, 0 to 1. Inlets stay.
    pub lost_ends: f64,
    /// Mean shortening of the other free ends in diameters, exponential, 0 to 100. Inlets stay whole.
    pub short_ends: f64,
    /// Displacement of points in point distances: normal, root mean square over the three axes together, 0 to 1.
    pub jitter: f64,
    /// Standard deviation of ln radius from point to point, 0 to 1.
    pub radius_noise: f64,
    /// Standard deviation of ln radius from fragment to fragment, 0 to 1.
    pub radius_bias: f64,
    /// Spurious bits per true fragment, 0 to 10. They are random walks near the vessels that touch nothing.
    pub spurious: f64,
    /// Least and greatest steps of a spurious bit, 2 to 1000 and in order.
    pub spurious_steps: [u32; 2],
}

impl Default for Breaks {
    fn default() -> Self {
        Self {
            seed: 0,
            spacing: metres(0.5),
            junction_gaps: 0.6,
            double_gaps: 0.05,
            vessel_gaps: 0.5,
            gap_diameters: [0.5, 3.0],
            long_gaps: 0.1,
            lost_ends: 0.05,
            short_ends: 1.0,
            jitter: 0.3,
            radius_noise: 0.1,
            radius_bias: 0.05,
            spurious: 0.3,
            spurious_steps: [5, 20],
        }
    }
}

impl Breaks {
    /// Refuses a field out of its range.
    ///
    /// # Errors
    ///
    /// Names the field, its value and its range.
    pub fn validate(&self) -> Result<()> {
        if !(self.spacing.is_finite() && self.spacing > 0.0) {
            return Err(Error::parameter("spacing", self.spacing, "expected a positive length, m"));
        }
        for (name, value, most) in [
            ("junction_gaps", self.junction_gaps, 1.0),
            ("double_gaps", self.double_gaps, 1.0),
            ("vessel_gaps", self.vessel_gaps, 100.0),
            ("long_gaps", self.long_gaps, 1.0),
            ("lost_ends", self.lost_ends, 1.0),
            ("short_ends", self.short_ends, 100.0),
            ("jitter", self.jitter, 1.0),
            ("radius_noise", self.radius_noise, 1.0),
            ("radius_bias", self.radius_bias, 1.0),
            ("spurious", self.spurious, 10.0),
        ] {
            if !(0.0..=most).contains(&value) {
                return Err(Error::parameter(name, value, format!("expected 0 to {most}")));
            }
        }
        let [least, most] = self.gap_diameters;
        if !(0.0 <= least && least <= most && most <= 100.0) {
            return Err(Error::parameter("gap_diameters", format!("{least},{most}"), "expected 0 to 100, the lesser first"));
        }
        let [least, most] = self.spurious_steps;
        if !(2 <= least && least <= most && most <= 1000) {
            return Err(Error::parameter("spurious_steps", format!("{least},{most}"), "expected 2 to 1000, the lesser first"));
        }
        Ok(())
    }
}
