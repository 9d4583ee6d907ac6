//! Fits the join model to skeletons whose true connections are known: boosted trees in two passes, then the calibration.

use std::collections::BTreeSet;

use ndarray::{Array2, Axis};

use super::cross_validation::fold_of;
use super::example::{Case, image_name, shown};
use super::known_connections::{KnownConnections, Match, found};
use super::logistic::calibrate;
use super::scores::average_precision;
use willis_core::decision::{BEST_FIRST, best_first};
use willis_core::error::{Error, Result};
use willis_core::support::boosted_trees::Boosted;
use willis_core::support::in_order;
use willis_core::support::model_provenance::ModelProvenance;
use willis_core::support::statistics::sigmoid;
use willis_models::candidates::features::Extraction;
use willis_models::candidates::joins::features::join_feature_names;
use willis_models::candidates::joins::image::features::image_feature_names;
use willis_models::candidates::joins::in_image::InImage;
use willis_models::candidates::joins::model::{ImagePass, JoinKind, JoinModel, JoinScores};
use willis_models::candidates::joins::{JoinTable, ShapeScores};
use willis_models::candidates::pairs::Pairs;
use willis_models::candidates::search::SearchOptions;

/// Inner folds, by subject: the second pass and the calibration see only scores of trees that never saw their subject.
const INNER: usize = 3;

/// A skeleton with its known connections and its candidates measured.
pub struct JoinExample<'a> {
    /// The case.
    pub case: &'a Case,
    /// Its candidates.
    pub table: JoinTable,
    /// What is right of the pairs.
    pub truth: PairTruth,
    /// Of the connections, how many candidates it takes to make all of them.
    pub needed: usize,
    /// The images beside it.
    pub images: Vec<ImageExample>,
}

/// What is right of some pairs.
pub struct PairTruth {
    /// Per pair the connection that it makes, if it is right.
    pub matches: Vec<Option<Match>>,
    /// Per pair whether it is right or wrong.
    pub clear: Vec<bool>,
}

/// A skeleton in an image.
pub struct ImageExample {
    /// The name of the image.
    pub name: String,
    /// Its candidates there.
    pub image: InImage,
    /// How noisy it is: see [`Scene::noise_share`](willis_io::masks::Scene::noise_share).
    pub noise_share: f64,
    /// What is right of their pairs.
    pub truth: PairTruth,
}

impl PairTruth {
    fn new(known: &KnownConnections, e: &Extraction, pairs: &Pairs) -> Self {
        let matches: Vec<Option<Match>> = pairs.points.iter().map(|[a, b]| known.matching(*a, *b)).collect();
        let clear = pairs.points.iter().zip(&matches);
        let clear = clear.map(|(points, right)| right.is_some() || !known.is_unclear(points.map(|point| e.position[point])));
        Self { clear: clear.collect(), matches }
    }
}

impl<'a> JoinExample<'a> {
    /// Measures the candidates of a case, whose truth is about the points of the resampled skeleton.
    ///
    /// # Errors
    ///
    /// A node without a position, points that are crowded, an image that cannot be read or does not show the vessels.
    pub fn new(case: &'a Case) -> Result<Self> {
        let table = JoinTable::new(&case.network, SearchOptions::default().branches)?;
        let of_pairs = |pairs: &Pairs| PairTruth::new(&case.truth, &table.extraction, pairs);
        let images = case.images.iter().map(|path| {
            let scene = shown(path, &table.extraction)?;
            let image = InImage::new(&table, &scene, None);
            let (truth, noise_share) = (of_pairs(&image.pairs), scene.noise_share);
            Ok(ImageExample { name: image_name(path), truth, image, noise_share })
        });
        let images = images.collect::<Result<Vec<_>>>()?;
        Ok(Self { case, needed: case.truth.needed(), truth: of_pairs(&table.pairs), table, images })
    }

