//! How well weights do on cases: average precision, calibration error, log-likelihood.

use std::collections::{BTreeMap, BTreeSet};

use super::example::CandidateExample;
use super::fit::LEAST_LISTED;
use super::known_connections::{JoinedPieces, Match};
use willis_core::error::Result;
use willis_core::forest_posterior::log_likelihood;
use willis_models::candidates::model::posterior::last_pass;
use willis_models::candidates::model::weights::{HeldOutScores, Weights};

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

/// Judges weights by a case.
///
/// # Errors
///
/// Weights of other features.
pub fn case_scores(example: &CandidateExample, weights: &Weights) -> Result<CaseScores> {
    let (forests, marginals) = last_pass(&example.extraction, &example.table, weights)?;
    let calibration = weights.calibration_of(&marginals);
    let p = example.table.summed_by_pair(&marginals.edges);
    let listed = p.iter().zip(&example.matches).filter(|(p, _)| **p > LEAST_LISTED);
    let ranked: Vec<(f64, Option<Match>)> = listed.map(|(p, right)| (calibration.apply(*p), *right)).collect();
    let needed = example.case.truth.needed();
    Ok(CaseScores {
        pairs: ranked.iter().map(|(p, right)| (*p, right.is_some())).collect(),
        average_precision: (needed > 0).then(|| average_precision(ranked, needed)),
        log_likelihood: log_likelihood(&forests, &marginals, &example.allowed).0,
    })
}

/// Average precision of ranked candidates over `needed` ones. Of several candidates that make one connection the first counts and the
/// others are passed over; equal ranks share one threshold.
pub fn average_precision(mut ranked: Vec<(f64, Option<Match>)>, needed: usize) -> f64 {
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut joined = JoinedPieces::default();
    let (mut found, mut wrong, mut sum) = (0, 0, 0.0);
    for tied in ranked.chunk_by(|a, b| a.0 == b.0) {
        let before = found;
        for (_, right) in tied {
            match right {
                None => wrong += 1,
                Some(right) => found += i32::from(joined.join(*right)),
            }
        }
        if found > before {
            sum += f64::from(found - before) * f64::from(found) / f64::from(found + wrong);
        }
    }
    sum / needed.max(1) as f64
}

/// Expected calibration error of the pairs that leave doubt: |mean P - share right| over ten bins, by their numbers.
pub fn calibration_error(pairs: impl Iterator<Item = (f64, bool)>) -> Option<f64> {
    let mut bins = [[0.0; 3]; BINS];
    for (p, right) in pairs.filter(|(p, _)| DOUBT[0] < *p && *p < DOUBT[1]) {
        let bin = &mut bins[((p * BINS as f64) as usize).min(BINS - 1)];
        for (sum, x) in bin.iter_mut().zip([p, f64::from(u8::from(right)), 1.0]) {
            *sum += x;
        }
    }
    let count: f64 = bins.iter().map(|bin| bin[2]).sum();
    (count > 0.0).then(|| bins.iter().map(|[p, right, _]| (p - right).abs()).sum::<f64>() / count)
}

/// Scores by data set, and by folder of those that have several.
pub fn held_out_scores(cases: &[(&CandidateExample, &CaseScores)]) -> Vec<HeldOutScores> {
    let mut of: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
    for (row, (example, _)) in cases.iter().enumerate() {
        of.entry((&example.case.data_set, "")).or_default().push(row);
        if !example.case.group.is_empty() {
            of.entry((&example.case.data_set, &example.case.group)).or_default().push(row);
        }
    }
    let folders = |data_set: &str| of.keys().filter(|(d, g)| *d == data_set && !g.is_empty()).count();
    of.iter()
        .filter(|((data_set, group), _)| group.is_empty() || folders(data_set) > 1)
        .map(|((data_set, group), rows)| {
            let scores = || rows.iter().map(|row| cases[*row].1);
            let precisions: Vec<f64> = scores().filter_map(|t| t.average_precision).collect();
            HeldOutScores {
                of: if group.is_empty() { (*data_set).to_owned() } else { format!("{data_set}/{group}") },
                cases: rows.len(),
                subjects: rows.iter().map(|row| &cases[*row].0.case.subject).collect::<BTreeSet<_>>().len(),
                average_precision: (!precisions.is_empty()).then(|| precisions.iter().sum::<f64>() / precisions.len() as f64),
                calibration_error: calibration_error(scores().flat_map(|t| t.pairs.iter().copied())),
                log_likelihood: scores().map(|t| t.log_likelihood).sum::<f64>() / rows.len() as f64,
            }
        })
        .collect()
}
