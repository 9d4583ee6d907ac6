//! Cross-validation by subject: every case is judged by weights that never saw its subject.

use std::collections::BTreeSet;

use super::example::{Case, Example, share_of};
use willis_core::error::{Error, Result};
use willis_core::support::in_order;

/// The fold, of so many, that holds a subject out: by a hash of its name.
pub fn fold_of(subject: &str, folds: usize) -> usize {
    ((share_of(&["fold", subject]) * folds as f64) as usize).min(folds.saturating_sub(1))
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
    folds: usize,
    mut fit: impl FnMut(usize, &dyn Fn(&Case) -> bool) -> Result<E::Model>,
) -> Result<Validated<'a, E>> {
    let (mut models, mut everything) = (Vec::new(), Vec::new());
    for fold in 0..folds {
        let is_held_out = |case: &Case| fold_of(&case.subject, folds) == fold;
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

/// Whether every fold has subjects to fit to and subjects to judge by.
///
/// # Errors
///
/// It has not: says how many subjects there are.
pub fn check_folds(cases: &[Case], folds: usize) -> Result<()> {
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
