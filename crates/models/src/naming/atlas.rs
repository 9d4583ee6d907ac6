//! The atlas: where each piece of each artery lies, how it runs, how wide it is, and which pieces follow each other.

use super::algebra::{Symmetric, inverse, plus_diagonal};
use super::states::{AtlasState, LABELS, NOWHERE, STATES, StateTables};
use willis_core::support::geometry::Point;

/// Where a state lies and how it looks, in the frame of the atlas: mm, RAS, about the middle between the carotid bifurcations.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct AtlasPiece {
    /// Mean position, mm.
    pub mean: Point,
    /// Covariance of the position, mm².
    pub covariance: Symmetric,
    /// Matrix of the angular central Gaussian distribution of the direction.
    pub direction: Symmetric,
    /// Mean logarithm of the radius over the median radius of the case.
    pub log_radius: f64,
    /// Its standard deviation.
    pub radius_spread: f64,
}

/// How often states were seen side by side.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Counts {
    /// Length in each state, mm.
    pub length: Vec<f64>,
    /// Neighbours within a branch, and neighbours of which one is a junction: `[state, state, count]`.
    pub neighbours: [Vec<(AtlasState, AtlasState, f64)>; 2],
    /// Bifurcations: the states of the three arms in order, the state of the middle, and how often they were seen.
    pub bifurcations: Vec<([AtlasState; 3], AtlasState, f64)>,
}

/// What was fitted to labelled tracings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AtlasData {
    /// Every state but [`NOWHERE`].
    pub pieces: Vec<AtlasPiece>,
    /// Mean and standard deviation of the log radius of what is no artery of the circle.
    pub other_radius: [f64; 2],
    /// The mean of the middles of the tracings.
    pub centroid: Point,
    /// Neighbours and bifurcations.
    pub counts: Counts,
}

/// The probability of a position that is no artery of the circle: uniform in 120 x 110 x 110 mm.
const OTHER_VOLUME: f64 = 120.0 * 110.0 * 110.0;

/// An atlas made ready for inference.
#[derive(Debug, Clone)]
pub struct Atlas {
    /// What it was made of.
    pub data: AtlasData,
    /// Tables over the states.
    pub tables: StateTables,
    /// Precision (1/mm²) of each state's position, and the log determinant of its covariance.
    pub position: Vec<(Symmetric, f64)>,
    /// Inverse of each state's direction matrix, and the log determinant of that matrix.
    pub direction: Vec<(Symmetric, f64)>,
    /// The log probability density (1/mm³) of a position that is no artery.
    pub log_other: f64,
    /// Per state the share of all length.
    pub prior: Vec<f64>,
    /// P(s, s')/(P(s) P(s')) of neighbours within branches and at junctions, by rows.
    pub pairs: [Vec<f64>; 2],
    /// The same over gaps of about 2, 4 and 8 mm.
    pub gaps: [Vec<f64>; 3],
    /// The kinds of bifurcation.
    pub bifurcations: Bifurcations,
}

/// Kinds of bifurcation: which three arteries meet.
#[derive(Debug, Clone, Default)]
pub struct Bifurcations {
    /// The labels of the three arms, in order.
    pub kinds: Vec<[usize; 3]>,
    /// The probability of each kind.
    pub probability: Vec<f64>,
    /// P(state | kind, arm)/P(state): kinds x 3 x states.
    pub arm: Vec<f64>,
    /// The same for an arm that begins behind a gap.
    pub arm_behind_gap: Vec<f64>,
    /// P(state of the middle | kind): kinds x states.
    pub middle: Vec<f64>,
}

