//! `willis bids`: a BIDS app, from the masks of vessels in a dataset to a dataset of derivatives.

pub(super) mod dataset;
mod derivative;

use std::{collections::BTreeSet, fs, path::Path, path::PathBuf};

use clap::{Args, ValueEnum};
use dataset::{Choice, Dataset, DatasetMask, MOST, check_labels};
use derivative::Derivative;
use serde_json::Value;

use super::cohort::{
    Cohort, Failure, Ledger, LedgerEntry, Work, check_files, failed, gather, make_each, say_notes_of, whole_record,
};
use super::command_line::{LinePart, infer_parts, parts_at_work, with_flags};
use super::print::{TextTerminal, listed, plural};
use super::{infer::InferenceArgs, infer::Inferences, shell::print_json, signals::listen, subjects::Subject};
use crate::internals::formats::{Covariates, is_there};
use crate::internals::output::names::{FAILURE, LEDGER, RECORD};
use crate::internals::output::{StagedFolder, read_json, write_json};
use crate::internals::report::cohort::{CohortRow, infer_figures, row_records};
use crate::internals::support::distinct;
use crate::{Result, error::Fault, internals::pipeline::require_in, internals::report::cohort::bids_columns};

/// Infer the topology of every mask of vessels in a BIDS dataset
///
/// A BIDS app. The level participant makes a run of willis infer for the mask of each session; what is done already is not done again,
/// and several commands may work on different participants at the same time. The level group makes the table of all runs, and its page.
///
/// Masks are sub-*/[ses-*/]anat/*_mask.nii.gz and *_dseg.nii.gz in BIDS_DIR and in BIDS_DIR/derivatives/* whose desc, label, seg or
/// atlas says vessels (a word with vessel, arter, vasc, lumen, angio or cow); where none says so, one that says nothing and has the
/// entities of an _angio image alone. Each session must have one.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  willis bids study study/derivatives/willis participant
  willis bids study study/derivatives/willis participant --participant-label 01 02
  willis bids study study/derivatives/willis group

--help lists every option.")]
pub struct BidsArgs {
    /// The dataset: its masks, or those in its derivatives
    #[arg(value_name = "BIDS_DIR", value_hint = clap::ValueHint::DirPath, help_heading = None::<&str>)]
    source: PathBuf,
    /// The dataset to write or to go on with, such as BIDS_DIR/derivatives/willis
    #[arg(value_name = "OUT_DIR", value_hint = clap::ValueHint::DirPath, help_heading = None::<&str>)]
    output: PathBuf,
    /// What to do
    // Not the id `level`, which is that of --level.
    #[arg(id = "of_analysis", value_name = "LEVEL", help_heading = None::<&str>)]
    level: AnalysisLevel,
    #[command(flatten)]
    choice: Choice,
    #[command(flatten)]
    inference: InferenceArgs,
}

/// A level of analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum AnalysisLevel {
    /// A run for each mask
    Participant,
    /// The table of all runs
    Group,
}

