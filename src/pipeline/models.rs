//! The models of a run: how probable each candidate is before any flow, with the over-connected graph that follows from it, and where contacts
//! of observed vessels are opened.

use std::{fmt, path::Path, path::PathBuf, str::FromStr, sync::Arc};

use serde::{Deserialize, Serialize};

use super::{Follow, ModelSource, SourceFile, Step, of_word, require, source_file::ending};
use crate::{CandidateOptions, Error, Keep, Network, ReadOptions, Result};
use willis_core::decision::{BEST_FIRST, PRICE, RECONNECT, has_evidence, knows_fragments};
use willis_core::{flow::Given, network::Origin, network::Role, network::centerlines::Centerlines};
use willis_core::{support::geometry::Point, support::geometry::bounds, support::suggestions::did_you_mean};
use willis_io::formats::{read_mask, read_prior_csv, read_prior_npy};
use willis_io::masks::{Field, Foreground, Scene, Unseen, View};
use willis_models::candidates::{Looked, NEAREST, build, build_joins, build_with_evidence};
use willis_models::circle_of_willis::split_where_labels_change;
use willis_models::contacts::split::{SuggestedCut, suggested_cuts};
use willis_models::{
    candidates::joins::model::JoinModel, candidates::model::Weights, candidates::resample::CenterlineKind,
    contacts::model::ContactModel, contacts::split::Pairings, contacts::with_contacts,
};

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
        if let Self::File(path) = self { write!(f, "{}", path.display()) } else { self.serialize(f) }
    }
}

impl FromStr for Prior {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        const WORDS: [&str; 6] = ["evidence", "weights:tracing", "weights:tubes", "weights:skeleton", "none", "uniform"];
        let prior = of_word(text).unwrap_or(Self::Evidence);
        let is_known = if let Self::File(path) = &prior { ["toml", "npy", "csv"].contains(&&*ending(path)) } else { true };
        let (meant, words) = (did_you_mean(text, WORDS), WORDS.join(", "));
        let accepted = format!("{meant}expected {words}, or a file .toml, .npy or .csv");
        require(is_known, "prior", format!("\"{text}\""), accepted).map(|()| prior)
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
        if let PriorModel::Joins(model) = &self.model { model.image.as_ref().map(|image| image.noise) } else { None }
    }

    /// [`CandidateOptions::k`] where none is given.
    pub(crate) fn usual_k(&self) -> usize {
        if self.is_evidence() { willis_models::candidates::search::SearchOptions::default().branches } else { NEAREST }
    }

    /// The over-connected graph: candidates are built around fragments, given the stated conditions by node, vessels are divided where the names
    /// along their lines change, and every candidate gets its prior; without `building` the network stays as it is. The image as it was measured is told too, or why it says nothing; and what to tell a person where the model knows no such fragments.
    pub(crate) fn graph(
        &self,
        network: Network,
        named_lines: Option<&Centerlines>,
        given: &[Given],
        building: Option<&CandidateOptions>,
        view: Option<View>,
    ) -> Result<(Network, Option<Looked>, Option<String>)> {
        let (mut looked, mut unlike) = (None, None);
        let mut graph = match (&self.model, building) {
            (_, None) => network,
            (PriorModel::Evidence(weights), Some(options)) => {
                let inlets: Vec<usize> = given.iter().filter(|g| g.role == Role::Inlet).map(|g| g.node).collect();
                let (graph, note) = build_with_evidence(&network, &inlets, options, weights)?;
                unlike = note;
                graph
            }
            (PriorModel::Joins(model), Some(options)) => {
                let (graph, found) = build_joins(&network, options, model, view)?;
                looked = found;
                graph
            }
            (_, Some(options)) => build(&network, options)?,
        };
        if let (Some(lines), Some(options)) = (named_lines, building) {
            graph = split_where_labels_change(&graph, lines, options.radius_rule);
        }
        if let PriorModel::Table(bytes, path) = &self.model {
            let read = if ending(path) == "csv" { read_prior_csv } else { read_prior_npy };
            read(bytes, &mut graph).map_err(|fault| fault.in_file(path))?;
        }
        Ok((graph, looked, unlike))
    }
}

/// Whether observed vessels that may only touch are cut apart; as text `auto`, `always`, `never`, or the path of a model.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cut {
    /// On automatic skeletons where there is a mask; without one cuts are suggested.
    #[default]
    Auto,
    /// On any centerlines.
    Always,
    /// Nowhere.
    Never,
    /// As `always`, by a model of one's own (`.toml`, from `willis train --model contacts`).
    #[serde(untagged)]
    File(PathBuf),
}