impl Atlas {
    /// The atlas of what was fitted.
    pub fn new(data: AtlasData) -> Self {
        let tables = StateTables::default();
        let position = data.pieces.iter().map(|piece| inverse(&piece.covariance)).collect();
        let direction = data.pieces.iter().map(|piece| inverse(&piece.direction)).collect();
        let mut prior: Vec<f64> = (0..STATES).map(|s| data.counts.length.get(s).copied().unwrap_or(0.0) + 1.0).collect();
        normalise(&mut prior);
        let counted = data.counts.neighbours.each_ref().map(|list| {
            let mut table = vec![0.0; STATES * STATES];
            for (a, b, n) in list {
                table[a * STATES + b] += n;
            }
            table
        });
        let pairs = [0, 1].map(|k| pair_factors(&tables, &counted, k));
        let gaps = gap_factors(&tables, &counted);
        let bifurcations = Bifurcations::of(&tables, &data.counts, &prior);
        Self { tables, position, direction, log_other: -OTHER_VOLUME.ln(), prior, pairs, gaps, bifurcations, data }
    }

    /// Precisions and log determinants of covariances that are widened by `tau` mm in every direction.
    pub fn widened(&self, tau: f64) -> Vec<(Symmetric, f64)> {
        if tau == 0.0 {
            return self.position.clone();
        }
        self.data.pieces.iter().map(|piece| inverse(&plus_diagonal(&piece.covariance, tau * tau))).collect()
    }
}

/// Weights of the same state and of the next one along an artery, beside the counts.
fn smoothing(tables: &StateTables) -> Vec<f64> {
    let mut smooth = vec![0.0; STATES * STATES];
    for state in 0..STATES {
        for bins in [-1, 0, 1] {
            if let Some(to) = tables.step(state, bins) {
                smooth[state * STATES + to] = if bins == 0 { 4.0 } else { 1.0 };
            }
        }
    }
    smooth
}

/// P(s, s')/(P(s) P(s')) from counts: smoothed along the arteries, with a trace of every pair of arteries that were seen side by side, and
/// less of all others. `kind` is 0 within branches, 1 at junctions.
fn pair_factors(tables: &StateTables, counted: &[Vec<f64>; 2], kind: usize) -> Vec<f64> {
    let labels = |k: usize| [tables.label[k / STATES], tables.label[k % STATES]];
    let mut met = [[false; LABELS]; LABELS];
    for k in (0..STATES * STATES).filter(|k| counted[0][*k] + counted[1][*k] > 0.0) {
        let [a, b] = labels(k);
        met[a][b] = true;
    }
    let (along, seen, trace) = [(2.0, 0.002, 2e-4), (0.3, 0.02, 1e-3)][kind];
    let smooth = smoothing(tables);
    let of = |k: usize| {
        let [a, b] = labels(k);
        let known = if met[a][b] { seen } else { 0.0 };
        counted[kind][k] + along * smooth[k] + known + trace
    };
    lift_of(&symmetric(&(0..STATES * STATES).map(of).collect::<Vec<f64>>()))
}

/// The mean of a table and its transpose.
fn symmetric(joint: &[f64]) -> Vec<f64> {
    let at = |a: usize, b: usize| joint[a * STATES + b];
    (0..STATES * STATES).map(|k| 0.5 * (at(k / STATES, k % STATES) + at(k % STATES, k / STATES))).collect()
}

/// P(a, b)/(P(a) P(b)) of a table of joint weights.
fn lift_of(joint: &[f64]) -> Vec<f64> {
    let total: f64 = joint.iter().sum();
    let sums: Vec<f64> = joint.chunks(STATES).map(|row| row.iter().sum::<f64>() / total).collect();
    (0..STATES * STATES).map(|k| joint[k] / total / (sums[k / STATES] * sums[k % STATES] + 1e-12)).collect()
}