    /// Measures several cases.
    ///
    /// # Errors
    ///
    /// As [`JoinExample::new`].
    pub fn measure(cases: &[&'a Case]) -> Result<Vec<Self>> {
        in_order(cases, |_, case| Self::new(case)).into_iter().collect()
    }

    /// How many of the candidates that the truth needs are among those found.
    pub fn reached(&self) -> usize {
        found(self.truth.matches.iter().flatten().copied())
    }
}

/// Fits the join model to measured cases. The same cases give the same bits at any number of threads.
///
/// # Errors
///
/// No case with a true connection within reach, fewer subjects than inner folds.
pub fn fit_joins(examples: &[&JoinExample], progress: &mut dyn FnMut(&str)) -> Result<JoinModel> {
    let subjects: BTreeSet<&str> = examples.iter().map(|e| e.case.subject.as_str()).collect();
    if subjects.len() < INNER || examples.iter().all(|e| e.reached() == 0) {
        let accepted = format!("expected {INNER} subjects at least, with true connections within reach");
        return Err(Error::parameter("cases", format!("{} of {} subjects", examples.len(), subjects.len()), accepted));
    }
    let order: Vec<&str> = subjects.iter().copied().collect();
    let fold = |e: &JoinExample| order.iter().position(|s| *s == e.case.subject).unwrap_or(0) % INNER;
    let inner: Vec<usize> = examples.iter().map(|e| fold(e)).collect();
    let all: Vec<usize> = (0..examples.len()).collect();
    let without = |held: usize| all.iter().copied().filter(|at| inner[*at] != held).collect::<Vec<usize>>();
    let within = |held: usize| all.iter().copied().filter(|at| inner[*at] == held).collect::<Vec<usize>>();

    // The first pass; the second sees scores that are out of fold.
    let firsts: Vec<&Array2<f32>> = examples.iter().map(|e| &e.table.features).collect();
    let first = boost(examples, &firsts, &all)?;
    progress("pass 1");
    let mut firsts_without = Vec::new();
    let mut scores: Vec<ShapeScores> = vec![ShapeScores { first: Vec::new(), second: Vec::new() }; examples.len()];
    for held in 0..INNER {
        let trees = boost(examples, &firsts, &without(held))?;
        for at in within(held) {
            scores[at].first = trees.scores(firsts[at]);
        }
        firsts_without.push(trees);
    }
    progress("pass 1, out of fold");
    let seconds = in_order(examples, |at, e| e.table.second(&scores[at].first));
    let seconds: Vec<&Array2<f32>> = seconds.iter().collect();
    let second = boost(examples, &seconds, &all)?;
    progress("pass 2");
    let mut pairs = Vec::new();
    // Per example and image the scores of its pairs.
    let mut in_images: Vec<Vec<Vec<f64>>> = vec![Vec::new(); examples.len()];
    for (held, first_without) in firsts_without.iter().enumerate() {
        let trees = boost(examples, &seconds, &without(held))?;
        for at in within(held) {
            let e = examples[at];
            scores[at].second = e.table.pairs.mean(&trees.scores(seconds[at]));
            let rows = scores[at].second.iter().zip(&e.truth.matches).zip(&e.truth.clear).filter(|(_, clear)| **clear);
            pairs.extend(rows.map(|((score, right), _)| (sigmoid(*score), [], right.is_some(), 1.0)));
            in_images[at] = in_order(&e.images, |_, of| of.image.scores(&e.table, [first_without, &trees], &scores[at]));
        }
    }
    progress("calibration");
    let image = fit_image_pass(examples, &in_images, &inner)?;
    if image.is_some() {
        progress("images");
    }
    Ok(JoinModel {
        kind: JoinKind::Skeleton,
        calibration: calibrate(pairs.into_iter()).0,
        features: join_feature_names().into_iter().map(str::to_owned).collect(),
        passes: [first, second],
        image,
        provenance: ModelProvenance::of(examples.len(), subjects.len()),
        figures: Vec::new(),
    })
}

/// The pass over images, given per example and image scores that are out of fold, and the inner fold of each example; `None` without images.
fn fit_image_pass(examples: &[&JoinExample], scores: &[Vec<Vec<f64>>], inner: &[usize]) -> Result<Option<ImagePass>> {
    let with_scores = |at: usize| examples[at].images.iter().zip(&scores[at]).map(move |(image, scores)| (at, image, scores));
    let views: Vec<(usize, &ImageExample, &Vec<f64>)> = (0..examples.len()).flat_map(with_scores).collect();
    if views.is_empty() {
        return Ok(None);
    }
    let features = in_order(&views, |_, (at, of, scores)| of.image.features(&examples[*at].table, scores));
    let rows_of = |is_in: &dyn Fn(usize) -> bool| {
        let mut rows: Vec<(usize, usize)> = Vec::new();
        for (view, (_, of, scores)) in views.iter().enumerate().filter(|(_, (at, ..))| is_in(*at)) {
            let seen = |p: &usize| of.truth.clear[*p] && of.image.between.is_seen(*p, scores[*p]);
            rows.extend((0..scores.len()).filter(seen).map(|p| (view, p)));
        }
        rows
    };
    let is_right = |(view, pair): &(usize, usize)| views[*view].1.truth.matches[*pair].is_some();
    let trees_of = |rows: &[(usize, usize)]| {
        let right: Vec<bool> = rows.iter().map(is_right).collect();
        let value = |row: usize, column: usize| features[rows[row].0][[rows[row].1, column]];
        super::boosting::boost(rows.len(), image_feature_names().len(), value, &right)
    };
    let mut pairs = Vec::new();
    for held in 0..INNER {
        let trees = trees_of(&rows_of(&|at| inner[at] != held))?;
        let scores: Vec<Vec<f64>> = features.iter().map(|f| trees.scores(f)).collect();
        let rows = rows_of(&|at| inner[at] == held);
        pairs.extend(rows.iter().map(|row| (sigmoid(scores[row.0][row.1]), [], is_right(row), 1.0)));
    }
    let noise = views.iter().map(|(_, of, _)| of.noise_share);
    let noise = [noise.clone().fold(f64::INFINITY, f64::min), noise.fold(0.0, f64::max)];
    Ok(Some(ImagePass {
        calibration: calibrate(pairs.into_iter()).0,
        noise,
        features: image_feature_names().into_iter().map(str::to_owned).collect(),
        trees: trees_of(&rows_of(&|_| true))?,
    }))
}

/// Boosted trees over the candidates of some of the cases, those that are neither right nor wrong left out.
fn boost(examples: &[&JoinExample], features: &[&Array2<f32>], cases: &[usize]) -> Result<Boosted> {
    let mut rows: Vec<(usize, usize)> = Vec::new();
    let mut right = Vec::new();
    for at in cases {
        let e = examples[*at];
        for (row, pair) in e.table.pairs.of.iter().enumerate().filter(|(_, pair)| e.truth.clear[**pair]) {
            rows.push((*at, row));
            right.push(e.truth.matches[*pair].is_some());
        }
    }
    let columns = features.first().map_or(0, |f| f.len_of(Axis(1)));
    super::boosting::boost(rows.len(), columns, |row, column| features[rows[row].0][[rows[row].1, column]], &right)
}

/// Probability of every pair of a case, and what is kept of them.
struct JudgedPairs<'a> {
    /// The name of the image; empty without one.
    image: &'a str,
    truth: &'a PairTruth,
    probability: Vec<f64>,
    kept: Vec<bool>,
}

