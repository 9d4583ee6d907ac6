//! A shard: the folder of a part of a run, from which `willis merge` puts the run together without its input.

use std::collections::BTreeMap;
use std::io::Write;
use std::ops::Range;
use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use willis::error::{Error, Fault, Result};
use willis::internals::io::{bytes_of, checksum_of_file};
use willis::internals::network::Network;
use willis::internals::network::units::centipoise;
use willis::internals::output::atomic::{StagedFolder, write_file};
use willis::internals::output::names::{SHARD, SHARD_SUMS};
use willis::internals::output::{read_json, read_part, write_part};
use willis::internals::report::figures::check_dpi;
use willis::internals::report::record::Built;
use willis::internals::report::{candidate_parameters, outlets_found, word_of_keep};
use willis::internals::sampling::{Method, PartialRun, Sampling, SamplingOptions};
use willis::internals::support::random::BLOCK;

use super::checkpoint::{Interval, Keeper, Watch};
use super::job::Job;
use super::terminal::{Terminal, count};

/// shard.json: of which run a shard is, and all that merge needs of it.
#[derive(Serialize, Deserialize)]
pub struct Record {
    /// The version.
    pub willis: String,
    /// The command of the whole run.
    pub command: String,
    /// The SHA-256 of the input.
    pub input: String,
    pub seed: u64,
    /// Of the whole run.
    pub samples: u64,
    /// The first sample of the shard, and the first after it.
    pub range: [u64; 2],
    /// Everything else that changes an output, by what it is called.
    pub parameters: BTreeMap<String, Value>,
    /// The SHA-256 of the graph with its conditions.
    pub graph: String,
    pub solver: Solver,
    /// The SHA-256 of shard.npz.
    pub sums: String,
    /// Seconds that sampling took.
    pub sampling_s: f64,
    pub params: SamplingOptions,
    pub job: Job,
}

/// How the samples were computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solver {
    flow: String,
    size: usize,
    forest: String,
    forest_joins: Option<usize>,
}

impl Solver {
    fn of(method: Method) -> Self {
        Self {
            flow: method.solver.to_owned(),
            size: method.solver_size,
            forest: method.forest.to_owned(),
            forest_joins: method.forest_joins,
        }
    }

    /// The same for the record of a run.
    pub fn method(&self) -> Method {
        Method {
            solver: ["lanes", "gradients"].into_iter().find(|name| *name == self.flow).unwrap_or("reference"),
            solver_size: self.size,
            forest: if self.forest == "bottleneck" { "bottleneck" } else { "kruskal" },
            forest_joins: self.forest_joins,
            instructions: "",
        }
    }
}

/// The blocks of a range `A..B` of so many samples.
pub fn blocks_of(text: &str, samples: u64) -> Result<Range<u64>> {
    let refused = |why: String| Err(Error::parameter("--range", text, why));
    let ends = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse::<u64>().ok()?, b.trim().parse::<u64>().ok()?)));
    let Some((first, last)) = ends else { return refused("expected A..B, as in 0..640".into()) };
    if first >= last || last > samples {
        return refused(format!("expected A < B, and B at most the {samples} --samples"));
    }
    if let Some(border) = [first, last].into_iter().find(|at| !at.is_multiple_of(BLOCK) && *at != samples) {
        let (below, above) = (border / BLOCK * BLOCK, border.next_multiple_of(BLOCK).min(samples));
        return refused(format!("{border} is no border of a block of {BLOCK} samples; the nearest are {below} and {above}"));
    }
    Ok(first / BLOCK..last.div_ceil(BLOCK))
}

/// The first sample of a range of blocks, and the first after it, of so many samples.
pub fn samples_of(blocks: &Range<u64>, samples: u64) -> [u64; 2] {
    [blocks.start * BLOCK, (blocks.end * BLOCK).min(samples)]
}

/// Everything that changes an output but the input, the seed and the samples.
fn parameters(job: &Job, params: &SamplingOptions) -> BTreeMap<String, Value> {
    let content = |record: &Value| record.get("sha256").unwrap_or(record).clone();
    let mut all = json!({
        "epsilon": params.epsilon,
        "uncertain": params.uncertain.name(),
        "weight": params.weight.name(),
        "viscosity_cP": centipoise(params.viscosity),
        "solver": params.solver,
        "keep": word_of_keep(job.rule),
        "outlets": outlets_found(job.outlets),
        "prior": content(&job.prior),
        "preset": job.paper.then_some("paper"),
        "dpi": job.dpi,
        "arteries": job.circle.as_ref().map(|found| &found.known_by),
        "landmarks": job.circle.as_ref().map(|found| content(&found.record())),
    });
    let built = job.candidates.as_ref().map_or(Built::Given, Built::Candidates);
    if let (Value::Object(all), Value::Object(built)) = (&mut all, candidate_parameters(built)) {
        all.extend(built);
    }
    serde_json::from_value(all).unwrap_or_default()
}

