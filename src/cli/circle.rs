//! `--landmarks` and `--labels`: where the arteries of a Circle of Willis are in an input.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use willis::error::Result;
use willis::internals::circle_of_willis::{Circle, LabelScheme, identify_landmarks};
use willis::internals::io::{bytes_of, checksum, read_landmarks};
use willis::internals::network::Network;
use willis::internals::network::units::Scale;

use super::beside::beside;

#[derive(Debug, Clone, Copy, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
enum Labels {
    /// Names of arteries, as L-A1, "A1 left", ACoA
    Names,
    /// The numbers of iCafe's VesselType
    Icafe,
    /// The numbers of the TopCoW challenge
    Topcow,
}

#[derive(Debug, Args, Serialize)]
#[command(next_help_heading = "Circle of Willis")]
pub struct CircleArgs {
    /// Where arteries enter and leave, in the place of labels: a CSV file of label,x_mm,y_mm,z_mm, or x,y,z in the unit of INPUT;
    /// in its name {} is INPUT without its ending and {dir} the folder of INPUT
    #[arg(long, value_name = "FILE", value_hint = clap::ValueHint::FilePath)]
    landmarks: Option<PathBuf>,
    /// What the labels are [default: names; numbers where only one list has them]
    #[arg(long, value_enum, conflicts_with = "landmarks")]
    labels: Option<Labels>,
}

/// Where the arteries are, and how that is known.
#[derive(Debug, Serialize, Deserialize)]
pub struct Found {
    pub circle: Circle,
    /// `names`, `icafe`, `topcow` or `landmarks`.
    pub known_by: String,
    /// Path and SHA-256 of the landmarks.
    pub landmarks: Option<(String, String)>,
    pub notes: Vec<String>,
}

impl Found {
    /// The record of the landmarks.
    pub fn record(&self) -> Value {
        self.landmarks.as_ref().map_or(Value::Null, |(path, sha256)| json!({ "path": path, "sha256": sha256 }))
    }
}

impl CircleArgs {
    /// Whether a person said how the arteries are known.
    pub fn is_given(&self) -> bool {
        self.landmarks.is_some() || self.labels.is_some()
    }

    /// As the record of a run says.
    pub fn of_record(parameters: &Value) -> Self {
        let labels =
            [(LabelScheme::Names, Labels::Names), (LabelScheme::ICafe, Labels::Icafe), (LabelScheme::TopCow, Labels::Topcow)];
        let known_by = |scheme: &LabelScheme| parameters["arteries"].as_str() == Some(scheme.name());
        Self {
            landmarks: parameters["landmarks"]["path"].as_str().map(PathBuf::from),
            labels: labels.into_iter().find(|(scheme, _)| known_by(scheme)).map(|(_, labels)| labels),
        }
    }

    /// Whether they are known by landmarks.
    pub fn is_by_landmarks(&self) -> bool {
        self.landmarks.is_some()
    }

    /// The file of landmarks that goes with an input.
    pub fn file(&self, input: &Path) -> Option<PathBuf> {
        self.landmarks.as_ref().map(|name| beside(name, input))
    }

    /// Finds the arteries in the network of an input.
    pub fn find(&self, input: &Path, network: &Network, scale: &Scale) -> Result<Found> {
        match self.file(input) {
            Some(file) => by_landmarks(&file, network, scale),
            None => self.by_labels(input, network),
        }
    }

    fn by_labels(&self, input: &Path, network: &Network) -> Result<Found> {
        let scheme = match self.labels {
            Some(Labels::Names) => LabelScheme::Names,
            Some(Labels::Icafe) => LabelScheme::ICafe,
            Some(Labels::Topcow) => LabelScheme::TopCow,
            None => {
                let labels = network.vessels().map(|(_, vessel)| vessel.label.as_str());
                LabelScheme::of(labels).map_err(|fault| fault.in_file(input))?
            }
        };
        let (circle, notes) = Circle::labelled(network, scheme).map_err(|fault| fault.in_file(input))?;
        Ok(Found { circle, known_by: scheme.name().to_owned(), landmarks: None, notes })
    }
}

fn by_landmarks(file: &Path, network: &Network, scale: &Scale) -> Result<Found> {
    let bytes = bytes_of(file)?;
    let landmarks = read_landmarks(&bytes, scale).and_then(identify_landmarks).map_err(|fault| fault.in_file(file))?;
    let (circle, notes) = Circle::at(network, &landmarks).map_err(|fault| fault.in_file(file))?;
    Ok(Found { circle, known_by: "landmarks".to_owned(), landmarks: Some((file.display().to_string(), checksum(&bytes))), notes })
}
