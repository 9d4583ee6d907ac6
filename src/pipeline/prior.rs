//! The prior: how probable each candidate is before any flow, and the over-connected graph that follows from it.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::source_file::{ModelSource, SourceFile, ending, of_word};
use willis_core::decision::{BEST_FIRST, Keep, PRICE, RECONNECT, has_evidence, knows_fragments};
use willis_core::error::{Error, Result};
use willis_core::flow::Given;
use willis_core::network::{Network, Origin, Role};
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::{read_prior_csv, read_prior_npy};
use willis_io::masks::View;
use willis_models::candidates::joins::model::JoinModel;
use willis_models::candidates::model::Weights;
use willis_models::candidates::resample::CenterlineKind;
use willis_models::candidates::search::SearchOptions;
use willis_models::candidates::{CandidateOptions, Looked, NEAREST, build, build_joins, build_with_evidence};

/// Where the prior of candidates comes from; as text `evidence`, `weights:tracing`, `weights:tubes`, `weights:skeleton`, `none`, `uniform`,
/// or the path of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Prior {
    /// The model that ships with willis for such an input, as [`CenterlineKind::of`] tells them apart. Also `weights:auto`.
    #[serde(alias = "weights:auto")]
    Evidence,
    /// The model of tracings that ships with willis: fragments form a forest.
    #[serde(rename = "weights:tracing")]
    Tracing,
    /// The model of tubes that ships with willis: the same, of vessels that were drawn one by one.
    #[serde(rename = "weights:tubes")]
    Tubes,
    /// The model of automatic skeletons that ships with willis: candidates are judged one by one.
    #[serde(rename = "weights:skeleton")]
    Skeleton,
    /// What the file of the graph states.
    None,
    /// One everywhere, as in the paper.
    Uniform,
    /// A file: weights of the evidence (`.toml`, from `willis train`), or numbers from 0 to 1 for pairs of nodes or for vessels (`.npy`,
    /// `.csv`).
    #[serde(untagged)]
    File(PathBuf),
}

impl fmt::Display for Prior {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            word => word.serialize(f),
        }
    }
}

impl FromStr for Prior {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        const WORDS: [&str; 6] = ["evidence", "weights:tracing", "weights:tubes", "weights:skeleton", "none", "uniform"];
        match of_word(text) {
            Some(Self::File(path)) if !["toml", "npy", "csv"].contains(&ending(&path).as_str()) => {
                let (meant, words) = (did_you_mean(text, WORDS), WORDS.join(", "));
                let accepted = format!("{meant}expected {words}, or a file .toml, .npy or .csv");
                Err(Error::parameter("prior", format!("\"{text}\""), accepted))
            }
            prior => Ok(prior.unwrap_or(Self::Evidence)),
        }
    }
}

impl Prior {
    /// Reads the files of the prior, for an input of some kind.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or weights with a fault.
    pub(crate) fn load(&self, kind: CenterlineKind) -> Result<LoadedPrior> {
        let chosen = match (self, kind) {
            (Self::Evidence, CenterlineKind::Tracing) => &Self::Tracing,
            (Self::Evidence, CenterlineKind::Tubes) => &Self::Tubes,
            (Self::Evidence, CenterlineKind::Skeleton) => &Self::Skeleton,
            _ => self,
        };
        let Self::File(path) = chosen else {
            let model = match chosen {
                Self::Tubes => PriorModel::Evidence(Box::new(Weights::shipped_for_tubes()?)),
                Self::Skeleton => PriorModel::Joins(JoinModel::shipped()?),
                Self::None => PriorModel::None,
                Self::Uniform => PriorModel::Uniform,
                _ => PriorModel::Evidence(Box::new(Weights::shipped()?)),
            };
            return Ok(LoadedPrior { model, source: ModelSource::Word(chosen.to_string()) });
        };
        let (model, source) = if ending(path) == "toml" {
            SourceFile::read_text(path, "expected weights as `willis train` writes them", |text| {
                Ok(if JoinModel::is_one(text) {
                    PriorModel::Joins(Arc::new(JoinModel::read(text)?))
                } else {
                    PriorModel::Evidence(Box::new(Weights::read(text)?))
                })
            })?
        } else {
            let (bytes, source) = SourceFile::read(path)?;
            (PriorModel::Table(bytes, path.clone()), source)
        };
        Ok(LoadedPrior { model, source: ModelSource::File(source) })
    }
}

