//! The join model: two passes of boosted trees, a third for what an image shows, and their file.

use std::io::{self, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::features::{SECOND_FEATURES, join_feature_names};
use super::image::features::image_feature_names;
use willis_core::error::{Fault, ensure};
use willis_core::support::boosted_trees::{Boosted, check_features};
use willis_core::support::calibration::Calibration;
use willis_core::support::statistics::sigmoid;
use willis_core::support::toml_text::{finite, parse, write};

const HEADING: &str = "\
# The model of connections on automatic skeletons, fitted by `willis train --model skeleton`; read by `willis infer --prior FILE`.
# A score is the sum of the trees of a pass, each read from left to right: `3<0.25 A B` is A where feature 3 (from 0) is less
# than 0.25, else B. Features have no unit. The second pass sees the scores of the first, before the features.
# P = 1/(1 + exp(-(a + b l + c min(l, 0)))), [a, b, c] the calibration and l the mean score of both directions.
# image: the third pass, where there is an image: over the mean score of the second and what lies between the ends in the image. The
# images had noise of such shares of the contrast of vessels.
# figures: cross-validated by subject: average precision over all right connections (mean over cases), precision and
# recall of what is kept, calibration error, sum of P against right pairs.
";

/// What tells the file of a join model from that of another one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub enum JoinKind {
    /// It is one.
    #[default]
    #[serde(rename = "skeleton")]
    Skeleton,
}

/// Boosted trees in two passes, and the calibration of the second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JoinModel {
    /// What the file is.
    pub kind: JoinKind,
    /// [`Calibration`] of the mean score of both directions.
    #[serde(deserialize_with = "finite")]
    pub calibration: [f64; 3],
    /// The names of the features of a candidate.
    pub features: Vec<String>,
    /// The trees of the first pass, over these features, and of the second, over those of the scores and the same features.
    #[serde(rename = "pass")]
    pub passes: [Boosted; 2],
    /// The third pass, where there is an image.
    pub image: Option<ImagePass>,
    /// Where it comes from.
    #[serde(default)]
    pub provenance: willis_core::support::model_provenance::ModelProvenance,
    /// How well such models did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<JoinScores>,
}

/// Boosted trees over the mean score of both directions and what the image shows between the ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImagePass {
    /// [`Calibration`] of their score.
    #[serde(deserialize_with = "finite")]
    pub calibration: [f64; 3],
    /// The least and the most [`noise_share`](willis_io::masks::Scene::noise_share) of the images that they were fitted to.
    #[serde(deserialize_with = "finite")]
    pub noise: [f64; 2],
    /// The names of the features, [`image_feature_names`].
    pub features: Vec<String>,
    /// The trees, over these features.
    #[serde(rename = "pass")]
    pub trees: Boosted,
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
    pub fn shipped() -> willis_core::error::Result<Arc<Self>> {
        Self::read(include_str!("skeleton.toml")).map(Arc::new).map_err(|fault| fault.in_file("skeleton.toml".as_ref()))
    }

    /// Whether a text is a join model, as opposed to weights of a tracing.
    pub fn is_one(text: &str) -> bool {
        toml::from_str::<toml::Table>(text).is_ok_and(|file| file.get("kind").is_some_and(toml::Value::is_str))
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
    pub fn read(text: &str) -> Result<Self, Fault> {
        let model: Self = parse(text, "expected a model as `willis train --model skeleton` writes it")?;
        let names = join_feature_names();
        check_features("features", &model.features, &names)?;
        model.passes[0].check("pass 1", names.len())?;
        model.passes[1].check("pass 2", names.len() + SECOND_FEATURES)?;
        if let Some(image) = &model.image {
            let names = image_feature_names();
            check_features("image.features", &image.features, &names)?;
            let [least, most] = image.noise;
            let accepted = "expected the least and the most, from 0 on";
            let wrong = || Fault::item("image.noise", format!("[{least}, {most}]"), accepted);
            ensure(least >= 0.0 && least <= most, wrong)?;
            image.trees.check("image.pass", names.len())?;
        }
        Ok(model)
    }

    /// Writes TOML; every number is read back as it was.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, out: impl Write) -> io::Result<()> {
        write(out, HEADING, true, self)
    }
}
