//! What is ready to be sampled, and what of it was known before there were candidates.

use std::{borrow::Cow, collections::BTreeMap, io::Write, path::Path, sync::Arc, time::Instant};

use serde::{Deserialize, Serialize};

use super::arteries::{self, FoundArteries};
use super::decisions::{Decidable, Decided};
use super::models::{Contacts, CutRecord};
use super::{ArterySource, Follow, InferOptions, ModelSource, Preset, RunOptions, Step, picture::ImageRecord};
use crate::{CandidateOptions, FoundConditions, FoundOutlets, Keep, Network, Result, SamplingOptions, Solver};
use willis_core::{flow::Boundary, flow::Given, support::distinct};
use willis_io::formats::{checksum, checksum_of};
use willis_report::{ImagePlace, Provenance, Segmentation};

/// An input made ready to be sampled: the over-connected graph and its boundary conditions, with everything that its files say.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Prepared {
    /// The over-connected graph.
    pub graph: Network,
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

    /// The graph with a person's edits and none of the decisions on connections, where it has the same rows; none where nobody decided.
    pub(crate) fn without_decisions(&self) -> Option<Cow<'_, Network>> {
        let (before, decided) = self.undecided.as_deref().zip(self.records.decisions.as_ref())?;
        if decided.edits.is_empty() {
            return Some(Cow::Borrowed(&before.graph));
        }
        let edited = before.clone().decided(&Decided { made: Vec::new(), ..decided.clone() }).ok()?.graph;
        (edited.vessel_count() == self.graph.vessel_count()).then_some(Cow::Owned(edited))
    }

    /// The options with the prior of this input. The paper fixes where blood enters and leaves, so its preset and its loop do too.
    pub(crate) fn sampled_with(&self, options: &SamplingOptions) -> SamplingOptions {
        let by_paper = self.options.infer.preset == Preset::Paper || options.solver == Solver::Reference || self.uniform_prior;
        let found_conditions = if by_paper { FoundConditions::Fixed } else { options.found_conditions };
        SamplingOptions { uniform_prior: self.uniform_prior, found_conditions, ..options.clone() }
    }

    /// All that the samples depend on, as SHA-256: what is kept of a run is resumed under it.
    pub fn key(&self, options: &SamplingOptions) -> String {
        let options = self.sampled_with(options);
        let samples = (!self.options.infer.until_stable).then_some(options.samples);
        // The graph with its conditions, exactly as they are sampled. Nothing fails here but the memory for a number.
        let graph = checksum_of(|out| {
            serde_json::to_writer(&mut *out, &self.graph)?;
            write!(out, "{:?}", self.boundary)
        });
        let (version, graph) = (env!("CARGO_PKG_VERSION"), graph.unwrap_or_default());
        let options = SamplingOptions { samples: 0, ..options };
        let all = serde_json::json!({ "willis": version, "graph": graph, "options": options, "samples": samples });
        checksum(all.to_string().as_bytes())
    }
}

/// What is known of an input before there are candidates. Its arteries and boundary conditions follow from it and from the graph, and do so
/// again when a person has decided on that.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct EarlyKnowledge {
    /// How many of its first nodes an input states as such; centerlines state points.
    pub(crate) own_nodes: usize,
    pub(crate) given: Vec<Given>,
    pub(crate) inlets_by_labels: Vec<usize>,
    pub(crate) arteries: EarlyArteries,
}

impl EarlyKnowledge {
    /// The same where each node has another row, that of the node that stands for it where it is gone.
    pub(crate) fn follow(&mut self, node_now: &[usize]) {
        self.own_nodes = distinct(node_now[..self.own_nodes].iter().copied()).len();
        let now = self.given.iter().rev().map(|given| (node_now[given.node], Given { node: node_now[given.node], ..*given }));
        self.given = now.collect::<BTreeMap<usize, Given>>().into_values().collect();
        self.inlets_by_labels.iter_mut().for_each(|node| *node = node_now[*node]);
        if let EarlyArteries::Landmarks(found) = &mut self.arteries {
            found.circle.follow(node_now);
        }
    }

    /// The arteries of a graph of the input at this path.
    pub(crate) fn arteries(&self, graph: &Network, path: &Path, run: &RunOptions) -> Result<Option<FoundArteries>> {
        let phenotypes = &run.infer.phenotypes;
        match (&self.arteries, &run.infer.arteries) {
            (EarlyArteries::Landmarks(found), _) => found.clone().with_names(graph, phenotypes).map(Some),
            (EarlyArteries::Geometry(_, bearings), _) => {
                arteries::by_geometry(path, graph, Some(bearings), &phenotypes.models()?).map(Some)
            }
            (EarlyArteries::Nothing, None | Some(ArterySource::Geometry)) => Ok(None),
            (EarlyArteries::Nothing, Some(labels)) => labels.find(path, graph, &run.read.scale, phenotypes).map(Some),
        }
    }

    /// The stated conditions of a graph, and those that are found: not where a candidate probably leaves.
    pub(crate) fn boundary(
        &self,
        graph: &Network,
        arteries: Option<&FoundArteries>,
        outlets: FoundOutlets,
        options: &InferOptions,
        follow: &mut dyn Follow,
    ) -> Result<Boundary> {
        let known = arteries.map_or_else(|| self.inlets_by_labels.clone(), |found| found.circle.labelled_inlets(graph));
        let boundary = Boundary::resolve_knowing(graph, &self.given, outlets, &known)?;
        let all_stated = boundary.found_outlets.is_empty() && arteries.is_none_or(|found| found.circle.outlets().is_empty());
        if options.preset == Preset::Willis && options.boundary.found_outlets.is_some() && all_stated {
            follow.step(Step::OutletsAllStated);
        }
        follow.step(Step::Boundary { graph, boundary: &boundary });
        Ok(boundary)
    }
}

/// What is known of the arteries before there are candidates: where they enter and leave is a boundary condition.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) enum EarlyArteries {
    /// Nothing: labels are looked at when every vessel has its row.
    Nothing,
    /// By landmarks, found before candidates make new nodes.
    Landmarks(FoundArteries),
    /// By geometry: where they lie was found with the candidates of a first over-connected graph, which pass names over gaps.
    Geometry(FoundArteries, willis_models::naming::Bearings),
}
