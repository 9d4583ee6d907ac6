//! A cohort: many subjects, one row and one folder each; made in one command, or of runs that were made separately (`willis merge`).

use std::{
    collections::BTreeMap, collections::BTreeSet, fs, path::Path, path::PathBuf, sync::Mutex, sync::PoisonError,
    sync::atomic::AtomicUsize, sync::atomic::Ordering, thread,
};

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::command_line::{command_line, is_option, with_flags};
use super::print::{TextTerminal, counted, plural, say_notes};
use super::subjects::{Subject, check_output, named, paths};
use super::{shell::print_json, signals::is_stopped, signals::listen};
use crate::internals::formats::{Covariates, checksum_of_file, companion_files, is_there, open_regular};
use crate::internals::output::names::{ACCURACY, COHORT, COHORT_PAGE, COHORT_TABLE, FAILURE, GRAPH, PAGE, RECORD, TOPOLOGY};
use crate::internals::output::{InProgress, StagedFiles, StagedFolder, read_json, relative, write_json};
use crate::internals::pipeline::{RunOptions, require_in};
use crate::internals::report::cohort::{CohortRow, Figures, infer_figures, row_records, write_cohort};
use crate::{Error, Result, error::Fault, internals::circle_of_willis::LANDMARK_NOTE_ENDING, internals::output::clear_leftovers};

/// The stack of a thread that works on subjects, as large as that of the first thread; in bytes.
const STACK: usize = 8 << 20;

/// What a command does with each subject.
pub trait Work: Sync + Sized {
    /// The figures of a subject in the table, from its run.json alone, so that one that was done before has the same.
    const FIGURES: fn(&Value) -> Figures;

    /// What other commands read in the folder of each subject: without it one is not done.
    const READ_AGAIN: &[&str];

    /// The same by the words of a command line; refuses options that do not go together.
    fn of(words: &[String]) -> Result<Self>;

    /// The files besides the input that go into it.
    fn files(&self, input: &Path) -> Vec<PathBuf>;

    /// Whether an option names this column of a manifest.
    fn names(&self, _column: &str) -> bool {
        false
    }

    /// Writes all files of a subject, run.json among them, into a folder.
    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: TextTerminal) -> Result<()>;
}

/// A cohort to be made, or resumed.
pub struct Cohort<'a> {
    /// The subcommand.
    pub command: &'static str,
    /// Every option that changes a result.
    pub parameters: Value,
    /// Its folder.
    pub output: &'a Path,
    /// Whether to start anew.
    pub force: bool,
    /// Whether to print the rows.
    pub json: bool,
}

/// cohort.json: with what a cohort was made, so that the same command can resume it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    /// The version.
    willis: String,
    /// The subcommand.
    command: String,
    /// What all subjects share: every option that changes a result.
    parameters: Value,
    /// The subjects in order.
    subjects: Vec<LedgerEntry>,
}

/// With what a subject was made.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LedgerEntry {
    /// The name of its folder.
    subject: String,
    /// Its input.
    input: String,
    /// The SHA-256 of all files that go into it; null for one that cannot be read.
    files: BTreeMap<String, Option<String>>,
    /// Its own options, of a manifest.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    options: Vec<String>,
}

impl LedgerEntry {
    /// The entry of a subject as the files are now: its input, those that are read beside it, and `others`.
    pub fn of(subject: &Subject, others: Vec<PathBuf>) -> Self {
        let input = file_of(subject);
        let topology = Some(subject.input.join(format!("{TOPOLOGY}.graphml"))).filter(|path| is_there(path));
        let mut files = BTreeMap::new();
        for path in std::iter::once(input.clone()).chain(topology).chain(companion_files(&input)).chain(others) {
            files.entry(path.display().to_string()).or_insert_with(|| checksum_of_file(&path).ok());
        }
        Self { subject: subject.name.clone(), input: input.display().to_string(), files, options: subject.own() }
    }

