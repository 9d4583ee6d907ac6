//! The model: the probability of every candidate before any flow, from its features, by weights fitted to cases whose connections are known.
//!
//! Candidate e attaches fragment c with weight w_e = exp(β·x_e), or c is a root with weight v_c = exp(γ·z_c); x and z are the
//! features of [`super::features`], and `forest_posterior` makes probabilities of the weights. A later pass measures what the
//! posterior of the pass before says of the surroundings of a candidate ([`FEEDBACK_FEATURES`](super::features::FEEDBACK_FEATURES)) and
//! weighs that too. Last, the probability of a pair of points, summed over its two directions, is calibrated:
//! P = σ(a + b l + c min(l, 0) + d m + e s + f m s), l = ln p/(1 - p), m and s of the whole extraction ([`weights::input_features`]).

pub mod weights;

pub use weights::{CLOSURE_FEATURES, Fold, HeldOutScores, PassWeights, Usual, Weights};
pub use willis_core::support::calibration::Calibration;

use std::collections::{BTreeMap, BTreeSet};

use ndarray::{Array1, Array2, ArrayView1, Axis};

use super::features::{
    Extraction, FreeEnd, MeasuredCandidate, bend_child, bend_parent, features, feedback_features, gap, log_detour, measured,
    relative_size, root_features,
};
use super::search::{EndCandidate, Pairs, unordered};
use willis_core::error::{Error, Result};
use willis_core::forest_posterior::{Edge, Forests, MOST_PAIRS, Marginals, arborescence, is_tangle, marginals};
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::support::distinct;
use willis_core::support::geometry::{centroid, distance, sub};
use willis_core::support::numbered::marked;
use willis_core::support::statistics::{median, sigmoid};
use willis_core::support::ties::{compare, near_zero, steady};

/// The posterior over how the fragments of an extraction are connected.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestPosterior {
    /// The candidates with their features; those between fragments are the edges of the forests, in their order.
    pub table: CandidateTable,
    /// The weights of the last pass.
    pub forests: Forests,
    /// The marginals of the last pass, not calibrated.
    pub marginals: Marginals,
    /// Per candidate the calibrated probability of its pair.
    pub probability: Vec<f64>,
    /// Per fragment the score of leaving it a root then.
    pub root_scores: Vec<f64>,
    /// The candidates within a fragment with the probability that they close a loop that is there.
    pub closures: Vec<(EndCandidate, f64)>,
}

/// The posterior that `weights` give the candidates of an extraction, which should be all of a search.
///
/// # Errors
///
/// Weights without a pass, or of other features than this program measures; fragments in a tangle.
pub fn posterior(extraction: &Extraction, candidates: &[EndCandidate], weights: &Weights) -> Result<ForestPosterior> {
    weights.validate()?;
    let table = CandidateTable::new(extraction, candidates)?;
    let (forests, marginals) = last_pass(extraction, &table, weights)?;
    let calibration = weights.calibration_of(&marginals);
    let of_pair: Vec<f64> = table.summed_by_pair(&marginals.edges).into_iter().map(|p| calibration.apply(p)).collect();
    let probability = table.pairs.of.iter().map(|pair| of_pair[*pair]).collect();
    let root_scores = root_scores(extraction, &marginals);
    let closures = if weights.closure.is_empty() {
        Vec::new()
    } else {
        let kept = arborescence(&forests, &attachment_scores(&table, &marginals, calibration), &root_scores);
        let found = closures(extraction, &table, &weights.passes[0], &marginals, &kept);
        found.iter().map(|c| (c.candidate, c.probability(&weights.closure))).collect()
    };
    Ok(ForestPosterior { table, forests, marginals, probability, root_scores, closures })
}

