//! The prior: how probable each candidate is before any flow, and the over-connected graph that follows from it.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::options::SourceFile;
use willis_core::decision::{BEST_FIRST, Keep, PRICE, RECONNECT, has_evidence, knows_fragments};
use willis_core::error::{Error, Fault, Result};
use willis_core::flow::Given;
use willis_core::network::{Network, Origin, Role};
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::{bytes_of, checksum, read_prior_csv, read_prior_npy};
use willis_io::masks::View;
use willis_models::candidates::joins::model::JoinModel;
use willis_models::candidates::kind::Kind;
use willis_models::candidates::model::Weights;
use willis_models::candidates::search::SearchOptions;
use willis_models::candidates::{CandidateOptions, Looked, NEAREST, build, build_joins, build_with_evidence};

/// Where the prior of candidates comes from; as text `evidence`, `weights:tracing`, `weights:tubes`, `weights:skeleton`, `none`, `uniform`,
/// or the path of a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Prior {
    /// The model that ships with willis for such an input, as [`Kind::of`] tells them apart. Also `weights:auto`.
    Evidence,
    /// The model of tracings that ships with willis: fragments form a forest.
    Tracing,
    /// The model of tubes that ships with willis: the same, of vessels that were drawn one by one.
    Tubes,
    /// The model of automatic skeletons that ships with willis: candidates are judged one by one.
    Skeleton,
    /// What the file of the graph states.
    None,
    /// One everywhere, as in the paper.
    Uniform,
    /// A file: weights of the evidence (`.toml`, from `willis train`), or numbers from 0 to 1 for pairs of nodes or for vessels (`.npy`,
    /// `.csv`).
    File(PathBuf),
}

const WORDS: [(&str, Prior); 6] = [
    ("evidence", Prior::Evidence),
    ("weights:tracing", Prior::Tracing),
    ("weights:tubes", Prior::Tubes),
    ("weights:skeleton", Prior::Skeleton),
    ("none", Prior::None),
    ("uniform", Prior::Uniform),
];
/// Another word for the choice by the input.
const AUTOMATIC: &str = "weights:auto";

impl fmt::Display for Prior {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, WORDS.iter().find(|(_, prior)| prior == self)) {
            (_, Some((word, _))) => f.write_str(word),
            (Self::File(path), _) => write!(f, "{}", path.display()),
            _ => Ok(()),
        }
    }
}

impl From<Prior> for String {
    fn from(prior: Prior) -> Self {
        prior.to_string()
    }
}

impl TryFrom<String> for Prior {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl FromStr for Prior {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some((_, prior)) = WORDS.into_iter().find(|(word, _)| *word == text) {
            return Ok(prior);
        }
        if text == AUTOMATIC {
            return Ok(Self::Evidence);
        }
        if matches!(ending(Path::new(text)).as_str(), "toml" | "npy" | "csv") {
            return Ok(Self::File(text.into()));
        }
        let meant = did_you_mean(text, WORDS.map(|(word, _)| word));
        let accepted = format!(
            "{meant}expected evidence, weights:tracing, weights:tubes, weights:skeleton, none, uniform, or a file .toml, .npy or .csv"
        );
        Err(Error::parameter("prior", format!("\"{text}\""), accepted))
    }
}

fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

