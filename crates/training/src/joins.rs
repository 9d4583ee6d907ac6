//! Fits the join model to skeletons whose true connections are known: boosted trees in two passes, then the calibration.

use std::collections::BTreeSet;

use ndarray::Array2;

use super::example::{
    Case, Example, Model, TreeExample, average_precision, binned, dealt, grouped, image_name, mean, name_of, shown,
};
use super::known_connections::{KnownConnections, Match, found};
use super::{boosting::boost, minimise::calibrate};
use willis_core::decision::{BEST_FIRST, best_first};
use willis_core::error::{Result, require};
use willis_core::support::{boosted_trees::Boosted, in_order, model_provenance::ModelProvenance, statistics::sigmoid};
use willis_models::candidates::joins::model::{ImagePass, JoinKind, JoinModel, JoinScores};
use willis_models::candidates::joins::{
    JoinTable, ShapeScores, features::join_feature_names, image::InImage, image::features::image_feature_names,
};
use willis_models::candidates::{features::Extraction, search::Pairs, search::SearchOptions};

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

impl JoinExample<'_> {
    /// How many of the candidates that the truth needs are among those found.
    pub fn reached(&self) -> usize {
        found(self.truth.matches.iter().flatten().copied())
    }
}

impl<'a> TreeExample<'a> for JoinExample<'a> {
    const KIND: Model = Model::Skeleton;

    /// Measures the candidates of a case, whose truth is about the points of the resampled skeleton.
    fn new(case: &'a Case) -> Result<Self> {
        let table = JoinTable::new(&case.network, SearchOptions::default().branches)?;
        let of_pairs = |pairs: &Pairs| PairTruth::new(&case.truth, &table.extraction, pairs);
        let images = case.images.iter().map(|path| {
            let scene = shown(path, case.network.frame, &table.extraction)?;
            let image = InImage::new(&table, &scene, None);
            let (truth, noise_share) = (of_pairs(&image.pairs), scene.noise_share);
            Ok(ImageExample { name: image_name(path), truth, image, noise_share })
        });
        let images = images.collect::<Result<Vec<_>>>()?;
        Ok(Self { case, truth: of_pairs(&table.pairs), table, images })
    }

    fn fit(examples: &[&Self], progress: &mut dyn FnMut(&str)) -> Result<JoinModel> {
        let (inner, subjects) = dealt(examples.iter().map(|e| e.case.subject.as_str()), INNER);
        let accepted = format!("expected {INNER} subjects at least, with true connections within reach");
        let is_enough = subjects >= INNER && examples.iter().any(|e| e.reached() > 0);
        require(is_enough, "cases", format!("{} of {subjects} subjects", examples.len()), accepted)?;
        let all: Vec<usize> = (0..examples.len()).collect();
        // The cases that are fitted to, and those that are held out.
        let parted = |held: usize| all.iter().copied().partition::<Vec<usize>, _>(|at| inner[*at] != held);

        // The first pass; the second sees scores that are out of fold.
        let firsts: Vec<&Array2<f32>> = examples.iter().map(|e| &e.table.features).collect();
        let first = boost_cases(examples, &firsts, &all)?;
        progress("pass 1");
        let mut firsts_without = Vec::new();
        let mut scores: Vec<ShapeScores> = vec![ShapeScores { first: Vec::new(), second: Vec::new() }; examples.len()];
        for held in 0..INNER {
            let (without, within) = parted(held);
            let trees = boost_cases(examples, &firsts, &without)?;
            for at in within {
                scores[at].first = trees.scores(firsts[at]);
            }
            firsts_without.push(trees);
        }
        progress("pass 1, out of fold");
        let seconds = in_order(examples, |at, e| e.table.second(&scores[at].first));
        let seconds: Vec<&Array2<f32>> = seconds.iter().collect();
        let second = boost_cases(examples, &seconds, &all)?;
        progress("pass 2");
        let mut pairs = Vec::new();
        // Per example and image the scores of its pairs.
        let mut in_images: Vec<Vec<Vec<f64>>> = vec![Vec::new(); examples.len()];
        for (held, first_without) in firsts_without.iter().enumerate() {
            let (without, within) = parted(held);
            let trees = boost_cases(examples, &seconds, &without)?;
            for at in within {
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
            provenance: ModelProvenance::of(examples.len(), subjects),
            figures: Vec::new(),
        })
    }
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
        let mut rows: Vec<(usize, usize, bool)> = Vec::new();
        for (view, (_, of, scores)) in views.iter().enumerate().filter(|(_, (at, ..))| is_in(*at)) {
            let seen = |p: &usize| of.truth.clear[*p] && of.image.is_seen(*p, scores[*p]);
            rows.extend((0..scores.len()).filter(seen).map(|p| (view, p, of.truth.matches[p].is_some())));
        }
        rows
    };
    let tables: Vec<&Array2<f32>> = features.iter().collect();
    let mut pairs = Vec::new();
    for held in 0..INNER {
        let trees = boost(&tables, &rows_of(&|at| inner[at] != held))?;
        let scores: Vec<Vec<f64>> = features.iter().map(|f| trees.scores(f)).collect();
        let rows = rows_of(&|at| inner[at] == held);
        pairs.extend(rows.iter().map(|(view, pair, right)| (sigmoid(scores[*view][*pair]), [], *right, 1.0)));
    }
    let noise = views.iter().map(|(_, of, _)| of.noise_share);
    let noise = [noise.clone().fold(f64::INFINITY, f64::min), noise.fold(0.0, f64::max)];
    Ok(Some(ImagePass {
        calibration: calibrate(pairs.into_iter()).0,
        noise,
        features: image_feature_names().into_iter().map(str::to_owned).collect(),
        trees: boost(&tables, &rows_of(&|_| true))?,
    }))
}

