//! Where contacts of observed vessels are opened: by which model, with which mask.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::progress::{Follow, Step};
use super::source_file::{ModelSource, SourceFile, ending, of_word};
use willis_core::error::{Error, Result};
use willis_core::network::Network;
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::{ReadOptions, read_mask};
use willis_io::masks::{Field, Foreground, Scene};
use willis_models::candidates::resample::CenterlineKind;
use willis_models::contacts::model::ContactModel;
use willis_models::contacts::split::{Pairings, SuggestedCut, suggested_cuts};
use willis_models::contacts::with_contacts;

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
        match of_word(text) {
            Some(Self::File(path)) if ending(&path) != "toml" => {
                let accepted = did_you_mean(text, ["auto", "always", "never"]) + "expected auto, always, never, or a file .toml";
                Err(Error::parameter("cut", format!("\"{text}\""), accepted))
            }
            cut => Ok(cut.unwrap_or_default()),
        }
    }
}

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            word => word.serialize(f),
        }
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

/// The model and the mask by which contacts are opened.
pub(crate) struct Cuts {
    model: Arc<ContactModel>,
    field: Option<Field>,
    pub(crate) record: CutRecord,
}

impl Cuts {
    /// What the vessels of an input are cut by, `lumen` being the mask that they come from; `None` where they are not.
    ///
    /// # Errors
    ///
    /// A model or a mask that cannot be read.
    pub(crate) fn load(
        cut: &Cut,
        mask: Option<&Path>,
        network: &Network,
        lumen: Option<&Foreground>,
        kind: CenterlineKind,
    ) -> Result<Option<Self>> {
        let is_skeleton = kind == CenterlineKind::Skeleton;
        if *cut == Cut::Never || (*cut == Cut::Auto && !is_skeleton) || !network.has_positions() {
            return Ok(None);
        }
        let field = match mask {
            Some(path) => Foreground::of(&read_mask(path, &ReadOptions::default())?.in_scanner_order()).as_ref().map(Field::of),
            None => lumen.map(Field::of),
        };
        let (model, source) = match cut {
            Cut::File(path) => {
                let expected = "expected a model as `willis train --model contacts` writes it";
                let (model, source) = SourceFile::read_text(path, expected, ContactModel::read)?;
                (Arc::new(model), ModelSource::File(source))
            }
            _ => (ContactModel::shipped()?, ModelSource::Word("shipped".to_owned())),
        };
        let only_suggested = *cut == Cut::Auto && mask.is_none() && lumen.is_none();
        let record = CutRecord { model: source, mask: field.is_some(), only_suggested };
        Ok(Some(Self { model, field, record }))
    }

    /// The graph with its contacts opened and how their vessels may be paired, or the graph and the cuts that are only suggested. Beside
    /// them what to tell a person where P of contacts may be off.
    pub(crate) fn open(
        &self,
        graph: Network,
        scene: Option<&Scene>,
        follow: &mut dyn Follow,
    ) -> (Network, Contacts, Option<String>) {
        let (opened, note) = with_contacts(&graph, self.field.as_ref(), scene, &self.model);
        if self.record.only_suggested {
            let suggested = suggested_cuts(&graph, &opened);
            follow.step(Step::CutsSuggested { suggested: suggested.len() });
            return (graph, Contacts { pairings: Vec::new(), suggested }, note);
        }
        // Whether contacts are judged by the image too.
        let with_image = self.record.mask && self.model.image.is_some() && scene.is_some();
        follow.step(Step::Cut { graph: &opened.graph, with_mask: self.record.mask, with_image });
        (opened.graph, Contacts { pairings: opened.pairings, suggested: Vec::new() }, note)
    }
}
