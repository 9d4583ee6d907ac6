//! What is known of an input before there are candidates, and the arteries and boundary conditions that follow from it and from a graph.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::arteries::{self, FoundArteries};
use super::artery_options::ArterySource;
use super::options::{InferOptions, Preset, RunOptions};
use super::progress::{Follow, Step};
use willis_core::error::Result;
use willis_core::flow::{Boundary, FoundOutlets, Given};
use willis_core::network::Network;
use willis_models::naming::Bearings;

/// What is known of an input before there are candidates. Its arteries and boundary conditions follow from it and from the graph, and do so
/// again when a person has decided on that.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct EarlyKnowledge {
    pub(crate) given: Vec<Given>,
    pub(crate) inlets_by_labels: Vec<usize>,
    pub(crate) arteries: EarlyArteries,
}

impl EarlyKnowledge {
    /// Whether it may be that of this graph, by the number of its nodes.
    pub(crate) fn fits(&self, graph: &Network) -> bool {
        self.given.iter().all(|given| given.node < graph.node_count())
            && !matches!(&self.arteries, EarlyArteries::Landmarks(found) if !found.circle.fits(graph))
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
        let known = arteries.map_or_else(|| self.inlets_by_labels.clone(), |found| found.known_inlets(graph));
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
    Geometry(FoundArteries, Bearings),
}
