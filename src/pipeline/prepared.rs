//! What is ready to be sampled, and its samples.

use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::Inference;
use super::arteries::FoundArteries;
use super::cuts::{Contacts, CutRecord};
use super::decisions::Decided;
use super::options::{ModelSource, Preset, RunOptions};
use super::picture::ImageRecord;
use super::progress::{Follow, Step};
use willis_core::decision::{Keep, all_decided};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::Network;
use willis_core::sampling::{FIRST_STABLE, FoundConditions, PartialRun, Sampling, SamplingOptions, Solver};
use willis_io::formats::{checksum, checksum_of};
use willis_models::candidates::CandidateOptions;
use willis_report::{ImageCut, Provenance, Segmentation};

/// An input made ready to be sampled: the over-connected graph and its boundary conditions, with everything that its files say.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Prepared {
    /// The over-connected graph.
    pub graph: Network,
    /// The rows of its first nodes that an input states as such; centerlines state points.
    #[serde(default)]
    pub(crate) own_nodes: usize,
    /// Its boundary conditions.
    pub boundary: Boundary,
    /// The file, and what a person should know.
    pub provenance: Provenance,
    /// The options that were given.
    pub options: RunOptions,
    /// What found outlets are.
    pub(crate) outlets: FoundOutlets,
    pub(crate) records: Records,
    /// What it shows along doubtful vessels.
    pub(crate) image_cuts: Vec<ImageCut>,
    /// The segmentation that the vessels were found in, where they were.
    pub(crate) segmentation: Option<Segmentation>,
    /// What is known of the contacts beside their vessels.
    pub(crate) contacts: Contacts,
    pub(crate) uniform_prior: bool,
    /// How candidates were built; `None` for a ready graph.
    pub(crate) candidates: Option<CandidateOptions>,
    pub(crate) keep: Keep,
    pub(crate) arteries: Option<FoundArteries>,
    #[serde(skip, default = "Instant::now")]
    pub(crate) started: Instant,
}

/// What was done with which file, for run.json.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct Records {
    pub(crate) prior: ModelSource,
    /// What opened contacts.
    pub(crate) cut: Option<CutRecord>,
    /// The image in which candidates were looked at.
    pub(crate) image: Option<ImageRecord>,
    pub(crate) decisions: Option<Decided>,
}

impl Prepared {
    /// Samples the graph and decides. The options need not be those of [`Prepared::options`]: several may share one graph.
    ///
    /// # Errors
    ///
    /// As [`infer_with`](crate::infer_with).
    pub fn sample(self: &Arc<Self>, options: &SamplingOptions, progress: &mut dyn Follow) -> Result<Inference> {
        let options = &self.sampled_with(options);
        let until_stable = self.options.infer.until_stable;
        let begun = Instant::now();
        progress.step(Step::Sampling { graph: &self.graph, options, until_stable });
        let first = SamplingOptions { samples: if until_stable { FIRST_STABLE } else { options.samples }, ..options.clone() };
        let mut sampling = Sampling::new(&self.graph, &self.boundary, &first)?;
        let samples = sampling.samples();
        let fits = |part: &PartialRun| part.samples() == samples || until_stable && part.samples().is_power_of_two();
        let resumed = progress.resume(&self.key(options), sampling.part().uncertain(), &fits);
        let mut part = resumed.unwrap_or_else(|| sampling.part());
        let before = part.done();
        let sampled = if until_stable {
            sampling.until_stable(&mut part, |result| all_decided(self.keep, &self.graph, result), progress)
        } else {
            sampling.sample(&mut part, progress).map(|()| sampling.likelihood(&part))
        };
        progress.sampled(&part, sampled.is_ok());
        let seconds = begun.elapsed().as_secs_f64();
        let method = sampling.method();
        let rate = (part.done() - before) as f64 / seconds;
        let (threads, instructions) = (rayon::current_num_threads(), method.instructions);
        let time = json!({ "sampling_s": seconds, "samples_per_s": rate, "threads": threads, "instructions": instructions });
        self.decide(options, sampled?, method, time)
    }

    /// What there is to see of a run while it is at work: the answer of the samples that are finished, as if they were all. Which these are
    /// depends on the threads, so it is a look and not a result. `seconds` is how long they took.
    ///
    /// # Errors
    ///
    /// No sample is finished.
    pub fn so_far(self: &Arc<Self>, options: &SamplingOptions, part: &PartialRun, seconds: f64) -> Result<Inference> {
        let samples = part.done();
        if samples == 0 {
            return Err(Error::parameter("samples", samples, "expected finished ones"));
        }
        let options = SamplingOptions { samples, exact: false, ..self.sampled_with(options) };
        let sampling = Sampling::new(&self.graph, &self.boundary, &options)?;
        let time = json!({ "sampling_s": seconds, "samples_per_s": samples as f64 / seconds });
        self.decide(&options, sampling.likelihood(part), sampling.method(), time)
    }

    /// Where the priors come from.
    pub fn prior(&self) -> &ModelSource {
        &self.records.prior
    }

    /// The options with the prior of this input. The paper fixes where blood enters and leaves, so its preset and its loop do too.
    fn sampled_with(&self, options: &SamplingOptions) -> SamplingOptions {
        let by_the_paper =
            self.options.infer.preset == Preset::Paper || options.solver == Solver::Reference || self.uniform_prior;
        let found_conditions = if by_the_paper { FoundConditions::Fixed } else { options.found_conditions };
        SamplingOptions { uniform_prior: self.uniform_prior, found_conditions, ..options.clone() }
    }

    /// All that the samples depend on, as SHA-256: what is kept of a run is resumed under it.
    pub fn key(&self, options: &SamplingOptions) -> String {
        let options = self.sampled_with(options);
        let samples = (!self.options.infer.until_stable).then_some(options.samples);
        let (version, graph) = (env!("CARGO_PKG_VERSION"), self.graph_checksum());
        let options = SamplingOptions { samples: 0, ..options };
        let all = json!({ "willis": version, "graph": graph, "options": options, "samples": samples });
        checksum(all.to_string().as_bytes())
    }

    /// The SHA-256 of the graph with its conditions, exactly as they are sampled.
    pub(crate) fn graph_checksum(&self) -> String {
        let written = checksum_of(|out| {
            serde_json::to_writer(&mut *out, &self.graph)?;
            write!(out, "{:?}", self.boundary)
        });
        // Nothing fails here but the memory for a number.
        written.unwrap_or_default()
    }
}
