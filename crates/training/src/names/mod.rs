//! Fits the model that names arteries to labelled tracings, whole and broken.

mod atlas;
mod cases;

pub use cases::{LabelledCase, read_labelled_cases};
pub use willis_models::naming::model::NamingModel;

use std::collections::BTreeSet;

use crate::example::dealt;
use crate::minimise::{RegressionRow, logistic};
use atlas::fit_atlas;
use willis_core::error::{Result, require};
use willis_core::sampling::SamplingOptions;
use willis_core::support::{distinct, in_order, model_provenance::ModelProvenance};
use willis_models::candidates::{CandidateOptions, build_with_evidence, model::Weights};
use willis_models::naming::atlas::{LABELS, OTHER, as_one_with_m1, most_probable};
use willis_models::naming::model::{Logistic, logistic_probability};
use willis_models::naming::pieces::PIECE_FEATURES;
use willis_models::naming::presence::{KINDS, PRESENCE_FEATURES, Seen, kind_of};
use willis_models::naming::{Names, NamingScores, labels_of, log_odds, name_again, name_arteries, topologies_say};

/// The penalty of slopes: that of one unit of a standardised slope against the sum over all rows.
const L2: f64 = 0.5;
/// The same for the presence of segments.
const PRESENCE_L2: f64 = 1.5;

/// A case as an atlas without its subject sees it.
struct NamedCase<'a> {
    case: &'a LabelledCase,
    fold: usize,
    names: Names,
}

/// Fits a model of all subjects, whose figures, by level, are those of the models of the folds on the subjects that they never saw; and, behind
/// it, one without each fold's subjects. With fewer folds than subjects, subjects are dealt to the folds in the order of their names.
///
/// # Errors
///
/// Fewer than three subjects, or fewer than two folds; no whole tracing; no broken one.
pub fn fit_names(cases: &[LabelledCase], folds: usize, progress: &mut dyn FnMut(&str)) -> Result<Vec<NamingModel>> {
    let subjects = distinct(cases.iter().map(|c| c.subject.as_str()));
    check(cases, subjects.len(), folds)?;
    // The last model holds nobody out.
    let all = folds;
    let (fold_of, _) = dealt(cases.iter().map(|case| case.subject.as_str()), folds);
    let numbers: Vec<usize> = (0..=all).collect();
    let mut models: Vec<NamingModel> = in_order(&numbers, |_, fold| {
        let inner: Vec<&LabelledCase> = cases.iter().zip(&fold_of).filter(|(_, of)| *of != fold).map(|(case, _)| case).collect();
        NamingModel {
            provenance: ModelProvenance::default(),
            figures: Vec::new(),
            atlas: fit_atlas(&inner),
            // Before anything is fitted, the first pass calls no piece false.
            false_pieces: [[&[f64::NEG_INFINITY][..], &[0.0; PIECE_FEATURES]].concat(), vec![0.0; 2 + PIECE_FEATURES]],
            presence: std::array::from_fn(|_| vec![0.0; 2 + PRESENCE_FEATURES]),
            share: [0.5; KINDS],
        }
    });
    progress("atlases");

    // Twice: the second pass sees the pieces as the first one left them.
    let mut named: Vec<NamedCase> = Vec::new();
    for pass in 0..2 {
        let found = in_order(cases, |at, case| {
            let of = &models[fold_of[at]];
            name_arteries(&case.graph, of)
        });
        let each = cases.iter().zip(&fold_of).zip(found);
        named = each.filter_map(|((case, fold), names)| Some(NamedCase { case, fold: *fold, names: names? })).collect();
        progress(["first pass", "second pass"][pass]);
        for (fold, of) in models.iter_mut().enumerate() {
            of.false_pieces[pass] = fit(&piece_rows(&named, fold, pass, &of.false_pieces[0]), L2);
        }
    }
    let weights = Weights::shipped()?;
    let judged: Vec<JudgedCase> = in_order(&named, |_, one| judge(one, &models[one.fold], &weights));
    let presence_rows = |fold: usize, kind: usize| -> Vec<RegressionRow> {
        let others = judged.iter().filter(|one| one.fold != fold);
        let each = others.flat_map(|one| (0..7).filter(|s| kind_of(*s) == kind).map(move |segment| (one, segment)));
        each.filter_map(|(one, s)| Some(([&[1.0][..], &one.features(s)].concat(), one.case.present[s]?, 1.0))).collect()
    };
    let share = |rows: &[RegressionRow]| (rows.iter().filter(|row| row.1).count() as f64 + 0.5) / (rows.len() as f64 + 1.0);
    for kind in 0..KINDS {
        for (fold, of) in models.iter_mut().enumerate() {
            let rows = presence_rows(fold, kind);
            (of.presence[kind], of.share[kind]) = (fit(&rows, PRESENCE_L2), share(&rows));
        }
    }
    progress("presence");
    let levels = cases.iter().map(|c| c.level.as_str()).collect::<BTreeSet<_>>();
    let figures = levels.into_iter().map(|level| scores_at(level, &judged, &models)).collect();
    for (fold, of) in models.iter_mut().enumerate() {
        let held_out: Vec<String> =
            subjects.iter().enumerate().filter(|(k, _)| k % folds == fold).map(|(_, s)| (*s).to_owned()).collect();
        let own = fold_of.iter().filter(|of| **of != fold).count();
        of.provenance =
            ModelProvenance { cases: own, subjects: subjects.len() - held_out.len(), held_out, ..ModelProvenance::default() };
    }
    models[all].figures = figures;
    models.rotate_right(1);
    Ok(models)
}

