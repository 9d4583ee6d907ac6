//! A shard: a range of the samples of a run, in a folder from which the run is put together without its input.

use std::collections::BTreeSet;
use std::fmt::Display;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::{Heard, Inference, Prepared, Progress, SaveOptions, Step};
use crate::error::{Error, Fault, Result};
use crate::io::{bytes_of, checksum_of_file};
use crate::network::Network;
use crate::output::atomic::write_file;
use crate::output::names::{SHARD, SHARD_SUMS};
use crate::output::partial_run_file::{read_part, write_part};
use crate::output::read_json;
use crate::sampling::{Likelihood, Method, PartialRun, Sampling, SamplingOptions};
use crate::support::random::BLOCK;

/// A range of the samples of a run.
#[derive(Debug)]
pub struct Shard {
    record: ShardRecord,
    part: PartialRun,
}

/// shard.json: of which run a shard is, and all that merging needs of it.
#[derive(Debug, Serialize, Deserialize)]
pub struct ShardRecord {
    /// The version.
    pub willis: String,
    /// The command of the whole run.
    pub command: String,
    /// The SHA-256 of the input.
    pub input: String,
    /// How the whole run samples.
    pub sampling: SamplingOptions,
    /// The first sample of the shard, and the first after it.
    pub range: [u64; 2],
    /// The SHA-256 of the graph with its conditions.
    graph: String,
    solver: Solver,
    /// The SHA-256 of shard.npz.
    sums: String,
    /// Seconds that sampling took.
    sampling_s: f64,
    /// How the folder of the run is to be written.
    save: SaveOptions,
    prepared: Arc<Prepared>,
}

/// How the samples were computed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Solver {
    flow: String,
    size: usize,
    forest: String,
    forest_joins: Option<usize>,
}

impl Solver {
    pub(super) fn of(method: Method) -> Self {
        let Method { solver, solver_size, forest, forest_joins, .. } = method;
        Self { flow: solver.to_owned(), size: solver_size, forest: forest.to_owned(), forest_joins }
    }

    /// Whether it is one that this program has.
    fn is_known(&self) -> bool {
        ["lanes", "gradients", "reference"].contains(&&*self.flow) && ["bottleneck", "kruskal"].contains(&&*self.forest)
    }

