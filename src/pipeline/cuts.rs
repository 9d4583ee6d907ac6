//! Where contacts of observed vessels are opened: by which model, with which mask.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::Input;
use super::options::SourceFile;
use willis_core::error::{Error, Fault, Result};
use willis_core::network::Network;
use willis_core::support::suggestions::did_you_mean;
use willis_io::formats::{ReadOptions, bytes_of, checksum, read_mask};
use willis_io::masks::{Field, Foreground, Scene};
use willis_models::candidates::kind::Kind;
use willis_models::contacts::model::ContactModel;
use willis_models::contacts::pairings::Pairings;
use willis_models::contacts::suggested_cuts::{SuggestedCut, suggested_cuts};
use willis_models::contacts::with_contacts;

/// Whether observed vessels that may only touch are cut apart; as text `auto`, `always`, `never`, or the path of a model.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum Cut {
    /// On automatic skeletons where there is a mask; without one cuts are suggested.
    #[default]
    Auto,
    /// On any centerlines.
    Always,
    /// Nowhere.
    Never,
    /// As `always`, by a model of one's own (`.toml`, from `willis train --model contacts`).
    File(PathBuf),
}

const WORDS: [(&str, Cut); 3] = [("auto", Cut::Auto), ("always", Cut::Always), ("never", Cut::Never)];

impl fmt::Display for Cut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, WORDS.iter().find(|(_, cut)| cut == self)) {
            (_, Some((word, _))) => f.write_str(word),
            (Self::File(path), _) => write!(f, "{}", path.display()),
            _ => Ok(()),
        }
    }
}

impl From<Cut> for String {
    fn from(cut: Cut) -> Self {
        cut.to_string()
    }
}

impl TryFrom<String> for Cut {
    type Error = Error;

    fn try_from(text: String) -> Result<Self> {
        text.parse()
    }
}

impl FromStr for Cut {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some((_, cut)) = WORDS.into_iter().find(|(word, _)| *word == text) {
            return Ok(cut);
        }
        if Path::new(text).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            return Ok(Self::File(text.into()));
        }
        let meant = did_you_mean(text, WORDS.map(|(word, _)| word));
        Err(Error::parameter("cut", format!("\"{text}\""), format!("{meant}expected auto, always, never, or a file .toml")))
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

/// The model and the mask by which contacts are opened.
pub(crate) struct Cuts {
    model: Arc<ContactModel>,
    source: Option<SourceFile>,
    field: Option<Field>,
    /// Whether cuts are suggested and not made.
    only_suggests: bool,
}

impl Cuts {
    /// What an input is cut by; `None` where it is not.
    ///
    /// # Errors
    ///
    /// A model or a mask that cannot be read.
    pub(crate) fn load(cut: &Cut, mask: Option<&Path>, input: &Input, kind: Kind) -> Result<Option<Self>> {
        let wanted = match cut {
            Cut::Never => false,
            Cut::Auto => kind == Kind::Skeleton,
            Cut::Always | Cut::File(_) => true,
        };
        let only_suggests = *cut == Cut::Auto && mask.is_none() && input.lumen.is_none();
        if !wanted || !input.is_fragments || !input.network.has_positions() {
            return Ok(None);
        }
        let field = match mask {
            Some(path) => Foreground::of(&read_mask(path, &ReadOptions::default())?.in_scanner_order()).as_ref().map(Field::of),
            None => input.lumen.as_ref().map(Field::of),
        };
        let (model, source) = match cut {
            Cut::File(path) => {
                let bytes = bytes_of(path)?;
                let not_utf8 = |_| Fault::file("not UTF-8", "expected a model as `willis train --model contacts` writes it");
                let text = std::str::from_utf8(&bytes).map_err(not_utf8).map_err(|fault| fault.in_file(path))?;
                let model = ContactModel::read(text).map_err(|fault| fault.in_file(path))?;
                (Arc::new(model), Some(SourceFile { path: path.clone(), sha256: checksum(&bytes) }))
            }
            _ => (ContactModel::shipped()?, None),
        };
        Ok(Some(Self { model, source, field, only_suggests }))
    }

    /// The graph with its contacts opened and how their vessels may be paired, or the graph and the cuts that are only suggested. Beside
    /// them what to tell a person where P of contacts may be off.
    pub(crate) fn open(&self, graph: Network, scene: Option<&Scene>) -> (Network, Contacts, Option<String>) {
        let (opened, note) = with_contacts(&graph, self.field.as_ref(), scene, &self.model);
        if !self.only_suggests {
            return (opened.graph, Contacts { pairings: opened.pairings, suggested: Vec::new() }, note);
        }
        let suggested = suggested_cuts(&graph, &opened);
        (graph, Contacts { pairings: Vec::new(), suggested }, note)
    }

    /// Whether cuts are suggested and not made.
    pub(crate) fn only_suggests(&self) -> bool {
        self.only_suggests
    }

    /// Whether there is a mask.
    pub(crate) fn has_mask(&self) -> bool {
        self.field.is_some()
    }

    /// Whether contacts are judged by this image.
    pub(crate) fn looks_at(&self, scene: Option<&Scene>) -> bool {
        self.has_mask() && self.model.image.is_some() && scene.is_some()
    }

    /// The record in run.json.
    pub(crate) fn record(&self) -> Value {
        let model = self.source.as_ref().map_or(json!("shipped"), |source| json!(source));
        json!({ "model": model, "mask": self.field.is_some(), "only_suggested": self.only_suggests })
    }
}
