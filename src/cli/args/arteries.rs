//! `--landmarks` and `--labels`: where the arteries of a Circle of Willis are in an input.

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
    #[command(flatten)]
    pub phenotypes: PhenotypeOptions,
}

impl ArteryArgs {
    /// How the arteries are known, where a person said it.
    pub fn source(&self) -> Option<ArterySource> {
        let is_auto = |path: &PathBuf| path.as_os_str() == "auto";
        let source = |path| if is_auto(&path) { ArterySource::Geometry } else { ArterySource::Landmarks(path) };
        self.landmarks.clone().map(source).or(self.labels.map(ArterySource::Labels))
    }
}

/// The same with the file of landmarks that goes with an input.
pub fn for_input(source: &ArterySource, input: &Path) -> ArterySource {
    match source {
        ArterySource::Landmarks(name) => ArterySource::Landmarks(file_of(name, input)),
        other => other.clone(),
    }
}
