//! What is ready to be sampled.

use std::io::Write;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};
use serde_json::json;

use super::arteries::FoundArteries;
use super::cuts::{Contacts, CutRecord};
use super::decisions::{Decidable, Decided};
use super::early::EarlyKnowledge;
use super::options::{Preset, RunOptions};
use super::picture::ImageRecord;
use super::source_file::ModelSource;
use willis_core::decision::Keep;
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::network::Network;
use willis_core::sampling::{FoundConditions, SamplingOptions, Solver};
use willis_io::formats::{checksum, checksum_of};
use willis_models::candidates::CandidateOptions;
use willis_report::{ImagePlace, Provenance, Segmentation};

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
    pub(crate) records: SourceRecords,
    /// What it shows along doubtful vessels.
    pub(crate) image_places: Vec<ImagePlace>,
    /// The segmentation that the vessels were found in, where they were.
    pub(crate) segmentation: Option<Segmentation>,
    /// What is known of the contacts beside their vessels.
    pub(crate) contacts: Contacts,
    pub(crate) uniform_prior: bool,
    /// The graph before a person decided on it; none where nobody did.
    #[serde(default)]
    pub(crate) undecided: Option<Arc<Decidable>>,
    pub(crate) early: EarlyKnowledge,
    /// How candidates were built; `None` for a ready graph.
    pub(crate) candidates: Option<CandidateOptions>,
    pub(crate) keep: Keep,
    pub(crate) arteries: Option<FoundArteries>,
    #[serde(skip, default = "Instant::now")]
    pub(crate) started: Instant,
}

/// What was done with which file, for run.json.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct SourceRecords {
    pub(crate) prior: ModelSource,
    /// What opened contacts.
    pub(crate) cut: Option<CutRecord>,
    /// The image in which candidates were looked at.
    pub(crate) image: Option<ImageRecord>,
    pub(crate) decisions: Option<Decided>,
}

impl Prepared {
    /// Where the priors come from.
    pub fn prior(&self) -> &ModelSource {
        &self.records.prior
    }

    /// The nodes whose conditions were stated, not found.
    pub(crate) fn given(&self) -> Vec<usize> {
        let conditions = self.boundary.conditions.iter().map(|(node, _)| *node);
        conditions.filter(|node| !self.boundary.is_found(*node)).collect()
    }

    /// The graph before a person decided on it.
    pub(crate) fn undecided_graph(&self) -> &Network {
        self.undecided.as_ref().map_or(&self.graph, |before| &before.graph)
    }

    /// The options with the prior of this input. The paper fixes where blood enters and leaves, so its preset and its loop do too.
    pub(crate) fn sampled_with(&self, options: &SamplingOptions) -> SamplingOptions {
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
