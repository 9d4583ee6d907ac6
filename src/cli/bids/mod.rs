//! `willis bids`: a BIDS app, from the masks of vessels in a dataset to a dataset of derivatives.

pub(super) mod dataset;
mod derivative;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Fault, Result};
use crate::internals::output::atomic::StagedFolder;
use crate::internals::output::names::{FAILURE, LEDGER, RECORD};
use crate::internals::output::{read_json, write_json};
use crate::internals::report::bids_table::bids_columns;
use crate::internals::report::cohort::{Row, infer_figures};
use clap::{Args, ValueEnum};
use serde_json::Value;

use super::cohort::{Cohort, Entry, Failure, Ledger, Work, gather, say_notes_of, work_on};
use super::command_line::command_line_of_mask;
use super::infer::{InferenceArgs, Inferences};
use super::print::{Terminal, plural};
use super::shell::print_json;
use super::signals::listen;
use super::subjects::Subject;
use super::with_flags;
use dataset::{Choice, Dataset, Filter, Mask, check_labels, labels, listed, parse_filter};
use derivative::Derivative;

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
    level: Level,
    /// Only these participants, with or without sub-
    #[arg(long, alias = "participant_label", value_name = "LABEL", num_args = 1.., value_delimiter = ',', help_heading = "Dataset")]
    participant_label: Vec<String>,
    /// Only these sessions, with or without ses-
    #[arg(long, alias = "session_label", value_name = "LABEL", num_args = 1.., value_delimiter = ',', help_heading = "Dataset")]
    session_label: Vec<String>,
    /// Only masks with this in their names: an entity (desc=vessels, run=1; space= is none), suffix=dseg, or pipeline=NAME of a folder
    /// in derivatives; with desc, label, seg or atlas the mask need not say vessels
    #[arg(long, value_name = "KEY=VALUE", value_delimiter = ',', value_parser = parse_filter, help_heading = "Dataset")]
    filter: Vec<Filter>,
    #[command(flatten)]
    inference: InferenceArgs,
}

/// A level of analysis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Level {
    /// A run for each mask
    Participant,
    /// The table of all runs
    Group,
}

