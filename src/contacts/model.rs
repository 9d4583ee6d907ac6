//! The contact model: boosted trees that score pairs of branch ends, and the weights of partitions, by what there is beside the centerlines; its file.

use std::io::{self, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Basis;
use super::crowding::Crowding;
use super::partition::PartitionWeights;
use crate::error::Fault;
use crate::support::boosted_trees::{Boosted, BoostedEntry};
use crate::support::calibration::Calibration;
use crate::support::toml_text::{list, parse, text};
use crate::support::tree_provenance::TreeProvenance;

/// The model that comes with the program.
const SHIPPED: &str = include_str!("contacts.toml");

const HEADING: &str = "\
# The model of contacts, fitted by `willis train --model contacts`; read by `willis infer --cut FILE`.
# The score of a pair of branch ends is the sum of the trees, each read from left to right: `3<0.25 A B` is A where feature 3 (from 0)
# is less than 0.25, else B. Features have no unit. The weights are those of partitions of two or three ends, of four, of more.
# P of a contact is 1/(1 + exp(-(a + b l))), [a, b] the calibration and l the log-odds by the partitions. crowding: the most contacts and
# handles per 1,000 radii of length in a case of the calibration.
kind = \"contacts\"
";

const FIGURES: &str = "# Cross-validated by subject, over pairs of branch ends at clusters of at most six ends.";

/// A calibration that changes nothing: that of a model which has none.
pub const NOT_CALIBRATED: [f64; 2] = [0.0, 1.0];

/// Scores of pairs, weights of partitions, and how often contacts that are found are one vessel.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPart {
    /// The score (log-odds) of a pair.
    pub trees: Boosted,
    /// The weights of the features of a partition.
    pub weights: PartitionWeights,
    /// a and b: P of a contact is σ(a + b l), l the log-odds that its two blocks are joined by the partitions; b is at least 0.
    pub calibration: [f64; 2],
    /// The most crowded of the cases that it was calibrated on; `None` for a model that is not calibrated.
    pub crowding: Option<Crowding>,
}

impl ContactPart {
    /// The share of contacts that are one vessel, of those that the partitions join with this probability.
    pub fn probability(&self, joined: f64) -> f64 {
        let [a, b] = self.calibration;
        Calibration([a, b, 0.0]).apply(joined)
    }
}

/// The contact model.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactModel {
    /// For centerlines alone.
    pub skeleton: ContactPart,
    /// For centerlines with their mask.
    pub mask: ContactPart,
    /// For centerlines with their mask and an image.
    pub image: Option<ContactPart>,
    /// Where it comes from.
    pub provenance: TreeProvenance<ContactScores>,
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
    #[serde(default)]
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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    kind: String,
    skeleton: PartEntry,
    mask: PartEntry,
    image: Option<PartEntry>,
    #[serde(default)]
    provenance: TreeProvenance<ContactScores>,
    #[serde(default)]
    figures: Vec<ContactScores>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartEntry {
    features: Vec<String>,
    weights: PartitionWeights,
    calibration: [f64; 2],
    crowding: Option<Crowding>,
    pairs: BoostedEntry,
}

impl ContactModel {
    /// The model that comes with the program.
    ///
    /// # Errors
    ///
    /// None in a released program: it is tested.
    pub fn shipped() -> crate::error::Result<Arc<Self>> {
        Self::read(SHIPPED).map(Arc::new).map_err(|fault| fault.in_file("contacts.toml".as_ref()))
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
    pub fn read(toml_text: &str) -> Result<Self, Fault> {
        const ACCEPTED: &str = "expected a model as `willis train --model contacts` writes it";
        let file: File = parse(toml_text, ACCEPTED)?;
        if file.kind != "contacts" {
            return Err(Fault::item("kind", file.kind, "expected contacts"));
        }
        Ok(Self {
            skeleton: part("skeleton", &file.skeleton, Basis::Skeleton)?,
            mask: part("mask", &file.mask, Basis::Mask)?,
            image: file.image.map(|entry| part("image", &entry, Basis::Image)).transpose()?,
            provenance: TreeProvenance { figures: file.figures, ..file.provenance },
        })
    }

    /// Writes TOML; every number is read back as it was.
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write(&self, mut out: impl Write) -> io::Result<()> {
        write!(out, "{HEADING}")?;
        for (name, basis) in [("skeleton", Basis::Skeleton), ("mask", Basis::Mask), ("image", Basis::Image)] {
            if basis == Basis::Image && self.image.is_none() {
                continue;
            }
            let part = self.part(basis);
            writeln!(out, "\n[{name}]\nfeatures = {}", list(&basis.feature_names()))?;
            writeln!(out, "weights = {:?}\ncalibration = {:?}", part.weights, part.calibration)?;
            if let Some(Crowding { contacts, handles }) = part.crowding {
                writeln!(out, "crowding = {{ contacts = {contacts:?}, handles = {handles:?} }}")?;
            }
            writeln!(out, "\n[{name}.pairs]")?;
            part.trees.write(&mut out)?;
        }
        self.provenance.write(&mut out, FIGURES, |f, out| {
            writeln!(out, "of = {}\nwith_mask = {}", text(&f.of), f.with_mask)?;
            if !f.image.is_empty() {
                writeln!(out, "image = {}", text(&f.image))?;
            }
            writeln!(out, "cases = {}\npairs = {}\njoined = {:?}", f.cases, f.pairs, f.joined)?;
            writeln!(out, "auc = {:?}\naverage_precision = {:?}", f.auc, f.average_precision)?;
            writeln!(out, "largest_bin_error = {:?}", f.largest_bin_error)
        })?;
        out.flush()
    }
}

fn part(place: &str, entry: &PartEntry, basis: Basis) -> Result<ContactPart, Fault> {
    let names = basis.feature_names();
    if entry.features != names {
        let wrong = entry.features.iter().zip(&names).find(|(have, expected)| have != expected);
        let found = wrong.map_or_else(|| entry.features.len().to_string(), |(have, _)| have.clone());
        let accepted = wrong.map_or_else(|| names.len().to_string(), |(_, expected)| expected.clone());
        return Err(Fault::item(format!("{place} features"), found, format!("expected {accepted} in this place")));
    }
    if let Some(x) = entry.weights.iter().flatten().find(|x| !x.is_finite()) {
        return Err(Fault::item(format!("{place} weights"), x.to_string(), "expected finite numbers"));
    }
    if entry.calibration.iter().any(|x| !x.is_finite()) || entry.calibration[1] < 0.0 {
        let accepted = "expected [a, b], finite, with b of at least 0";
        return Err(Fault::item(format!("{place} calibration"), format!("{:?}", entry.calibration), accepted));
    }
    if let Some(most) = entry.crowding.filter(|most| !(most.contacts >= 0.0 && most.handles >= 0.0)) {
        let found = format!("{} and {}", most.contacts, most.handles);
        return Err(Fault::item(format!("{place} crowding"), found, "expected numbers from 0 on"));
    }
    let trees = Boosted::read(place, &entry.pairs, names.len())?;
    Ok(ContactPart { trees, weights: entry.weights, calibration: entry.calibration, crowding: entry.crowding })
}