/// Weights and marginals of the last of all passes; each pass sees the posterior of the one before.
///
/// # Errors
///
/// A graph whose elimination has more joins than memory holds.
pub fn last_pass(extraction: &Extraction, table: &CandidateTable, weights: &Weights) -> Result<(Forests, Marginals)> {
    let mut last: Option<(Forests, Marginals)> = None;
    for pass in &weights.passes {
        let forests = match &last {
            None => table.forests(pass, &table.features)?,
            Some((forests, marginals)) => {
                let feedback = feedback_features(extraction, &table.candidates, forests, marginals);
                table.forests(pass, &table.features_and(&feedback))?
            }
        };
        let marginals = marginals(&forests);
        last = Some((forests, marginals));
    }
    last.ok_or_else(|| Error::parameter("weights", "of no pass", "expected one pass at least"))
}

/// A fragment that blood enters is no false one, so leaving it a root can only lose a connection.
const FED: f64 = 0.3;
/// Where no inlet is given, inlets that nobody marked make every fragment somewhat more likely to lead to one.
const UNMARKED: f64 = 0.7;

/// Per fragment P(root) times 0.3 where blood enters it, times n/(n + 10) elsewhere, n the number of fragments; times 0.7 when no
/// inlet is given. In a circle of few fragments one lost connection changes the whole, in a brain of a hundred one false twig more joins it.
pub fn root_scores(extraction: &Extraction, marginals: &Marginals) -> Vec<f64> {
    let n = extraction.fragments.len() as f64;
    let inlets = known_or_likely_inlets(extraction);
    let fed = marked(extraction.fragments.len(), inlets.iter().map(|point| extraction.fragment[*point]));
    let unmarked = if extraction.inlets.is_empty() { UNMARKED } else { 1.0 };
    marginals.roots.iter().zip(fed).map(|(p, fed)| p * unmarked * if fed { FED } else { n / (n + weights::FEW) }).collect()
}

/// Per candidate the score of attaching its child by it: the share that its direction has of the calibrated probability of its pair.
pub fn attachment_scores(table: &CandidateTable, marginals: &Marginals, calibration: Calibration) -> Vec<f64> {
    let sum = table.summed_by_pair(&marginals.edges);
    let share = |(p, pair): (&f64, &usize)| if sum[*pair] > 0.0 { calibration.apply(sum[*pair]) * (p / sum[*pair]) } else { 0.0 };
    marginals.edges.iter().zip(&table.pairs.of).map(share).collect()
}

/// Log weights are cut at ±25, so that one odd feature does not decide everything.
const MOST_LOG_WEIGHT: f64 = 25.0;

/// The candidates of an extraction, measured.
#[derive(Debug, Clone, PartialEq)]
pub struct CandidateTable {
    /// The candidates between fragments, in the order of the search.
    pub candidates: Vec<EndCandidate>,
    /// The candidates within a fragment.
    pub within: Vec<EndCandidate>,
    /// The features of those within a fragment, shape (candidates within a fragment, features).
    pub within_features: Array2<f64>,
    /// Child and parent fragment of each candidate between fragments.
    pub fragments: Vec<[usize; 2]>,
    /// Those between fragments as pairs of points.
    pub pairs: Pairs,
    /// The features of those between fragments, shape (candidates, features).
    pub features: Array2<f64>,
    /// Features of the fragments as roots, shape (fragments, features).
    pub root_features: Array2<f64>,
}

impl CandidateTable {
    /// Measures the candidates of a search; those within a fragment count among the rivals of the others.
    ///
    /// # Errors
    ///
    /// Fragments that depend on one another so much that their posterior would take very long, before anything is measured: more than 500 million
    /// pairs of fragments meet when they are eliminated one after another.
    pub fn new(extraction: &Extraction, found: &[EndCandidate]) -> Result<Self> {
        let across = || found.iter().filter(|candidate| !candidate.within);
        let links = distinct(across().map(|c| unordered(c.fragments(extraction))));
        let count = extraction.fragments.len();
        if is_tangle(count, &links) {
            let mut gaps: Vec<f64> = across().map(|c| c.gap(extraction)).collect();
            gaps.sort_unstable_by(f64::total_cmp);
            let most = willis_core::network::units::millimetres(gaps[gaps.len() / 2]);
            let given = format!(
                "{count}, of which {} pairs may be joined: by way of others, more than {MOST_PAIRS} pairs depend on one another",
                links.len()
            );
            let fewer = format!("give `max_gap` below {most:.3} mm, which half of the candidates are, or `prior=none`");
            return Err(Error::parameter("fragments", given, format!("evidence takes fewer: {fewer}")));
        }
        let (within, between): (Vec<usize>, Vec<usize>) = (0..found.len()).partition(|row| found[*row].within);
        let all = features(extraction, found);
        let [features, within_features] = [&between, &within].map(|rows| all.select(Axis(0), rows));
        let [candidates, within] = [between, within].map(|rows| rows.into_iter().map(|row| found[row]).collect::<Vec<_>>());
        let pairs = Pairs::new(extraction, &candidates);
        let fragments = candidates.iter().map(|candidate| candidate.fragments(extraction)).collect();
        let root_features = root_features(extraction);
        Ok(Self { candidates, within, within_features, fragments, pairs, features, root_features })
    }

