//! The contact model: boosted trees that score pairs of branch ends, and the weights of partitions, by what there is beside the centerlines; its file.

use std::io::{self, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::evidence::{IMAGE_FEATURES, MASK_FEATURES};
use willis_core::error::Fault;
use willis_core::network::{Network, Origin, Vessel, fragments};
use willis_core::support::boosted_trees::{Boosted, check_features};
use willis_core::support::statistics::median;
use willis_core::support::toml_text::{finite, parse, write};
use willis_io::masks::{Field, Scene};

const HEADING: &str = "\
# The model of contacts, fitted by `willis train --model contacts`; read by `willis infer --cut FILE`.
# The score of a pair of branch ends is the sum of the trees, each read from left to right: `3<0.25 A B` is A where feature 3 (from 0)
# is less than 0.25, else B. Features have no unit. The weights are those of partitions of two or three ends, of four, of more.
# P of a contact is 1/(1 + exp(-(a + b l))), [a, b] the calibration and l the log-odds by the partitions. crowding: the most contacts and
# handles per 1,000 radii of length in a case of the calibration.
# figures: cross-validated by subject, over pairs of branch ends at clusters of at most six ends.
";

/// A calibration that changes nothing: that of a model which has none.
pub const NOT_CALIBRATED: [f64; 2] = [0.0, 1.0];

/// Scores of pairs, weights of partitions, and how often contacts that are found are one vessel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactPart {
    /// The names of the features of a pair.
    pub features: Vec<String>,
    /// The weights of the features of a partition.
    #[serde(deserialize_with = "finite")]
    pub weights: super::partition::PartitionWeights,
    /// a and b: P of a contact is σ(a + b l), l the log-odds that its two blocks are joined by the partitions; b is at least 0.
    #[serde(deserialize_with = "finite")]
    pub calibration: [f64; 2],
    /// The most crowded of the cases that it was calibrated on; `None` for a model that is not calibrated.
    pub crowding: Option<Crowding>,
    /// The score (log-odds) of a pair.
    #[serde(rename = "pairs")]
    pub trees: Boosted,
}

impl ContactPart {
    /// The share of contacts that are one vessel, of those that the partitions join with this probability.
    pub fn probability(&self, joined: f64) -> f64 {
        let [a, b] = self.calibration;
        willis_core::support::calibration::Calibration([a, b, 0.0]).apply(joined)
    }
}

/// What tells the file of a contact model from that of another one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub enum ContactKind {
    /// It is one.
    #[default]
    #[serde(rename = "contacts")]
    Contacts,
}

/// The contact model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactModel {
    /// What the file is.
    pub kind: ContactKind,
    /// For centerlines alone.
    pub skeleton: ContactPart,
    /// For centerlines with their mask.
    pub mask: ContactPart,
    /// For centerlines with their mask and an image.
    pub image: Option<ContactPart>,
    /// Where it comes from.
    #[serde(default)]
    pub provenance: willis_core::support::model_provenance::ModelProvenance,
    /// How well such models did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<ContactScores>,
}

/// How well a contact model did on cases that it was not fitted to, over pairs of ends at clusters of at most six.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactScores {
    /// The data set, or a folder in it.
    pub of: String,
    /// Whether the mask was looked at.
    pub with_mask: bool,
    /// The image that was looked at; empty without one.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub image: String,
    /// How many cases.
    pub cases: usize,
    /// How many pairs.
    pub pairs: usize,
    /// The share of them that are one vessel.
    pub joined: f64,
    /// Probability that a pair of one vessel scores higher than one of two.
    pub auc: f64,
    /// Average precision of the pairs of two vessels.
    pub average_precision: f64,
    /// The largest difference of predicted and found share in ten bins of at least fifty pairs.
    pub largest_bin_error: f64,
}

impl ContactModel {
    /// The model that comes with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: it is tested.
    pub fn shipped() -> willis_core::error::Result<Arc<Self>> {
        Self::read(include_str!("contacts.toml")).map(Arc::new).map_err(|fault| fault.in_file("contacts.toml".as_ref()))
    }

    /// The part that goes by this; that of masks where the model does not know images.
    pub fn part(&self, basis: Basis) -> &ContactPart {
        match (basis, &self.image) {
            (Basis::Skeleton, _) => &self.skeleton,
            (Basis::Image, Some(image)) => image,
            _ => &self.mask,
        }
    }