    /// The same with its files called otherwise.
    pub fn renamed(self, name: impl Fn(&Path) -> String) -> Self {
        let files = self.files.into_iter().map(|(path, sha256)| (name(Path::new(&path)), sha256)).collect();
        Self { input: name(Path::new(&self.input)), files, ..self }
    }

    /// The SHA-256 of the input, if it can be read.
    fn sha256(&self) -> Option<&str> {
        self.files.get(&self.input)?.as_deref()
    }
}

/// The file that is read of a subject.
fn file_of(subject: &Subject) -> PathBuf {
    if subject.input.is_dir() { subject.input.join(GRAPH) } else { subject.input.clone() }
}

/// Checks that every file of a subject is a regular one: each is read more than once, and most were found by a pattern.
///
/// # Errors
///
/// As [`open_regular`].
pub fn check_files(subject: &Subject, others: Vec<PathBuf>) -> Result<()> {
    let input = file_of(subject);
    // A folder without a graph is no run, which is said when it is read.
    if is_there(&input) || !subject.input.is_dir() {
        open_regular(&input)?;
    }
    companion_files(&input).into_iter().chain(others).try_for_each(|path| open_regular(&path).map(drop))
}

impl Ledger {
    pub fn new(command: &str, parameters: &Value, subjects: Vec<LedgerEntry>) -> Self {
        Self { willis: env!("CARGO_PKG_VERSION").into(), command: command.into(), parameters: parameters.clone(), subjects }
    }

    /// Writes it into the folder of a cohort, in place of an earlier one.
    fn write(&self, folder: &Path) -> Result<()> {
        let file = StagedFiles::new(&folder.join(COHORT), true)?;
        write_json(&file.path(), self)?;
        file.commit().map(drop)
    }

    /// Refuses to resume a cohort of other parameters, or one with a subject that is not among these.
    fn resumes(&self, earlier: &Self, folder: &Path) -> Result<()> {
        const MEND: &str = "choose another --output, or give --force to start anew";
        let refused = |why: String| Err(Error::parameter("output", folder.display(), format!("{why}; {MEND}")));
        if self.command != earlier.command {
            return refused(format!("holds a cohort of willis {}", earlier.command));
        }
        if let Some(which) = self.other_parameters(earlier) {
            return refused(format!("holds a cohort made with other parameters ({which})"));
        }
        let stays = |old: &&LedgerEntry| self.subjects.iter().any(|new| new.subject == old.subject && new.input == old.input);
        let lost = |old: &LedgerEntry| format!("holds subject {} of {}, which is not among these inputs", old.subject, old.input);
        earlier.subjects.iter().find(|old| !stays(old)).map(lost).map_or(Ok(()), refused)
    }

    /// The first option that was another in an earlier ledger of this version, in words.
    pub fn other_parameters(&self, earlier: &Self) -> Option<String> {
        let (option, [now, before]) =
            (self.willis == earlier.willis).then(|| differing(&self.parameters, &earlier.parameters)).flatten()?;
        Some(format!("{option} was {before}, now {now}"))
    }

    /// The first input of an earlier ledger that is none of these.
    pub fn other_input<'a>(&self, earlier: &'a Self) -> Option<&'a str> {
        let inputs = earlier.subjects.iter().map(|old| old.input.as_str());
        inputs.into_iter().find(|old| !self.subjects.iter().any(|new| new.input == *old))
    }

    /// Whether a subject stands as the files are now, with this record of its run; `earlier` is the ledger that was found.
    pub fn stands(&self, at: usize, earlier: &Self, record: &Value) -> bool {
        let entry = &self.subjects[at];
        let is_known = self.willis == earlier.willis && earlier.subjects.contains(entry);
        is_known && entry.sha256().is_some_and(|sha256| record["input"]["sha256"].as_str() == Some(sha256))
    }
}