/// Whether there is enough to fit to.
fn check(cases: &[LabelledCase], subjects: usize, folds: usize) -> Result<()> {
    require(subjects >= 3, "CASES", format!("{subjects} subjects"), "expected three at least")?;
    let accepted = format!("expected 2 to {subjects}, the number of subjects");
    require((2..=subjects).contains(&folds), "folds", folds, accepted)?;
    [("whole tracing", true), ("broken tracing", false)].into_iter().try_for_each(|(what, whole)| {
        let is_there = cases.iter().any(|case| case.is_whole == whole);
        require(is_there, "CASES", format!("no {what}"), "expected both whole and broken tracings")
    })
}

/// What a model without its subject says of a case.
fn judge<'a>(one: &NamedCase<'a>, of: &NamingModel, weights: &Weights) -> JudgedCase<'a> {
    let names = &one.names;
    let [first, second] = &names.piece_features;
    let both = second.iter().zip(first);
    let pieces = both.map(|(x, before)| of.is_false(x, Some((of.is_false(before, None) + 1e-3).ln()))).collect::<Vec<f64>>();
    let labels = labels_of(&names.nodes, &names.states, &pieces, &of.atlas);
    let at_first = || Seen::of(&names.nodes, &labels, &pieces, &names.bridge_factor, names.seen.evidence);
    let (seen, topologies) = seen_again(names, one.case, of, weights).unwrap_or_else(|| (at_first(), [0.5; 7]));
    JudgedCase { case: one.case, fold: one.fold, right: length_right(one, &labels), topologies, seen }
}

/// What is seen of a case, and the share of its plausible topologies with each segment, once candidates know where blood enters: as `infer`
/// and `classify` see it. `None` where no circle was found.
fn seen_again(names: &Names, case: &LabelledCase, of: &NamingModel, weights: &Weights) -> Option<(Seen, [f64; 7])> {
    let (circle, _) = name_again(&case.network, of, &names.bearings)?.located(&case.network, of).ok()?;
    let graph = build_with_evidence(&case.network, &circle.inlets(), &CandidateOptions::default(), weights).ok()?.0;
    let names = name_again(&graph, of, &names.bearings)?;
    let (circle, _) = names.located(&graph, of).ok()?;
    let topologies = topologies_say(&circle, &names.circle(of), &graph, &SamplingOptions::default());
    Some((names.seen, topologies))
}

