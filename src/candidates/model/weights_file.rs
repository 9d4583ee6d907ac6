//! Weights as TOML, each by the name of its feature.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Deserialize;

use super::loop_closures::CLOSURE_FEATURES;
use super::usual::{FIGURES, Usual};
use super::weights::{Fold, HeldOutScores, Pass, Provenance, Weights};
use crate::error::Fault;
use crate::support::suggestions::did_you_mean;
use crate::support::toml_text::{list, parse, text};

const HEADING: &str = "\
# Weights of the evidence model, fitted by `willis train`; read by `willis infer --prior FILE`.
# A bridge weighs exp(sum of weight times feature), a root likewise. Features have no unit: angles are in rad, lengths are
# divided by lengths. Pass 2 and later see the posterior of the pass before.
";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    calibration: [f64; 3],
    #[serde(default)]
    of_input: [f64; 3],
    pass: Vec<PassEntry>,
    closure: Option<BTreeMap<String, f64>>,
    usual: Option<BTreeMap<String, [f64; 2]>>,
    #[serde(default)]
    provenance: Provenance,
    #[serde(default)]
    figures: Vec<HeldOutScores>,
    #[serde(default)]
    fold: Vec<Fold>,
}

#[derive(Deserialize)]
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
        let file: File = parse(text, "expected weights as `willis train` writes them")?;
        let mut passes = Vec::new();
        for (number, entry) in file.pass.into_iter().enumerate() {
            let place = |of: &str| format!("pass {} {of}", number + 1);
            passes.push(Pass {
                candidate: by_name(&place("bridge"), entry.bridge, Pass::candidate_features(number).collect())?,
                root: by_name(&place("root"), entry.root, Pass::root_features().collect())?,
            });
        }
        let closure =
            file.closure.map(|given| by_name("closure", given, CLOSURE_FEATURES.to_vec())).transpose()?.unwrap_or_default();
        let usual = file.usual.map(|given| by_name("usual", given, FIGURES.map(|(name, _)| name).to_vec())).transpose()?;
        let usual = usual.and_then(|ranges| ranges.try_into().ok()).map(Usual);
        let provenance = Provenance { figures: file.figures, folds: file.fold, ..file.provenance };
        let weights = Weights { passes, calibration: file.calibration, of_input: file.of_input, usual, closure, provenance };
        weights.validate().map_err(|error| Fault::file(error.to_string(), "weights as `willis train` writes them are"))?;
        Ok(weights)
    }

    /// Writes TOML; every number is read back as it was.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let provenance = &self.provenance;
        write!(out, "{HEADING}")?;
        writeln!(
            out,
            "\n# P = 1/(1 + exp(-(a + b l + c min(l, 0) + d m + e s + f m s))), l = ln p/(1 - p), p the posterior of a link in the last pass;\n\
             # m = ln((A + 1)/(n - A + 1)), A of n fragments being attached by the posterior, and s = 10/(n + 10)."
        )?;
        writeln!(out, "calibration = {:?}\nof_input = {:?}", self.calibration, self.of_input)?;
        for (number, pass) in self.passes.iter().enumerate() {
            writeln!(out, "\n[[pass]]\n[pass.bridge]")?;
            for (name, weight) in Pass::candidate_features(number).zip(&pass.candidate) {
                writeln!(out, "{name} = {weight:?}")?;
            }
            writeln!(out, "[pass.root]")?;
            for (name, weight) in Pass::root_features().zip(&pass.root) {
                writeln!(out, "{name} = {weight:?}")?;
            }
        }
        if !self.closure.is_empty() {
            writeln!(
                out,
                "\n# A bridge within one fragment closes a loop with probability 1/(1 + exp(-(sum of weight times feature))).\n[closure]"
            )?;
            for (name, weight) in CLOSURE_FEATURES.iter().zip(&self.closure) {
                writeln!(out, "{name} = {weight:?}")?;
            }
        }
        if let Some(Usual(ranges)) = self.usual {
            writeln!(
                out,
                "\n# The least and the most of all cases: fragments, their free ends, steps in the radius of an end, standard deviation of ln r.\n[usual]"
            )?;
            for ((name, _), range) in FIGURES.iter().zip(ranges) {
                writeln!(out, "{name} = {range:?}")?;
            }
        }
        writeln!(out, "\n# What the weights were fitted to.\n[provenance]")?;
        writeln!(
            out,
            "cases = {}\nsubjects = {}\nmade_by = {}",
            provenance.cases,
            provenance.subjects,
            text(&provenance.made_by)
        )?;
        if !provenance.held_out.is_empty() {
            writeln!(out, "held_out = {}", list(&provenance.held_out))?;
        }
        if !provenance.figures.is_empty() {
            writeln!(
                out,
                "\n# Cross-validated by subject: average precision over all right links (mean over cases), calibration error of"
            )?;
            writeln!(out, "# links with 0.05 < P < 0.95, log-likelihood in nats a case.")?;
        }
        for figures in &provenance.figures {
            write_figures("figures", figures, &mut out)?;
        }
        for fold in &provenance.folds {
            writeln!(out, "\n[[fold]]\nheld_out = {}", list(&fold.held_out))?;
            for figures in &fold.figures {
                write_figures("fold.figures", figures, &mut out)?;
            }
        }
        out.flush()
    }
}

/// The weights in the order of the features' names.
fn by_name<T>(place: &str, mut given: BTreeMap<String, T>, names: Vec<&str>) -> Result<Vec<T>, Fault> {
    let mut out = Vec::new();
    for name in &names {
        let weight = given.remove(*name);
        out.push(weight.ok_or_else(|| Fault::item(place, format!("no weight {name}"), "expected one for every feature"))?);
    }
    match given.into_keys().next() {
        Some(other) => {
            let meant = did_you_mean(&other, names);
            Err(Fault::item(place, format!("weight \"{other}\""), format!("{meant}expected the name of a feature")))
        }
        None => Ok(out),
    }
}

fn write_figures(table: &str, figures: &HeldOutScores, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "\n[[{table}]]\nof = {}", text(&figures.of))?;
    writeln!(out, "cases = {}\nsubjects = {}", figures.cases, figures.subjects)?;
    if let Some(x) = figures.average_precision {
        writeln!(out, "average_precision = {x:?}")?;
    }
    if let Some(x) = figures.calibration_error {
        writeln!(out, "calibration_error = {x:?}")?;
    }
    writeln!(out, "log_likelihood = {:?}", figures.log_likelihood)
}
