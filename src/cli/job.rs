//! The inference of one input: samples it, decides, writes its folder.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use willis::error::{Error, Result};
use willis::internals::candidates;
use willis::internals::decision::{Decision, Keep, Topology, all_decided, decide, expected_errors, has_evidence};
use willis::internals::flow::{Boundary, FoundOutlets};
use willis::internals::io::{checksum, checksum_of, write_csv};
use willis::internals::network::Network;
use willis::internals::output::atomic::{StagedFolder, write_file};
use willis::internals::output::names::AGREEMENT;
use willis::internals::output::told;
use willis::internals::output::write_record;
use willis::internals::report::record::Built;
use willis::internals::report::{Outcome, Provenance, Summary, agreement, phenotype_json, write_outcome, write_phenotype};
use willis::internals::sampling::{FIRST_STABLE, Likelihood, Method, PartialRun, Sampling, SamplingOptions};

use super::checkpoint::{Interval, Keeper, Watch};
use super::circle::Found;
use super::plausible::posterior;
use super::run::Run;
use super::tell::say_outcome;
use super::tell_circle::say_variant;
use super::terminal::{Terminal, count, plural};

/// An input made ready: what all its occlusion probabilities share.
#[derive(Serialize, Deserialize)]
pub struct Job {
    pub graph: Network,
    pub boundary: Boundary,
    pub outlets: FoundOutlets,
    pub provenance: Provenance,
    /// The record of the prior.
    pub prior: Value,
    pub uniform_prior: bool,
    /// How candidates were built; `None` for a ready graph.
    pub candidates: Option<candidates::CandidateOptions>,
    pub rule: Keep,
    pub until_stable: bool,
    pub paper: bool,
    pub dpi: u32,
    /// Where the arteries of a Circle of Willis are, where that is asked for.
    pub circle: Option<Found>,
}

/// What the samples of a run came to.
pub struct Sampled {
    pub result: Likelihood,
    pub method: Method,
    /// For run.json: how long it took, on what.
    pub time: Value,
    pub seconds: f64,
}

impl Sampled {
    /// With how long it took to compute so many of the samples.
    pub fn new(result: Likelihood, method: Method, computed: u64, seconds: f64) -> Self {
        let rate = computed as f64 / seconds;
        let threads = rayon::current_num_threads();
        let time =
            json!({ "sampling_s": seconds, "samples_per_s": rate, "threads": threads, "instructions": method.instructions });
        Self { result, method, time, seconds }
    }
}

impl Job {
    /// Writes the folder of an inference, or one for each of several `runs`, and returns their records; `start` is when the work
    /// on the input began.
    pub fn write(
        &self,
        runs: &[SamplingOptions],
        folder: &StagedFolder,
        interval: Interval,
        start: Instant,
        terminal: Terminal,
    ) -> Result<Vec<Summary>> {
        let path = folder.path();
        // Before the first of several looks at what is there.
        for params in runs {
            Keeper::files(folder, &self.key(&self.sampled_with(params), None));
        }
        if let [params] = runs {
            return Ok(vec![self.run(params, folder, &path, interval, start, terminal)?.1]);
        }
        let (mut decisions, mut records) = (Vec::new(), Vec::new());
        for params in runs {
            let sub = path.join(format!("epsilon-{}", params.epsilon));
            std::fs::create_dir(&sub).map_err(|source| Error::Write { path: told(&sub), source })?;
            let (answer, record) = self.run(params, folder, &sub, interval, start, terminal)?;
            decisions.push((params.epsilon, answer));
            records.push(record);
        }
        let uncertain = runs[0].uncertain.vessels(&self.graph);
        write_file(&path.join(AGREEMENT), |out| write_csv(out, &agreement(&decisions, &uncertain)))?;
        Ok(records)
    }

    /// Samples and writes the folder `path` of one occlusion probability, within or the same as `folder`.
    fn run(
        &self,
        params: &SamplingOptions,
        folder: &StagedFolder,
        path: &Path,
        interval: Interval,
        start: Instant,
        terminal: Terminal,
    ) -> Result<(Decision, Summary)> {
        let params = &self.sampled_with(params);
        let begun = Instant::now();
        self.say_sampling(params, terminal);
        let first = if self.until_stable { SamplingOptions { samples: FIRST_STABLE, ..params.clone() } } else { params.clone() };
        let mut sampling = Sampling::new(&self.graph, &self.boundary, &first)?;
        let mut keeper = Keeper::new(interval, folder, &self.key(params, None), &self.provenance.command, terminal);
        let fits =
            |part: &PartialRun| part.samples() == sampling.samples() || self.until_stable && part.samples().is_power_of_two();
        let mut part = keeper.take_up(sampling.part().uncertain(), fits).unwrap_or_else(|| sampling.part());
        let before = part.done();
        let mut watch = Watch { progress: terminal.progress("sampling", "samples", part.samples()), keeper: &mut keeper };
        let result = if self.until_stable {
            sampling.until_stable(&mut part, |result| all_decided(self.rule, &self.graph, result), &mut watch)
        } else {
            sampling.sample(&mut part, 0..sampling.blocks(), &mut watch).map(|()| sampling.likelihood(&part))
        };
        watch.progress.finish();
        let written = result.and_then(|result| {
            keeper.sampled(&part);
            let computed = part.done() - before;
            let sampled = Sampled::new(result, sampling.method(), computed, begun.elapsed().as_secs_f64());
            let written = self.write_one(params, &sampled, path, start, terminal)?;
            // Nothing is written after a stop.
            let (done, total) = (part.done(), part.samples());
            if terminal.is_stopped() { Err(Error::Stopped { done, total }) } else { Ok(written) }
        });
        written.map_err(|error| keeper.rescue(&part, error))
    }