/// The first option in which two sets of them differ, and in words what it is in the one and in the other.
fn differing(one: &Value, other: &Value) -> Option<(String, [String; 2])> {
    let names: BTreeSet<_> = [one, other].into_iter().filter_map(Value::as_object).flat_map(serde_json::Map::keys).collect();
    let name = names.into_iter().find(|name| one[*name] != other[*name])?;
    let said = |value: &Value| if value.is_null() { "not given".into() } else { value.to_string() };
    Some((name.replace('_', "-"), [said(&one[name]), said(&other[name])]))
}

impl Cohort<'_> {
    /// Does the work for every subject that is not done, then writes the table and the page.
    ///
    /// # Errors
    ///
    /// A folder that is not that of such a cohort, or cannot be written; subjects that failed, once all else is written; a stop.
    pub fn run<W: Work>(&self, subjects: &[Subject], work: &W, terminal: TextTerminal) -> Result<()> {
        if let Some(pattern) = ["{}", "{dir}"].iter().find(|pattern| self.output.to_string_lossy().contains(*pattern)) {
            let accepted = format!("{pattern} stands for an input in `landmarks`, `bc` and `loops`; expected one folder for all");
            return Err(Error::parameter("output", self.output.display(), accepted));
        }
        // What is done with a subject that has options of its own.
        let mut own = BTreeMap::new();
        for (at, subject) in subjects.iter().enumerate() {
            if let Some(words) = subject.own_words() {
                own.insert(at, W::of(&words).map_err(|error| subject.fault(error))?);
            }
        }
        let work_of = |at: usize| own.get(&at).unwrap_or(work);
        let columns = subjects.iter().take(1).flat_map(Subject::covariates).map(|(column, _)| &**column);
        let is_shared = |column: &str| {
            let plain = column.trim_start_matches('-').to_lowercase().replace('_', "-");
            is_option(&plain, Some(self.command))
        };
        let (shared, columns): (Vec<&str>, Vec<&str>) =
            columns.filter(|column| !work.names(column)).partition(|column| is_shared(column));
        let whole = "columns of the manifest go into cohort.csv and change nothing; options of the whole run are given on the command line";
        for (columns, says) in [(columns, "columns of the manifest that are no options go into cohort.csv"), (shared, whole)] {
            if !columns.is_empty() {
                terminal.say("note", format!("{says}: {}", columns.join(", ")));
            }
        }
        listen(2);
        let entry = |(at, subject): (usize, &Subject)| LedgerEntry::of(subject, work_of(at).files(&subject.input));
        let ledger = Ledger::new(self.command, &self.parameters, subjects.iter().enumerate().map(entry).collect());
        let earlier = self.earlier(subjects, &ledger)?;
        // Keeps a second command off while this one lives.
        let _lock = InProgress::new(self.output)?;
        clear_leftovers(self.output)?;
        let record_of = |at: usize| whole_record::<W>(&self.output.join(&subjects[at].name));
        let is_done = |at: usize| record_of(at).is_some_and(|record| ledger.stands(at, &earlier, &record));
        let done: Vec<bool> = (0..subjects.len()).map(is_done).collect();
        self.clear(subjects, &done)?;
        ledger.write(self.output)?;
        let make = |at: usize| self.subject(&subjects[at], work_of(at), terminal.of_many());
        let made = make_each(subjects, &done, ["cohort", "subject"], Some(self.output), make, terminal)?;
        let records: Vec<Option<Value>> = (0..subjects.len()).map(record_of).collect();
        let row = |at: usize| {
            let (entry, name) = (&ledger.subjects[at], &subjects[at].name);
            let failure = made[at].clone().and_then(Result::err);
            let record = || records[at].as_ref().ok_or_else(|| format!("{name}: run.json is not there any more"));
            let page = (!self.output.join(name).join(PAGE).is_file()).then(|| format!("{name}/{RECORD}"));
            let figures = failure.map_or_else(|| record().map(W::FIGURES), Err);
            let (input, sha256) = (entry.input.clone(), entry.sha256().unwrap_or_default().to_owned());
            CohortRow { subject: name.clone(), input, sha256, covariates: subjects[at].covariates().to_vec(), page, figures }
        };
        let rows: Vec<CohortRow> = (0..subjects.len()).map(row).collect();
        say_notes_of(records.iter().flatten(), terminal);
        self.write_table(self.output, &rows)?;
        terminal.say("written", format!("{}: {}", self.output.display(), plural(subjects.len(), "subject")));
        failed(rows.iter().filter(|row| row.figures.is_err()).count(), rows.len())
    }

    /// Writes the table and the page into a folder, and prints the rows where that is asked for.
    fn write_table(&self, folder: &Path, rows: &[CohortRow]) -> Result<()> {
        // A BIDS app has its output among its words.
        let line = command_line(if self.command == "bids" { "" } else { "again" });
        write_cohort(folder, rows, self.command, &line, &self.parameters)?;
        if self.json { row_records(rows).iter().try_for_each(print_json) } else { Ok(()) }
    }

    /// The ledger of the cohort to resume; the new one, without a subject, where the folder is made anew.
    fn earlier(&self, subjects: &[Subject], ledger: &Ledger) -> Result<Ledger> {
        if self.output.exists() && !self.force {
            let earlier: Result<Ledger> = read_json(&self.output.join(COHORT), "");
            let Ok(earlier) = earlier else { return Err(Error::Exists { path: self.output.to_owned() }) };
            ledger.resumes(&earlier, self.output)?;
            return Ok(earlier);
        }
        let files = ledger.subjects.iter().flat_map(|entry| entry.files.keys()).map(Path::new);
        check_output(self.output, self.force, files.chain(subjects.iter().map(|subject| &*subject.input)))?;
        let empty = Ledger { subjects: Vec::new(), ..ledger.clone() };
        StagedFolder::fill(self.output, self.force, |folder| empty.write(&folder.path()))?;
        Ok(empty)
    }

    /// Takes away what will be made again, so that nothing of an earlier state is taken for the new one.
    fn clear(&self, subjects: &[Subject], done: &[bool]) -> Result<()> {
        let folders = subjects.iter().zip(done).filter(|(_, done)| !**done).map(|(s, _)| self.output.join(&s.name));
        let stale: Vec<PathBuf> = folders.filter(|folder| folder.exists()).collect();
        stale.iter().try_for_each(|folder| StagedFolder::check(folder, true))?;
        stale.iter().try_for_each(|folder| StagedFolder::remove(folder))?;
        // What is compared with the truth follows the manifest too, which may have changed.
        let tables = if done.iter().all(|done| *done) { &[ACCURACY][..] } else { &[COHORT_TABLE, COHORT_PAGE, ACCURACY] };
        for path in tables.iter().map(|name| self.output.join(name)).filter(|path| path.exists()) {
            fs::remove_file(&path).map_err(|source| Error::Write { path, source })?;
        }
        Ok(())
    }

    fn subject(&self, subject: &Subject, work: &impl Work, terminal: TextTerminal) -> Result<()> {
        terminal.say("subject", &subject.name);
        check_files(subject, work.files(&subject.input))?;
        StagedFolder::fill(&self.output.join(&subject.name), false, |folder| work.write(subject, folder, terminal))
    }
}