    /// Reads a model that `willis train --model contacts` made, as TOML.
    ///
    /// # Errors
    ///
    /// Not TOML, a feature that this program does not measure, a tree that is none, a number that is not finite: the line or the name.
    pub fn read(text: &str) -> Result<Self, Fault> {
        let model: Self = parse(text, "expected a model as `willis train --model contacts` writes it")?;
        let image = model.image.iter().map(|part| ("image", part, Basis::Image));
        for (place, part, basis) in
            [("skeleton", &model.skeleton, Basis::Skeleton), ("mask", &model.mask, Basis::Mask)].into_iter().chain(image)
        {
            let names = basis.feature_names();
            check_features(&format!("{place} features"), &part.features, &names)?;
            if part.calibration[1] < 0.0 {
                let accepted = "expected [a, b] with b of at least 0";
                return Err(Fault::item(format!("{place} calibration"), format!("{:?}", part.calibration), accepted));
            }
            if let Some(most) = part.crowding.filter(|most| !(most.contacts >= 0.0 && most.handles >= 0.0)) {
                let found = format!("{} and {}", most.contacts, most.handles);
                return Err(Fault::item(format!("{place} crowding"), found, "expected numbers from 0 on"));
            }
            part.trees.check(place, names.len())?;
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

/// What contacts are judged by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Basis {
    /// The centerlines alone.
    Skeleton,
    /// Their mask.
    Mask,
    /// The mask and an image beside it.
    Image,
}

impl Basis {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Skeleton, Self::Mask, Self::Image];

    /// By what is there: an image without a mask says nothing.
    pub fn of(mask: Option<&Field>, scene: Option<&Scene>) -> Self {
        match (mask, scene) {
            (None, _) => Self::Skeleton,
            (Some(_), None) => Self::Mask,
            (Some(_), Some(_)) => Self::Image,
        }
    }

    /// The names of the features, in their order.
    pub fn feature_names(self) -> Vec<String> {
        let named = |of: &str, names: &str| names.split(' ').map(|name| format!("{of}_{name}")).collect::<Vec<String>>();
        match self {
            Self::Skeleton => super::features::skeleton_feature_names(),
            Self::Mask => named("mask", MASK_FEATURES),
            Self::Image => [named("mask", MASK_FEATURES), named("image", IMAGE_FEATURES)].concat(),
        }
    }
}

/// Figures are per so many radii of length.
const RADII: f64 = 1e3;
/// More than so many times the most of the calibration is told: subjects differ.
const TOLD: f64 = 1.5;

/// Contacts and handles per 1,000 radii of the length of observed vessels, the radius being the median of branches.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crowding {
    /// Contacts, kept or cut.
    pub contacts: f64,
    /// Independent cycles of the observed vessels before anything is cut.
    pub handles: f64,
}

impl Crowding {
    /// That of a network in which so many contacts were found; zeros without a branch.
    pub fn new(network: &Network, branches: &super::branches::Branches, contacts: usize) -> Self {
        let is_observed = |vessel: &Vessel| vessel.origin == Origin::Observed;
        let lengths: Vec<f64> = network.vessels().filter(|(_, v)| is_observed(v)).map(|(_, vessel)| vessel.length).collect();
        let handles = lengths.len() + fragments(network, |_, v| is_observed(v)).count - network.node_count();
        let length: f64 = lengths.iter().sum();
        let radius = median(&branches.branches.iter().map(|branch| branch.radius).collect::<Vec<f64>>());
        let per = |count: usize| radius.filter(|_| length > 0.0).map_or(0.0, |radius| count as f64 * RADII * radius / length);
        Self { contacts: per(contacts), handles: per(handles) }
    }

    /// The larger of both figures of two cases.
    #[must_use]
    pub fn most(self, other: Self) -> Self {
        Self { contacts: self.contacts.max(other.contacts), handles: self.handles.max(other.handles) }
    }

    /// What to tell a person of vessels more crowded than the `most` crowded that a model was calibrated on; `None` where they are not.
    pub fn unlike(self, most: Self) -> Option<String> {
        let figures = [("contacts", self.contacts, most.contacts), ("handles", self.handles, most.handles)];
        let beyond = figures.into_iter().filter(|(_, here, most)| *here > TOLD * most);
        let told = beyond.map(|(name, here, most)| format!("{here:.1} {name} (at most {most:.1})"));
        let beyond: Vec<String> = told.collect();
        (!beyond.is_empty()).then(|| {
            format!(
                "the vessels are unlike those that P of contacts was calibrated on: {} per 1,000 radii of length; read P as a rank, not as a share",
                beyond.join(" and ")
            )
        })
    }
}
