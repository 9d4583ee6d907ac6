//! Cross-validation by subject: every case is judged by weights that never saw its subject.

use std::collections::BTreeSet;

use super::example::{CandidateExample, Case, share_of};
use super::fit::{FittedPass, TrainParams, fit};
use super::scores::{CaseScores, case_scores, held_out_scores};
use willis_core::error::{Error, Result};
use willis_core::support::in_order;
use willis_models::candidates::model::weights::{Fold, HeldOutScores, Weights};

/// The fold, of so many, that holds a subject out: by a hash of its name.
pub fn fold_of(subject: &str, folds: usize) -> usize {
    ((share_of(&["fold", subject]) * folds as f64) as usize).min(folds.saturating_sub(1))
}

/// The outcome of a cross-validation.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidation {
    /// Over all cases.
    pub figures: Vec<HeldOutScores>,
    /// Fold by fold.
    pub folds: Vec<Fold>,
    /// The weights of each fold.
    pub weights: Vec<Weights>,
}

/// Fits weights without each fold's subjects and judges them by those. `training` and `judged` are the same cases, measured for
/// the one purpose and the other; the cases in `calibrating` have a part in the calibration alone, and are judged too. `progress` is
/// called after every pass with the number of the fold, counted from 1.
///
/// # Errors
///
/// Fewer than two folds, a fold without any subject on one side, and those of [`fit`].
pub fn cross_validate(
    training: &[&CandidateExample],
    judged: &[&CandidateExample],
    calibrating: &[&CandidateExample],
    folds: usize,
    params: &TrainParams,
    progress: &mut dyn FnMut(usize, &FittedPass),
) -> Result<CrossValidation> {
    let all: Vec<&Case> = training.iter().map(|e| e.case).collect();
    check_folds(&all, folds)?;
    let outside = |e: &CandidateExample, fold: usize| fold_of(&e.case.subject, folds) == fold;
    let mut out = CrossValidation { figures: Vec::new(), folds: Vec::new(), weights: Vec::new() };
    let mut everything: Vec<(&CandidateExample, CaseScores)> = Vec::new();
    for fold in 0..folds {
        let inner: Vec<&CandidateExample> = training.iter().copied().filter(|e| !outside(e, fold)).collect();
        let calibrating_inner: Vec<&CandidateExample> = calibrating.iter().copied().filter(|e| !outside(e, fold)).collect();
        let mut weights = fit(&inner, &calibrating_inner, params, &mut |step| progress(fold + 1, step))?;
        let outer: Vec<&CandidateExample> = judged.iter().chain(calibrating).copied().filter(|e| outside(e, fold)).collect();
        let scores = in_order(&outer, |_, e| case_scores(e, &weights)).into_iter().collect::<Result<Vec<CaseScores>>>()?;
        let held_out: BTreeSet<&String> = outer.iter().map(|e| &e.case.subject).collect();
        let held_out: Vec<String> = held_out.into_iter().cloned().collect();
        weights.provenance.held_out.clone_from(&held_out);
        let of: Vec<(&CandidateExample, &CaseScores)> = outer.iter().copied().zip(&scores).collect();
        weights.figures = held_out_scores(&of);
        out.folds.push(Fold { held_out, figures: weights.figures.clone() });
        out.weights.push(weights);
        everything.extend(outer.into_iter().zip(scores));
    }
    out.figures = held_out_scores(&everything.iter().map(|(e, t)| (*e, t)).collect::<Vec<_>>());
    Ok(out)
}

/// Whether every fold has subjects to fit to and subjects to judge by.
///
/// # Errors
///
/// It has not: says how many subjects there are.
pub fn check_folds(cases: &[&Case], folds: usize) -> Result<()> {
    let subjects: BTreeSet<&str> = cases.iter().map(|c| c.subject.as_str()).collect();
    let taken: BTreeSet<usize> = subjects.iter().map(|s| fold_of(s, folds)).collect();
    if folds < 2 || taken.len() < folds {
        let accepted = match subjects.len() {
            n if folds >= 2 => format!("leaves a fold empty: expected fewer for {n} subjects, or 0 for none"),
            _ => "expected 0 for no cross-validation, or 2 or more".to_owned(),
        };
        return Err(Error::parameter("folds", folds, accepted));
    }
    Ok(())
}
