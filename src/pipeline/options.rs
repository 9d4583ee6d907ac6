//! The options of runs and simulations: plain data, with the defaults of the command line, stored in run.json as they stand here.

use std::path::{Path, PathBuf};

#[cfg(feature = "cli")]
use clap::ValueHint::FilePath;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{BoundaryOptions, Cut, Prior, SourceFile, require};
use crate::{
    Appearance, Attach, CandidateOptions, CandidateRadius, FoundOutlets, Friction, Keep, LabelScheme, ReadOptions, Result,
    SamplingOptions, Uncertain, Unfed, WallLaw,
};
use willis_core::flow::poiseuille::{BLOOD_VISCOSITY, check_viscosity};
use willis_core::{flow::state::BLOOD_DENSITY, network::Windkessel};
use willis_io::formats::check_name;
use willis_models::{circle_of_willis::VariantFrequencies, naming, naming::NamingModel, naming::NamingModels};

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
        let candidates = CandidateOptions { attach: Attach::Ends, radius: CandidateRadius::Mean, ..CandidateOptions::default() };
        let boundary = BoundaryOptions { found_outlets: Some(FoundOutlets::Ground), ..BoundaryOptions::default() };
        let sampling = SamplingOptions { uncertain: Uncertain::All, ..SamplingOptions::default() };
        Self {
            preset: Preset::Paper,
            candidates,
            prior: Some(Prior::Uniform),
            boundary,
            sampling,
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
        self.files().iter().try_for_each(|file| check_name(file))?;
        self.keep.map_or(Ok(()), Keep::validate)
    }

    /// Every file that they name, all of which go into a result.
    pub(crate) fn files(&self) -> Vec<PathBuf> {
        let prior = if let Some(Prior::File(path)) = &self.prior { Some(path) } else { None };
        let cut = if let Cut::File(path) = &self.cut { Some(path) } else { None };
        let landmarks = if let Some(ArterySource::Landmarks(path)) = &self.arteries { Some(path) } else { None };
        let images = [&self.mask, &self.image, &self.probability].map(Option::as_ref);
        let others = [self.boundary.conditions.as_ref(), prior, cut, landmarks, self.decisions.as_ref()];
        others.into_iter().chain(images).flatten().cloned().chain(self.phenotypes.files()).collect()
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
        let own = ["landmarks", "decisions", "mask", "image", "probability"].map(|name| (name, name));
        for (own, name) in [("loops", "loops"), ("conditions", "bc")].into_iter().chain(own) {
            let is_given = flat.remove(own).is_some_and(|path| !path.is_null());
            flat.insert(name.to_owned(), if is_given { "a file".into() } else { Value::Null });
        }
        if self.infer.arteries == Some(ArterySource::Geometry) {
            // Not under `arteries`, which is the model that names them.
            flat.insert("landmarks".to_owned(), "auto".into());
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
    /// Whether to close each vessel in turn.
    pub occlude_each: bool,
    /// How the flow pulsates; `None` leaves it steady.
    pub pulse: Option<PulseOptions>,
    /// What becomes of vessels that no inlet feeds.
    pub unfed: Unfed,
}

impl Default for FlowOptions {
    fn default() -> Self {
        let boundary = BoundaryOptions::default();
        Self { boundary, viscosity: BLOOD_VISCOSITY, transport: false, occlude_each: false, pulse: None, unfed: Unfed::Keep }
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

/// How the flow pulsates. The default is what `willis simulate --pulse` does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PulseOptions {
    /// What drives the inlets: a table of one period for all of them (`FILE`) or for one (`NODE=FILE`), or in the place of a file
    /// `carotid`, `vertebral` or `typical`, shapes of the flow whose mean is the steady flow there. Without any: `typical`.
    pub waveforms: Vec<String>,
    /// The period T, s, positive; by default what the tables mean.
    #[serde(rename = "period_s")]
    pub period: Option<f64>,
    /// The mean of every waveform that is a table: a pressure is shifted to it, a flow scaled to it.
    pub mean: Option<PulseMean>,
    /// How many harmonics are solved, 1 to 1000.
    pub harmonics: usize,
    /// The law of the walls; by default what the vessels state, or Olufsen's law where none does.
    pub wall: Option<WallLaw>,
    /// φ of a Kelvin-Voigt wall, s; 0 of an elastic one.
    #[serde(rename = "wall_viscosity_s")]
    pub wall_viscosity: f64,
    /// RC of outlets with a terminal resistance that state no compliance, s, positive; `None` leaves them resistances.
    #[serde(rename = "time_constant_s")]
    pub time_constant: Option<f64>,
    /// The profile by which the flow meets friction.
    pub friction: Friction,
    /// Density of blood ρ, kg/m³, positive.
    #[serde(rename = "density_kg_per_m3")]
    pub density: f64,
    /// At how many even times of the period waveforms are written, 10 to 10000.
    pub times: usize,
}

/// What the mean of a waveform becomes.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum PulseMean {
    /// Pa.
    #[serde(rename = "pressure_Pa")]
    Pressure(f64),
    /// m³/s.
    #[serde(rename = "flow_m3_per_s")]
    Flow(f64),
}

impl Default for PulseOptions {
    fn default() -> Self {
        Self {
            waveforms: Vec::new(),
            period: None,
            mean: None,
            harmonics: 40,
            wall: None,
            wall_viscosity: 0.0,
            time_constant: Some(Windkessel::TIME_CONSTANT),
            friction: Friction::default(),
            density: BLOOD_DENSITY,
            times: 100,
        }
    }
}

impl PulseOptions {
    /// Checks every field that can be checked without an input.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        let positive = |name: &str, value: Option<f64>, unit: &str| {
            let x = value.unwrap_or(1.0);
            require(x.is_finite() && x > 0.0, name, x, format!("expected a positive number of {unit}"))
        };
        positive("period", self.period, "s")?;
        positive("windkessel", self.time_constant, "s")?;
        positive("density", Some(self.density), "kg/m3")?;
        let x = self.wall_viscosity;
        require(x.is_finite() && x >= 0.0, "wall_viscosity", x, "expected zero or a positive number of s")?;
        require((1..=1000).contains(&self.harmonics), "harmonics", self.harmonics, "expected a number from 1 to 1000")?;
        require((10..=10_000).contains(&self.times), "times", self.times, "expected a number from 10 to 10000")
    }
}