/// The record of a subject in its folder, where all is there that other commands read.
pub fn whole_record<W: Work>(folder: &Path) -> Option<Value> {
    let is_whole = W::READ_AGAIN.iter().all(|file| folder.join(file).is_file());
    is_whole.then(|| read_json(&folder.join(RECORD), "").ok())?
}

/// Works on the subjects that are not `done`, several at a time, and says how each went; of each that was not done what was made, or why it
/// failed. They are called `noun`, and `heading` together, which is kept in `place`, where it is.
///
/// # Errors
///
/// A stop.
pub fn make_each<T: Send>(
    subjects: &[Subject],
    done: &[bool],
    [heading, noun]: [&str; 2],
    place: Option<&Path>,
    make: impl Fn(usize) -> Result<T> + Sync,
    terminal: TextTerminal,
) -> Result<Vec<Option<Result<T, String>>>> {
    let total = subjects.len();
    let open: Vec<usize> = (0..total).filter(|at| !done[*at]).collect();
    let skipped = total - open.len();
    if skipped > 0 {
        terminal.say(heading, format!("{skipped} of {} done already", plural(total, noun)));
    }
    let (next, ended) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let worker = || {
        while !is_stopped()
            && let Some(at) = open.get(next.fetch_add(1, Ordering::Relaxed)).copied()
        {
            let made = make(at);
            if matches!(made, Err(Error::Stopped { .. } | Error::StoppedAndKept { .. })) {
                return;
            }
            let made = made.map_err(|error| with_flags(&error));
            let mut ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
            let place = format!("{}/{total} {}", skipped + ended.len() + 1, subjects[at].name);
            match &made {
                Ok(_) => terminal.say("done", place),
                Err(error) => terminal.say("failed", format!("{place}: {error}")),
            }
            ended.push((at, made));
        }
    };
    // What is said of a subject stays together when one is done after the other.
    let threads = if terminal.verbose { 1 } else { rayon::current_num_threads().min(open.len()) };
    thread::scope(|scope| {
        for _ in 1..threads {
            // Without another thread this one does it all.
            let _ = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, worker);
        }
        worker();
    });
    let ended = ended.into_inner().unwrap_or_else(PoisonError::into_inner);
    if ended.len() < open.len() {
        let done = skipped + ended.iter().filter(|(_, made)| made.is_ok()).count();
        return Err(Error::StoppedCohort { path: place.map(Path::to_owned), done, total });
    }
    let mut all: Vec<_> = (0..total).map(|_| None).collect();
    for (at, made) in ended {
        all[at] = Some(made);
    }
    Ok(all)
}

