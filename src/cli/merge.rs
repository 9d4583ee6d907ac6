//! `willis merge`: the shards of one run become the run, runs that were made apart a cohort.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use serde_json::{Value, json};
use willis::error::{Error, Fault, Result};
use willis::internals::network::Network;
use willis::internals::output::StagedFolder;
use willis::internals::output::names::SHARD;
use willis::internals::sampling::{Likelihood, PartialRun};

use super::apart::gather;
use super::failure::Failure;
use super::job::Sampled;
use super::run::Run;
use super::shard::Record;
use super::shell::print_json;
use super::subjects::paths;
use super::terminal::{Terminal, count, listen, plural};

/// Put together what was made apart: the shards of one run to the run, runs of many subjects to a cohort
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
            return gather(&folders, &self.output, force, self.json, terminal);
        }
        if kinds.iter().any(|kind| matches!(kind, Kind::FailedShard(_))) {
            return self.fail(&folders, kinds, force, terminal);
        }
        let (mut shards, mut graph): (Vec<(&Path, Record)>, _) = (Vec::new(), Network::new());
        for path in &folders {
            let mut record = Record::read(path)?;
            // All have the same graph, which may be large.
            let own = std::mem::take(&mut record.job.graph);
            match shards.first() {
                Some((first, of)) => belongs(path, &record, first, of)?,
                None => graph = own,
            }
            shards.push((path, record));
        }
        shards.sort_by_key(|(_, record)| record.range);
        complete(&shards)?;
        let mut whole: Option<PartialRun> = None;
        for (path, record) in &shards {
            let part = record.part(path, &graph)?;
            match &mut whole {
                None => whole = Some(part),
                Some(whole) => drop(whole.join(part)),
            }
        }
        let (seconds, parts): (f64, _) = (shards.iter().map(|(_, record)| record.sampling_s).sum(), shards.len());
        let Some((part, (_, mut first))) = whole.zip(shards.into_iter().next()) else { return Ok(()) };
        first.job.graph = graph;
        terminal.say("merging", format!("{}: {} samples, seed {}", plural(parts, "shard"), count(part.done()), first.seed));
        listen();
        let folder = StagedFolder::new(&self.output, force)?;
        let result = Likelihood::new(part.total().unwrap_or_default(), part.uncertain().to_vec(), part.trace());
        let time = json!({ "sampling_s": seconds, "samples_per_s": part.done() as f64 / seconds, "shards": parts });
        let sampled = Sampled { result, method: first.solver.method(), time, seconds };
        let (_, record) = first.job.write_one(&first.params, &sampled, &folder.path(), start, terminal)?;
        if terminal.is_stopped() {
            return Err(Error::Stopped { done: part.done(), total: part.samples() });
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
        let mut failed: Option<(&Path, Failure)> = None;
        let mut made = Vec::new();
        for (path, kind) in folders.iter().zip(kinds) {
            if let Kind::FailedShard(failure) = kind {
                made.push((path, failure.willis.clone(), failure.command.clone()));
                failed.get_or_insert((path, failure));
            } else {
                let shard = Record::read(path)?;
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
        Failure { range: None, ..failure }.write(&self.output, force)
    }
}

/// What a folder holds.
enum Kind {
    /// A run, or why there is none.
    Run,
    Shard,
    /// Why there is no shard.
    FailedShard(Failure),
}

impl Kind {
    /// Of a folder that must hold something.
    fn of(folder: &Path) -> Result<Self> {
        match Self::in_folder(folder)? {
            Some(kind) => Ok(kind),
            // Which says what is missing.
            None => Record::read(folder).map(|_| Self::Shard),
        }
    }

    /// Of a folder; `None` where it is none of them.
    fn in_folder(folder: &Path) -> Result<Option<Self>> {
        Ok(if Run::stands_in(folder) {
            Some(Self::Run)
        } else if folder.join(SHARD).is_file() {
            Some(Self::Shard)
        } else if Failure::stands_in(folder) {
            let failure = Failure::read(folder)?;
            Some(if failure.range.is_some() { Self::FailedShard(failure) } else { Self::Run })
        } else {
            None
        })
    }
}

/// Refuses a shard of another run than the first one's, by what differs.
fn belongs(path: &Path, shard: &Record, first: &Path, of: &Record) -> Result<()> {
    let differs = |what: &str, here: &dyn std::fmt::Display, there: &dyn std::fmt::Display| {
        let found = format!("{what} {here}, where {} has {there}", first.display());
        Err(Fault::file(found, "expected the shards of one run").in_file(path))
    };
    if shard.willis != of.willis {
        return differs("was made by willis", &shard.willis, &of.willis);
    }
    if shard.input != of.input {
        return differs("is of another input, with SHA-256", &shard.input, &of.input);
    }
    if shard.seed != of.seed {
        return differs("has seed", &shard.seed, &of.seed);
    }
    if shard.samples != of.samples {
        return differs("is of a run of samples", &shard.samples, &of.samples);
    }
    let names = shard.parameters.keys().chain(of.parameters.keys());
    let value = |of: &Record, name: &str| of.parameters.get(name).unwrap_or(&Value::Null).clone();
    if let Some(name) = names.into_iter().find(|name| value(shard, name) != value(of, name)) {
        return differs(&format!("has {name}"), &value(shard, name), &value(of, name));
    }
    if shard.graph != of.graph {
        return differs("has another graph or other boundary conditions, with SHA-256", &shard.graph, &of.graph);
    }
    if shard.solver != of.solver {
        let words = |record: &Record| format!("{:?}", record.solver);
        return differs("was computed by", &words(shard), &words(of));
    }
    Ok(())
}

/// Refuses shards, in rising order, that have samples in common or leave some out.
fn complete(shards: &[(&Path, Record)]) -> Result<()> {
    let refused = |path: &Path, found: String| Err(Fault::file(found, "expected every sample in one shard").in_file(path));
    let (mut next, mut last): (_, Option<&Path>) = (0, None);
    for (path, record) in shards {
        let [from, to] = record.range;
        match last {
            Some(before) if from < next => {
                return refused(path, format!("samples {from}..{} are in {} too", next.min(to), before.display()));
            }
            _ if from > next => return refused(path, format!("samples {next}..{from} before it are in no shard")),
            _ => (next, last) = (to, Some(*path)),
        }
    }
    match (shards.last(), last) {
        (Some((_, record)), Some(path)) if next < record.samples => {
            refused(path, format!("samples {next}..{} after it are in no shard", record.samples))
        }
        _ => Ok(()),
    }
}
