//! `willis merge`: the shards of one run become the run, runs that were made separately a cohort.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::error::{Error, Fault, Result};
use crate::internals::output::atomic::StagedFolder;
use crate::internals::output::names::{RECORD, SHARD};
use crate::internals::pipeline::ShardRecord;
use crate::merge;
use clap::Args;
use serde_json::Value;

use super::cohort::{Cohort, Failure, gather};
use super::print::arteries::say_variant;
use super::print::inference::say_outcome;
use super::print::{Terminal, count, plural};
use super::shell::print_json;
use super::signals::listen;
use super::subjects::{named, paths};

/// Put together what was made separately: the shards of one run to the run, runs of many subjects to a cohort
///
/// A shard is what willis infer --range A..B writes; all shards of a run make the files of the whole run, in whatever order they
/// are given. Runs are the folders of willis infer: they make cohort.csv and cohort.html, with the rows that willis infer writes for all inputs
/// in one command, and links to the reports where they are. They must have the same options and seed. A folder that
/// willis infer --record-failure wrote is a row that failed. The inputs need not be there.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// The folders of the shards of one run, or of runs; a pattern in quotes ('runs/*') is all that fit it
    #[arg(value_name = "FOLDER", required = true, value_hint = clap::ValueHint::DirPath)]
    folders: Vec<PathBuf>,
    /// The folder to write; it must not exist
    #[arg(short, long, value_name = "FOLDER", value_hint = clap::ValueHint::DirPath)]
    output: PathBuf,
    /// Print run.json on standard output too, in one line; of a cohort, its row of each subject
    #[arg(long)]
    json: bool,
}

impl MergeArgs {
    pub fn run(self, terminal: Terminal, force: bool) -> Result<()> {
        let start = Instant::now();
        StagedFolder::check(&self.output, force)?;
        let is_known = |path: &Path| Kind::in_folder(path).is_ok_and(|kind| kind.is_some());
        let folders = paths(&self.folders, "folder of a shard or a run", is_known)?;
        let kinds = folders.iter().map(|folder| Kind::of(folder)).collect::<Result<Vec<_>>>()?;
        if let Some(run) = kinds.iter().position(|kind| matches!(kind, Kind::Run)) {
            if let Some(shard) = kinds.iter().position(|kind| !matches!(kind, Kind::Run)) {
                let found = format!("a shard, where {} is a run", folders[run].display());
                return Err(Fault::file(found, "expected shards or runs, not both").in_file(&folders[shard]));
            }
            let cohort = Cohort { command: "merge", parameters: Value::Null, output: &self.output, force, json: self.json };
            return gather(&folders, &cohort, named, terminal).map(drop);
        }
        if kinds.iter().any(|kind| matches!(kind, Kind::FailedShard(_))) {
            return self.fail(&folders, kinds, force, terminal);
        }
        let (inference, save) = merge(&folders, |parts, samples, seed| {
            terminal.say("merging", format!("{}: {} samples, seed {seed}", plural(parts, "shard"), count(samples)));
        })?;
        listen(1);
        let folder = StagedFolder::new(&self.output, force)?;
        say_outcome(terminal, &inference.outcome(), inference.seconds());
        let (record, notes) = inference.write(&folder.path(), &save)?;
        for note in &notes {
            terminal.say("note", note);
        }
        if let Some((posterior, how)) = inference.posterior() {
            terminal.say("drawn", how);
            say_variant(terminal, &posterior.best(), inference.hypoplastic(), Some(posterior));
        }
        if terminal.is_stopped() {
            let samples = inference.likelihood().samples;
            return Err(Error::Stopped { done: samples, total: samples });
        }
        folder.commit()?;
        if self.json {
            print_json(&record)?;
        }
        terminal.say("written", format!("{} in {:.1} s", self.output.display(), start.elapsed().as_secs_f64()));
        Ok(())
    }

    /// Of shards of which some failed: the run failed.
    fn fail(&self, folders: &[PathBuf], kinds: Vec<Kind>, force: bool, terminal: Terminal) -> Result<()> {
        let mut failed: Option<(&Path, Box<Failure>)> = None;
        let mut made = Vec::new();
        for (path, kind) in folders.iter().zip(kinds) {
            if let Kind::FailedShard(failure) = kind {
                made.push((path, failure.willis.clone(), failure.command.clone()));
                failed.get_or_insert((path, failure));
            } else {
                let shard = ShardRecord::read(path)?;
                made.push((path, shard.willis, shard.command));
            }
        }
        let Some((first, failure)) = failed else { return Ok(()) };
        if let Some((path, willis, command)) =
            made.iter().find(|(_, willis, command)| (willis, command) != (&failure.willis, &failure.command))
        {
            let found = format!(
                "was made by {command} of version {willis}, where {} was by {} of version {}",
                first.display(),
                failure.command,
                failure.willis
            );
            return Err(Fault::file(found, "expected the shards of one run").in_file(path));
        }
        terminal.say("failed", &failure.error);
        Failure { range: None, ..*failure }.write(&self.output, force)
    }
}

/// What a folder holds.
enum Kind {
    /// A run, or why there is none.
    Run,
    Shard,
    /// Why there is no shard.
    FailedShard(Box<Failure>),
}

impl Kind {
    /// Of a folder that must hold something.
    fn of(folder: &Path) -> Result<Self> {
        match Self::in_folder(folder)? {
            Some(kind) => Ok(kind),
            // Which says what is missing.
            None => ShardRecord::read(folder).map(|_| Self::Shard),
        }
    }

    /// Of a folder; `None` where it is none of them.
    fn in_folder(folder: &Path) -> Result<Option<Self>> {
        Ok(if folder.join(RECORD).is_file() {
            Some(Self::Run)
        } else if folder.join(SHARD).is_file() {
            Some(Self::Shard)
        } else if Failure::is_in(folder) {
            let failure = Failure::read(folder)?;
            Some(if failure.range.is_some() { Self::FailedShard(Box::new(failure)) } else { Self::Run })
        } else {
            None
        })
    }
}
