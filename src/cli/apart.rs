//! A cohort of runs that were made apart: their table and page, which opens the report of each where it is.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf, absolute};

use serde_json::{Value, json};
use willis::error::{Fault, Result};
use willis::internals::output::names::PAGE;
use willis::internals::output::{StagedFolder, read_json};
use willis::internals::report::cohort::{About, Row, infer_figures, write_cohort};

use super::failure::Failure;
use super::infer::InferArgs;
use super::ledger::{Entry, Ledger, differing};
use super::provenance::command_line;
use super::run::Run;
use super::shell::print_json;
use super::subjects::named;
use super::terminal::{Terminal, plural};

/// Options that name a file of the subject, which may differ from one to the next.
const OWN: [&str; 3] = ["bc", "landmarks", "loops"];

/// A run that was made apart, or why there is none.
struct Apart<'a> {
    folder: &'a Path,
    input: String,
    sha256: Option<String>,
    /// Every option that changes a result.
    parameters: Value,
    /// Its run.json, or the error.
    record: Result<Value, String>,
}

/// Writes the cohort of the runs, or failures, in these folders.
///
/// # Errors
///
/// A folder that holds none; runs of other options, seed or version than the first; two of one input; a folder that cannot be written.
pub fn gather(folders: &[PathBuf], output: &Path, force: bool, json: bool, terminal: Terminal) -> Result<()> {
    let runs = folders.iter().map(|folder| Apart::read(folder)).collect::<Result<Vec<_>>>()?;
    let Some(parameters) = shared(&runs)? else { return Ok(()) };
    let subjects = named(runs.iter().map(|run| PathBuf::from(&run.input)).collect());
    let folder = StagedFolder::new(output, force)?;
    let rows = runs.iter().zip(&subjects).map(|(run, subject)| Row {
        subject: subject.name.clone(),
        input: run.input.clone(),
        sha256: run.sha256.clone().unwrap_or_default(),
        page: run.record.is_ok().then(|| run.page(output)).flatten(),
        figures: run.record.as_ref().map(infer_figures).map_err(String::clone),
    });
    let rows: Vec<Row> = rows.collect();
    let entries = runs.iter().zip(&subjects).map(|(run, subject)| Entry {
        subject: subject.name.clone(),
        input: run.input.clone(),
        files: BTreeMap::from([(run.input.clone(), run.sha256.clone())]),
    });
    let ledger = Ledger {
        willis: env!("CARGO_PKG_VERSION").to_owned(),
        command: "merge".to_owned(),
        parameters: parameters.clone(),
        subjects: entries.collect(),
    };
    ledger.write(&folder.path())?;
    write_cohort(&folder.path(), &rows, &About { command: "merge", line: command_line(), parameters: &parameters })?;
    folder.commit()?;
    if json {
        rows.iter().try_for_each(|row| print_json(&row.record()))?;
    }
    for row in &rows {
        if let Err(error) = &row.figures {
            terminal.say("failed", format!("{}: {error}", row.subject));
        }
    }
    let failed = rows.iter().filter(|row| row.figures.is_err()).count();
    terminal.say("written", format!("{}: {}, {failed} failed", output.display(), plural(rows.len(), "subject")));
    Ok(())
}

