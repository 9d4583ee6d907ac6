//! Follows a run: shows its progress, and keeps what is finished beside its output, so that the same command resumes it (`--checkpoint`).

use std::{fs, io, path::Path, path::PathBuf, time::Duration, time::Instant};

use serde::{Deserialize, Serialize, de::DeserializeOwned, de::IgnoredAny};

use super::print::{CountProgress, TextTerminal, count, say_step};
use crate::internals::formats::{is_there, regular_bytes_of};
use crate::internals::output::{StagedFolder, read_stored, replace_file, write_stored};
use crate::{Error, Follow, Progress, Result, Step, internals::sampling::PartialRun};

/// Between the beginning and the first time that something is kept, and between two of them, where nobody says otherwise.
const FIRST: Duration = Duration::from_mins(1);
const BETWEEN: Duration = Duration::from_secs(45);
/// The share of its time that a run may spend on keeping: a hundredth.
const SHARE: u32 = 100;

/// How often what is finished is kept: from when on, and at least how long between two; never where there is none.
pub type Interval = Option<[Duration; 2]>;

/// The interval that a word means: `auto`, once a run takes over a minute; `off`; or so many seconds, from the start.
pub fn parse_interval(text: &str) -> Result<Interval, String> {
    let seconds = || text.parse().ok().and_then(|s| Duration::try_from_secs_f64(s).ok());
    match text {
        "auto" => Ok(Some([FIRST, BETWEEN])),
        "off" => Ok(None),
        _ => seconds().map(|time| Some([time; 2])).ok_or_else(|| "expected auto, off or a number of seconds".into()),
    }
}

/// What is kept of a run, with its command for the notes of other runs.
#[derive(Serialize, Deserialize)]
struct KeptRun<P> {
    command: String,
    part: P,
}

impl<P: DeserializeOwned> KeptRun<P> {
    fn read(path: &Path) -> Result<Self> {
        read_stored(&regular_bytes_of(path)?).map_err(|fault| fault.in_file(path))
    }
}

/// Follows one run.
pub struct Follower<'a> {
    terminal: TextTerminal,
    bar: Option<CountProgress>,
    keeper: Option<Keeper<'a>>,
    /// Samples that are finished, and all that there are to be.
    samples: (u64, u64),
    part: Option<PartialRun>,
}

impl<'a> Follower<'a> {
    /// Shows progress and keeps nothing.
    pub fn new(terminal: TextTerminal) -> Self {
        Self { terminal, bar: None, keeper: None, samples: (0, 0), part: None }
    }

    /// Keeps what is finished in the folder where the output is being made.
    pub fn keeping(terminal: TextTerminal, interval: Interval, folder: &'a StagedFolder, command: &str) -> Self {
        let keeper = Keeper {
            interval,
            terminal,
            folder,
            file: PathBuf::new(),
            command: command.to_owned(),
            start: Instant::now(),
            last: None,
            cost: Duration::ZERO,
            kept: 0,
            failed: false,
        };
        Self { keeper: Some(keeper), ..Self::new(terminal) }
    }

    /// Shows the progress of something else than samples.
    pub fn counting(terminal: TextTerminal, doing: &'static str, things: &'static str, total: u64) -> Self {
        Self { bar: Some(terminal.progress(doing, things, total)), ..Self::new(terminal) }
    }

    /// The file in which a run is kept, which stays when it does not come to its end; `key` is hexadecimal.
    pub fn file(folder: &StagedFolder, key: &str) -> PathBuf {
        folder.keep(&format!("{}.part", key.get(..16).unwrap_or(key)))
    }

    /// Samples that are finished, and all that there are to be.
    pub fn samples(&self) -> (u64, u64) {
        self.samples
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.iter().for_each(CountProgress::finish);
    }

    /// Keeps what is finished of a run that ends before its output stands, and says so in its error.
    pub fn rescue(&mut self, error: Error) -> Error {
        let (Some(keeper), Some(part)) = (&mut self.keeper, &self.part) else { return error };
        let (folder, place) = (keeper.folder, keeper.folder.checkpoint_folder());
        match error {
            Error::Stopped { done, total } => {
                keeper.keep(part);
                let kept = Error::StoppedAndKept { done, total, path: place.to_owned() };
                if keeper.kept > 0 { kept } else { error }
            }
            Error::Write { path, source } => {
                // What was written is of no use, and may be what fills the disk.
                let _ = fs::remove_dir_all(folder.path());
                keeper.keep(part);
                let (place, samples) = (place.display(), count(keeper.kept));
                let kept = format!("{source}; {samples} samples are kept in {place}, and the same command goes on from there");
                Error::Write { path, source: if keeper.kept > 0 { io::Error::other(kept) } else { source } }
            }
            _ => error,
        }
    }
}

