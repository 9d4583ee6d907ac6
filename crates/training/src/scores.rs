//! How well weights do on cases: average precision, calibration error, log-likelihood.

use std::collections::{BTreeMap, BTreeSet};

use super::example::{CandidateExample, Case, Example};
use super::fit::LEAST_LISTED;
use super::known_connections::{JoinedPieces, Match};
use willis_core::error::Result;
use willis_core::forest_posterior::log_likelihood;
use willis_core::support::model_provenance::ModelProvenance;
use willis_models::candidates::model::{HeldOutScores, Weights, last_pass};

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
    const FOLDS_KEEP_FIGURES: bool = true;

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
        of.iter()
            .filter(|([data_set, group], _)| group.is_empty() || folders(data_set) > 1)
            .map(|(group, cases)| {
                let scores = || cases.iter().map(|(_, scores)| scores);
                HeldOutScores {
                    of: name_of(*group),
                    cases: cases.len(),
                    subjects: cases.iter().map(|(e, _)| &e.case.subject).collect::<BTreeSet<_>>().len(),
                    average_precision: mean(&scores().filter_map(|t| t.average_precision).collect::<Vec<f64>>()),
                    calibration_error: calibration_error(scores().flat_map(|t| t.pairs.iter().copied())),
                    log_likelihood: scores().map(|t| t.log_likelihood).sum::<f64>() / cases.len() as f64,
                }
            })
            .collect()
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
