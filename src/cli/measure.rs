//! `willis measure`: lengths, widths, bends, angles and orders of vessels, and of whole networks, as tables.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::error::{Error, Result};
use crate::internals::formats::{Column, checksum_of_file, write_csv, write_stacked};
use crate::internals::network::units::millimetres;
use crate::internals::output::atomic::StagedFolder;
use crate::internals::output::names::{BIFURCATIONS, ENDS, INTERVALS, SUBJECTS, VESSELS};
use crate::internals::output::write_file;
use crate::internals::output::write_record;
use crate::internals::report::cohort::{CohortRow, cohort_columns};
use crate::{BoundaryOptions, MeasureOptions, Measurement, measure};
use clap::Args;
use serde_json::{Value, json};

use super::args::boundary_for;
use super::args::figures::length;
use super::args::reading::RunsArgs;
use super::checkpoint::Follower;
use super::cohort::{Each, failed};
use super::command_line::command_line;
use super::print::{TextTerminal, plural};
use super::shell::print_json;
use super::signals::listen;
use super::subjects::{Inputs, Subject, expand, name_of};

/// Measure vessels: lengths, radii, bends, bifurcations, orders, and whole networks
///
/// Tables with a row for each vessel, bifurcation, end and subject, units in their names. Of the folder of willis infer the plausible topology is
/// measured, and the figures of a whole network have their mean and 95 % interval over the topologies that are plausible.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  willis measure circle.graphml -o measured
  willis measure 'cohort/*' -o measured")]
pub struct MeasureArgs {
    #[command(flatten)]
    runs: RunsArgs,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Over which length the course of a vessel is smoothed before its bends are measured, in mm unless it says otherwise [default: six
    /// of its radii]
    #[arg(long, value_name = "LENGTH", value_parser = length("smoothing"), hide_short_help = true)]
    smoothing: Option<f64>,
    /// Print the row of each subject on standard output too, as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    boundary: BoundaryOptions,
}

impl MeasureArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        self.runs.reading.refuse_candidates("measure")?;
        self.runs.reading.shared()?;
        StagedFolder::check(&self.output, force)?;
        let subjects = match expand(&self.runs.inputs, true)? {
            Inputs::Many(subjects) => subjects,
            Inputs::One(input) => {
                vec![Subject { name: name_of(&input), input, line: command_line("again"), row: None }]
            }
        };
        if let Some(subject) = subjects.iter().find(|subject| !subject.own().is_empty()) {
            let own = subject.own().join(" ");
            return Err(subject.fault(Error::parameter("manifest", own, "measure takes no options from a manifest")));
        }
        let measured = Mutex::new((0..subjects.len()).map(|_| None).collect::<Vec<Option<Measurement>>>());
        let one = |at: usize, terminal: TextTerminal| -> Result<()> {
            let found = self.measure(&subjects[at], terminal)?;
            measured.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(found);
            Ok(())
        };
        let failures = if let [_] = &*subjects {
            one(0, terminal)?;
            vec![None]
        } else {
            listen(2);
            let done = vec![false; subjects.len()];
            let each = Each { subjects: &subjects, done: &done, heading: "measured", noun: "subject", place: &self.output };
            each.make(|at| one(at, terminal.of_many()), terminal)?
        };
        let measured = measured.into_inner().unwrap_or_else(PoisonError::into_inner);
        let rows: Vec<CohortRow> =
            (0..subjects.len()).map(|at| row_of(&subjects[at], measured[at].as_ref(), failures[at].clone())).collect();
        self.write(&rows, measured.iter().flatten(), force)?;
        if self.json {
            rows.iter().try_for_each(|row| print_json(&row.record()))?;
        }
        terminal.say("written", format!("{}: {}", self.output.display(), plural(rows.len(), "subject")));
        failed(rows.iter().filter(|row| row.figures.is_err()).count(), rows.len())
    }

    fn measure(&self, subject: &Subject, terminal: TextTerminal) -> Result<Measurement> {
        let path = &subject.input;
        let input = self.runs.reading.read(path, subject.line.clone(), terminal)?;
        // Beside its plausible topology all that a run finds plausible.
        let run = path
            .is_dir()
            .then(|| self.runs.reading.read_run(path, subject.line.clone(), TextTerminal::new(true, false)))
            .transpose()?;
        let found = measure(&subject.name, &input, run.as_ref(), &self.options(path), &mut Follower::new(terminal))?;
        for note in &found.notes {
            terminal.say("note", note);
        }
        Ok(found)
    }

    fn options(&self, input: &Path) -> MeasureOptions {
        MeasureOptions { boundary: boundary_for(&self.boundary, input), smoothing: self.smoothing }
    }

    /// Writes the tables of all subjects, one below the other, and the record.
    fn write<'a>(&self, rows: &[CohortRow], measured: impl Iterator<Item = &'a Measurement>, force: bool) -> Result<()> {
        let tables: Vec<[Vec<Column>; 4]> = measured.map(Measurement::tables).collect();
        let folder = StagedFolder::new(&self.output, force)?;
        for (at, name) in [VESSELS, BIFURCATIONS, ENDS, INTERVALS].into_iter().enumerate() {
            let own: Vec<&[Column]> = tables.iter().map(|tables| &*tables[at]).collect();
            write_file(&folder.path().join(name), |out| write_stacked(out, &own))?;
        }
        write_file(&folder.path().join(SUBJECTS), |out| write_csv(out, &cohort_columns(rows)))?;
        write_record(&folder.path(), &self.record(rows))?;
        folder.commit()
    }

    fn record(&self, rows: &[CohortRow]) -> Value {
        json!({
            "willis": env!("CARGO_PKG_VERSION"),
            "command": command_line("again"),
            "parameters": { "smoothing_mm": self.smoothing.map(millimetres), "boundary": self.boundary },
            "subjects": rows.iter().map(CohortRow::record).collect::<Vec<Value>>(),
        })
    }
}

/// The row of a subject.
fn row_of(subject: &Subject, measured: Option<&Measurement>, failure: Option<String>) -> CohortRow {
    CohortRow {
        subject: subject.name.clone(),
        input: subject.input.display().to_string(),
        sha256: measured.map(|found| found.sha256.clone()).or_else(|| checksum_of_file(&subject.input).ok()).unwrap_or_default(),
        covariates: subject.row.as_ref().map_or_else(Vec::new, |row| row.covariates.clone()),
        page: None,
        figures: measured.map(Measurement::figures).ok_or_else(|| failure.unwrap_or_default()),
    }
}