impl Progress for Follower<'_> {
    fn report(&mut self, done: u64, total: u64) -> bool {
        self.samples = (done, total);
        let terminal = self.terminal;
        self.bar.get_or_insert_with(|| terminal.progress("sampling", "samples", total)).report(done, total)
    }

    fn finished(&mut self, part: &PartialRun) {
        if let Some(keeper) = self.keeper.as_mut().filter(|keeper| keeper.is_due()) {
            keeper.keep(part);
        }
    }
}

impl Follow for Follower<'_> {
    fn step(&mut self, step: Step<'_>) {
        say_step(self.terminal, &step);
    }

    fn resume(&mut self, key: &str, fits: &dyn Fn(&PartialRun) -> bool) -> Option<PartialRun> {
        let keeper = self.keeper.as_mut()?;
        keeper.file = Self::file(keeper.folder, key);
        keeper.take_up(fits)
    }

    fn sampled(&mut self, part: &PartialRun, is_complete: bool) {
        self.finish();
        if let Some(keeper) = &mut self.keeper {
            self.samples = (part.done(), part.samples());
            self.part = Some(part.clone());
            // Of a run that has come so far that its samples are worth keeping.
            if is_complete && (keeper.last.is_some() || keeper.is_due()) {
                keeper.keep(part);
            }
        }
    }
}

/// Keeps the finished part of one run.
struct Keeper<'a> {
    interval: Interval,
    terminal: TextTerminal,
    folder: &'a StagedFolder,
    file: PathBuf,
    /// The command of the run.
    command: String,
    start: Instant,
    last: Option<Instant>,
    /// How long it took the last time.
    cost: Duration,
    /// Samples that are kept.
    kept: u64,
    failed: bool,
}

impl Keeper<'_> {
    /// The part that an earlier run of the same command left, if it left one that `fits`; what other runs left is only noted.
    fn take_up(&mut self, fits: &dyn Fn(&PartialRun) -> bool) -> Option<PartialRun> {
        self.note_others();
        if self.interval.is_none() || !is_there(&self.file) {
            return None;
        }
        match KeptRun::read(&self.file) {
            Ok(KeptRun { part, .. }) if !fits(&part) => None,
            Ok(KeptRun { part, .. }) => {
                self.kept = part.done();
                self.terminal.say("resumed", format!("{} of {} samples were kept", count(part.done()), count(part.samples())));
                Some(part)
            }
            Err(error) => {
                self.terminal.say("note", format!("{error}; the run begins anew"));
                None
            }
        }
    }

    fn note_others(&self) {
        let entries = fs::read_dir(self.folder.checkpoint_folder()).into_iter().flatten().flatten().map(|entry| entry.path());
        for path in entries.filter(|path| path.extension().is_some_and(|e| e == "part") && !self.folder.is_kept(path)) {
            if let Ok(KeptRun::<IgnoredAny> { command, .. }) = KeptRun::read(&path) {
                let place = self.folder.checkpoint_folder().display();
                let whose = if command == self.command { " on another graph or by another version" } else { "" };
                self.terminal.say("note", format!("{place} also keeps samples of another run: {command}{whose}"));
            }
        }
    }

    /// Whether it is time to keep what is finished.
    fn is_due(&self) -> bool {
        let Some([first, between]) = self.interval else { return false };
        let again = |last: Instant| last.elapsed() >= between.max(SHARE * self.cost);
        self.last.map_or_else(|| self.start.elapsed() >= first, again)
    }

    /// Keeps what is finished; a run goes on when that cannot be done.
    fn keep(&mut self, part: &PartialRun) {
        let done = part.done();
        if self.interval.is_none() || done <= self.kept {
            return;
        }
        let begun = Instant::now();
        let kept = KeptRun { command: self.command.clone(), part };
        match replace_file(&self.file, |out| write_stored(out, &kept)) {
            Ok(()) => (self.kept, self.failed) = (done, false),
            Err(error) => {
                if !self.failed {
                    self.terminal.say("note", format!("what is finished cannot be kept: {error}"));
                }
                self.failed = true;
            }
        }
        (self.last, self.cost) = (Some(Instant::now()), begun.elapsed());
    }
}
