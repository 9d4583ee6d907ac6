//! A case: an extraction whose true connections are known.

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::contact_truth::ContactTruth;
use super::known_connections::{KnownConnections, Match, found};
use willis_core::error::{Fault, Result};
use willis_core::network::Network;
use willis_core::support::in_order;
use willis_core::support::model_provenance::ModelProvenance;
use willis_io::formats::{ReadOptions, read_image};
use willis_io::masks::{Appearance, Scene, View};
use willis_models::candidates::features::Extraction;
use willis_models::candidates::model::CandidateTable;
use willis_models::candidates::resample::{CenterlineKind, Resampled};
use willis_models::candidates::search::{SearchOptions, search};

/// What a model is fitted to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Model {
    /// Tracings: fragments form a forest.
    #[default]
    Tracing,
    /// Automatic skeletons: candidates are judged one by one.
    Skeleton,
    /// Automatic skeletons: which branch ends are one vessel where they meet.
    Contacts,
}

/// An extraction with its known connections.
#[derive(Debug, Clone, Default)]
pub struct Case {
    /// The data set it belongs to, for scores.
    pub data_set: String,
    /// The folder within the data set, for scores; empty without one.
    pub group: String,
    /// Whom it shows. No subject is on both sides of a fold.
    pub subject: String,
    /// Its name within the data set.
    pub name: String,
    /// What the image showed.
    pub network: Network,
    /// The nodes where blood is known to enter.
    pub inlets: Vec<usize>,
    /// The known connections, by the points of [`Extraction`].
    pub truth: KnownConnections,
    /// What its contacts are, where that is asked for.
    pub contacts: Option<ContactTruth>,
    /// Its mask, where it has one beside it.
    pub mask: Option<PathBuf>,
    /// Its images, where it has some beside it.
    pub images: Vec<PathBuf>,
}

/// A case with what models of a kind see of it.
pub trait Example<'a>: Sized + Send + Sync {
    /// What is fitted to such examples.
    type Model: Sync;
    /// What a model says of a case as it is seen: without image, or in one.
    type Judged: Send;
    /// How well models did.
    type Scores: Clone + Serialize;
    /// Whether the model of a fold keeps the figures of that fold.
    const FOLDS_KEEP_FIGURES: bool;

    /// The case.
    fn case(&self) -> &'a Case;

    /// Judges a model by the case.
    ///
    /// # Errors
    ///
    /// A model of other features.
    fn judge(&self, model: &Self::Model) -> Result<Vec<Self::Judged>>;

    /// Figures over cases, by data set and folder.
    fn scores(judged: &[(&Self, &Self::Judged)]) -> Vec<Self::Scores>;

    /// Where a model comes from, and how well such models did.
    fn record(model: &mut Self::Model) -> (&mut ModelProvenance, &mut Vec<Self::Scores>);
}

/// A skeleton with what models of boosted trees see of it.
pub trait TreeExample<'a>: Example<'a> {
    /// What its case is read for.
    const KIND: Model;

    /// Measures a case.
    ///
    /// # Errors
    ///
    /// A node without a position, points that are crowded, a mask or an image that cannot be read, an image that does not show the vessels.
    fn new(case: &'a Case) -> Result<Self>;

    /// Fits a model to measured cases. The same cases give the same bits at any number of threads.
    ///
    /// # Errors
    ///
    /// Nothing to learn from, fewer subjects than inner folds.
    fn fit(examples: &[&Self], progress: &mut dyn FnMut(&str)) -> Result<Self::Model>;

    /// Measures several cases.
    ///
    /// # Errors
    ///
    /// As [`TreeExample::new`].
    fn measure(cases: &'a [Case]) -> Result<Vec<Self>> {
        in_order(cases, |_, case| Self::new(case)).into_iter().collect()
    }
}

/// A case with its candidates measured.
pub struct CandidateExample<'a> {
    /// The case.
    pub case: &'a Case,
    /// Its extraction, with or without inlets.
    pub extraction: Extraction,
    /// Its candidates.
    pub table: CandidateTable,
    /// Per candidate whether the truth allows its child to be attached by it.
    pub allowed: Vec<bool>,
    /// Per pair of the table the connection that it makes, if it is right.
    pub matches: Vec<Option<Match>>,
}

impl<'a> CandidateExample<'a> {
    /// Searches and measures the candidates of a case, with its inlets or as if nobody had named any.
    ///
    /// # Errors
    ///
    /// A node without a position; fragments in a tangle.
    pub fn new(case: &'a Case, with_inlets: bool) -> Result<Self> {
        let extraction =
            Resampled::new(&case.network, CenterlineKind::Tracing).extraction(if with_inlets { &case.inlets } else { &[] })?;
        let table = CandidateTable::new(&extraction, &search(&extraction, &SearchOptions::default())?)?;
        let points = table.candidates.iter().map(|c| [extraction.ends[c.end].point, c.point]);
        let candidates: Vec<_> = points.zip(table.fragments.iter().copied()).collect();
        let allowed = case.truth.allowed(&candidates);
        let mut matches = vec![None; table.pairs.points.len()];
        for (([from, to], _), pair) in candidates.iter().zip(&table.pairs.of) {
            matches[*pair] = case.truth.matching(*from, *to).or(matches[*pair]);
        }
        Ok(Self { case, extraction, table, allowed, matches })
    }

    /// Measures several cases, with their inlets or without.
    ///
    /// # Errors
    ///
    /// A node without a position.
    pub fn measure(cases: impl Iterator<Item = &'a Case>, with_inlets: bool) -> Result<Vec<Self>> {
        in_order(&cases.collect::<Vec<_>>(), |_, case| Self::new(case, with_inlets)).into_iter().collect()
    }

    /// How many of the candidates that the truth needs are among those found.
    pub fn reached(&self) -> usize {
        found(self.matches.iter().flatten().copied())
    }
}

/// A number in [0, 1) that looks random, the same for the same words on every machine.
pub fn share_of(words: &[&str]) -> f64 {
    let digest = Sha256::digest(words.join("\u{0}").as_bytes());
    digest.iter().take(6).rev().fold(0.0, |x, byte| (x + f64::from(*byte)) / 256.0)
}

/// The image in a file, around the vessels of an extraction.
///
/// # Errors
///
/// A file that cannot be read, an image that does not show the vessels.
pub fn shown(path: &Path, extraction: &Extraction) -> Result<Scene> {
    let (image, _) = read_image(path, &ReadOptions::default())?;
    Scene::new(&extraction.centerlines(), View { image, appearance: Appearance::Auto })
        .map_err(|why| Fault::file(format!("it does not show the vessels: {why}"), "expected an image of them").in_file(path))
}

/// The name of an image: that of its file before .nii.
pub fn image_name(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    name.split(".nii").next().unwrap_or_default().to_owned()
}
