//! A case: an extraction whose true connections are known; cross-validation by subject, and how well models do on cases.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::contact_truth::ContactTruth;
use super::known_connections::{KnownConnections, Match, found, joiner};
use willis_core::error::{Fault, Result, require};
use willis_core::support::{in_order, model_provenance::ModelProvenance};
use willis_core::{forest_posterior::log_likelihood, network::Frame, network::Network};
use willis_io::formats::{ReadOptions, read_image};
use willis_io::masks::{Appearance, Scene, View};
use willis_models::candidates::model::{CandidateTable, HeldOutScores, Weights, last_pass};
use willis_models::candidates::search::{SearchOptions, search};
use willis_models::candidates::{features::Extraction, resample::CenterlineKind, resample::Resampled};

/// Pairs no more probable than this are left out of calibration and scores.
pub(crate) const LEAST_LISTED: f64 = 1e-3;

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
    const FOLDS_KEEP_FIGURES: bool = true;

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

/// The image in a file, around the vessels of an extraction in this frame.
///
/// # Errors
///
/// A file that cannot be read, an image that does not show the vessels.
pub fn shown(path: &Path, frame: Frame, extraction: &Extraction) -> Result<Scene> {
    let (image, _) = read_image(path, &ReadOptions::default(), frame)?;
    Scene::new(&extraction.centerlines(), View { image, appearance: Appearance::Auto })
        .map_err(|why| Fault::file(format!("it does not show the vessels: {why}"), "expected an image of them").in_file(path))
}

/// The name of an image: that of its file before .nii.
pub fn image_name(path: &Path) -> String {
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    name.split(".nii").next().unwrap_or_default().to_owned()
}

/// The fold, of so many, that holds a subject out: by a hash of its name.
pub fn fold_of(subject: &str, folds: usize) -> usize {
    ((share_of(&["fold", subject]) * folds as f64) as usize).min(folds.saturating_sub(1))
}

/// Which fold of a cross-validation holds a subject out: that of [`fold_of`], to which further subjects change nothing; where this leaves a
/// fold without a case, subjects are dealt in the order of their names.
#[derive(Debug, Default)]
pub struct Folds {
    count: usize,
    dealt: BTreeMap<String, usize>,
}

impl Folds {
    /// So many folds of some cases; 0 for none.
    ///
    /// # Errors
    ///
    /// One fold, or fewer subjects than folds.
    pub fn new(cases: &[Case], count: usize) -> Result<Self> {
        let subjects: BTreeSet<&str> = cases.iter().map(|case| case.subject.as_str()).collect();
        let accepted = format!("expected 2 to {}, the number of subjects, or 0 for no cross-validation", subjects.len());
        require(count == 0 || (2..=subjects.len()).contains(&count), "folds", count, accepted)?;
        let taken: BTreeSet<usize> = subjects.iter().map(|subject| fold_of(subject, count)).collect();
        let names = if taken.len() < count { subjects } else { BTreeSet::new() };
        let (folds, _) = dealt(names.iter().copied(), count);
        Ok(Self { count, dealt: names.into_iter().map(str::to_owned).zip(folds).collect() })
    }

    /// The fold of a subject, counted from 0.
    pub fn of(&self, subject: &str) -> usize {
        self.dealt.get(subject).copied().unwrap_or_else(|| fold_of(subject, self.count))
    }
}

/// The fold of each case, of so many, subjects dealt in the order of their names; and how many subjects there are.
pub(crate) fn dealt<'s>(subjects: impl Iterator<Item = &'s str> + Clone, folds: usize) -> (Vec<usize>, usize) {
    let order: BTreeSet<&str> = subjects.clone().collect();
    (subjects.map(|subject| order.range(..subject).count() % folds).collect(), order.len())
}

/// The models of the folds, and the figures over all examples.
type Validated<'a, E> = (Vec<<E as Example<'a>>::Model>, Vec<<E as Example<'a>>::Scores>);

/// Fits models without each fold's subjects and judges them by those: `fit` gets the number of the fold, counted from 1, and which cases it
/// holds out.
///
/// # Errors
///
/// Those of `fit`, and of [`Example::judge`].
pub fn cross_validate<'a, E: Example<'a>>(
    examples: &[&E],
    folds: &Folds,
    mut fit: impl FnMut(usize, &dyn Fn(&Case) -> bool) -> Result<E::Model>,
) -> Result<Validated<'a, E>> {
    let (mut models, mut everything) = (Vec::new(), Vec::new());
    for fold in 0..folds.count {
        let is_held_out = |case: &Case| folds.of(&case.subject) == fold;
        let mut model = fit(fold + 1, &is_held_out)?;
        let outer: Vec<&E> = examples.iter().copied().filter(|e| is_held_out(e.case())).collect();
        let found = in_order(&outer, |_, e| e.judge(&model)).into_iter().collect::<Result<Vec<_>>>()?;
        let found: Vec<(&E, E::Judged)> =
            outer.iter().zip(found).flat_map(|(e, views)| views.into_iter().map(|judged| (*e, judged))).collect();
        let held_out: BTreeSet<&String> = outer.iter().map(|e| &e.case().subject).collect();
        let (provenance, figures) = E::record(&mut model);
        provenance.held_out = held_out.into_iter().cloned().collect();
        if E::FOLDS_KEEP_FIGURES {
            *figures = scores_of(&found);
        }
        models.push(model);
        everything.extend(found);
    }
    Ok((models, scores_of(&everything)))
}

fn scores_of<'a, E: Example<'a>>(judged: &[(&E, E::Judged)]) -> Vec<E::Scores> {
    E::scores(&judged.iter().map(|(e, judged)| (*e, judged)).collect::<Vec<_>>())
}