/// The options of all runs, without those that name a file of the subject where these differ.
fn shared(runs: &[Apart<'_>]) -> Result<Option<Value>> {
    let Some(first) = runs.iter().find(|run| run.record.is_ok()).or(runs.first()) else { return Ok(None) };
    let mut shared = first.parameters.clone();
    for (at, run) in runs.iter().enumerate() {
        let refused = |found: String, expected: &str| Err(Fault::file(found, expected).in_file(run.folder));
        if let Some((option, [here, there])) = run.differs(first) {
            let found = format!("has {option} {here}, where {} has {there}", first.folder.display());
            return refused(found, "expected runs with the same options");
        }
        let is_same = |other: &&Apart<'_>| run.sha256.is_some() && (&run.input, &run.sha256) == (&other.input, &other.sha256);
        if let Some(other) = runs[..at].iter().find(is_same) {
            let found = format!("is of {}, as {} is", run.input, other.folder.display());
            return refused(found, "expected one run of each input");
        }
        for name in OWN.into_iter().filter(|name| run.parameters[name] != first.parameters[name]) {
            shared[name] = Value::Null;
        }
    }
    Ok(Some(shared))
}

impl<'a> Apart<'a> {
    fn read(folder: &'a Path) -> Result<Self> {
        let run = "expected the folder of a run of willis infer for one occlusion probability";
        let (version, command, input, record) = if Failure::stands_in(folder) {
            let Failure { willis, command, input, error, .. } = Failure::read(folder)?;
            (willis, command, json!({ "path": input.path, "sha256": input.sha256 }), Err(error))
        } else {
            let record: Value = read_json(&Run::record(folder), run)?;
            let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
            (text(&record["willis"]), text(&record["command"]), record["input"].clone(), Ok(record))
        };
        if version != env!("CARGO_PKG_VERSION") {
            let found = format!("was made by willis {version}, and this is {}", env!("CARGO_PKG_VERSION"));
            return Err(Fault::file(found, "expected a run of this version").in_file(folder));
        }
        let Some(mut parameters) = InferArgs::parameters_of(&command) else {
            return Err(Fault::file(format!("was made by {command}"), run).in_file(folder));
        };
        if let Ok(record) = &record {
            // Of several probabilities the folder is of one.
            parameters["epsilon"] = json!([record["parameters"]["epsilon"]]);
        }
        let text = |name: &str| input[name].as_str().map(str::to_owned);
        Ok(Self { folder, input: text("path").unwrap_or_default(), sha256: text("sha256"), parameters, record })
    }

    /// The first option that differs from that of another run, with what it is in either.
    fn differs(&self, other: &Self) -> Option<(String, [String; 2])> {
        let mut pair = [self.parameters.clone(), other.parameters.clone()];
        let mut stated = |name: &str, by: [Value; 2]| {
            if pair.iter().all(|parameters| !parameters[name].is_null()) {
                pair.iter_mut().zip(by).for_each(|(parameters, value)| parameters[name] = value);
            }
        };
        for name in OWN {
            stated(name, [Value::Null, Value::Null]);
        }
        // A file of priors is known by its content, not by its name; a run that failed does not tell it.
        let prior = |run: &Self| run.record.as_ref().map_or(Value::Null, |r| r["parameters"]["prior"]["sha256"].clone());
        match [prior(self), prior(other)] {
            [_, Value::Null] => {}
            [Value::Null, _] if self.record.is_ok() => {}
            [Value::Null, _] => stated("prior", [Value::Null, Value::Null]),
            both => stated("prior", both),
        }
        differing(&pair[0], &pair[1])
    }

    /// Its page, or its record where the graph is too large for one, seen from the folder of the cohort; `None` where no path leads
    /// there.
    fn page(&self, cohort: &Path) -> Option<String> {
        let page = Some(self.folder.join(PAGE)).filter(|page| page.is_file());
        relative(&page.unwrap_or_else(|| Run::record(self.folder)), cohort)
    }
}

/// The way from a folder to a file, with `/` between its steps.
fn relative(file: &Path, folder: &Path) -> Option<String> {
    let (file, folder) = (plain(file)?, plain(folder)?);
    let shared = file.iter().zip(&folder).take_while(|(a, b)| a == b).count();
    // On another drive there is no way.
    let steps = if shared == 0 { None } else { Some(folder.len() - shared) };
    let up = std::iter::repeat_n("..".to_owned(), steps?);
    Some(up.chain(file[shared..].iter().cloned()).collect::<Vec<_>>().join("/"))
}

/// The steps to a path from the root, none of which leads back.
fn plain(path: &Path) -> Option<Vec<String>> {
    let mut steps: Vec<String> = Vec::new();
    for step in absolute(path).ok()?.components() {
        match step {
            Component::ParentDir => drop(steps.pop()),
            Component::CurDir => {}
            step => steps.push(step.as_os_str().to_str()?.to_owned()),
        }
    }
    Some(steps)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_way_leads_from_folder_to_file() {
        let way = |file: &str, folder: &str| relative(Path::new(file), Path::new(folder)).expect("a way");
        assert_eq!(way("/a/runs/x/r.html", "/a/cohort"), "../runs/x/r.html");
        assert_eq!(way("runs/x/r.html", "./out/../cohort"), "../runs/x/r.html");
        assert_eq!(way("cohort/x/r.html", "cohort"), "x/r.html");
        assert_eq!(way("/b/r.html", "/a/c/d"), "../../../b/r.html");
    }
}
