//! `--landmarks` and `--labels`: where the arteries of a Circle of Willis are in an input.

use crate::internals::network::quantity::Dimension;
use crate::{ArterySource, LabelScheme, PhenotypeOptions};
use std::path::{Path, PathBuf};

use clap::Args;

use super::{file_of, words};

#[derive(Debug, Args)]
#[command(next_help_heading = "Circle of Willis")]
pub struct ArteryArgs {
    /// Where arteries enter and leave, in the place of labels: auto, to name them by their geometry, or a CSV file of label,x_mm,y_mm,z_mm, or x,y,z in the unit of INPUT;
    /// in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    landmarks: Option<PathBuf>,
    /// What the labels are [default: names; numbers where only one list has them]
    #[arg(long, conflicts_with = "landmarks", hide_short_help = true, value_parser = words::<LabelScheme>(&[("names", "Names of arteries, as L-A1, \"A1 left\", ACoA"),
        ("icafe", "The numbers of iCafe's VesselType"), ("topcow", "The numbers of the TopCoW challenge")]))]
    labels: Option<LabelScheme>,
    /// How frequent each variant is among such people, in the place of the published table: a CSV file of missing,share
    #[arg(long, value_name = "FILE.csv", value_hint = clap::ValueHint::FilePath, hide_short_help = true)]
    variant_prior: Option<PathBuf>,
    /// How often a segment that is there is not in the extraction at all [default: 0]
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true, hide_short_help = true)]
    unseen: Option<f64>,
    /// A model of `willis train --model labels` that names the arteries, in the place of the one that ships
    #[arg(long, value_name = "MODEL.toml", value_hint = clap::ValueHint::FilePath, hide_short_help = true)]
    arteries: Option<PathBuf>,
    /// The diameter below which a segment is hypoplastic [default: 1mm]
    #[arg(long, value_name = "DIAMETER", value_parser = diameter, allow_negative_numbers = true, hide_short_help = true)]
    hypoplastic: Option<f64>,
}

/// A diameter, m.
fn diameter(text: &str) -> Result<f64, String> {
    let diameter = Dimension::Length.parse(text)?;
    if diameter > 0.0 { Ok(diameter) } else { Err("expected a positive diameter, such as 0.8mm".to_owned()) }
}

impl ArteryArgs {
    /// How the arteries are known, where a person said it.
    pub fn source(&self) -> Option<ArterySource> {
        let is_auto = |path: &PathBuf| path.as_os_str() == "auto";
        let landmarks = self
            .landmarks
            .clone()
            .map(|path| if is_auto(&path) { ArterySource::Geometry } else { ArterySource::Landmarks(path) });
        landmarks.or(self.labels.map(ArterySource::Labels))
    }

    /// What is known of people's circles before one is seen.
    pub fn phenotypes(&self) -> PhenotypeOptions {
        PhenotypeOptions {
            frequencies: self.variant_prior.clone(),
            unseen: self.unseen,
            arteries: self.arteries.clone(),
            hypoplastic: self.hypoplastic,
        }
    }
}

/// The same with the file of landmarks that goes with an input.
pub fn for_input(source: &ArterySource, input: &Path) -> ArterySource {
    match source {
        ArterySource::Landmarks(name) => ArterySource::Landmarks(file_of(name, input)),
        other => other.clone(),
    }
}