fn judge<'a>(e: &'a JoinExample, model: &JoinModel, of: Option<&'a ImageExample>) -> JudgedPairs<'a> {
    let scores = e.table.scores(model);
    let (probability, pairs) = match of {
        Some(of) => (of.image.probabilities(&e.table, model, &scores), &of.image.pairs),
        None => (e.table.probabilities(model, &scores), &e.table.pairs),
    };
    let ends: Vec<[Option<usize>; 2]> =
        pairs.points.iter().map(|points| points.map(|point| e.table.extraction.end_at[point])).collect();
    let kept = best_first(&probability, &ends, BTreeSet::new(), BEST_FIRST);
    JudgedPairs { image: of.map_or("", |of| &of.name), truth: of.map_or(&e.truth, |of| &of.truth), probability, kept }
}

/// Cross-validation by subject: models without each fold's subjects, judged by those. The models of the folds, and the figures over
/// all cases by data set and folder.
///
/// # Errors
///
/// Those of [`fit_joins`].
pub fn cross_validate_joins(
    examples: &[JoinExample],
    folds: usize,
    progress: &mut dyn FnMut(usize, &str),
) -> Result<(Vec<JoinModel>, Vec<JoinScores>)> {
    let (mut models, mut judged) = (Vec::new(), Vec::new());
    for fold in 0..folds {
        let held = |e: &&JoinExample| fold_of(&e.case.subject, folds) == fold;
        let inner: Vec<&JoinExample> = examples.iter().filter(|e| !held(e)).collect();
        let mut model = fit_joins(&inner, &mut |step| progress(fold + 1, step))?;
        let outer: Vec<&JoinExample> = examples.iter().filter(held).collect();
        let views: Vec<(&JoinExample, Option<&ImageExample>)> =
            outer.iter().flat_map(|e| std::iter::once(None).chain(e.images.iter().map(Some)).map(|image| (*e, image))).collect();
        let found: Vec<JudgedPairs> = in_order(&views, |_, (e, image)| judge(e, &model, *image));
        let subjects: BTreeSet<&String> = outer.iter().map(|e| &e.case.subject).collect();
        model.provenance.held_out = subjects.into_iter().cloned().collect();
        let pairs: Vec<(&JoinExample, &JudgedPairs)> = views.iter().map(|(e, _)| *e).zip(&found).collect();
        model.figures = join_scores(&pairs);
        models.push(model);
        judged.extend(views.into_iter().map(|(e, _)| e).zip(found));
    }
    let figures = join_scores(&judged.iter().map(|(e, j)| (*e, j)).collect::<Vec<_>>());
    Ok((models, figures))
}

