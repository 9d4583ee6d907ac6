//! The weights of the prior, and where they come from.

use serde::{Deserialize, Serialize};

use super::loop_closures::CLOSURE_FEATURES;
use super::pass::PassWeights;
use super::usual::Usual;
use willis_core::error::{Error, Result};
use willis_core::forest_posterior::Marginals;
use willis_core::support::calibration::Calibration;
use willis_core::support::model_provenance::ModelProvenance;

/// The weights that come with the program.
const SHIPPED: &str = include_str!("weights.toml");
/// Those for tubes.
const TUBES: &str = include_str!("tubes.toml");

/// What is fitted to cases whose connections are known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Weights {
    /// The passes, one at least; each is fed by the posterior of the one before.
    pub passes: Vec<PassWeights>,
    /// [`Calibration`] of the last pass.
    pub calibration: [f64; 3],
    /// How much the calibration is moved by the [`input_features`] of an extraction; zeros where too few cases were seen.
    pub of_input: [f64; 3],
    /// The range of the cases that the weights or their calibration were fitted to; `None` for fewer than 50.
    pub usual: Option<Usual>,
    /// Per feature of a closure, as [`CLOSURE_FEATURES`] orders them; empty where no case had any.
    pub closure: Vec<f64>,
    /// Where the weights come from.
    pub provenance: ModelProvenance,
    /// How well such weights did on subjects that they were not fitted to, each case by the weights of the fold that held it out.
    pub figures: Vec<HeldOutScores>,
    /// The folds.
    pub folds: Vec<Fold>,
}

/// An extraction is few fragments as 10/(n + 10).
pub(super) const FEW: f64 = 10.0;

/// What the calibration asks of a whole extraction: m, s and m s, where m = ln((A + 1)/(n - A + 1)), A of the n fragments being attached
/// to another one by the posterior, and s = 10/(n + 10).
pub fn input_features(marginals: &Marginals) -> [f64; 3] {
    let n = marginals.roots.len() as f64;
    let attached: f64 = marginals.roots.iter().map(|root| 1.0 - root).sum();
    let m = ((attached + 1.0) / (n - attached + 1.0)).ln();
    let s = FEW / (n + FEW);
    [m, s, m * s]
}

/// One fold of a cross-validation.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fold {
    /// The subjects it held out.
    pub held_out: Vec<String>,
    /// Scores on their cases.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<HeldOutScores>,
}

/// How well the weights did on cases that they were not fitted to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HeldOutScores {
    /// The data set, or a folder in it.
    pub of: String,
    /// How many cases.
    pub cases: usize,
    /// Of how many subjects.
    pub subjects: usize,
    /// Average precision over all true connections, found or not; the mean over cases that have one. `None` where none has.
    pub average_precision: Option<f64>,
    /// Expected calibration error of the pairs with 0.05 < P < 0.95, all cases together, ten bins. `None` without such a pair.
    pub calibration_error: Option<f64>,
    /// Log-likelihood of the truth by the last pass, mean over cases.
    pub log_likelihood: f64,
}

/// The largest weight: beyond it products could overflow.
const MOST_WEIGHT: f64 = 1e6;

impl Weights {
    /// The weights that come with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: they are tested.
    pub fn shipped() -> Result<Self> {
        Self::read(SHIPPED).map_err(|fault| fault.in_file("weights.toml".as_ref()))
    }

    /// The weights for tubes, drawn one by one, that come with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: they are tested.
    pub fn shipped_for_tubes() -> Result<Self> {
        Self::read(TUBES).map_err(|fault| fault.in_file("tubes.toml".as_ref()))
    }

    /// The calibration of the pairs of an extraction with these marginals in the last pass.
    pub fn calibration_of(&self, marginals: &Marginals) -> Calibration {
        let moved: f64 = self.of_input.iter().zip(input_features(marginals)).map(|(weight, x)| weight * x).sum();
        let [a, b, c] = self.calibration;
        Calibration([a + moved, b, c])
    }

    /// Checks numbers of weights and their ranges.
    ///
    /// # Errors
    ///
    /// Names the pass and the feature, the value and the range.
    pub fn validate(&self) -> Result<()> {
        if self.passes.is_empty() {
            return Err(Error::parameter("weights", "of no pass", "expected one pass at least"));
        }
        for (number, pass) in self.passes.iter().enumerate() {
            let place = |of: &str| format!("pass {} {of}", number + 1);
            check(&place("bridge"), &pass.candidate, PassWeights::candidate_features(number).collect())?;
            check(&place("root"), &pass.root, PassWeights::root_features().collect())?;
        }
        if !self.closure.is_empty() {
            check("closure", &self.closure, CLOSURE_FEATURES.to_vec())?;
        }
        if let Some(x) = self.calibration.iter().chain(&self.of_input).find(|x| is_wild(**x)) {
            return Err(Error::parameter("calibration", x, format!("expected numbers from -{MOST_WEIGHT} to {MOST_WEIGHT}")));
        }
        Ok(())
    }
}

/// Whether a weight is no number, or too large.
fn is_wild(weight: f64) -> bool {
    weight.is_nan() || weight.abs() > MOST_WEIGHT
}

fn check(place: &str, weights: &[f64], names: Vec<&str>) -> Result<()> {
    if weights.len() != names.len() {
        return Err(Error::parameter(place, format!("has {} weights", weights.len()), format!("expected {}", names.len())));
    }
    match weights.iter().zip(names).find(|(w, _)| is_wild(**w)) {
        Some((w, name)) => {
            Err(Error::parameter(format!("{place} {name}"), w, format!("expected a number from -{MOST_WEIGHT} to {MOST_WEIGHT}")))
        }
        None => Ok(()),
    }
}