/// Probabilities that leave doubt.
const DOUBT: [f64; 2] = [0.05, 0.95];
const BINS: usize = 10;

/// How well weights do on one case.
#[derive(Debug, Clone, PartialEq)]
pub struct CaseScores {
    /// Average precision over all true connections; `None` without one.
    pub average_precision: Option<f64>,
    /// Log-likelihood of the truth.
    pub log_likelihood: f64,
    /// Calibrated probability of every pair of points that is listed, and whether it is right.
    pub pairs: Vec<(f64, bool)>,
}

impl<'a> Example<'a> for CandidateExample<'a> {
    type Model = Weights;
    type Judged = CaseScores;
    type Scores = HeldOutScores;

    fn case(&self) -> &'a Case {
        self.case
    }

    fn judge(&self, weights: &Weights) -> Result<Vec<CaseScores>> {
        let (forests, marginals) = last_pass(&self.extraction, &self.table, weights)?;
        let calibration = weights.calibration_of(&marginals);
        let p = self.table.summed_by_pair(&marginals.edges);
        let listed = p.iter().zip(&self.matches).filter(|(p, _)| **p > LEAST_LISTED);
        let ranked: Vec<(f64, Option<Match>)> = listed.map(|(p, right)| (calibration.apply(*p), *right)).collect();
        let needed = self.case.truth.needed();
        Ok(vec![CaseScores {
            pairs: ranked.iter().map(|(p, right)| (*p, right.is_some())).collect(),
            average_precision: (needed > 0).then(|| average_precision(ranked, needed)),
            log_likelihood: log_likelihood(&forests, &marginals, &self.allowed).0,
        }])
    }

    /// Figures by data set, and by folder of those that have several.
    fn scores(judged: &[(&Self, &CaseScores)]) -> Vec<HeldOutScores> {
        let of = grouped(judged, |e, _| [[&e.case.data_set, ""], [&e.case.data_set, &e.case.group]]);
        let folders = |data_set: &str| of.keys().filter(|[d, group]| *d == data_set && !group.is_empty()).count();
        let listed = of.iter().filter(|([data_set, group], _)| group.is_empty() || folders(data_set) > 1);
        let figures = listed.map(|(group, cases)| {
            let scores = || cases.iter().map(|(_, scores)| scores);
            HeldOutScores {
                of: name_of(*group),
                cases: cases.len(),
                subjects: cases.iter().map(|(e, _)| &e.case.subject).collect::<BTreeSet<_>>().len(),
                average_precision: mean(&scores().filter_map(|t| t.average_precision).collect::<Vec<f64>>()),
                calibration_error: calibration_error(scores().flat_map(|t| t.pairs.iter().copied())),
                log_likelihood: scores().map(|t| t.log_likelihood).sum::<f64>() / cases.len() as f64,
            }
        });
        figures.collect()
    }

    fn record(model: &mut Weights) -> (&mut ModelProvenance, &mut Vec<HeldOutScores>) {
        (&mut model.provenance, &mut model.figures)
    }
}

/// What was judged, by the groups of each.
pub(crate) fn grouped<'e, E, J, K: Ord>(
    judged: &[(&'e E, &'e J)],
    groups: impl Fn(&'e E, &'e J) -> [K; 2],
) -> BTreeMap<K, Vec<(&'e E, &'e J)>> {
    let mut of: BTreeMap<K, Vec<(&E, &J)>> = BTreeMap::new();
    for (e, judged) in judged {
        for group in BTreeSet::from(groups(e, judged)) {
            of.entry(group).or_default().push((*e, *judged));
        }
    }
    of
}

/// The name of a group of cases: data set, folder and image, where there are any.
pub(crate) fn name_of<const N: usize>(group: [&str; N]) -> String {
    group.into_iter().filter(|part| !part.is_empty()).collect::<Vec<&str>>().join("/")
}

/// The mean of some values; `None` of none.
pub(crate) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Average precision of ranked candidates over `needed` ones. Of several candidates that make one connection the first counts and the
/// others are passed over; equal ranks share one threshold.
pub fn average_precision(mut ranked: Vec<(f64, Option<Match>)>, needed: usize) -> f64 {
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut joins = joiner();
    let (mut found, mut wrong, mut sum) = (0, 0, 0.0);
    for tied in ranked.chunk_by(|a, b| a.0 == b.0) {
        let before = found;
        for (_, right) in tied {
            match right {
                None => wrong += 1,
                Some(right) => found += i32::from(joins(right)),
            }
        }
        if found > before {
            sum += f64::from(found - before) * f64::from(found) / f64::from(found + wrong);
        }
    }
    sum / needed.max(1) as f64
}

/// Probabilities with whether they were right, in ten bins: per bin the sums of both, and how many there are.
pub(crate) fn binned(pairs: impl Iterator<Item = (f64, bool)>) -> [[f64; 3]; BINS] {
    let mut bins = [[0.0; 3]; BINS];
    for (p, right) in pairs {
        let bin = &mut bins[((p * BINS as f64) as usize).min(BINS - 1)];
        *bin = [bin[0] + p, bin[1] + f64::from(u8::from(right)), bin[2] + 1.0];
    }
    bins
}

/// Expected calibration error of the pairs that leave doubt: |mean P - share right| over ten bins, by their numbers.
pub fn calibration_error(pairs: impl Iterator<Item = (f64, bool)>) -> Option<f64> {
    let bins = binned(pairs.filter(|(p, _)| DOUBT[0] < *p && *p < DOUBT[1]));
    let count: f64 = bins.iter().map(|bin| bin[2]).sum();
    (count > 0.0).then(|| bins.iter().map(|[p, right, _]| (p - right).abs()).sum::<f64>() / count)
}