impl Prior {
    /// Reads the files of the prior, for an input of some kind.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or weights with a fault.
    pub(crate) fn load(&self, kind: Kind) -> Result<LoadedPrior> {
        let path = match self {
            Self::Evidence => {
                return match kind {
                    Kind::Tracing => Self::Tracing,
                    Kind::Tubes => Self::Tubes,
                    Kind::Skeleton => Self::Skeleton,
                }
                .load(kind);
            }
            Self::Tracing => {
                return Ok(LoadedPrior::Evidence { weights: Box::new(Weights::shipped()?), record: json!(self) });
            }
            Self::Tubes => {
                return Ok(LoadedPrior::Evidence { weights: Box::new(Weights::shipped_for_tubes()?), record: json!(self) });
            }
            Self::Skeleton => return Ok(LoadedPrior::Joins { model: JoinModel::shipped()?, record: json!(self) }),
            Self::None => return Ok(LoadedPrior::None),
            Self::Uniform => return Ok(LoadedPrior::Uniform),
            Self::File(path) => path,
        };
        let bytes = bytes_of(path)?;
        let source = SourceFile { path: path.clone(), sha256: checksum(&bytes) };
        if ending(path) != "toml" {
            return Ok(LoadedPrior::Table { bytes, source });
        }
        let fault = |_| Fault::file("not UTF-8", "expected weights as `willis train` writes them").in_file(path);
        let text = std::str::from_utf8(&bytes).map_err(fault)?;
        if JoinModel::is_one(text) {
            let model = Arc::new(JoinModel::read(text).map_err(|fault| fault.in_file(path))?);
            return Ok(LoadedPrior::Joins { model, record: json!(source) });
        }
        let weights = Box::new(Weights::read(text).map_err(|fault| fault.in_file(path))?);
        Ok(LoadedPrior::Evidence { weights, record: json!(source) })
    }
}

/// A prior whose files have been read.
pub(crate) enum LoadedPrior {
    /// A model of the evidence, and how run.json names it.
    Evidence { weights: Box<Weights>, record: Value },
    /// A model of joins on skeletons, likewise.
    Joins { model: Arc<JoinModel>, record: Value },
    /// What the file of the graph states.
    None,
    /// One everywhere.
    Uniform,
    /// A matrix or table.
    Table { bytes: Vec<u8>, source: SourceFile },
}

impl LoadedPrior {
    pub(crate) fn is_evidence(&self) -> bool {
        matches!(self, Self::Evidence { .. } | Self::Joins { .. })
    }

    /// The rule that decides where none is given.
    pub(crate) fn usual_rule(&self, graph: &Network) -> Keep {
        match self {
            _ if graph.vessels().any(|(_, v)| v.origin == Origin::Contact) => Keep::Reconnect(RECONNECT),
            Self::Joins { .. } => Keep::BestFirst(BEST_FIRST),
            _ if knows_fragments(graph) => Keep::Probable(PRICE),
            _ if has_evidence(graph) => Keep::BestFirst(BEST_FIRST),
            _ => Keep::Median,
        }
    }

    /// The record in run.json: the word, or the file with its checksum.
    pub(crate) fn record(&self) -> Value {
        match self {
            Self::None => json!("none"),
            Self::Uniform => json!("uniform"),
            Self::Evidence { record, .. } | Self::Joins { record, .. } => record.clone(),
            Self::Table { source, .. } => json!(source),
        }
    }

    /// Whether candidates are judged by an image too.
    pub(crate) fn looks_at_images(&self) -> bool {
        matches!(self, Self::Joins { model, .. } if model.image.is_some())
    }

    /// The least and the most noise of the images that the model of candidates was fitted to, as shares of the contrast of vessels.
    pub(crate) fn noise_of_images(&self) -> Option<[f64; 2]> {
        match self {
            Self::Joins { model, .. } => model.image.as_ref().map(|image| image.noise),
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
        let mut graph = match self {
            _ if !is_fragments => network,
            Self::Evidence { weights, .. } => {
                let inlets: Vec<usize> = given.iter().filter(|g| g.role == Role::Inlet).map(|g| g.node).collect();
                let (graph, note) = build_with_evidence(&network, &inlets, options, weights)?;
                unlike = note;
                graph
            }
            Self::Joins { model, .. } => {
                let (graph, found) = build_joins(&network, options, model, view)?;
                looked = found;
                graph
            }
            _ => build(&network, options)?,
        };
        if let Self::Table { bytes, source } = self {
            let read = if ending(&source.path) == "csv" { read_prior_csv } else { read_prior_npy };
            read(bytes, &mut graph).map_err(|fault| fault.in_file(&source.path))?;
        }
        Ok((graph, looked, unlike))
    }
}