/// Figures by data set, by folder of those that have several, and by image.
fn join_scores(judged: &[(&JoinExample, &JudgedPairs)]) -> Vec<JoinScores> {
    let mut groups: BTreeSet<(&str, &str, &str)> = BTreeSet::new();
    for (e, judged) in judged {
        groups.insert((&e.case.data_set, "", judged.image));
        groups.insert((&e.case.data_set, &e.case.group, judged.image));
    }
    let of_group = |(data_set, group, image): (&str, &str, &str)| {
        let is_in = |e: &JoinExample| e.case.data_set == data_set && (group.is_empty() || e.case.group == group);
        let of: Vec<&(&JoinExample, &JudgedPairs)> =
            judged.iter().filter(|(e, judged)| is_in(e) && judged.image == image).collect();
        let name = [data_set, group, image].into_iter().filter(|part| !part.is_empty()).collect::<Vec<&str>>().join("/");
        scores_of(name, &of)
    };
    groups.into_iter().map(of_group).collect()
}

const BINS: usize = 10;

fn scores_of(name: String, of: &[&(&JoinExample, &JudgedPairs)]) -> JoinScores {
    let (mut precisions, mut bins) = (Vec::new(), [[0.0; 2]; BINS]);
    let (mut kept, mut right, mut needed, mut expected, mut all, mut true_pairs) = (0, 0, 0, 0.0, 0, 0);
    for (e, judged) in of {
        let PairTruth { matches, clear } = judged.truth;
        let clear: Vec<usize> = (0..clear.len()).filter(|pair| clear[*pair]).collect();
        let ranked = clear.iter().map(|pair| (judged.probability[*pair], matches[*pair])).collect();
        if e.needed > 0 {
            precisions.push(average_precision(ranked, e.needed));
        }
        for pair in &clear {
            let (p, is_right) = (judged.probability[*pair], matches[*pair].is_some());
            let bin = &mut bins[((p * BINS as f64) as usize).min(BINS - 1)];
            bin[0] += p;
            bin[1] += f64::from(u8::from(is_right));
            expected += p;
            true_pairs += usize::from(is_right);
        }
        all += clear.len();
        let chosen: Vec<usize> = clear.into_iter().filter(|pair| judged.kept[*pair]).collect();
        let made = found(chosen.iter().filter_map(|pair| matches[*pair]));
        // A second candidate for the same connection is neither gain nor loss.
        kept += made + chosen.iter().filter(|pair| matches[**pair].is_none()).count();
        right += made;
        needed += e.needed;
    }
    let share = |of: usize, whole: usize| (whole > 0).then(|| of as f64 / whole as f64);
    JoinScores {
        of: name,
        cases: of.len(),
        subjects: of.iter().map(|(e, _)| &e.case.subject).collect::<BTreeSet<_>>().len(),
        average_precision: (!precisions.is_empty()).then(|| precisions.iter().sum::<f64>() / precisions.len() as f64),
        precision: share(right, kept),
        recall: share(right, needed),
        calibration_error: bins.iter().map(|[p, right]| (p - right).abs()).sum::<f64>()
            / f64::from(u32::try_from(all.max(1)).unwrap_or(u32::MAX)),
        expected,
        right: true_pairs,
    }
}
