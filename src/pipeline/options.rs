//! The options of a run: plain data, with the defaults of the command line, stored in run.json as they stand here.

use std::path::{Path, PathBuf};

#[cfg(feature = "cli")]
use clap::ValueHint::FilePath;
use serde::de::value::StrDeserializer;
use serde::de::{DeserializeOwned, IntoDeserializer};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::arteries::ArterySource;
use super::boundary_options::BoundaryOptions;
use super::cuts::Cut;
use super::prior::Prior;
use super::pulse::PulseOptions;
use willis_core::decision::Keep;
use willis_core::error::{Error, Fault, Result};
use willis_core::flow::poiseuille::{BLOOD_VISCOSITY, check_viscosity};
use willis_core::flow::{FoundOutlets, Unfed};
use willis_core::sampling::{SamplingOptions, Uncertain};
use willis_io::formats::{ReadOptions, bytes_of, checksum};
use willis_io::masks::Appearance;
use willis_models::candidates::{Attach, CandidateOptions, CandidateRadius};
use willis_models::circle_of_willis::VariantFrequencies;
use willis_report::figures::{DEFAULT_DPI, check_dpi};

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

/// What is known of people's circles before one is seen.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "cli", derive(clap::Args))]
#[serde(default, deny_unknown_fields)]
pub struct PhenotypeOptions {
    /// How frequent each variant is among such people, in the place of the published table: a CSV file of missing,share
    #[serde(rename = "variant_prior")]
    #[cfg_attr(feature = "cli", arg(long = "variant-prior", value_name = "FILE.csv", value_hint = FilePath, hide_short_help = true))]
    pub frequencies: Option<PathBuf>,
    /// How often a segment that is there is not in the extraction at all [default: 0]
    #[cfg_attr(feature = "cli", arg(long, value_name = "SHARE", allow_negative_numbers = true, hide_short_help = true))]
    pub unseen: Option<f64>,
    /// A model of `willis train --model labels` that names the arteries, in the place of the one that ships
    #[cfg_attr(feature = "cli", arg(long, value_name = "MODEL.toml", value_hint = FilePath, hide_short_help = true))]
    pub arteries: Option<PathBuf>,
    /// The diameter below which a segment is hypoplastic [default: 1mm]
    // In m, positive.
    #[serde(rename = "hypoplastic_m")]
    #[cfg_attr(feature = "cli", arg(long, value_name = "DIAMETER", value_parser = diameter))]
    #[cfg_attr(feature = "cli", arg(allow_negative_numbers = true, hide_short_help = true))]
    pub hypoplastic: Option<f64>,
}

/// A diameter as a person types it, m.
#[cfg(feature = "cli")]
fn diameter(text: &str) -> std::result::Result<f64, String> {
    let diameter = willis_core::network::quantity::Dimension::Length.parse(text)?;
    if diameter > 0.0 { Ok(diameter) } else { Err("expected a positive diameter, such as 0.8mm".to_owned()) }
}

impl PhenotypeOptions {
    /// Checks every field that can be checked without a file.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        if let Some(share) = self.unseen.filter(|share| !(0.0..1.0).contains(share)) {
            return Err(Error::parameter("unseen", share, "expected a share from 0 to below 1"));
        }
        match self.hypoplastic.filter(|diameter| !(*diameter > 0.0 && diameter.is_finite())) {
            Some(diameter) => Err(Error::parameter("hypoplastic", diameter, "expected a positive diameter")),
            None => Ok(()),
        }
    }

    /// The same, with what is not said here as others say it.
    #[must_use]
    pub fn or(&self, others: &Self) -> Self {
        Self {
            frequencies: self.frequencies.clone().or_else(|| others.frequencies.clone()),
            unseen: self.unseen.or(others.unseen),
            arteries: self.arteries.clone().or_else(|| others.arteries.clone()),
            hypoplastic: self.hypoplastic.or(others.hypoplastic),
        }
    }

    /// Checks the files that are named, whether or not anything looks at them.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, or is not what it should be.
    pub(crate) fn check_files(&self) -> Result<()> {
        if self.frequencies.is_some() {
            self.prior()?;
        }
        if self.arteries.is_some() {
            self.models()?;
        }
        Ok(())
    }

    /// The models that name arteries.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is no model.
    pub(crate) fn models(&self) -> Result<willis_models::naming::NamingModels> {
        super::label::load_models(self.arteries.as_deref())
    }

    /// The prior that they mean.
    pub(crate) fn prior(&self) -> Result<willis_models::naming::Prior> {
        let frequencies = match &self.frequencies {
            Some(path) => VariantFrequencies::of_file(path)?,
            None => VariantFrequencies::published()?,
        };
        Ok(willis_models::naming::Prior { frequencies, is_own: self.frequencies.is_some(), unseen: self.unseen.unwrap_or(0.0) })
    }
}

