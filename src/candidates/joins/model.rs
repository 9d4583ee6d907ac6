//! The join model: two passes of boosted trees, a third for what an image shows, and their file.

use std::io::{self, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::features::join_feature_names;
use super::image::features::IMAGE_FEATURES;
use super::rivals::SECOND_FEATURES;
use crate::error::Fault;
use crate::support::boosted_trees::{Boosted, BoostedEntry};
use crate::support::calibration::Calibration;
use crate::support::statistics::sigmoid;
use crate::support::suggestions::did_you_mean;
use crate::support::toml_text::{list, parse, text};
use crate::support::tree_provenance::TreeProvenance;

/// The model that comes with the program.
const SHIPPED: &str = include_str!("skeleton.toml");

const HEADING: &str = "\
# The model of connections on automatic skeletons, fitted by `willis train --model skeleton`; read by `willis infer --prior FILE`.
# A score is the sum of the trees of a pass, each read from left to right: `3<0.25 A B` is A where feature 3 (from 0) is less
# than 0.25, else B. Features have no unit. The second pass sees the scores of the first, before the features.
kind = \"skeleton\"
";

const IMAGE: &str = "\
# The third pass, where there is an image: over the mean score of the second and what lies between the ends in the image.";

const FIGURES: &str = "\
# Cross-validated by subject: average precision over all right connections (mean over cases), precision and
# recall of what is kept, calibration error, sum of P against right pairs.";

/// Boosted trees in two passes, and the calibration of the second.
#[derive(Debug, Clone, PartialEq)]
pub struct JoinModel {
    /// The trees of the first pass, over the features of a candidate.
    pub first: Boosted,
    /// The trees of the second pass, over those of the scores and the same features.
    pub second: Boosted,
    /// [`Calibration`] of the mean score of both directions.
    pub calibration: [f64; 3],
    /// The third pass, where there is an image.
    pub image: Option<ImagePass>,
    /// Where it comes from.
    pub provenance: TreeProvenance<JoinScores>,
}

/// Boosted trees over the mean score of both directions and what the image shows between the ends.
#[derive(Debug, Clone, PartialEq)]
pub struct ImagePass {
    /// The trees, over [`IMAGE_FEATURES`].
    pub trees: Boosted,
    /// [`Calibration`] of their score.
    pub calibration: [f64; 3],
    /// The least and the most [`noise_share`](crate::masks::Scene::noise_share) of the images that they were fitted to.
    pub noise: [f64; 2],
}

/// How well a join model did on cases that it was not fitted to.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JoinScores {
    /// The data set, or a folder in it.
    pub of: String,
    /// How many cases.
    pub cases: usize,
    /// Of how many subjects.
    pub subjects: usize,
    /// Average precision over all true connections, found or not; the mean over cases that have one.
    pub average_precision: Option<f64>,
    /// Precision and recall of the joins kept, all cases together.
    pub precision: Option<f64>,
    /// See `precision`.
    pub recall: Option<f64>,
    /// Calibration error over all pairs, all cases together, ten bins.
    pub calibration_error: f64,
    /// The sum of P over all pairs of points.
    pub expected: f64,
    /// How many of them are right.
    pub right: usize,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    kind: String,
    calibration: [f64; 3],
    features: Vec<String>,
    pass: [BoostedEntry; 2],
    image: Option<ImageEntry>,
    #[serde(default)]
    provenance: TreeProvenance<JoinScores>,
    #[serde(default)]
    figures: Vec<JoinScores>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageEntry {
    calibration: [f64; 3],
    noise: [f64; 2],
    features: Vec<String>,
    pass: BoostedEntry,
}

/// What tells a join model from weights of a tracing.
#[derive(Deserialize)]
struct Kind {
    kind: Option<String>,
}

impl ImagePass {
    /// Probability of each score.
    pub fn probability(&self, score: f64) -> f64 {
        Calibration(self.calibration).apply(sigmoid(score))
    }
}

impl JoinModel {
    /// The model that comes with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: it is tested.
    pub fn shipped() -> crate::error::Result<Arc<Self>> {
        Self::read(SHIPPED).map(Arc::new).map_err(|fault| fault.in_file("skeleton.toml".as_ref()))
    }

    /// Whether a text is a join model, as opposed to weights of a tracing.
    pub fn is_one(text: &str) -> bool {
        toml::from_str::<Kind>(text).is_ok_and(|file| file.kind.is_some())
    }

    /// Probability of each score.
    pub fn probability(&self, score: f64) -> f64 {
        Calibration(self.calibration).apply(sigmoid(score))
    }

    /// Reads a model that `willis train --model skeleton` made, as TOML.
    ///
    /// # Errors
    ///
    /// Not TOML, a feature that this program does not measure, a tree that is none, a number that is not finite: the line or the name.
    pub fn read(toml_text: &str) -> Result<Self, Fault> {
        const ACCEPTED: &str = "expected a model as `willis train --model skeleton` writes it";
        let file: File = parse(toml_text, ACCEPTED)?;
        if file.kind != "skeleton" {
            return Err(Fault::item("kind", file.kind, "expected skeleton"));
        }
        let names = join_feature_names();
        check_features("features", &file.features, &names)?;
        check_calibration("calibration", file.calibration)?;
        let [first, second] = file.pass;
        let provenance = TreeProvenance { figures: file.figures, ..file.provenance };
        let first = Boosted::read("pass 1", &first, names.len())?;
        let second = Boosted::read("pass 2", &second, names.len() + SECOND_FEATURES.len())?;
        let image = file.image.map(|image| {
            check_features("image.features", &image.features, &IMAGE_FEATURES)?;
            check_calibration("image.calibration", image.calibration)?;
            let [least, most] = image.noise;
            if !(least >= 0.0 && least <= most && most.is_finite()) {
                return Err(Fault::item(
                    "image.noise",
                    format!("[{least}, {most}]"),
                    "expected the least and the most, from 0 on",
                ));
            }
            let trees = Boosted::read("image.pass", &image.pass, IMAGE_FEATURES.len())?;
            Ok(ImagePass { trees, calibration: image.calibration, noise: image.noise })
        });
        Ok(Self { first, second, calibration: file.calibration, image: image.transpose()?, provenance })
    }

    /// Writes TOML; every number is read back as it was.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        let [a, b, c] = self.calibration;
        write!(out, "{HEADING}")?;
        writeln!(out, "\n# P = 1/(1 + exp(-(a + b l + c min(l, 0)))), l the mean score of both directions.")?;
        writeln!(out, "calibration = [{a:?}, {b:?}, {c:?}]\n")?;
        let names: Vec<String> = join_feature_names().into_iter().map(str::to_owned).collect();
        writeln!(out, "features = {}", list(&names))?;
        for pass in [&self.first, &self.second] {
            writeln!(out, "\n[[pass]]")?;
            pass.write(&mut out)?;
        }
        if let Some(image) = &self.image {
            let [a, b, c] = image.calibration;
            let [least, most] = image.noise;
            writeln!(out, "\n{IMAGE}\n[image]\ncalibration = [{a:?}, {b:?}, {c:?}]")?;
            writeln!(out, "# The images had noise of such shares of the contrast of vessels.\nnoise = [{least:?}, {most:?}]\n")?;
            writeln!(out, "features = {}\n\n[image.pass]", list(&IMAGE_FEATURES.map(str::to_owned)))?;
            image.trees.write(&mut out)?;
        }
        self.provenance.write(&mut out, FIGURES, |figures, out| {
            writeln!(out, "of = {}", text(&figures.of))?;
            writeln!(out, "cases = {}\nsubjects = {}", figures.cases, figures.subjects)?;
            for (name, x) in [
                ("average_precision", figures.average_precision),
                ("precision", figures.precision),
                ("recall", figures.recall),
                ("calibration_error", Some(figures.calibration_error)),
                ("expected", Some(figures.expected)),
            ] {
                if let Some(x) = x {
                    writeln!(out, "{name} = {x:?}")?;
                }
            }
            writeln!(out, "right = {}", figures.right)
        })?;
        out.flush()
    }
}

/// Checks that the features of a file are those that this program measures.
fn check_features(place: &str, found: &[String], names: &[&str]) -> Result<(), Fault> {
    if let Some((have, expected)) = found.iter().zip(names).find(|(have, expected)| have != *expected) {
        let is_known = names.contains(&have.as_str());
        let meant = if is_known { String::new() } else { did_you_mean(have, names.iter().copied()) };
        return Err(Fault::item(place, format!("\"{have}\""), format!("{meant}expected {expected} in this place")));
    }
    if found.len() != names.len() {
        return Err(Fault::item(place, found.len().to_string(), format!("expected {}", names.len())));
    }
    Ok(())
}

fn check_calibration(place: &str, numbers: [f64; 3]) -> Result<(), Fault> {
    let wrong = numbers.iter().find(|x| !x.is_finite());
    wrong.map_or(Ok(()), |x| Err(Fault::item(place, x.to_string(), "expected a finite number")))
}
