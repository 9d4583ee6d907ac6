//! What the weights make of an extraction: the posterior over its forests and the probability of every link.

use super::closures::closures;
use super::decision_scores::{alone, hangs};
use super::feature_table::Rows;
use super::weights::Weights;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::feedback::Feedback;
use crate::candidates::search::by_evidence::FoundBridge;
use crate::error::{Error, Result};
use crate::forest_posterior::{Forests, Marginals, arborescence, check_tangle, marginals};
use crate::support::statistics::sigmoid;

/// The posterior over how the fragments of an extraction hang together.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// The bridges between fragments, in the order of [`Belief::forests`].
    pub bridges: Vec<FoundBridge>,
    /// The weights of the last pass.
    pub forests: Forests,
    /// The marginals of the last pass, not calibrated.
    pub marginals: Marginals,
    /// Per bridge the number of its link: the two directions between a pair of free ends share one.
    pub link: Vec<usize>,
    /// Per bridge the calibrated probability of its link.
    pub probability: Vec<f64>,
    /// Per bridge what speaks for hanging its child by it when a forest is decided.
    pub hangs: Vec<f64>,
    /// Per fragment what speaks for leaving it alone then.
    pub alone: Vec<f64>,
    /// The bridges within a fragment with the probability that they close a loop that is there.
    pub closures: Vec<(FoundBridge, f64)>,
}

/// The posterior that `weights` give the bridges of an extraction, which should be all of a search.
///
/// # Errors
///
/// Weights without a pass, or of other features than this program measures; fragments in a tangle.
pub fn believe(extraction: &Extraction, bridges: &[FoundBridge], weights: &Weights) -> Result<Belief> {
    weights.validate()?;
    let rows = Rows::new(extraction, bridges);
    let (forests, marginals) = last_pass(extraction, &rows, weights)?;
    let calibration = Calibration(weights.calibration);
    let of_link: Vec<f64> = rows.summed(&marginals.bridges).into_iter().map(|p| calibration.apply(p)).collect();
    let probability = rows.link.iter().map(|link| of_link[*link]).collect();
    let hangs = hangs(extraction, &rows.bridges, &marginals);
    let alone = alone(extraction, &marginals);
    let closures = if weights.closure.is_empty() {
        Vec::new()
    } else {
        let kept = arborescence(&forests, &hangs, &alone);
        let found = closures(extraction, &rows, &weights.passes[0], &marginals, &kept);
        found.iter().map(|c| (c.bridge, c.probability(&weights.closure))).collect()
    };
    Ok(Belief { hangs, alone, bridges: rows.bridges, forests, marginals, link: rows.link, probability, closures })
}

/// Weights and marginals of the last of all passes, each fed by the one before.
pub(crate) fn last_pass(extraction: &Extraction, rows: &Rows, weights: &Weights) -> Result<(Forests, Marginals)> {
    let mut last: Option<(Forests, Marginals)> = None;
    let mut feedback = None;
    for pass in &weights.passes {
        let forests = match &last {
            None => {
                let forests = rows.forests(pass, &rows.bridge)?;
                check_tangle(&forests)?;
                forests
            }
            Some((forests, marginals)) => {
                let feedback = feedback.get_or_insert_with(|| Feedback::new(extraction, &rows.bridges));
                rows.forests(pass, &rows.beside(&feedback.features(forests, marginals)))?
            }
        };
        let marginals = marginals(&forests);
        last = Some((forests, marginals));
    }
    last.ok_or_else(|| Error::parameter("weights", "of no pass", "expected one pass at least"))
}

/// The least probability, and the least doubt, whose log-odds are told apart.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odds_are_raised_to_the_slope_of_their_side() {
        let map = Calibration([0.0, 2.0, -1.0]);
        // Odds 4 become 16; odds 1/4 keep a slope of 2 - 1 = 1.
        assert!((map.apply(0.8) - 16.0 / 17.0).abs() < 1e-15 && (map.apply(0.2) - 0.2).abs() < 1e-15);
        assert_eq!([map.apply(0.0), map.apply(0.5)], [0.0, 0.5]);
        assert!(map.apply(1.0) <= 1.0 && map.apply(1.0) > 1.0 - 1e-12);
    }
}
