//! Many inputs in one command: a folder for each subject, a table and a page of all; what is done already is not done again.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use serde_json::Value;
use willis::error::{Error, Result};
use willis::internals::circle_of_willis::LANDMARK_NOTE_ENDING;
use willis::internals::output::Making;
use willis::internals::output::StagedFolder;
use willis::internals::output::atomic::sweep_own;
use willis::internals::output::names::{COHORT_PAGE, COHORT_TABLE, RECORD};
use willis::internals::output::read_json;
use willis::internals::report::cohort::{About, Figures, Row, write_cohort};

use super::ledger::{Entry, Ledger};
use super::provenance::command_line;
use super::shell::print_json;
use super::subjects::Subject;
use super::tell_notes::{counted, say_notes};
use super::terminal::{Terminal, is_stopped, listen, plural};

/// The stack of a thread that works on subjects, as large as that of the first thread; in bytes.
const STACK: usize = 8 << 20;

/// What a command does with each subject.
pub trait Work: Sync {
    /// The files besides the input that go into a subject.
    fn files(&self, input: &Path) -> Vec<PathBuf>;

    /// Writes all files of a subject, run.json among them, into a folder.
    fn write(&self, subject: &Subject, folder: &StagedFolder, terminal: Terminal) -> Result<()>;

    /// The figures of its row, from run.json alone, so that a subject that was done before has the same.
    fn figures(&self, record: &Value) -> Figures;
}

/// A cohort to be made, or to go on with.
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