/// A prior whose files have been read.
pub(crate) struct LoadedPrior {
    model: PriorModel,
    /// The record in run.json: the word, or the file with its checksum.
    pub(crate) source: ModelSource,
}

/// What says how probable candidates are.
enum PriorModel {
    /// A model of the evidence.
    Evidence(Box<Weights>),
    /// A model of joins on skeletons.
    Joins(Arc<JoinModel>),
    /// What the file of the graph states.
    None,
    /// One everywhere.
    Uniform,
    /// A matrix or table, and its file.
    Table(Vec<u8>, PathBuf),
}

impl LoadedPrior {
    pub(crate) fn is_evidence(&self) -> bool {
        matches!(self.model, PriorModel::Evidence(_) | PriorModel::Joins(_))
    }

    pub(crate) fn is_uniform(&self) -> bool {
        matches!(self.model, PriorModel::Uniform)
    }

    /// The rule that decides where none is given.
    pub(crate) fn usual_rule(&self, graph: &Network) -> Keep {
        match self.model {
            _ if graph.vessels().any(|(_, v)| v.origin == Origin::Contact) => Keep::Reconnect(RECONNECT),
            PriorModel::Joins(_) => Keep::BestFirst(BEST_FIRST),
            _ if knows_fragments(graph) => Keep::Probable(PRICE),
            _ if has_evidence(graph) => Keep::BestFirst(BEST_FIRST),
            _ => Keep::Median,
        }
    }

    /// The least and the most noise of the images that the model of candidates was fitted to, as shares of the contrast of vessels;
    /// none of a model that does not look at images.
    pub(crate) fn noise_of_images(&self) -> Option<[f64; 2]> {
        match &self.model {
            PriorModel::Joins(model) => model.image.as_ref().map(|image| image.noise),
            _ => None,
        }
    }

    /// [`CandidateOptions::k`] where none is given.
    pub(crate) fn usual_k(&self) -> usize {
        if self.is_evidence() { SearchOptions::default().branches } else { NEAREST }
    }

    /// The over-connected graph: candidates are built around fragments, given the stated conditions by node, and every candidate gets its prior. The image as it was
    /// measured is told too, or why it says nothing; and what to tell a person where the model knows no such fragments.
    pub(crate) fn graph(
        &self,
        network: Network,
        is_fragments: bool,
        given: &[Given],
        options: &CandidateOptions,
        view: Option<View>,
    ) -> Result<(Network, Option<Looked>, Option<String>)> {
        let (mut looked, mut unlike) = (None, None);
        let mut graph = match &self.model {
            _ if !is_fragments => network,
            PriorModel::Evidence(weights) => {
                let inlets: Vec<usize> = given.iter().filter(|g| g.role == Role::Inlet).map(|g| g.node).collect();
                let (graph, note) = build_with_evidence(&network, &inlets, options, weights)?;
                unlike = note;
                graph
            }
            PriorModel::Joins(model) => {
                let (graph, found) = build_joins(&network, options, model, view)?;
                looked = found;
                graph
            }
            _ => build(&network, options)?,
        };
        if let PriorModel::Table(bytes, path) = &self.model {
            let read = if ending(path) == "csv" { read_prior_csv } else { read_prior_npy };
            read(bytes, &mut graph).map_err(|fault| fault.in_file(path))?;
        }
        Ok((graph, looked, unlike))
    }
}