impl BidsArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        let derivative = Derivative::new(&self.output, &self.source)?;
        let dataset = Dataset::open(&self.source, &self.output)?;
        match self.level {
            AnalysisLevel::Participant => self.participants(&dataset, &derivative, terminal, force),
            AnalysisLevel::Group => self.group(&dataset, &derivative, terminal),
        }
    }

    /// A run for each mask that is chosen.
    fn participants(self, dataset: &Dataset, derivative: &Derivative, terminal: TextTerminal, force: bool) -> Result<()> {
        let json = self.inference.json;
        let work = Inferences::new(self.inference)?;
        let parameters = work.of_many()?;
        let (masks, without) = dataset.masks(&self.choice)?;
        let given = parts_at_work();
        let runs: Vec<MaskRun> = masks.iter().map(|mask| MaskRun::of(mask, &given, &work, &parameters, dataset)).collect();
        let earlier: Vec<Option<_>> = runs.iter().map(|run| read_json(&derivative.run(run.mask).join(LEDGER), "").ok()).collect();
        if !force {
            runs.iter().zip(&earlier).try_for_each(|(run, earlier)| run.check(earlier.as_ref(), &derivative.run(run.mask)))?;
        }
        derivative.describe(dataset, &self.source)?;
        listen(2);
        let people: BTreeSet<&str> = masks.iter().map(|mask| &*mask.participant).collect();
        let (count, whose) = (plural(masks.len(), "mask"), plural(people.len(), "participant"));
        terminal.say("found", format!("{count} of {whose}, in {}", Dataset::places(&masks)));
        if !without.is_empty() {
            terminal.say("note", format!("no mask of vessels of {}", listed(without.into_iter(), MOST)));
        }
        let record = |run: &MaskRun<'_>| whole_record::<Inferences>(&derivative.run(run.mask));
        let is_done = |(run, earlier): (&MaskRun<'_>, &Option<Ledger>)| {
            let stands = earlier.as_ref().zip(record(run));
            !force && stands.is_some_and(|(earlier, record)| run.ledger.stands(0, earlier, &record))
        };
        let done: Vec<bool> = runs.iter().zip(&earlier).map(is_done).collect();
        let subjects: Vec<Subject> = runs.iter().map(|run| run.subject.clone()).collect();
        let unnamed = masks.iter().zip(&done).filter(|(mask, done)| **done && !derivative.has(mask));
        unnamed.into_iter().try_for_each(|(mask, _)| derivative.export(mask, dataset))?;
        let make = |at: usize| runs[at].make(&work, derivative, dataset, terminal.of_many());
        let ended = make_each(&subjects, &done, ["dataset", "run"], Some(&derivative.runs()), make, terminal)?;

        let records: Vec<Option<Value>> = runs.iter().map(record).collect();
        say_notes_of(records.iter().flatten(), terminal);
        if json {
            let rows = runs.iter().zip(&records).map(|(run, record)| run.row(record.as_ref(), derivative));
            row_records(&rows.collect::<Vec<CohortRow>>()).iter().try_for_each(print_json)?;
        }
        terminal.say("written", format!("{}: {}", self.output.display(), plural(records.iter().flatten().count(), "run")));
        // A run may stand, and its files under names of BIDS not.
        let is_lost =
            |(record, ended): &(&Option<Value>, &Option<Result<(), String>>)| record.is_none() || matches!(ended, Some(Err(_)));
        failed(records.iter().zip(&ended).filter(is_lost).count(), runs.len())
    }

    /// The table and the page of all runs.
    fn group(&self, dataset: &Dataset, derivative: &Derivative, terminal: TextTerminal) -> Result<()> {
        let of_run = |name: &str| {
            let (participant, session) = name.split_once('_').map_or((name, None), |(a, b)| (a, Some(b)));
            (participant.to_owned(), session.map(str::to_owned))
        };
        let entries = fs::read_dir(derivative.runs()).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_run = |path: &PathBuf| is_there(&path.join(RECORD)) || is_there(&path.join(FAILURE));
        let mut folders = distinct(entries.filter(is_run));
        let name_of = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let known: Vec<(String, Option<String>)> = folders.iter().map(|path| of_run(&name_of(path))).collect();
        require_in(&self.output, !folders.is_empty(), "no run of a participant", "run the level participant first")?;
        let people: BTreeSet<String> = known.iter().map(|(participant, _)| participant.clone()).collect();
        let sessions: BTreeSet<String> = known.iter().filter_map(|(_, session)| session.clone()).collect();
        let asked = self.choice.labels();
        check_labels("participant_label", &asked.0, &people)?;
        check_labels("session_label", &asked.1, &sessions)?;
        folders.retain(|path| {
            let (participant, session) = of_run(&name_of(path));
            let is_session = asked.1.is_empty() || session.is_some_and(|session| asked.1.contains(&session));
            (asked.0.is_empty() || asked.0.contains(&participant)) && is_session
        });
        let without: Vec<String> = dataset.participants.iter().filter(|name| !people.contains(*name)).cloned().collect();
        if !without.is_empty() {
            terminal.say("note", format!("no run of {}", listed(without.into_iter(), MOST)));
        }

        let output = derivative.folder.join("group");
        let cohort = Cohort { command: "bids", parameters: Value::Null, output: &output, force: true, json: self.inference.json };
        let named = |_: &[PathBuf]| folders.iter().map(|path| name_of(path)).collect();
        let participants = dataset.covariates()?;
        let covariates = |run: &str| {
            let known = participants.iter().find(|(name, _)| *name == of_run(run).0);
            known.map_or_else(Covariates::new, |(_, known)| known.clone())
        };
        let mut rows = gather(&folders, &cohort, named, covariates, terminal)?;
        derivative.describe(dataset, &self.source)?;
        derivative.keep(dataset, participants.iter().filter(|(name, _)| people.contains(name)))?;
        for row in &mut rows {
            row.input = dataset.place_of(Path::new(&row.input));
        }
        let names: Vec<(String, Option<String>)> = rows.iter().map(|row| of_run(&row.subject)).collect();
        let table = derivative.write_table(&bids_columns(&rows, &names))?;
        terminal.say("written", table.display().to_string());
        Ok(())
    }
}

