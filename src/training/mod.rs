//! Fits the evidence model to cases: extractions whose true connections are known, read from folders.

mod case_folders;
pub mod cross_validation;
pub mod example;
pub mod fit;
pub mod known_connections;
pub mod logistic;
pub mod minimise;
pub mod objective;
mod read_case;
pub mod scores;
mod truth_file;

pub use cross_validation::{CrossValidation, check_folds, cross_validate, fold_of};
pub use example::{Case, Example};
pub use fit::{Step, TrainParams, fit, goes_without_inlets, train};
pub use known_connections::Match;
pub use logistic::calibrate;
pub use objective::{Objective, case_weights};
pub use scores::{average_precision, calibration_error, case_scores, held_out_scores};

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::support::in_order;

/// Cases that were read.
#[derive(Debug, Clone, Default)]
pub struct Cases {
    /// The cases by data set, in the order of their names there.
    pub cases: Vec<Case>,
    /// What a person should know about how they were read, with the number of cases concerned.
    pub notes: BTreeMap<String, usize>,
}

/// Reads all cases in some folders, each a data set.
///
/// A case folder holds `fragments.swc` (or one other file of centerlines of that name) and the truth: `truth.json`, or
/// `links.csv`. Beside them may lie `inlets.csv`, the nodes where blood is known to enter, and `loops.csv`, links that SWC cannot hold.
///
/// # Errors
///
/// A folder without a case; a file that cannot be read or is wrong; a truth that does not fit its fragments.
pub fn read_cases(data_sets: &[PathBuf]) -> Result<Cases> {
    let mut found = Cases::default();
    let mut folders = Vec::new();
    for (at, data_set) in data_sets.iter().enumerate() {
        let short = last_name(data_set);
        let twice = data_sets.iter().enumerate().any(|(other, path)| other != at && last_name(path) == short);
        let name = if twice { data_set.display().to_string() } else { short };
        let (here, unanswered) = case_folders::find(data_set)?;
        if here.is_empty() {
            let accepted = "expected folders with fragments.swc and truth.json or links.csv in it";
            return Err(Error::parameter("CASES", format!("{}: no case", data_set.display()), accepted));
        }
        if unanswered > 0 {
            *found.notes.entry("fragments without an answer: left out".into()).or_default() += unanswered;
        }
        folders.extend(here.into_iter().map(|folder| (name.clone(), folder)));
    }
    for read in in_order(&folders, |_, (data_set, folder)| read_case::read(data_set, folder)) {
        let (case, notes) = read?;
        found.cases.push(case);
        for note in notes {
            *found.notes.entry(note).or_default() += 1;
        }
    }
    Ok(found)
}

/// The last name of a path, also of `.`.
fn last_name(path: &Path) -> String {
    let whole = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    whole.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}