/// How the arteries of a Circle of Willis are known.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ArterySource {
    /// By the labels of vessels: names, or numbers where only one list has them.
    #[default]
    AnyLabels,
    /// By labels of this kind.
    Labels(LabelScheme),
    /// By the labels of vessels where they name arteries, else by their geometry alone.
    Automatic,
    /// By their geometry alone: `landmarks` auto. [`infer`](crate::infer) goes without where they show no circle.
    Geometry,
    /// By a file of landmarks: CSV of `label,x_mm,y_mm,z_mm`, or `x,y,z` in the unit of the input, or a point list of 3D Slicer
    /// (`.mrk.json`, `.fcsv`).
    Landmarks(PathBuf),
}

impl ArterySource {
    /// The file that says it.
    pub(crate) fn file(&self) -> Option<&Path> {
        if let Self::Landmarks(path) = self { Some(path) } else { None }
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
        let (share, diameter) = (self.unseen.unwrap_or(0.0), self.hypoplastic.unwrap_or(1.0));
        require((0.0..1.0).contains(&share), "unseen", share, "expected a share from 0 to below 1")?;
        require(diameter > 0.0 && diameter.is_finite(), "hypoplastic", diameter, "expected a positive diameter")
    }

    /// The same, with what is not said here as others say it.
    #[must_use]
    pub fn or(&self, others: &Self) -> Self {
        let frequencies = self.frequencies.clone().or_else(|| others.frequencies.clone());
        let arteries = self.arteries.clone().or_else(|| others.arteries.clone());
        let (unseen, hypoplastic) = (self.unseen.or(others.unseen), self.hypoplastic.or(others.hypoplastic));
        Self { frequencies, unseen, arteries, hypoplastic }
    }

    /// The files that they name.
    pub(crate) fn files(&self) -> impl Iterator<Item = PathBuf> {
        [&self.frequencies, &self.arteries].into_iter().flatten().cloned()
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
        self.arteries.is_some().then(|| self.models()).transpose().map(drop)
    }

    /// The models that name arteries.
    ///
    /// # Errors
    ///
    /// A file that cannot be read or is no model.
    pub(crate) fn models(&self) -> Result<NamingModels> {
        let Some(path) = &self.arteries else { return NamingModels::shipped() };
        let expected = "expected a model as `willis train --model labels` writes it";
        Ok(NamingModels::one(SourceFile::read_text(path, expected, NamingModel::read)?.0))
    }

    /// The prior that they mean.
    pub(crate) fn prior(&self) -> Result<naming::CirclePrior> {
        let own = self.frequencies.as_deref().map(VariantFrequencies::of_file);
        let frequencies = own.unwrap_or_else(VariantFrequencies::published)?;
        Ok(naming::CirclePrior { frequencies, is_own: self.frequencies.is_some(), unseen: self.unseen.unwrap_or(0.0) })
    }
}