    /// The parameters with the prior of this input.
    pub fn sampled_with(&self, params: &SamplingOptions) -> SamplingOptions {
        SamplingOptions { uniform_prior: self.uniform_prior, ..params.clone() }
    }

    /// All that the samples depend on, as SHA-256: what is kept of a run, or of a `range` of its samples, goes on under it.
    pub fn key(&self, params: &SamplingOptions, range: Option<&str>) -> String {
        let samples = (!self.until_stable).then_some(params.samples);
        let graph = self.graph_checksum();
        let all = json!({ "willis": env!("CARGO_PKG_VERSION"), "graph": graph, "params": SamplingOptions { samples: 0, ..params.clone() }, "samples": samples, "range": range });
        checksum(all.to_string().as_bytes())
    }

    /// The SHA-256 of the graph with its conditions, exactly as they are sampled.
    pub fn graph_checksum(&self) -> String {
        let written = checksum_of(|out| {
            serde_json::to_writer(&mut *out, &self.graph)?;
            write!(out, "{:?}", self.boundary)
        });
        // Nothing fails here but the memory for a number.
        written.unwrap_or_default()
    }

    /// Whether its rows are all there, as they are unless the job comes from a file.
    pub fn is_whole(&self) -> bool {
        let (nodes, boundary) = (self.graph.node_count(), &self.boundary);
        let conditions = boundary.conditions.iter().map(|(node, _)| node);
        boundary.roles.len() == nodes
            && boundary.conditions.is_sorted_by(|a, b| a.0 < b.0)
            && conditions.chain(&boundary.found_inlets).chain(&boundary.found_outlets).all(|node| *node < nodes)
            && self.circle.as_ref().is_none_or(|found| found.circle.fits(&self.graph))
    }

    /// Says what is about to be sampled.
    pub fn say_sampling(&self, params: &SamplingOptions, terminal: Terminal) {
        let uncertain = params.uncertain.vessels(&self.graph).iter().filter(|u| **u).count();
        let how = format!(
            "epsilon {}, {} samples, seed {}, {}",
            params.epsilon,
            count(params.samples),
            params.seed,
            plural(rayon::current_num_threads(), "thread")
        );
        terminal.say(
            "sampling",
            format!("{how}: {} of {} uncertain", count(uncertain as u64), plural(self.graph.vessel_count(), "vessel")),
        );
    }

    /// Decides, and writes everything into the folder of one occlusion probability.
    pub fn write_one(
        &self,
        params: &SamplingOptions,
        sampled: &Sampled,
        folder: &Path,
        start: Instant,
        terminal: Terminal,
    ) -> Result<(Decision, Summary)> {
        let (result, method) = (&sampled.result, sampled.method);
        let answer = decide(self.rule, &self.graph, result)?;
        let topology = |kept: &[bool]| Topology::of(&self.graph, &result.uncertain, kept, &self.boundary);
        let outcome = Outcome {
            network: &self.graph,
            boundary: &self.boundary,
            result,
            rule: self.rule,
            answer: &answer,
            kept: topology(&answer.kept),
            above_median: topology(&answer.above_median),
            expected: expected_errors(&self.graph, &answer.kept),
            uniform_prior: params.uniform_prior,
            method,
            weight: params.weight,
            exact: params.exact,
            viscosity: params.viscosity,
        };
        let built = self.candidates.as_ref().map_or(Built::Given, Built::Candidates);
        let mut summary = Summary::new(&outcome, &self.provenance, params, built, self.outlets);
        summary.state_prior(self.prior.clone());
        if self.paper {
            summary.follow_the_paper();
        }
        summary.time = sampled.time.clone();
        say_outcome(terminal, &outcome, sampled.seconds);
        for note in write_outcome(folder, &outcome, &mut summary, self.dpi)? {
            terminal.say("note", note);
        }
        if let Some(found) = &self.circle {
            let conditions = self.boundary.conditions.iter().map(|(node, _)| *node);
            let given: Vec<usize> = conditions.filter(|node| !self.boundary.is_found(*node)).collect();
            let above = (!has_evidence(&self.graph)).then_some(&answer.above_median[..]);
            let (posterior, how) = posterior(&self.graph, &self.boundary, params, &found.circle, &given, above)?;
            let variant = posterior.best();
            terminal.say("drawn", how);
            say_variant(terminal, &variant, Some(&posterior));
            let phenotype = phenotype_json(&self.graph, &variant, Some(&posterior));
            write_phenotype(folder, &Run::subject(Path::new(&self.provenance.input)), &variant, Some(&posterior), &phenotype)?;
            summary.state_phenotype(phenotype, &found.known_by, found.record());
        }
        // Known only once all else is written.
        summary.time["wall_s"] = json!(start.elapsed().as_secs_f64());
        write_record(folder, &summary)?;
        Ok((answer, summary))
    }
}