impl BidsArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let derivative = Derivative::new(&self.output, &self.source)?;
        let dataset = Dataset::open(&self.source, &self.output)?;
        match self.level {
            Level::Participant => self.participants(&dataset, &derivative, terminal, force),
            Level::Group => self.group(&dataset, &derivative, terminal),
        }
    }

    /// A run for each mask that is chosen.
    fn participants(&self, dataset: &Dataset, derivative: &Derivative<'_>, terminal: Terminal, force: bool) -> Result<()> {
        let places = [self.source.display().to_string(), self.output.display().to_string(), "participant".to_owned()];
        let line = |input: &Path| command_line_of_mask(input, &places);
        let work = Inferences::new(&self.inference, &line)?;
        let parameters = work.of_many()?;
        let choice = Choice {
            participants: self.participant_label.clone(),
            sessions: self.session_label.clone(),
            filters: self.filter.clone(),
        };
        let (masks, without) = dataset.masks(&choice)?;
        let runs = Runs { masks: &masks, parameters, dataset, derivative, work: &work };
        let earlier: Vec<Option<Ledger>> = masks.iter().map(|mask| runs.earlier(mask)).collect();
        if !force {
            masks.iter().zip(&earlier).try_for_each(|(mask, earlier)| runs.check(mask, earlier.as_ref()))?;
        }
        derivative.describe(dataset, &self.source)?;
        listen(2);
        let people: BTreeSet<&str> = masks.iter().map(|mask| &*mask.participant).collect();
        let found =
            format!("{} of {}, in {}", plural(masks.len(), "mask"), plural(people.len(), "participant"), Dataset::places(&masks));
        terminal.say("found", found);
        if !without.is_empty() {
            terminal.say("note", format!("no mask of vessels of {}", listed(without.into_iter())));
        }
        runs.make(&earlier, terminal, force)?;
        runs.end(self.inference.json, terminal, &self.output)
    }

    /// The table and the page of all runs.
    fn group(&self, dataset: &Dataset, derivative: &Derivative<'_>, terminal: Terminal) -> Result<()> {
        let of_run = |name: &str| {
            let (participant, session) = name.split_once('_').map_or((name, None), |(a, b)| (a, Some(b)));
            (participant.to_owned(), session.map(str::to_owned))
        };
        let entries = fs::read_dir(derivative.runs()).into_iter().flatten().flatten().map(|entry| entry.path());
        let is_run = |path: &PathBuf| path.join(RECORD).is_file() || path.join(FAILURE).is_file();
        let mut folders: Vec<PathBuf> = entries.filter(is_run).collect();
        folders.sort();
        let name_of = |path: &Path| path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let known: Vec<(String, Option<String>)> = folders.iter().map(|path| of_run(&name_of(path))).collect();
        if folders.is_empty() {
            let accepted = "run the level participant first";
            return Err(Fault::file("no run of a participant", accepted).in_file(&self.output));
        }
        let people: BTreeSet<String> = known.iter().map(|(participant, _)| participant.clone()).collect();
        let sessions: BTreeSet<String> = known.iter().filter_map(|(_, session)| session.clone()).collect();
        let asked = (labels(&self.participant_label, "sub-"), labels(&self.session_label, "ses-"));
        check_labels("participant_label", &asked.0, &people)?;
        check_labels("session_label", &asked.1, &sessions)?;
        folders.retain(|path| {
            let (participant, session) = of_run(&name_of(path));
            let is_session = asked.1.is_empty() || session.is_some_and(|session| asked.1.contains(&session));
            (asked.0.is_empty() || asked.0.contains(&participant)) && is_session
        });
        let without: Vec<String> = dataset.participants().iter().filter(|name| !people.contains(*name)).cloned().collect();
        if !without.is_empty() {
            terminal.say("note", format!("no run of {}", listed(without.into_iter())));
        }

        let output = derivative.group();
        let cohort = Cohort { command: "bids", parameters: Value::Null, output: &output, force: true, json: self.inference.json };
        let named = |inputs: Vec<PathBuf>| {
            let subject = |(path, input): (&PathBuf, PathBuf)| Subject::new(name_of(path), input);
            folders.iter().zip(inputs).map(subject).collect()
        };
        let mut rows = gather(&folders, &cohort, named, terminal)?;
        derivative.describe(dataset, &self.source)?;
        for row in &mut rows {
            row.input = dataset.place_of(Path::new(&row.input));
        }
        let names: Vec<(String, Option<String>)> = rows.iter().map(|row| of_run(&row.subject)).collect();
        let table = derivative.write_table(&bids_columns(&rows, &names))?;
        terminal.say("written", table.display().to_string());
        Ok(())
    }
}

/// The runs of many masks.
struct Runs<'a> {
    masks: &'a [Mask],
    /// Every option that changes a result.
    parameters: Value,
    dataset: &'a Dataset,
    derivative: &'a Derivative<'a>,
    work: &'a Inferences<'a>,
}

