//! The options of a Circle of Willis: how its arteries are known, and what is known of people's circles before one is seen.

use std::path::{Path, PathBuf};

#[cfg(feature = "cli")]
use clap::ValueHint::FilePath;
use serde::{Deserialize, Serialize};

use super::source_file::SourceFile;
use willis_core::error::{Error, Result};
use willis_models::circle_of_willis::{LabelScheme, VariantFrequencies};
use willis_models::naming::{self, NamingModel, NamingModels};

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

    pub(crate) fn is_labels(&self) -> bool {
        matches!(self, Self::AnyLabels | Self::Labels(_))
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
        self.frequencies.is_some().then(|| self.prior()).transpose()?;
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
        let frequencies = match &self.frequencies {
            Some(path) => VariantFrequencies::of_file(path)?,
            None => VariantFrequencies::published()?,
        };
        Ok(naming::CirclePrior { frequencies, is_own: self.frequencies.is_some(), unseen: self.unseen.unwrap_or(0.0) })
    }
}