impl FromStr for Cut {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let cut = of_word(text).unwrap_or_default();
        let is_known = if let Self::File(path) = &cut { ending(path) == "toml" } else { true };
        let accepted = did_you_mean(text, ["auto", "always", "never"]) + "expected auto, always, never, or a file .toml";
        require(is_known, "cut", format!("\"{text}\""), accepted).map(|()| cut)
    }
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Self::File(path) = self { write!(f, "{}", path.display()) } else { self.serialize(f) }
    }
}

/// What is known of the contacts of a graph beside their vessels.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(crate) struct Contacts {
    /// How the vessels of those that are opened may be paired.
    pub(crate) pairings: Vec<Pairings>,
    /// Those that are left together.
    pub(crate) suggested: Vec<SuggestedCut>,
}

/// What contacts are opened by, as run.json has it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct CutRecord {
    model: ModelSource,
    /// Whether there is a mask.
    pub(crate) mask: bool,
    /// Whether cuts are suggested and not made.
    pub(crate) only_suggested: bool,
}

/// Why a mask, whose depths are known, does not show vessels: most of their points are further than a voxel outside of its walls.
fn unseen_in(mask: &Foreground, field: &Field, vessels: &Network) -> Option<Unseen> {
    let places: Vec<Point> = vessels.places().collect();
    let inside = places.iter().filter(|place| field.signed(**place) > -field.voxel()).count();
    (2 * inside < places.len()).then(|| Unseen::by(mask.bounds(), bounds(places)))
}

/// The model and the mask by which contacts are opened.
pub(crate) struct Cuts {
    model: Arc<ContactModel>,
    field: Option<Field>,
    /// What a person should know of the mask: that it does not show the vessels.
    pub(crate) note: Option<String>,
    pub(crate) record: CutRecord,
}

impl Cuts {
    /// What the vessels of an input, which was read by `read`, are cut by; `lumen` is the mask that they come from; `None` where they are not.
    ///
    /// # Errors
    ///
    /// A model or a mask that cannot be read.
    pub fn load(
        cut: &Cut,
        mask: Option<&Path>,
        read: &ReadOptions,
        network: &Network,
        lumen: Option<&Foreground>,
        kind: CenterlineKind,
    ) -> Result<Option<Self>> {
        let is_skeleton = kind == CenterlineKind::Skeleton;
        if *cut == Cut::Never || (*cut == Cut::Auto && !is_skeleton) || !network.has_positions() {
            return Ok(None);
        }
        let read = ReadOptions { scale: read.scale, max_input: read.max_input, ..ReadOptions::default() };
        let beside = |path: &Path| Ok(Foreground::of(&read_mask(path, &read, network.frame)?.in_scanner_order()));
        let given: Option<Foreground> = mask.map(beside).transpose()?.flatten();
        let field = given.as_ref().map(Field::of);
        let unseen = given.zip(field.as_ref()).and_then(|(mask, field)| unseen_in(&mask, field, network));
        let field = field.filter(|_| unseen.is_none()).or_else(|| lumen.map(Field::of));
        let said = |(path, why): (&Path, Unseen)| {
            format!("{} does not show the vessels: {why}; contacts are judged without it", path.display())
        };
        let (model, source) = match cut {
            Cut::File(path) => {
                let expected = "expected a model as `willis train --model contacts` writes it";
                let (model, source) = SourceFile::read_text(path, expected, ContactModel::read)?;
                (Arc::new(model), ModelSource::File(source))
            }
            _ => (ContactModel::shipped()?, ModelSource::Word("shipped".to_owned())),
        };
        let only_suggested = *cut == Cut::Auto && field.is_none();
        let record = CutRecord { model: source, mask: field.is_some(), only_suggested };
        Ok(Some(Self { model, field, note: mask.zip(unseen).map(said), record }))
    }

    /// The graph with its contacts opened and how their vessels may be paired, or the graph and the cuts that are only suggested. Beside
    /// them what to tell a person where P of contacts may be off. `moved` hears the rows that nodes have now.
    pub fn open(
        &self,
        graph: Network,
        moved: impl FnOnce(&[usize]),
        scene: Option<&Scene>,
        follow: &mut dyn Follow,
    ) -> (Network, Contacts, Option<String>) {
        let (opened, note) = with_contacts(&graph, self.field.as_ref(), scene, &self.model);
        if self.record.only_suggested {
            let suggested = suggested_cuts(&graph, &opened);
            follow.step(Step::CutsSuggested { suggested: suggested.len() });
            return (graph, Contacts { pairings: Vec::new(), suggested }, note);
        }
        moved(&opened.node_now);
        // Whether contacts are judged by the image too.
        let with_image = self.record.mask && self.model.image.is_some() && scene.is_some();
        follow.step(Step::Cut { graph: &opened.graph, with_mask: self.record.mask, with_image });
        (opened.graph, Contacts { pairings: opened.pairings, suggested: Vec::new() }, note)
    }
}
