//! The weights of the prior: where they come from, their file, what the inputs were like that they were fitted to.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use crate::candidates::features::{Extraction, FEATURES, FEEDBACK_FEATURES, ROOT_FEATURES, radius_variation, width_in_spacings};
use willis_core::error::{Error, Fault, Result, require};
use willis_core::forest_posterior::Marginals;
use willis_core::support::calibration::Calibration;
use willis_core::support::model_provenance::ModelProvenance;
use willis_core::support::toml_text::{parse, write};

/// The features of a closure, in the order of their weights.
pub const CLOSURE_FEATURES: [&str; 10] =
    ["one", "score", "detour", "gap", "bend_child_sq", "bend_parent_sq", "wide", "size", "two_inlets", "claimed"];

/// One pass over the candidates.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PassWeights {
    /// Per feature of a candidate, as [`PassWeights::candidate_features`] orders them.
    pub candidate: Vec<f64>,
    /// Per feature of a root, as [`ROOT_FEATURES`] orders them.
    pub root: Vec<f64>,
}

impl PassWeights {
    /// The names of a candidate's features in the pass of a number, counted from 0: feedback comes with the second.
    pub fn candidate_features(number: usize) -> impl Iterator<Item = &'static str> {
        FEATURES.iter().map(|(name, _)| *name).chain(FEEDBACK_FEATURES.iter().copied().filter(move |_| number > 0))
    }

    /// The names of a root's features.
    pub fn root_features() -> impl Iterator<Item = &'static str> {
        ROOT_FEATURES.iter().map(|(name, _)| *name)
    }
}

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
        Self::read(include_str!("weights.toml")).map_err(|fault| fault.in_file("weights.toml".as_ref()))
    }

    /// The weights for tubes, drawn one by one, that come with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: they are tested.
    pub fn shipped_for_tubes() -> Result<Self> {
        Self::read(include_str!("tubes.toml")).map_err(|fault| fault.in_file("tubes.toml".as_ref()))
    }

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
        require(!self.passes.is_empty(), "weights", "of no pass", "expected one pass at least")?;
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
    let (given, expected) = (weights.len(), names.len());
    require(given == expected, place, format!("has {given} weights"), format!("expected {expected}"))?;
    match weights.iter().zip(names).find(|(w, _)| is_wild(**w)) {
        Some((w, name)) => {
            Err(Error::parameter(format!("{place} {name}"), w, format!("expected a number from -{MOST_WEIGHT} to {MOST_WEIGHT}")))
        }
        None => Ok(()),
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
            let meant = willis_core::support::suggestions::did_you_mean(&other, names);
            Err(Fault::item(place, format!("weight \"{other}\""), format!("{meant}expected the name of a feature")))
        }
        None => Ok(out),
    }
}

/// The figures by their names in files and in words: how many fragments there are, and of a fragment the mean of its free ends, the geometric
/// mean of the radius of its widest end in steps of the points, and the mean standard deviation of ln r along it.
pub const FIGURES: [(&str, &str); 4] = [
    ("fragments", "fragments"),
    ("free_ends", "free ends a fragment"),
    ("end_radius", "steps in the radius of an end"),
    ("radius_variation", "variation of the radius"),
];

/// The range of each of [`FIGURES`] over some extractions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Usual(pub [[f64; 2]; FIGURES.len()]);

impl Usual {
    /// That of one extraction; `None` without a fragment.
    pub fn new(extraction: &Extraction) -> Option<Self> {
        let fragments = &extraction.fragments;
        let mean = |of: &dyn Fn(usize) -> f64| (0..fragments.len()).map(of).sum::<f64>() / fragments.len() as f64;
        let figures = [
            fragments.len() as f64,
            mean(&|f| fragments[f].free_ends as f64),
            mean(&|f| width_in_spacings(extraction, &fragments[f])).exp(),
            mean(&|f| radius_variation(extraction, &fragments[f])),
        ];
        (!fragments.is_empty()).then(|| Self(figures.map(|x| [x; 2])))
    }

    /// The range over both.
    #[must_use]
    pub fn with(mut self, other: Self) -> Self {
        for ([least, most], [a, b]) in self.0.iter_mut().zip(other.0) {
            (*least, *most) = (least.min(a), most.max(b));
        }
        self
    }

    /// What to tell a person of one extraction with a figure that none of those in the range `seen` had; `None` where it has none.
    pub fn unlike(self, seen: Self) -> Option<String> {
        let figures = FIGURES.into_iter().zip(self.0).zip(seen.0);
        let told: Vec<String> = figures
            .filter(|((_, [here, _]), [least, most])| here < least || here > most)
            .map(|(((_, words), [here, _]), range)| {
                let [least, most] = range.map(short);
                format!("{} {words} (there {least} to {most})", short(here))
            })
            .collect();
        (!told.is_empty()).then(|| {
            format!(
                "the centerlines are unlike all that the probabilities were fitted to: {}; read them as a rank, not as a share",
                told.join(" and ")
            )
        })
    }
}

/// A whole number as it is, another with two digits behind the point.
fn short(x: f64) -> String {
    if x.fract() == 0.0 { format!("{x:.0}") } else { format!("{x:.2}") }
}