/// How the models of the folds did at a level of damage.
fn scores_at(level: &str, judged: &[JudgedCase], models: &[NamingModel]) -> NamingScores {
    let own: Vec<&JudgedCase> = judged.iter().filter(|one| one.case.level == level).collect();
    let n = own.len() as f64;
    // Segments right, all; cases with every segment right.
    let (mut right, mut all, mut exact) = (0.0, 0.0, 0.0);
    for one in &own {
        let mut whole = true;
        for segment in 0..7 {
            let Some(there) = one.case.present[segment] else { continue };
            let said = logistic_probability(&models[one.fold].presence[kind_of(segment)], &one.features(segment));
            let is_right = (said > 0.5) == there;
            all += 1.0;
            right += f64::from(u8::from(is_right));
            whole &= is_right;
        }
        exact += f64::from(u8::from(whole));
    }
    NamingScores {
        of: level.to_owned(),
        cases: own.len(),
        length_right: own.iter().map(|one| one.right[0]).sum::<f64>() / n,
        length_right_mca: own.iter().map(|one| one.right[1]).sum::<f64>() / n,
        presence_right: right / f64::max(all, 1.0),
        exact: exact / n,
    }
}

/// A case with what names and topologies say of its segments.
struct JudgedCase<'a> {
    case: &'a LabelledCase,
    fold: usize,
    /// The shares of the length with the right name.
    right: [f64; 2],
    seen: Seen,
    /// Per segment the share of the plausible topologies that have it.
    topologies: [f64; 7],
}

impl JudgedCase<'_> {
    fn features(&self, segment: usize) -> Vec<f64> {
        [&self.seen.features(segment)[..], &[log_odds(self.topologies[segment])]].concat()
    }
}

/// The features of pieces that an atlas without their subject found, with whether they are false.
fn piece_rows(named: &[NamedCase], without: usize, pass: usize, first: &[f64]) -> Vec<RegressionRow> {
    let mut rows = Vec::new();
    for one in named.iter().filter(|one| one.fold != without) {
        let nodes = &one.names.nodes;
        let known = &one.case.truth;
        if known.nodes.len() != nodes.len() {
            continue;
        }
        let (mut wrong, mut total) = (vec![0.0; nodes.pieces], vec![1e-9; nodes.pieces]);
        for n in 0..nodes.len() {
            total[nodes.piece[n]] += nodes.weight[n];
            wrong[nodes.piece[n]] += if known.label[n] == OTHER { nodes.weight[n] } else { 0.0 };
        }
        for piece in 0..nodes.pieces {
            let mut x = vec![1.0];
            x.extend(one.names.piece_features[pass][piece]);
            if pass == 1 {
                x.push((logistic_probability(first, &one.names.piece_features[0][piece]) + 1e-3).ln());
            }
            rows.push((x, wrong[piece] / total[piece] > 0.5, 1.0));
        }
    }
    rows
}

fn fit(rows: &[RegressionRow], l2: f64) -> Logistic {
    logistic(rows, l2 / rows.len().max(1) as f64)
}

/// The shares of the true length that have the right name: all names, and M1 and M2 as one.
fn length_right(one: &NamedCase, labels: &[[f64; LABELS]]) -> [f64; 2] {
    let known = &one.case.truth;
    let (mut right, mut merged, mut all) = (0.0, 0.0, 1e-9);
    if known.nodes.len() != labels.len() {
        return [0.0; 2];
    }
    for (n, p) in labels.iter().enumerate().filter(|(n, _)| known.label[*n] != OTHER) {
        let best = most_probable(p);
        let w = known.nodes.weight[n];
        all += w;
        right += if best == known.label[n] { w } else { 0.0 };
        merged += if as_one_with_m1(best) == as_one_with_m1(known.label[n]) { w } else { 0.0 };
    }
    [right / all, merged / all]
}
