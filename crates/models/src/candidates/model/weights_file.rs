//! Weights as TOML, each by the name of its feature.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::loop_closures::CLOSURE_FEATURES;
use super::pass::PassWeights;
use super::usual::{FIGURES, Usual};
use super::weights::{Fold, HeldOutScores, Weights};
use willis_core::error::Fault;
use willis_core::support::model_provenance::ModelProvenance;
use willis_core::support::suggestions::did_you_mean;
use willis_core::support::toml_text::{parse, write};

const HEADING: &str = "\
# Weights of the evidence model, fitted by `willis train`; read by `willis infer --prior FILE`.
# A bridge weighs exp(sum of weight times feature), a root likewise. Features have no unit: angles are in rad, lengths are
# divided by lengths. Pass 2 and later see the posterior of the pass before.
# P = 1/(1 + exp(-(a + b l + c min(l, 0) + d m + e s + f m s))), [a, b, c] the calibration and [d, e, f] of_input; l = ln p/(1 - p), p the
# posterior of a link in the last pass; m = ln((A + 1)/(n - A + 1)), A of n fragments being attached by the posterior, s = 10/(n + 10).
# closure: a bridge within one fragment closes a loop with probability 1/(1 + exp(-(sum of weight times feature))).
# usual: the least and the most of all cases: fragments, their free ends, steps in the radius of an end, standard deviation of ln r.
# figures: cross-validated by subject: average precision over all right links (mean over cases), calibration error of links with
# 0.05 < P < 0.95, log-likelihood in nats a case.
";

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct WeightsFile {
    calibration: [f64; 3],
    #[serde(default)]
    of_input: [f64; 3],
    pass: Vec<PassEntry>,
    closure: Option<BTreeMap<String, f64>>,
    usual: Option<BTreeMap<String, [f64; 2]>>,
    #[serde(default)]
    provenance: ModelProvenance,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    figures: Vec<HeldOutScores>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    fold: Vec<Fold>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PassEntry {
    bridge: BTreeMap<String, f64>,
    root: BTreeMap<String, f64>,
}

impl Weights {
    /// Reads weights that `willis train` made, as TOML.
    ///
    /// # Errors
    ///
    /// Not TOML, a name that is unknown, missing or comes twice, a number that is not finite: the line or the name.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let file: WeightsFile = parse(text, "expected weights as `willis train` writes them")?;
        let mut passes = Vec::new();
        for (number, entry) in file.pass.into_iter().enumerate() {
            let place = |of: &str| format!("pass {} {of}", number + 1);
            passes.push(PassWeights {
                candidate: in_order(&place("bridge"), entry.bridge, PassWeights::candidate_features(number).collect())?,
                root: in_order(&place("root"), entry.root, PassWeights::root_features().collect())?,
            });
        }
        let closure = file.closure.map(|given| in_order("closure", given, CLOSURE_FEATURES.to_vec())).transpose()?;
        let usual = file.usual.map(|given| in_order("usual", given, FIGURES.map(|(name, _)| name).to_vec())).transpose()?;
        let weights = Weights {
            passes,
            calibration: file.calibration,
            of_input: file.of_input,
            usual: usual.and_then(|ranges| ranges.try_into().ok()).map(Usual),
            closure: closure.unwrap_or_default(),
            provenance: file.provenance,
            figures: file.figures,
            folds: file.fold,
        };
        weights.validate().map_err(|error| Fault::file(error.to_string(), "weights as `willis train` writes them are"))?;
        Ok(weights)
    }

    /// Writes TOML; every number is read back as it was.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        let pass = |(number, pass): (usize, &PassWeights)| PassEntry {
            bridge: by_name(PassWeights::candidate_features(number), &pass.candidate),
            root: by_name(PassWeights::root_features(), &pass.root),
        };
        let file = WeightsFile {
            calibration: self.calibration,
            of_input: self.of_input,
            pass: self.passes.iter().enumerate().map(pass).collect(),
            closure: (!self.closure.is_empty()).then(|| by_name(CLOSURE_FEATURES, &self.closure)),
            usual: self.usual.map(|Usual(ranges)| by_name(FIGURES.map(|(name, _)| name), &ranges)),
            provenance: self.provenance.clone(),
            figures: self.figures.clone(),
            fold: self.folds.clone(),
        };
        write(out, HEADING, false, &file)
    }
}

/// The weights by the features' names.
fn by_name<T: Copy>(names: impl IntoIterator<Item = &'static str>, weights: &[T]) -> BTreeMap<String, T> {
    names.into_iter().map(str::to_owned).zip(weights.iter().copied()).collect()
}

/// The weights in the order of the features' names.
fn in_order<T>(place: &str, mut given: BTreeMap<String, T>, names: Vec<&str>) -> Result<Vec<T>, Fault> {
    let missing = |name: &str| Fault::item(place, format!("no weight {name}"), "expected one for every feature");
    let out = names.iter().map(|name| given.remove(*name).ok_or_else(|| missing(name))).collect::<Result<_, _>>()?;
    match given.into_keys().next() {
        Some(other) => {
            let meant = did_you_mean(&other, names);
            Err(Fault::item(place, format!("weight \"{other}\""), format!("{meant}expected the name of a feature")))
        }
        None => Ok(out),
    }
}