/// How [`simulate`](crate::simulate) works.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct FlowOptions {
    /// Where blood enters and leaves.
    pub boundary: BoundaryOptions,
    /// Blood viscosity µ, Pa s, positive.
    #[serde(rename = "viscosity_Pa_s")]
    pub viscosity: f64,
    /// Whether to follow the blood: who feeds what, and when it arrives.
    pub transport: bool,
    /// How the flow pulsates; `None` leaves it steady.
    pub pulse: Option<PulseOptions>,
    /// What becomes of vessels that no inlet feeds.
    pub unfed: Unfed,
}

impl Default for FlowOptions {
    fn default() -> Self {
        let boundary = BoundaryOptions::default();
        Self { boundary, viscosity: BLOOD_VISCOSITY, transport: false, pulse: None, unfed: Unfed::Keep }
    }
}

impl FlowOptions {
    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check_viscosity(self.viscosity)?;
        self.pulse.as_ref().map_or(Ok(()), PulseOptions::validate)
    }
}

/// How an output folder is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SaveOptions {
    /// Resolution of the pictures, dots an inch, 30 to 1200.
    pub dpi: u32,
}

impl Default for SaveOptions {
    fn default() -> Self {
        Self { dpi: DEFAULT_DPI }
    }
}

impl SaveOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        check_dpi(self.dpi)
    }
}

/// The choice that serde writes as this word, or that a file of this name is.
pub(crate) fn of_word<T: DeserializeOwned>(word: &str) -> Option<T> {
    let word: StrDeserializer<'_, serde::de::value::Error> = word.into_deserializer();
    T::deserialize(word).ok()
}

/// The ending of a file, in small letters.
pub(crate) fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
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
        flat.remove("max_input");
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

/// A file that was read beside the input.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceFile {
    /// Its path as given.
    pub path: PathBuf,
    /// The SHA-256 of its bytes.
    pub sha256: String,
}

impl SourceFile {
    /// A file and what it holds.
    pub(crate) fn read(path: &Path) -> Result<(Vec<u8>, Self)> {
        let bytes = bytes_of(path)?;
        let sha256 = checksum(&bytes);
        Ok((bytes, Self { path: path.to_owned(), sha256 }))
    }

    /// A file of text, such as a model, and what `reader` makes of it; where it is no text, what was `expected`.
    pub(crate) fn read_text<T>(
        path: &Path,
        expected: &str,
        reader: impl FnOnce(&str) -> std::result::Result<T, Fault>,
    ) -> Result<(T, Self)> {
        let (bytes, source) = Self::read(path)?;
        let text = std::str::from_utf8(&bytes).map_err(|_| Fault::file("not UTF-8", expected));
        Ok((text.and_then(reader).map_err(|fault| fault.in_file(path))?, source))
    }
}

/// Where a model or a prior comes from, as run.json names it: a word for what ships with willis, or a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ModelSource {
    /// A word.
    Word(String),
    /// A file.
    File(SourceFile),
}