/// Factors over gaps: chains of 2, 4 and 8 steps.
fn gap_factors(tables: &StateTables, counted: &[Vec<f64>; 2]) -> [Vec<f64>; 3] {
    let smooth = smoothing(tables);
    let mut step: Vec<f64> = (0..STATES * STATES).map(|k| counted[0][k] + counted[1][k] + 2.0 * smooth[k] + 1e-3).collect();
    step.chunks_mut(STATES).for_each(normalise);
    let mut stationary = vec![1.0 / STATES as f64; STATES];
    for _ in 0..300 {
        let mut next = vec![0.0; STATES];
        for (from, row) in stationary.iter().zip(step.chunks(STATES)) {
            next.iter_mut().zip(row).for_each(|(to, p)| *to += from * p);
        }
        stationary = next;
    }
    let two = matrix_product(&step, &step);
    let four = matrix_product(&two, &two);
    let eight = matrix_product(&four, &four);
    [two, four, eight].map(|chain| {
        let joint: Vec<f64> = (0..STATES * STATES).map(|k| chain[k] * stationary[k / STATES]).collect();
        lift_of(&symmetric(&joint))
    })
}

fn matrix_product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; STATES * STATES];
    for (row, to) in a.chunks(STATES).zip(out.chunks_mut(STATES)) {
        for (x, from) in row.iter().zip(b.chunks(STATES)) {
            to.iter_mut().zip(from).for_each(|(t, f)| *t += x * f);
        }
    }
    out
}

impl Bifurcations {
    fn of(tables: &StateTables, counts: &Counts, prior: &[f64]) -> Self {
        let labels = |arms: &[AtlasState; 3]| arms.map(|state| tables.label[state]);
        let mut kinds: Vec<[usize; 3]> = counts.bifurcations.iter().map(|(arms, ..)| labels(arms)).collect();
        kinds.sort_unstable();
        kinds.dedup();
        let n = kinds.len();
        // Half a bifurcation of each kind more than was seen.
        let mut probability = vec![0.5; n];
        let (mut arm, mut middle) = (vec![0.0; n * 3 * STATES], vec![0.0; n * STATES]);
        for (arms, at, count) in &counts.bifurcations {
            let Ok(kind) = kinds.binary_search(&labels(arms)) else { continue };
            probability[kind] += count;
            for (number, state) in arms.iter().enumerate() {
                spread(tables, *state, &[(-1, 0.15), (0, 0.7), (1, 0.15)], |to, share| {
                    arm[(kind * 3 + number) * STATES + to] += count * share;
                });
            }
            spread(tables, *at, &[(-1, 0.15), (0, 0.7), (1, 0.15)], |to, share| middle[kind * STATES + to] += count * share);
        }
        normalise(&mut probability);
        arm.chunks_mut(STATES).chain(middle.chunks_mut(STATES)).for_each(normalise);
        let mut arm_behind_gap = vec![0.0; n * 3 * STATES];
        for (from, to) in arm.chunks(STATES).zip(arm_behind_gap.chunks_mut(STATES)) {
            for (state, p) in from.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                spread(tables, state, &[(0, 0.4), (1, 0.4), (-1, 0.2)], |at, share| to[at] += p * share);
            }
        }
        for row in arm.chunks_mut(STATES).chain(arm_behind_gap.chunks_mut(STATES)) {
            row.iter_mut().zip(prior).for_each(|(p, all)| *p /= all);
        }
        Self { kinds, probability, arm, arm_behind_gap, middle }
    }
}

/// Shares of a state over those some bins further; what would leave the artery stays.
fn spread(tables: &StateTables, state: AtlasState, shares: &[(isize, f64)], mut add: impl FnMut(AtlasState, f64)) {
    for (bins, share) in shares {
        add(tables.step(state, *bins).unwrap_or(state), *share);
    }
}

fn normalise(row: &mut [f64]) {
    let sum: f64 = row.iter().sum();
    if sum > 0.0 {
        for p in row.iter_mut() {
            *p /= sum;
        }
    }
}

/// The states that are pieces of arteries.
pub fn arteries() -> std::ops::Range<AtlasState> {
    0..NOWHERE
}

/// All states.
pub fn all_states() -> Vec<AtlasState> {
    (0..STATES).collect()
}