/// An error where some subjects failed.
pub fn failed(failed: usize, total: usize) -> Result<()> {
    if failed == 0 { Ok(()) } else { Err(Error::Subjects { failed, total }) }
}

/// Says the notes of many runs, those that are alike once.
pub fn say_notes_of<'a>(records: impl IntoIterator<Item = &'a Value>, terminal: TextTerminal) {
    let notes = records.into_iter().filter_map(|record| record["notes"].as_array()).flatten().filter_map(Value::as_str);
    // Where the landmarks of each lie is said nowhere but there.
    say_notes(terminal, &counted(notes.filter(|note| !note.ends_with(LANDMARK_NOTE_ENDING))), "subject");
}

/// failed.json: why an input gave no run, in the place of its run, for `willis merge` to make a row of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Failure {
    /// The version.
    pub willis: String,
    /// The command of the run.
    pub command: String,
    pub input: FailedInput,
    pub options: RunOptions,
    /// The one line that says why.
    pub error: String,
}

/// The file that was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailedInput {
    pub path: String,
    /// None where it cannot be read.
    pub sha256: Option<String>,
}

impl Failure {
    /// Whether an error is one of the input, which comes again, and not of the machine.
    pub fn is_of_input(error: &Error) -> bool {
        error.is_usage() || matches!(error, Error::Breakdown)
    }

    /// The failure in a folder.
    ///
    /// # Errors
    ///
    /// A file that is none.
    pub fn read(folder: &Path) -> Result<Self> {
        read_json(&folder.join(FAILURE), "expected it as willis infer --record-failure wrote it")
    }

    /// Writes its folder.
    pub fn write(&self, output: &Path, force: bool) -> Result<()> {
        StagedFolder::fill(output, force, |folder| write_json(&folder.path().join(FAILURE), self))
    }
}

