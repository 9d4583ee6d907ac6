//! The options of a run: plain data, with the defaults of the command line, stored in run.json as they stand here.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::artery_options::{ArterySource, PhenotypeOptions};
use super::boundary_options::BoundaryOptions;
use super::cuts::Cut;
use super::prior::Prior;
use willis_core::decision::Keep;
use willis_core::error::Result;
use willis_core::flow::FoundOutlets;
use willis_core::sampling::{SamplingOptions, Uncertain};
use willis_io::formats::ReadOptions;
use willis_io::masks::Appearance;
use willis_models::candidates::{Attach, CandidateOptions, CandidateRadius};

/// How [`infer`](crate::infer) works. The default is what `willis infer` does.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct InferOptions {
    /// On whose choices the other fields rest; it changes nothing but what run.json says.
    pub preset: Preset,
    /// How candidates are built around fragments.
    pub candidates: CandidateOptions,
    /// How probable a candidate is before any flow; by default evidence on centerlines, and what the file states on a ready graph.
    pub prior: Option<Prior>,
    /// Whether observed vessels that may only touch are cut apart.
    pub cut: Cut,
    /// The mask that the centerlines were made of; one that is read itself needs none.
    pub mask: Option<PathBuf>,
    /// The image of the vessels, in which candidates are looked at.
    pub image: Option<PathBuf>,
    /// The probabilities of vessels that a segmenter gave, from 0 to 1, in which candidates are looked at in place of an image.
    pub probability: Option<PathBuf>,
    /// How vessels look in the image.
    pub vessels: Appearance,
    /// At how many of the most doubtful places at the most the page shows the image; 50 by default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub image_places: Option<usize>,
    /// Where blood enters and leaves.
    pub boundary: BoundaryOptions,
    /// Occlusion, samples, seed, viscosity.
    pub sampling: SamplingOptions,
    /// Whether samples are doubled until every decision is two standard errors from flipping, up to 2²⁰, whatever
    /// [`SamplingOptions::samples`] says.
    pub until_stable: bool,
    /// Which uncertain vessels stay; by default those of the most probable forest on tracings, the most probable candidates on
    /// skeletons, with the contacts that join two parts where contacts were found, and without evidence those above the median of L.
    pub keep: Option<Keep>,
    /// The decisions of a person, as the page of a run writes them: accepted connections are certain, rejected ones are gone.
    pub decisions: Option<PathBuf>,
    /// Where the arteries of a Circle of Willis are, where it is to be classified.
    pub arteries: Option<ArterySource>,
    /// What is known of people's circles before one is seen.
    pub phenotypes: PhenotypeOptions,
}

/// A set of choices.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Preset {
    /// Those of this program.
    #[default]
    Willis,
    /// Those of Moriconi et al. 2019.
    Paper,
}

impl InferOptions {
    /// Every choice as in Moriconi et al. 2019; where the paper is silent, as [`Default`]. Resistances that are stated at outlets stay, though the paper
    /// has ground only: a note says so.
    pub fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            candidates: CandidateOptions { attach: Attach::Ends, radius: CandidateRadius::Mean, ..CandidateOptions::default() },
            prior: Some(Prior::Uniform),
            boundary: BoundaryOptions { found_outlets: Some(FoundOutlets::Ground), ..BoundaryOptions::default() },
            sampling: SamplingOptions { uncertain: Uncertain::All, ..SamplingOptions::default() },
            keep: Some(Keep::Median),
            cut: Cut::Never,
            ..Self::default()
        }
    }

    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        self.candidates.validate()?;
        self.sampling.validate()?;
        self.phenotypes.validate()?;
        self.keep.map_or(Ok(()), Keep::validate)
    }
}

/// All options of a run, as run.json stores them.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RunOptions {
    /// How the input was read.
    pub read: ReadOptions,
    /// What was done with it.
    pub infer: InferOptions,
}

impl RunOptions {
    /// The options one by one under their own names, for two runs to be compared. Of a file that belongs to one subject
    /// only that there is one; a file of priors is known by its content: `prior` is the record of it, with its SHA-256.
    pub fn comparable(&self, prior: &Value) -> Value {
        let mut flat = serde_json::Map::new();
        flatten(serde_json::to_value(self).unwrap_or_default(), &mut flat);
        // What changes no figure.
        flat.remove("max_input");
        flat.remove("image_places");
        for (own, name) in [("loops", "loops"), ("conditions", "bc"), ("landmarks", "landmarks"), ("decisions", "decisions")] {
            let is_given = flat.remove(own).is_some_and(|path| !path.is_null());
            flat.insert(name.to_owned(), if is_given { "a file".into() } else { Value::Null });
        }
        if let Some(sha256) = prior.get("sha256") {
            flat.insert("prior".to_owned(), sha256.clone());
        }
        Value::Object(flat)
    }
}

fn flatten(value: Value, into: &mut serde_json::Map<String, Value>) {
    let Value::Object(fields) = value else { return };
    for (name, value) in fields {
        if value.is_object() { flatten(value, into) } else { drop(into.insert(name, value)) }
    }
}
