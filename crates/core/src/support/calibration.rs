//! From the probability that a model states to the share of such cases that is right.

use super::sigmoid;

/// The least probability, and the least doubt, whose log-odds are distinguished.
const LEAST: f64 = 1e-12;

/// P = σ(a + b l + c min(l, 0)), l the log-odds of the model's own probability: Platt's map with a slope for either side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration(pub [f64; 3]);

impl Calibration {
    /// 1, l and min(l, 0) of a probability.
    pub fn design(p: f64) -> [f64; 3] {
        let p = p.clamp(LEAST, 1.0 - LEAST);
        let log_odds = (p / (1.0 - p)).ln();
        [1.0, log_odds, log_odds.min(0.0)]
    }

    /// The calibrated probability; what cannot be stays so.
    pub fn apply(&self, p: f64) -> f64 {
        if p <= 0.0 {
            return 0.0;
        }
        let z: f64 = self.0.iter().zip(Self::design(p)).map(|(a, x)| a * x).sum();
        sigmoid(z)
    }
}