    /// The features of the candidates with more columns.
    pub fn features_and(&self, more: &Array2<f64>) -> Array2<f64> {
        let (rows, own) = self.features.dim();
        Array2::from_shape_fn((rows, own + more.ncols()), |(row, column)| {
            if column < own { self.features[[row, column]] } else { more[[row, column - own]] }
        })
    }

    /// Per pair the sum of a quantity over its candidates, at most 1.
    pub fn summed_by_pair(&self, of_candidate: &[f64]) -> Vec<f64> {
        self.pairs.sum(of_candidate).into_iter().map(|x: f64| x.min(1.0)).collect()
    }

    /// The forests that the weights of a pass make of the features of its candidates.
    ///
    /// # Errors
    ///
    /// A feature or weight that is no number.
    pub fn forests(&self, pass: &PassWeights, features: &Array2<f64>) -> Result<Forests> {
        let cut = |x: &f64| x.clamp(-MOST_LOG_WEIGHT, MOST_LOG_WEIGHT);
        let log_weights: Array1<f64> = features.dot(&ArrayView1::from(&pass.candidate));
        let edge = |([child, parent], w): (&[usize; 2], &f64)| Edge { child: *child, parent: *parent, log_weight: cut(w) };
        let roots = self.root_features.dot(&ArrayView1::from(&pass.root));
        Forests::new(roots.iter().map(cut).collect(), self.fragments.iter().zip(&log_weights).map(edge).collect())
    }
}

/// Whether a log weight is at its limit, where the weights of features no longer move it.
pub fn is_cut(log_weight: f64) -> bool {
    log_weight.abs() >= MOST_LOG_WEIGHT
}

/// So many of the widest free ends are taken for inlets.
const LIKELY_INLETS: usize = 3;

/// The points where blood enters: the inlets given, without any the three widest free ends, of equally wide ones those farthest from the middle
/// of all.
pub fn known_or_likely_inlets(extraction: &Extraction) -> Vec<usize> {
    if !extraction.inlets.is_empty() {
        return extraction.inlets.clone();
    }
    let mut ends: Vec<_> = extraction.ends.iter().collect();
    let at = |end: &FreeEnd| extraction.position[end.point];
    let middle = centroid(ends.iter().map(|end| at(end)));
    let order = |end: &FreeEnd| {
        let [x, y, z] = sub(at(end), middle).map(|x| near_zero(x / extraction.spacing));
        [-steady(end.radius / extraction.spacing), -near_zero(distance(at(end), middle) / extraction.spacing), z, y, x]
    };
    ends.sort_by(|a, b| compare(&order(a), &order(b)).then(a.point.cmp(&b.point)));
    ends.iter().take(LIKELY_INLETS).map(|end| end.point).collect()
}

/// Candidates with a lower score in the first pass close none.
const LEAST_SCORE: f64 = -3.0;

/// A candidate that may close a loop.
pub struct Closure {
    /// The candidate; of two directions the one with the better score.
    pub candidate: EndCandidate,
    /// Its features, as [`CLOSURE_FEATURES`] names them.
    pub features: [f64; 10],
}