impl Runs<'_> {
    fn subject(mask: &Mask) -> Subject {
        Subject::new(mask.run(), mask.path.clone())
    }

    fn folder(&self, mask: &Mask) -> PathBuf {
        self.derivative.runs().join(mask.run())
    }

    /// With what a run is made.
    fn ledger(&self, mask: &Mask) -> Ledger {
        let subject = Self::subject(mask);
        let entry = Entry::of(&subject, self.work.files(&subject));
        // The same by whatever way the dataset is named.
        Ledger::new("bids", &self.parameters, vec![entry.renamed(|path| self.dataset.place_of(path))])
    }

    /// With what the run that stands was made.
    fn earlier(&self, mask: &Mask) -> Option<Ledger> {
        read_json(&self.folder(mask).join(LEDGER), "").ok()
    }

    /// The record of the run that stands.
    fn record(&self, mask: &Mask) -> Option<Value> {
        read_json(&self.folder(mask).join(RECORD), "").ok()
    }

    /// Refuses a run that stands and was made with other parameters, or of another mask.
    fn check(&self, mask: &Mask, earlier: Option<&Ledger>) -> Result<()> {
        let Some(earlier) = earlier else { return Ok(()) };
        let ledger = self.ledger(mask);
        let found = match (ledger.other_parameters(earlier), ledger.other_input(earlier)) {
            (Some(which), _) => format!("holds a run made with other parameters ({which})"),
            (None, Some(input)) => format!("holds the run of another mask, {input}"),
            (None, None) => return Ok(()),
        };
        Err(Fault::file(found, "choose another OUT_DIR, or give --force to make it anew").in_file(&self.folder(mask)))
    }

    /// Makes the runs that do not stand, and gives an error where a person stopped it.
    fn make(&self, earlier: &[Option<Ledger>], terminal: Terminal, force: bool) -> Result<()> {
        let is_done = |(mask, earlier): (&Mask, &Option<Ledger>)| {
            let stands = earlier.as_ref().zip(self.record(mask));
            !force && stands.is_some_and(|(earlier, record)| self.ledger(mask).stands(0, earlier, &record))
        };
        let done: Vec<bool> = self.masks.iter().zip(earlier).map(is_done).collect();
        let skipped = done.iter().filter(|done| **done).count();
        if skipped > 0 {
            terminal.say("dataset", format!("{skipped} of {} done already", plural(done.len(), "run")));
        }
        let unnamed = self.masks.iter().zip(&done).filter(|(mask, done)| **done && !self.derivative.has(mask));
        unnamed.into_iter().try_for_each(|(mask, _)| self.derivative.export(mask, self.dataset))?;
        let subjects: Vec<Subject> = self.masks.iter().map(Self::subject).collect();
        let make = |subject: &Subject| match self.masks.iter().find(|mask| mask.path == subject.input) {
            Some(mask) => self.one(mask, subject, terminal.of_many()),
            None => Ok(()),
        };
        let ended = work_on(&subjects, &done, make, terminal);
        if ended.len() + skipped < subjects.len() {
            let done = skipped + ended.iter().filter(|(_, failure)| failure.is_none()).count();
            return Err(Error::StoppedCohort { path: self.derivative.runs(), done, total: subjects.len() });
        }
        Ok(())
    }

    /// Makes one run; where the mask gives none, why is in its place.
    fn one(&self, mask: &Mask, subject: &Subject, terminal: Terminal) -> Result<()> {
        let target = self.folder(mask);
        // The files as they are before they are read.
        let ledger = self.ledger(mask);
        StagedFolder::check(&target, true)?;
        let folder = StagedFolder::new(&target, true)?;
        match self.work.write(subject, &folder, terminal) {
            Ok(()) => {
                write_json(&folder.path().join(LEDGER), &ledger)?;
                folder.commit()?;
                self.derivative.clear(mask)?;
                self.derivative.export(mask, self.dataset)
            }
            Err(error) if Failure::is_of_input(&error) => {
                drop(folder);
                let line = self.work.line_of(&mask.path);
                self.work.failure(&mask.path, line, with_flags(&error))?.write(&target, true)?;
                self.derivative.clear(mask)?;
                Err(error)
            }
            Err(error) => Err(error),
        }
    }

    /// Says what came out of the runs, and gives an error where some failed.
    fn end(&self, json: bool, terminal: Terminal, output: &Path) -> Result<()> {
        let records: Vec<Option<Value>> = self.masks.iter().map(|mask| self.record(mask)).collect();
        let made: Vec<Value> = records.iter().flatten().cloned().collect();
        say_notes_of(&made, terminal);
        for (mask, record) in self.masks.iter().zip(records).filter(|_| json) {
            let failure = || Failure::read(&self.folder(mask));
            let sha256 = match &record {
                Some(record) => record["input"]["sha256"].as_str().map(str::to_owned),
                None => failure().ok().and_then(|failure| failure.input.sha256),
            };
            let why = || failure().map_or_else(|error| with_flags(&error), |failure| failure.error);
            let (figures, sha256) = (record.as_ref().map(infer_figures).ok_or_else(why), sha256.unwrap_or_default());
            let row = Row { subject: mask.run(), input: mask.path.display().to_string(), sha256, page: None, figures };
            print_json(&row.record())?;
        }
        terminal.say("written", format!("{}: {}", output.display(), plural(made.len(), "run")));
        match self.masks.len() - made.len() {
            0 => Ok(()),
            failed => Err(Error::Subjects { failed, total: self.masks.len() }),
        }
    }
}