/// The run of a mask.
struct MaskRun<'a> {
    mask: &'a DatasetMask,
    subject: Subject,
    /// With what it is made.
    ledger: Ledger,
}

impl<'a> MaskRun<'a> {
    fn of(mask: &'a DatasetMask, given: &[LinePart], work: &Inferences, parameters: &Value, dataset: &Dataset) -> Self {
        let parts = infer_parts(given.to_vec(), &mask.path);
        let subject = Subject { name: mask.run(), input: mask.path.clone(), parts, row: None };
        let entry = LedgerEntry::of(&subject, work.files(&mask.path));
        // The same by whatever way the dataset is named.
        let ledger = Ledger::new("bids", parameters, vec![entry.renamed(|path| dataset.place_of(path))]);
        Self { mask, subject, ledger }
    }

    /// Refuses a run that stands in a folder and was made with other parameters, or of another mask.
    fn check(&self, earlier: Option<&Ledger>, folder: &Path) -> Result<()> {
        let Some(earlier) = earlier else { return Ok(()) };
        let found = match (self.ledger.other_parameters(earlier), self.ledger.other_input(earlier)) {
            (Some(which), _) => format!("holds a run made with other parameters ({which})"),
            (None, Some(input)) => format!("holds the run of another mask, {input}"),
            (None, None) => return Ok(()),
        };
        Err(Fault::file(found, "choose another OUT_DIR, or give --force to make it anew").in_file(folder))
    }

    /// Makes it; where the mask gives none, why is in its place.
    fn make(&self, work: &Inferences, derivative: &Derivative, dataset: &Dataset, terminal: TextTerminal) -> Result<()> {
        let (mask, target) = (self.mask, derivative.run(self.mask));
        StagedFolder::check(&target, true)?;
        let folder = StagedFolder::new(&target, true)?;
        let checked = check_files(&self.subject, work.files(&mask.path));
        match checked.and_then(|()| Work::write(work, &self.subject, &folder, terminal)) {
            Ok(()) => {
                write_json(&folder.path().join(LEDGER), &self.ledger)?;
                folder.commit()?;
                derivative.clear(mask)?;
                derivative.export(mask, dataset)
            }
            Err(error) if Failure::is_of_input(&error) => {
                drop(folder);
                work.failure(&mask.path, self.subject.line("again"), with_flags(&error))?.write(&target, true)?;
                derivative.clear(mask)?;
                Err(error)
            }
            Err(error) => Err(error),
        }
    }

    /// Its row, by its record or by why there is none.
    fn row(&self, record: Option<&Value>, derivative: &Derivative) -> CohortRow {
        let (figures, sha256) = match record {
            Some(record) => (Ok(infer_figures(record)), record["input"]["sha256"].as_str().map(str::to_owned)),
            None => match Failure::read(&derivative.run(self.mask)) {
                Ok(failure) => (Err(failure.error), failure.input.sha256),
                Err(error) => (Err(with_flags(&error)), None),
            },
        };
        let (subject, input) = (self.subject.name.clone(), self.mask.path.display().to_string());
        CohortRow { subject, input, sha256: sha256.unwrap_or_default(), covariates: Vec::new(), page: None, figures }
    }
}