    /// The same for the record of a run.
    pub(super) fn method(&self) -> Method {
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
///
/// # Errors
///
/// A range that does not begin and end at the borders of blocks of 64 samples, or lies outside of the run.
pub fn blocks_of(text: &str, samples: u64) -> Result<Range<u64>> {
    let refused = |why: String| Err(Error::parameter("range", text, why));
    let ends = text.split_once("..").and_then(|(a, b)| Some((a.trim().parse::<u64>().ok()?, b.trim().parse::<u64>().ok()?)));
    let Some((first, last)) = ends else { return refused("expected A..B, as in 0..640".into()) };
    if first >= last || last > samples {
        return refused(format!("expected A < B, and B at most the {samples} `samples`"));
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

impl Prepared {
    /// Samples a range of blocks, for [`merge`].
    ///
    /// # Errors
    ///
    /// As [`infer_with`](crate::infer_with); a graph that cannot be stored.
    pub fn sample_range(
        self: &Arc<Self>,
        options: &SamplingOptions,
        blocks: &Range<u64>,
        progress: &mut dyn Progress,
    ) -> Result<Shard> {
        let options = self.sampled_with(options);
        // Before the work: what cannot be read back cannot be merged.
        let stored = serde_json::to_string(self).and_then(|text| serde_json::from_str::<Self>(&text));
        stored
            .map_err(|e| Error::parameter("range", "cannot be stored", format!("expected finite numbers in the graph ({e})")))?;
        progress.step(Step::Sampling { graph: &self.graph, options: &options, until_stable: false });
        let begun = Instant::now();
        let sampling = Sampling::new(&self.graph, &self.boundary, &options)?;
        let range = samples_of(blocks, options.samples);
        let fits = |part: &PartialRun| part.samples() == options.samples;
        let resumed = progress.resume(&self.key(&options, Some(range)), sampling.part().uncertain(), &fits);
        let mut part = resumed.unwrap_or_else(|| sampling.part());
        let sampled = sampling.sample(&mut part, blocks.clone(), &mut Heard(progress));
        progress.sampled(&part, sampled.is_ok());
        sampled?;
        let record = ShardRecord {
            willis: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.provenance.command.clone(),
            input: self.provenance.sha256.clone(),
            sampling: options,
            range,
            graph: self.graph_checksum(),
            solver: Solver::of(sampling.method()),
            sums: String::new(),
            sampling_s: begun.elapsed().as_secs_f64(),
            save: SaveOptions::default(),
            prepared: Arc::clone(self),
        };
        Ok(Shard { record, part })
    }

    /// Whether its rows are all there, as they are unless it comes from a file.
    pub(super) fn is_whole(&self) -> bool {
        let (nodes, boundary) = (self.graph.node_count(), &self.boundary);
        let conditions = boundary.conditions.iter().map(|(node, _)| node);
        boundary.roles.len() == nodes
            && boundary.conditions.is_sorted_by(|a, b| a.0 < b.0)
            && conditions.chain(&boundary.found_inlets).chain(&boundary.found_outlets).all(|node| *node < nodes)
            && self.arteries.as_ref().is_none_or(|found| found.circle.fits(&self.graph))
    }
}

impl Shard {
    /// Which samples, and how long they took in s.
    pub fn samples(&self) -> ([u64; 2], f64) {
        (self.record.range, self.record.sampling_s)
    }

    /// Writes shard.npz and shard.json into a folder that is there; `save` is how the folder of the run is to be written.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(mut self, folder: &Path, save: &SaveOptions) -> Result<()> {
        self.record.save = *save;
        write_file(&folder.join(SHARD_SUMS), |out| write_part(out, &self.part))?;
        self.record.sums = checksum_of_file(&folder.join(SHARD_SUMS))?;
        write_file(&folder.join(SHARD), |out| {
            serde_json::to_writer(&mut *out, &self.record)?;
            out.write_all(b"\n")
        })
    }
}

impl ShardRecord {
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
        let range = record.range[0] < record.range[1] && record.range[1] <= record.sampling.samples;
        let known = record.solver.is_known() && record.sampling_s.is_finite() && record.sampling_s >= 0.0;
        let whole = range && known && record.prepared.is_whole() && record.prepared.graph_checksum() == record.graph;
        let valid =
            record.sampling.validate().and_then(|()| record.prepared.keep.validate()).and_then(|()| record.save.validate());
        if !whole || valid.is_err() {
            let found = "damaged: its range, parameters or graph are not those that were sampled";
            return Err(Fault::file(found, "expected it as the shard wrote it").in_file(&path));
        }
        Ok(record)
    }

    /// The sums of the shard in a folder, as they were written.
    fn part(&self, folder: &Path, graph: &Network) -> Result<PartialRun> {
        let path = folder.join(SHARD_SUMS);
        let damaged = |found: &str| Fault::file(found, "expected it as the shard wrote it").in_file(&path);
        if checksum_of_file(&path)? != self.sums {
            return Err(damaged("damaged: its SHA-256 is not that of shard.json"));
        }
        let bytes = bytes_of(&path)?;
        let part = read_part(&bytes, self.sampling.uncertain.vessels(graph)).map_err(|fault| fault.in_file(&path))?;
        let blocks = self.range[0] / BLOCK..self.range[1].div_ceil(BLOCK);
        let whole = part.samples() == self.sampling.samples && part.gaps(blocks.clone()).is_empty();
        if !whole || part.done() != part.samples_in(&blocks) {
            return Err(damaged("not the samples that shard.json says"));
        }
        // A forest of N nodes has N - 1 vessels at the most.
        let most = part.done() as f64 * graph.node_count().saturating_sub(1) as f64;
        if part.total().is_some_and(|sums| sums.count.iter().sum::<f64>() > most) {
            return Err(damaged("more vessels in its forests than the graph has nodes for"));
        }
        Ok(part)
    }

    /// Refuses a shard of another run than the first one's, by what differs.
    fn belongs(&self, path: &Path, first: &Path, of: &Self) -> Result<()> {
        let differs = |what: &str, here: &dyn Display, there: &dyn Display| {
            let found = format!("{what} {here}, where {} has {there}", first.display());
            Err(Fault::file(found, "expected the shards of one run").in_file(path))
        };
        if self.willis != of.willis {
            return differs("was made by willis", &self.willis, &of.willis);
        }
        if self.input != of.input {
            return differs("is of another input, with SHA-256", &self.input, &of.input);
        }
        if self.sampling.seed != of.sampling.seed {
            return differs("has seed", &self.sampling.seed, &of.sampling.seed);
        }
        if self.sampling.samples != of.sampling.samples {
            return differs("is of a run of samples", &self.sampling.samples, &of.sampling.samples);
        }
        let (here, there) = (self.comparable(), of.comparable());
        if let Some(name) = differing(&here, &there) {
            return differs(&format!("has {name}"), &here[&name], &there[&name]);
        }
        if self.graph != of.graph {
            return differs("has another graph or other boundary conditions, with SHA-256", &self.graph, &of.graph);
        }
        if self.solver != of.solver {
            return differs("was computed by", &format!("{:?}", self.solver), &format!("{:?}", of.solver));
        }
        Ok(())
    }

    /// Everything that changes an output but the input, the seed and the samples.
    fn comparable(&self) -> Value {
        let prepared = &self.prepared;
        let mut options = prepared.options.clone();
        options.infer.sampling = self.sampling.clone();
        let mut all = options.comparable(&prepared.prior);
        all["dpi"] = json!(self.save.dpi);
        all["keep"] = json!(prepared.keep);
        all["landmarks"] = json!(prepared.arteries.as_ref().and_then(|found| Some(&found.landmarks.as_ref()?.sha256)));
        all
    }
}

/// The name of the first option in which two sets of them differ.
pub fn differing(one: &Value, other: &Value) -> Option<String> {
    let names: BTreeSet<&String> =
        [one, other].into_iter().filter_map(Value::as_object).flat_map(serde_json::Map::keys).collect();
    names.into_iter().find(|name| one[*name] != other[*name]).cloned()
}

/// Puts a run together from the folders of all its shards, in whatever order; and how its folder is to be written.
///
/// # Errors
///
/// A folder that is no shard, shards of different runs, samples in two shards or in none.
pub fn merge(folders: &[PathBuf], mut each: impl FnMut(usize, u64, u64)) -> Result<(Inference, SaveOptions)> {
    let started = Instant::now();
    let (mut shards, mut graph): (Vec<(&Path, ShardRecord)>, _) = (Vec::new(), Network::new());
    for path in folders {
        let mut record = ShardRecord::read(path)?;
        // All have the same graph, which may be large.
        let own = Arc::get_mut(&mut record.prepared).map(|prepared| std::mem::take(&mut prepared.graph)).unwrap_or_default();
        match shards.first() {
            Some((first, of)) => record.belongs(path, first, of)?,
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
    let (seconds, count): (f64, _) = (shards.iter().map(|(_, record)| record.sampling_s).sum(), shards.len());
    let (Some(part), Some((_, mut first))) = (whole, shards.into_iter().next()) else {
        return Err(Error::parameter("folders", "", "expected one shard at least"));
    };
    if let Some(prepared) = Arc::get_mut(&mut first.prepared) {
        (prepared.graph, prepared.started) = (graph, started);
    }
    each(count, part.done(), first.sampling.seed);
    let likelihood = Likelihood::new(part.total().unwrap_or_default(), part.uncertain().to_vec(), part.trace());
    let time = json!({ "sampling_s": seconds, "samples_per_s": part.done() as f64 / seconds, "shards": count });
    Ok((first.prepared.decide(&first.sampling, likelihood, first.solver.method(), time)?, first.save))
}

/// Refuses shards, in rising order, that have samples in common or leave some out.
fn complete(shards: &[(&Path, ShardRecord)]) -> Result<()> {
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
        (Some((_, record)), Some(path)) if next < record.sampling.samples => {
            refused(path, format!("samples {next}..{} after it are in no shard", record.sampling.samples))
        }
        _ => Ok(()),
    }
}