impl Closure {
    /// 1/(1 + exp(-b·x)).
    pub fn probability(&self, weights: &[f64]) -> f64 {
        sigmoid(self.features.iter().zip(weights).map(|(x, w)| x * w).sum())
    }
}

/// The candidates that may close a loop once the fragments are joined by the candidates `kept` (per fragment the row of the one
/// that attaches it): those whose ends are left free.
///
/// The features: 1; the score of the first pass, β·x; ln of the path along the vessels over the gap; gap and squared bends
/// as other candidates have them; ln of the end's radius over the median of all ends, and of the thinner radius over the widest end;
/// whether along the joined vessels its two sides are nearest to different inlets; and the sum of the probabilities of the other
/// candidates at its end.
pub fn closures(
    extraction: &Extraction,
    table: &CandidateTable,
    first: &PassWeights,
    marginals: &Marginals,
    kept: &[Option<usize>],
) -> Vec<Closure> {
    let kept: Vec<[usize; 2]> = kept.iter().flatten().map(|row| table.candidates[*row].points(extraction)).collect();
    let used: BTreeSet<usize> = kept.iter().flatten().copied().collect();
    let mut claimed = vec![0.0; extraction.position.len()];
    for (candidate, p) in table.candidates.iter().zip(&marginals.edges) {
        for point in candidate.points(extraction) {
            claimed[point] += p;
        }
    }
    let inlet = nearest_inlet(extraction, &kept);
    let middling = median(&extraction.ends.iter().map(|e| e.radius).collect::<Vec<_>>()).unwrap_or(1.0);
    let score = table.within_features.dot(&ArrayView1::from(&first.candidate));
    let features = |c: &MeasuredCandidate, score: f64| {
        let [from, to] = [inlet[c.child.point], inlet[c.point]];
        let two_inlets = if from.is_some() && to.is_some() && from != to { 1.0 } else { 0.0 };
        let [child, parent] = [bend_child(c), bend_parent(c)].map(|bend| bend.powi(2));
        let (wide, claimed) = ((c.child.radius / middling).ln(), f64::min(claimed[c.child.point], 1.0));
        [1.0, score, log_detour(c), gap(c), child, parent, wide, relative_size(c), two_inlets, claimed]
    };
    let mut best: BTreeMap<[usize; 2], (usize, f64)> = BTreeMap::new();
    let measured = measured(extraction, &table.within);
    for (row, (candidate, score)) in measured.iter().zip(&score).enumerate() {
        let (from, to) = (candidate.child.point, candidate.point);
        if *score > LEAST_SCORE && !used.contains(&from) && !(candidate.parent_end.is_some() && used.contains(&to)) {
            let best = best.entry(unordered([from, to])).or_insert((row, *score));
            if *score > best.1 {
                *best = (row, *score);
            }
        }
    }
    let rows = distinct(best.into_values().map(|(row, _)| row));
    rows.iter().map(|row| Closure { candidate: table.within[*row], features: features(&measured[*row], score[*row]) }).collect()
}

/// Per point the inlet that is nearest along the vessels and the candidates kept; none where no inlet is joined.
fn nearest_inlet(extraction: &Extraction, kept: &[[usize; 2]]) -> Vec<Option<usize>> {
    let points = extraction.position.len();
    let steps = extraction.lines.iter().flat_map(|line| line.windows(2).map(|w| [w[0], w[1]]));
    let length = |[a, b]: [usize; 2]| distance(extraction.position[a], extraction.position[b]);
    let edges = steps.chain(kept.iter().copied()).enumerate().map(|(row, ends)| (row, ends, length(ends)));
    let edges = lengths_at(points, edges);
    let mut nearest = vec![(f64::INFINITY, None); points];
    let mut paths = ShortestPaths::new(points);
    for inlet in known_or_likely_inlets(extraction) {
        paths.search(&[inlet], f64::INFINITY, |point| edges[point].iter().copied(), |_, _| true);
        for (nearest, length) in nearest.iter_mut().zip(paths.lengths()) {
            if *length < nearest.0 {
                *nearest = (*length, Some(inlet));
            }
        }
    }
    nearest.into_iter().map(|(_, inlet)| inlet).collect()
}
