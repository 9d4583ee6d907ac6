//! The atlas: its labels and states (4 mm pieces along each artery, and one for what is no artery), where each lies, and which follow each other.

use std::collections::BTreeMap;

use super::algebra::{self, Symmetric, inverse};
use crate::circle_of_willis::{Artery, AtlasArtery, BodySide, IN_ATLAS};
use willis_core::support::{distinct, geometry::Point};

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

/// Two states side by side.
pub type StatePair = (AtlasState, AtlasState);
/// The states of the three arms of a bifurcation, in order, and the state of its middle.
pub type StatesOfArms = ([AtlasState; 3], AtlasState);

/// What was fitted to labelled tracings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AtlasData {
    /// Every state but [`NOWHERE`].
    pub pieces: Vec<AtlasPiece>,
    /// Mean and standard deviation of the log radius of what is no artery of the circle.
    pub other_radius: [f64; 2],
    /// The mean of the middles of the tracings.
    pub centroid: Point,
    /// Length in each state, mm.
    pub length: Vec<f64>,
    /// How often states were neighbours within a branch, and of which one is a junction.
    pub neighbours: [BTreeMap<StatePair, f64>; 2],
    /// How often bifurcations were seen.
    pub bifurcations: Vec<(StatesOfArms, f64)>,
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
        let mut prior: Vec<f64> = (0..STATES).map(|s| data.length.get(s).copied().unwrap_or(0.0) + 1.0).collect();
        normalise(&mut prior);
        let counted = data.neighbours.each_ref().map(|counts| {
            let mut table = vec![0.0; STATES * STATES];
            for ((a, b), n) in counts {
                table[a * STATES + b] += n;
            }
            table
        });
        let pairs = [0, 1].map(|k| pair_factors(&tables, &counted, k));
        let gaps = gap_factors(&tables, &counted);
        let bifurcations = Bifurcations::of(&tables, &data.bifurcations, &prior);
        Self { tables, position, direction, log_other: -OTHER_VOLUME.ln(), prior, pairs, gaps, bifurcations, data }
    }

    /// Precisions and log determinants of covariances that are widened by `tau` mm in every direction.
    pub fn widened(&self, tau: f64) -> Vec<(Symmetric, f64)> {
        if tau == 0.0 {
            return self.position.clone();
        }
        let wider = |[a, b, c, d, e, f]: Symmetric| [a + tau * tau, b + tau * tau, c + tau * tau, d, e, f];
        self.data.pieces.iter().map(|piece| inverse(&wider(piece.covariance))).collect()
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
    fn of(tables: &StateTables, seen: &[(StatesOfArms, f64)], prior: &[f64]) -> Self {
        let labels = |arms: &[AtlasState; 3]| arms.map(|state| tables.label[state]);
        let kinds = distinct(seen.iter().map(|((arms, _), _)| labels(arms)));
        let n = kinds.len();
        // Half a bifurcation of each kind more than was seen.
        let mut probability = vec![0.5; n];
        let (mut arm, mut middle) = (vec![0.0; n * 3 * STATES], vec![0.0; n * STATES]);
        for ((arms, at), count) in seen {
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

/// Makes the sum one, but that of nothing.
fn normalise(row: &mut [f64]) {
    if row.iter().sum::<f64>() > 0.0 {
        algebra::normalise(row);
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

/// An artery of the circle, or [`OTHER`]: sided arteries left then right, then the basilar and the anterior communicating artery.
pub type ArteryLabel = usize;
/// A piece of an artery, or [`NOWHERE`].
pub type AtlasState = usize;

/// The length of a state along its artery, mm.
pub const BIN: f64 = 4.0;

/// The sided arteries that the atlas holds.
const SIDED: usize = IN_ATLAS.len() - 2;

/// How many labels there are, [`OTHER`] included.
pub const LABELS: usize = 2 * SIDED + 3;
/// No artery of the circle.
pub const OTHER: ArteryLabel = LABELS - 1;
/// The basilar artery.
pub const BA: ArteryLabel = 2 * SIDED;
/// How many states there are, [`NOWHERE`] included.
pub const STATES: usize = {
    let (mut states, mut family) = (1, 0);
    while family < IN_ATLAS.len() {
        states += if family < SIDED { 2 } else { 1 } * IN_ATLAS[family].bins;
        family += 1;
    }
    states
};
/// The state of what is no artery of the circle.
pub const NOWHERE: AtlasState = STATES - 1;

/// The label of an artery; [`OTHER`] of one that the atlas does not hold.
pub fn label_of(artery: Artery) -> ArteryLabel {
    (0..OTHER).find(|label| artery_of(*label) == Some(artery)).unwrap_or(OTHER)
}

/// The artery of a label; `None` of [`OTHER`].
pub fn artery_of(label: ArteryLabel) -> Option<Artery> {
    let side = BodySide::BOTH[if label < 2 * SIDED { label % 2 } else { 0 }];
    (label != OTHER).then(|| (in_atlas(label).artery)(side))
}

/// The label under which M2 counts as M1.
pub fn as_one_with_m1(of: ArteryLabel) -> ArteryLabel {
    if let Some(Artery::M2(side)) = artery_of(of) { label_of(Artery::M1(side)) } else { of }
}

/// The label of the highest probability, the first of equals.
pub fn most_probable(p: &[f64; LABELS]) -> ArteryLabel {
    (0..LABELS).fold(0, |best, label| if p[label] > p[best] { label } else { best })
}

/// The artery of a label, which is not [`OTHER`], without its side.
pub fn in_atlas(label: ArteryLabel) -> &'static AtlasArtery {
    &IN_ATLAS[if label < 2 * SIDED { label / 2 } else { label - SIDED }]
}

/// The name that willis writes: `L-M2`, `BA`, `other`.
pub fn name_of(label: ArteryLabel) -> String {
    artery_of(label).map_or_else(|| "other".to_owned(), |artery| artery.to_string())
}

/// The label of a name that willis writes.
pub fn label_named(name: &str) -> Option<ArteryLabel> {
    (0..LABELS).find(|label| name_of(*label) == name)
}

/// The label on the other side.
pub fn mirrored(label: ArteryLabel) -> ArteryLabel {
    artery_of(label).map_or(label, |artery| label_of(artery.opposite()))
}

/// The first state of a label.
pub fn first_state(label: ArteryLabel) -> AtlasState {
    (0..label).map(bins_of).sum()
}

/// How many states a label has.
pub fn bins_of(label: ArteryLabel) -> usize {
    if label == OTHER { 1 } else { in_atlas(label).bins }
}

/// A row of a table whose columns are the states.
pub fn row(table: &[f64], at: usize) -> &[f64] {
    &table[at * STATES..(at + 1) * STATES]
}

/// A row of such a table, to be changed.
pub fn row_mut(table: &mut [f64], at: usize) -> &mut [f64] {
    &mut table[at * STATES..(at + 1) * STATES]
}

/// The states of a label.
pub fn states_of(label: ArteryLabel) -> std::ops::Range<AtlasState> {
    first_state(label)..first_state(label) + bins_of(label)
}

/// The state at a distance (mm) along an artery from its reference end.
pub fn state_at(label: ArteryLabel, along: f64) -> AtlasState {
    first_state(label) + ((along / BIN) as usize).min(bins_of(label) - 1)
}

/// Whether the reference end of the first label is where the second one begins or ends.
pub fn begins_at(label: ArteryLabel, other: ArteryLabel) -> bool {
    let begins = |artery: Artery| in_atlas(label).begins_at.iter().any(|at| BodySide::BOTH.map(at).contains(&artery));
    label != OTHER && artery_of(other).is_some_and(begins)
}

/// Tables over the states.
#[derive(Debug, Clone)]
pub struct StateTables {
    /// The label of each state.
    pub label: Vec<ArteryLabel>,
    /// The state's number within its label.
    pub bin: Vec<usize>,
    /// The state on the other side.
    pub mirrored: Vec<AtlasState>,
    /// Whether only one stretch of a patient's arteries can be in the state: not M2, of which there are several, and not a last state,
    /// which has no end.
    pub once: Vec<bool>,
}

impl Default for StateTables {
    /// The tables.
    fn default() -> Self {
        let all: Vec<(ArteryLabel, usize)> =
            (0..LABELS).flat_map(|label| (0..bins_of(label)).map(move |bin| (label, bin))).collect();
        let once = |(label, bin): &(ArteryLabel, usize)| match artery_of(*label) {
            None | Some(Artery::M2(_)) => false,
            Some(artery) => artery == Artery::AComm || bin + 1 < bins_of(*label),
        };
        Self {
            label: all.iter().map(|(label, _)| *label).collect(),
            bin: all.iter().map(|(_, bin)| *bin).collect(),
            mirrored: all.iter().map(|(label, bin)| first_state(mirrored(*label)) + bin).collect(),
            once: all.iter().map(once).collect(),
        }
    }
}

impl StateTables {
    /// Two neighbours in either order, and their mirror images.
    pub fn alike(&self, a: AtlasState, b: AtlasState) -> [StatePair; 4] {
        let (ma, mb) = (self.mirrored[a], self.mirrored[b]);
        [(a, b), (b, a), (ma, mb), (mb, ma)]
    }

    /// The mirror image of a bifurcation, whose arms are in order.
    pub fn mirrored_bifurcation(&self, (arms, middle): StatesOfArms) -> StatesOfArms {
        let mut arms = arms.map(|state| self.mirrored[state]);
        arms.sort_unstable();
        (arms, self.mirrored[middle])
    }

    /// The state so many bins further along the same artery, or none.
    pub fn step(&self, state: AtlasState, bins: isize) -> Option<AtlasState> {
        let to = state.checked_add_signed(bins)?;
        (to < STATES && self.label[to] == self.label[state]).then_some(to)
    }
}