/// Options that each subject has its own of, since its scanner chose them.
const OF_SUBJECT: [&str; 1] = ["spacing_mm"];

/// A run that was made separately, or why there is none.
struct SeparateRun<'a> {
    folder: &'a Path,
    input: FailedInput,
    /// Every option that changes a result.
    parameters: Value,
    /// Its run.json, or the error.
    record: Result<Value, String>,
}

/// Writes the cohort of the runs, or failures, in these folders, and gives its rows. `cohort` has no parameters yet; `name` gives the
/// inputs their names, and `covariates` says what else is known of a name.
///
/// # Errors
///
/// A folder that holds none; runs of other options, seed or version than the first; two of one input; a folder that cannot be written.
pub fn gather(
    folders: &[PathBuf],
    cohort: &Cohort<'_>,
    name: impl FnOnce(&[PathBuf]) -> Vec<String>,
    covariates: impl Fn(&str) -> Covariates,
    terminal: TextTerminal,
) -> Result<Vec<CohortRow>> {
    let output = cohort.output;
    let runs = folders.iter().map(|folder| SeparateRun::read(folder)).collect::<Result<Vec<_>>>()?;
    let Some(first) = runs.iter().find(|run| run.record.is_ok()).or(runs.first()) else { return Ok(Vec::new()) };
    runs.iter().enumerate().try_for_each(|(at, run)| run.check(first, &runs[..at]))?;
    let names = name(&runs.iter().map(|run| PathBuf::from(&run.input.path)).collect::<Vec<_>>());
    let row = |(run, name): (&SeparateRun<'_>, &String)| {
        let (input, sha256) = (run.input.path.clone(), run.input.sha256.clone().unwrap_or_default());
        let page = run.record.is_ok().then(|| run.page(output)).flatten();
        let figures = run.record.as_ref().map(infer_figures).map_err(String::clone);
        CohortRow { subject: name.clone(), input, sha256, covariates: covariates(name), page, figures }
    };
    let rows: Vec<CohortRow> = runs.iter().zip(&names).map(row).collect();
    let entries = runs.iter().zip(&names).map(|(run, name)| {
        let FailedInput { path, sha256 } = run.input.clone();
        LedgerEntry { subject: name.clone(), input: path.clone(), files: [(path, sha256)].into(), options: Vec::new() }
    });
    let mut parameters = first.parameters.clone();
    if let Some(option) = OF_SUBJECT.iter().find(|option| runs.iter().any(|run| run.parameters[*option] != parameters[*option])) {
        parameters[*option] = "of each subject".into();
    }
    let cohort = Cohort { parameters, ..*cohort };
    check_output(output, cohort.force, folders.iter().map(|folder| &**folder))?;
    let ledger = Ledger::new(cohort.command, &cohort.parameters, entries.collect());
    StagedFolder::fill(output, cohort.force, |folder| {
        ledger.write(&folder.path())?;
        cohort.write_table(&folder.path(), &rows)
    })?;
    for row in &rows {
        if let Err(error) = &row.figures {
            terminal.say("failed", format!("{}: {error}", row.subject));
        }
    }
    let failed = rows.iter().filter(|row| row.figures.is_err()).count();
    terminal.say("written", format!("{}: {}, {failed} failed", output.display(), plural(rows.len(), "subject")));
    Ok(rows)
}