/// Samples a range of blocks and writes the folder of a shard.
pub fn write_shard(
    job: Job,
    params: &SamplingOptions,
    blocks: &Range<u64>,
    folder: &StagedFolder,
    interval: Interval,
    terminal: Terminal,
) -> Result<()> {
    let params = job.sampled_with(params);
    // Before the work: what cannot be read back cannot be merged.
    let stored = serde_json::to_string(&job).and_then(|text| serde_json::from_str::<Job>(&text));
    stored.map_err(|e| Error::parameter("--range", "cannot be stored", format!("expected finite numbers in the graph ({e})")))?;
    job.say_sampling(&params, terminal);
    let begun = Instant::now();
    let sampling = Sampling::new(&job.graph, &job.boundary, &params)?;
    let range = samples_of(blocks, params.samples);
    let graph = job.graph_checksum();
    let key = job.key(&params, Some(&format!("{}..{}", range[0], range[1])));
    let mut keeper = Keeper::new(interval, folder, &key, &job.provenance.command, terminal);
    let fits = |part: &PartialRun| part.samples() == params.samples;
    let mut part = keeper.take_up(sampling.part().uncertain(), fits).unwrap_or_else(|| sampling.part());
    let mut watch = Watch { progress: terminal.progress("sampling", "samples", range[1] - range[0]), keeper: &mut keeper };
    let sampled = sampling.sample(&mut part, blocks.clone(), &mut watch);
    watch.progress.finish();
    let seconds = begun.elapsed().as_secs_f64();
    let written = sampled.and_then(|()| {
        keeper.sampled(&part);
        let path = folder.path();
        write_file(&path.join(SHARD_SUMS), |out| write_part(out, &part))?;
        let record = Record {
            willis: env!("CARGO_PKG_VERSION").to_owned(),
            command: job.provenance.command.clone(),
            input: job.provenance.sha256.clone(),
            seed: params.seed,
            samples: params.samples,
            range,
            parameters: parameters(&job, &params),
            graph,
            solver: Solver::of(sampling.method()),
            sums: checksum_of_file(&path.join(SHARD_SUMS))?,
            sampling_s: seconds,
            params,
            job,
        };
        write_file(&path.join(SHARD), |out| {
            serde_json::to_writer(&mut *out, &record)?;
            out.write_all(b"\n")
        })
    });
    written.map_err(|error| keeper.rescue(&part, error))?;
    let done = range[1] - range[0];
    terminal.say("shard", format!("samples {}..{} of {}, in {seconds:.1} s", range[0], range[1], count(sampling.samples())));
    debug_assert_eq!(part.done(), done);
    Ok(())
}

impl Record {
    /// The record of a shard.
    ///
    /// # Errors
    ///
    /// A folder that is no shard.
    pub fn read(folder: &Path) -> Result<Self> {
        let expected = "expected the folder of a shard or of a run, from willis infer";
        let path = if folder.exists() { folder.join(SHARD) } else { folder.to_owned() };
        if folder.exists() && !path.exists() {
            let found = if folder.is_dir() { "a folder without shard.json or run.json" } else { "no folder" };
            return Err(Fault::file(found, expected).in_file(folder));
        }
        let record: Self = read_json(&path, expected)?;
        let range = record.range[0] < record.range[1] && record.range[1] <= record.samples;
        let whole = range && record.job.is_whole() && record.job.graph_checksum() == record.graph;
        let valid = record.params.validate().and_then(|()| record.job.rule.validate()).and_then(|()| check_dpi(record.job.dpi));
        if !whole || valid.is_err() {
            let found = "damaged: its range, parameters or graph are not those that were sampled";
            return Err(Fault::file(found, "expected it as willis infer --range wrote it").in_file(&path));
        }
        Ok(record)
    }

    /// The sums of the shard of a graph in a folder, as they were written.
    ///
    /// # Errors
    ///
    /// They are damaged, or those of another shard.
    pub fn part(&self, folder: &Path, graph: &Network) -> Result<PartialRun> {
        let path = folder.join(SHARD_SUMS);
        let damaged = |found: &str| Fault::file(found, "expected it as willis infer --range wrote it").in_file(&path);
        if checksum_of_file(&path)? != self.sums {
            return Err(damaged("damaged: its SHA-256 is not that of shard.json"));
        }
        let bytes = bytes_of(&path)?;
        let uncertain = self.params.uncertain.vessels(graph);
        let part = read_part(&bytes, uncertain).map_err(|fault| fault.in_file(&path))?;
        let blocks = self.range[0] / BLOCK..self.range[1].div_ceil(BLOCK);
        let whole = part.samples() == self.samples && part.gaps(blocks.clone()).is_empty();
        if !whole || part.done() != part.samples_in(&blocks) {
            return Err(damaged("not the samples that shard.json says"));
        }
        Ok(part)
    }
}