/// Boosted trees over the candidates of some of the cases, those that are neither right nor wrong left out.
fn boost_cases(examples: &[&JoinExample], features: &[&Array2<f32>], cases: &[usize]) -> Result<Boosted> {
    let mut rows: Vec<(usize, usize, bool)> = Vec::new();
    for at in cases {
        let JoinExample { table, truth, .. } = examples[*at];
        let clear = table.pairs.of.iter().enumerate().filter(|(_, pair)| truth.clear[**pair]);
        rows.extend(clear.map(|(row, pair)| (*at, row, truth.matches[*pair].is_some())));
    }
    boost(features, &rows)
}

/// Probability of every pair of a case, and what is kept of them.
pub struct JudgedPairs {
    /// The image among those of the example; none without one.
    image: Option<usize>,
    probability: Vec<f64>,
    kept: Vec<bool>,
}

impl<'a> Example<'a> for JoinExample<'a> {
    type Model = JoinModel;
    type Judged = JudgedPairs;
    type Scores = JoinScores;

    fn case(&self) -> &'a Case {
        self.case
    }

    fn judge(&self, model: &JoinModel) -> Result<Vec<JudgedPairs>> {
        let views: Vec<Option<usize>> = std::iter::once(None).chain((0..self.images.len()).map(Some)).collect();
        let scores = self.table.scores(model);
        Ok(in_order(&views, |_, image| {
            let (probability, pairs) = match image.map(|row| &self.images[row].image) {
                Some(image) => (image.probabilities(&self.table, model, &scores), &image.pairs),
                None => (self.table.probabilities(model, &scores), &self.table.pairs),
            };
            let ends: Vec<[Option<usize>; 2]> =
                pairs.points.iter().map(|points| points.map(|point| self.table.extraction.end_at[point])).collect();
            let kept = best_first(&probability, &ends, BTreeSet::new(), BEST_FIRST);
            JudgedPairs { image: *image, probability, kept }
        }))
    }

    /// Figures by data set, by folder of those that have several, and by image.
    fn scores(judged: &[(&Self, &JudgedPairs)]) -> Vec<JoinScores> {
        let groups = grouped(judged, |e, judged| {
            let image = judged.image.map_or("", |row| &e.images[row].name);
            [[&e.case.data_set, "", image], [&e.case.data_set, &e.case.group, image]]
        });
        groups.into_iter().map(|(group, of)| scores_of(name_of(group), &of)).collect()
    }

    fn record(model: &mut JoinModel) -> (&mut ModelProvenance, &mut Vec<JoinScores>) {
        (&mut model.provenance, &mut model.figures)
    }
}

fn scores_of(name: String, of: &[(&JoinExample, &JudgedPairs)]) -> JoinScores {
    let (mut precisions, mut pairs) = (Vec::new(), Vec::new());
    let (mut kept, mut right, mut needed) = (0, 0, 0);
    for (e, judged) in of {
        let PairTruth { matches, clear } = judged.image.map_or(&e.truth, |row| &e.images[row].truth);
        let clear: Vec<usize> = (0..clear.len()).filter(|pair| clear[*pair]).collect();
        let ranked: Vec<(f64, Option<Match>)> = clear.iter().map(|pair| (judged.probability[*pair], matches[*pair])).collect();
        pairs.extend(ranked.iter().map(|(p, right)| (*p, right.is_some())));
        let all = e.case.truth.needed();
        if all > 0 {
            precisions.push(average_precision(ranked, all));
        }
        let chosen: Vec<usize> = clear.into_iter().filter(|pair| judged.kept[*pair]).collect();
        let made = found(chosen.iter().filter_map(|pair| matches[*pair]));
        // A second candidate for the same connection is neither gain nor loss.
        kept += made + chosen.iter().filter(|pair| matches[**pair].is_none()).count();
        right += made;
        needed += all;
    }
    let share = |of: usize, whole: usize| (whole > 0).then(|| of as f64 / whole as f64);
    let errors = binned(pairs.iter().copied()).map(|[p, right, _]| (p - right).abs());
    JoinScores {
        of: name,
        cases: of.len(),
        subjects: of.iter().map(|(e, _)| &e.case.subject).collect::<BTreeSet<_>>().len(),
        average_precision: mean(&precisions),
        precision: share(right, kept),
        recall: share(right, needed),
        calibration_error: errors.iter().sum::<f64>() / pairs.len().max(1) as f64,
        expected: pairs.iter().fold(0.0, |sum, (p, _)| sum + p),
        right: pairs.iter().filter(|(_, right)| *right).count(),
    }
}