impl<'a> SeparateRun<'a> {
    fn read(folder: &'a Path) -> Result<Self> {
        const RUN: &str = "expected the folder of a run of willis infer for one occlusion probability";
        let (version, input, options, prior, record) = if is_there(&folder.join(FAILURE)) {
            let Failure { willis, input, options, error, .. } = Failure::read(folder)?;
            (willis, input, json!(options), Value::Null, Err(error))
        } else {
            let found = if folder.is_dir() { "a folder without run.json" } else { "a file" };
            require_in(folder, !folder.exists() || is_there(&folder.join(RECORD)), found, RUN)?;
            let record: Value = read_json(&folder.join(RECORD), RUN)?;
            let text = |value: &Value| value.as_str().map(str::to_owned);
            let (path, sha256) = (text(&record["input"]["path"]).unwrap_or_default(), text(&record["input"]["sha256"]));
            let input = FailedInput { path, sha256 };
            let (options, prior) = (record["options"].clone(), record["parameters"]["prior"].clone());
            (text(&record["willis"]).unwrap_or_default(), input, options, prior, Ok(record))
        };
        let found = format!("was made by willis {version}, and this is {}", env!("CARGO_PKG_VERSION"));
        require_in(folder, version == env!("CARGO_PKG_VERSION"), found, "expected a run of this version")?;
        let command = record.as_ref().map_or("", |record| record["command"].as_str().unwrap_or_default());
        let other = |_| Fault::file(format!("was made by {command}"), RUN).in_file(folder);
        let options: RunOptions = serde_json::from_value(options).map_err(other)?;
        Ok(Self { folder, input, parameters: options.comparable(&prior), record })
    }

    /// Refuses a run of other options than the `first`, or of an input that one of those `before` has.
    fn check(&self, first: &Self, before: &[Self]) -> Result<()> {
        let refused = |found: String, expected: &str| Err(Fault::file(found, expected).in_file(self.folder));
        let (mut here, mut there) = (self.parameters.clone(), first.parameters.clone());
        // A run that failed knows neither the content of a file of priors nor a spacing that nothing states, with its unit.
        let unknown = if self.record.is_err() == first.record.is_err() { &[][..] } else { &["prior", "unit"] };
        for option in OF_SUBJECT.iter().chain(unknown).copied() {
            (here[option], there[option]) = (Value::Null, Value::Null);
        }
        if let Some((option, [here, there])) = differing(&here, &there) {
            let found = format!("has {option} {here}, where {} has {there}", first.folder.display());
            return refused(found, "expected runs with the same options");
        }
        let is_same = |other: &&Self| self.input.sha256.is_some() && self.input == other.input;
        match before.iter().find(is_same) {
            Some(other) => {
                let found = format!("is of {}, as {} is", self.input.path, other.folder.display());
                refused(found, "expected one run of each input")
            }
            None => Ok(()),
        }
    }

    /// Its page, or its record where the graph is too large for one, seen from the folder of the cohort; `None` where no path leads
    /// there.
    fn page(&self, cohort: &Path) -> Option<String> {
        let page = Some(self.folder.join(PAGE)).filter(|page| page.is_file());
        relative(&page.unwrap_or_else(|| self.folder.join(RECORD)), cohort)
    }
}

/// Make a cohort of runs of many subjects that were made separately
///
/// Runs are the folders of willis infer: they make cohort.csv and cohort.html, with the rows that willis infer writes for all inputs
/// in one command, and links to the reports where they are. They must have the same options and seed. A folder that
/// willis infer --record-failure wrote is a row that failed. The inputs need not be there.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  willis merge 'runs/*' -o merged")]
pub struct MergeArgs {
    /// The folders of the runs; a pattern in quotes ('runs/*') is all that fit it
    #[arg(value_name = "FOLDER", required = true, value_hint = clap::ValueHint::DirPath)]
    folders: Vec<PathBuf>,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Print the row of each subject on standard output too, in JSON
    #[arg(long)]
    json: bool,
}

impl MergeArgs {
    pub fn run(self, terminal: TextTerminal, force: bool) -> Result<()> {
        StagedFolder::check(&self.output, force)?;
        let is_run = |path: &Path| is_there(&path.join(RECORD)) || is_there(&path.join(FAILURE));
        let folders = paths(&self.folders, "folder of a run", is_run)?;
        let cohort = Cohort { command: "merge", parameters: Value::Null, output: &self.output, force, json: self.json };
        gather(&folders, &cohort, named, |_| Vec::new(), terminal).map(drop)
    }
}