impl Cohort<'_> {
    /// Does the work for every subject that is not done, then writes the table and the page.
    ///
    /// # Errors
    ///
    /// A folder that is not that of such a cohort, or cannot be written; subjects that failed, once all else is written; a stop.
    pub fn run(&self, subjects: &[Subject], work: &impl Work, terminal: Terminal) -> Result<()> {
        listen();
        let entries: Vec<Entry> = subjects.iter().map(|s| Entry::of(s, work.files(&s.input))).collect();
        let ledger = Ledger {
            willis: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.command.to_owned(),
            parameters: self.parameters.clone(),
            subjects: entries,
        };
        let earlier = self.earlier(&ledger)?;
        // Keeps a second command off while this one lives.
        let _lock = Making::new(self.output)?;
        sweep_own(self.output)?;
        let is_done = |at: usize| {
            let record = self.record(&subjects[at].name);
            ledger.stands(at, &earlier) && record.is_some_and(|r| r["input"]["sha256"].as_str() == ledger.subjects[at].sha256())
        };
        let mut done: Vec<bool> = (0..subjects.len()).map(is_done).collect();
        self.clear(subjects, &done)?;
        ledger.write(self.output)?;
        let skipped = done.iter().filter(|done| **done).count();
        if skipped > 0 {
            terminal.say("cohort", format!("{skipped} of {} done already", plural(subjects.len(), "subject")));
        }

        let ended = self.work(subjects, &done, work, terminal);
        for (at, failure) in &ended {
            done[*at] = failure.is_none();
        }
        if ended.len() + skipped < subjects.len() {
            let done = done.iter().filter(|done| **done).count();
            return Err(Error::StoppedCohort { path: self.output.to_owned(), done, total: subjects.len() });
        }
        let row = |at: usize| {
            let (entry, name) = (&ledger.subjects[at], &subjects[at].name);
            let failure = ended.iter().find(|(of, _)| *of == at).and_then(|(_, failure)| failure.clone());
            let record = || self.record(name).ok_or_else(|| format!("{name}: run.json is not there any more"));
            Row {
                subject: name.clone(),
                input: entry.input.clone(),
                sha256: entry.sha256().unwrap_or_default().to_owned(),
                page: None,
                figures: failure.map_or_else(|| record().map(|record| work.figures(&record)), Err),
            }
        };
        let rows: Vec<Row> = (0..subjects.len()).map(row).collect();
        let records: Vec<Value> = subjects.iter().filter_map(|subject| self.record(&subject.name)).collect();
        let notes = records.iter().filter_map(|record| record["notes"].as_array()).flatten().filter_map(Value::as_str);
        // Where the landmarks of each lie is told nowhere but there.
        let notes = notes.filter(|note| !note.ends_with(LANDMARK_NOTE_ENDING));
        say_notes(terminal, &counted(notes), "subject");
        let about = About { command: self.command, line: command_line(), parameters: &self.parameters };
        write_cohort(self.output, &rows, &about)?;
        if self.json {
            rows.iter().try_for_each(|row| print_json(&row.record()))?;
        }
        terminal.say("written", format!("{}: {}", self.output.display(), plural(subjects.len(), "subject")));
        match rows.iter().filter(|row| row.figures.is_err()).count() {
            0 => Ok(()),
            failed => Err(Error::Subjects { failed, total: rows.len() }),
        }
    }

    /// The ledger of the cohort to go on with; the new one, without a subject, where the folder is made anew.
    fn earlier(&self, ledger: &Ledger) -> Result<Ledger> {
        if self.output.exists() && !self.force {
            let Some(earlier) = Ledger::read(self.output) else { return Err(Error::Exists { path: self.output.to_owned() }) };
            ledger.goes_on(&earlier, self.output)?;
            return Ok(earlier);
        }
        let empty = Ledger { subjects: Vec::new(), ..ledger.clone() };
        let folder = StagedFolder::new(self.output, self.force)?;
        empty.write(&folder.path())?;
        folder.commit()?;
        Ok(empty)
    }

    /// Takes away what will be made again, so that nothing of an earlier state is taken for the new one.
    fn clear(&self, subjects: &[Subject], done: &[bool]) -> Result<()> {
        let folders = subjects.iter().zip(done).filter(|(_, done)| !**done).map(|(s, _)| self.output.join(&s.name));
        let stale: Vec<PathBuf> = folders.filter(|folder| folder.exists()).collect();
        stale.iter().try_for_each(|folder| StagedFolder::check(folder, true))?;
        stale.iter().try_for_each(|folder| StagedFolder::remove(folder))?;
        if done.iter().any(|done| !done) {
            for path in [COHORT_TABLE, COHORT_PAGE].iter().map(|name| self.output.join(name)).filter(|path| path.exists()) {
                fs::remove_file(&path).map_err(|source| Error::Write { path, source })?;
            }
        }
        Ok(())
    }

    /// Works on the subjects that are not done, several at a time, and says how each went; those that a stop left out are not
    /// among the answers.
    fn work(&self, subjects: &[Subject], done: &[bool], work: &impl Work, terminal: Terminal) -> Vec<(usize, Option<String>)> {
        let open: Vec<usize> = (0..subjects.len()).filter(|at| !done[*at]).collect();
        let (next, ended) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
        let worker = || {
            while !is_stopped()
                && let Some(at) = open.get(next.fetch_add(1, Ordering::Relaxed)).copied()
            {
                let made = self.subject(&subjects[at], work, terminal.of_many());
                if matches!(made, Err(Error::Stopped { .. } | Error::StoppedAndKept { .. })) {
                    return;
                }
                let mut ended = ended.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                let place = format!("{}/{} {}", subjects.len() - open.len() + ended.len() + 1, subjects.len(), subjects[at].name);
                match &made {
                    Ok(()) => terminal.say("done", place),
                    Err(error) => terminal.say("failed", format!("{place}: {error}")),
                }
                ended.push((at, made.err().map(|error| error.to_string())));
            }
        };
        // What is told of a subject stays together when one is done after the other.
        let threads = if terminal.is_verbose() { 1 } else { rayon::current_num_threads().min(open.len()) };
        thread::scope(|scope| {
            for _ in 1..threads {
                // Without another thread this one does it all.
                let _ = thread::Builder::new().stack_size(STACK).spawn_scoped(scope, worker);
            }
            worker();
        });
        ended.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
    }

    fn subject(&self, subject: &Subject, work: &impl Work, terminal: Terminal) -> Result<()> {
        terminal.say("subject", &subject.name);
        let folder = StagedFolder::new(&self.output.join(&subject.name), false)?;
        work.write(subject, &folder, terminal)?;
        folder.commit()
    }

    /// The record of a subject that stands.
    fn record(&self, name: &str) -> Option<Value> {
        read_json(&self.output.join(name).join(RECORD), "").ok()
    }
}
