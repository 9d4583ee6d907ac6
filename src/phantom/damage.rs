//! Which points of every vessel an extraction misses: junctions, stretches midway, ends.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, Exp1, Poisson, StandardNormal, UnitSphere};

use super::breaks::Breaks;
use crate::network::{Network, Role};
use crate::support::geometry::{Point, distance, lerp, unit};

/// The least number of points that damage leaves of a piece of vessel.
const LEAST: usize = 3;

/// A vessel resampled at equal steps, and the inclusive ranges of its points that are still there, in order.
pub(crate) struct Sampled {
    /// Points with radii, both nodes included.
    pub points: Vec<(Point, f64)>,
    /// The step, m.
    pub step: f64,
    /// Mean radius, m.
    pub radius: f64,
    /// What is left; none for a lost vessel.
    pub pieces: Vec<[usize; 2]>,
}

impl Sampled {
    /// The vessel of a row at steps of about `spacing`.
    pub fn of(network: &Network, row: usize, spacing: f64) -> Self {
        Self::at(network, row, |length| ((length / spacing).round() as usize).max(LEAST - 1))
    }

    /// The vessel of a row at as many equal steps as its length (m) asks for, one at least; without path it is straight between its
    /// nodes.
    pub fn at(network: &Network, row: usize, steps: impl FnOnce(f64) -> usize) -> Self {
        let vessel = network.vessel(row);
        let mut path: Vec<(Point, f64)> = vessel.path.iter().map(|p| (p.position, p.radius)).collect();
        if path.len() < 2 {
            let node = |end: usize| network.node(end).position.expect("break_up and gaps refuse nodes without positions");
            path = network.ends(row).map(|end| (node(end), vessel.radius)).to_vec();
        }
        let mut arc = vec![0.0];
        for pair in path.windows(2) {
            arc.push(arc[arc.len() - 1] + distance(pair[0].0, pair[1].0));
        }
        let length = arc[arc.len() - 1];
        let steps = steps(length);
        let mut at = 0;
        let points: Vec<_> = (0..=steps)
            .map(|i| {
                let wanted = length * i as f64 / steps as f64;
                while at + 2 < arc.len() && arc[at + 1] < wanted {
                    at += 1;
                }
                let span = arc[at + 1] - arc[at];
                let share = if i == steps { 1.0 } else { ((wanted - arc[at]) / span.max(f64::MIN_POSITIVE)).min(1.0) };
                let ((p, r), (q, s)) = (path[at], path[at + 1]);
                (if i == steps { q } else { lerp(p, q, share) }, r + share * (s - r))
            })
            .collect();
        Self { step: length / steps as f64, radius: vessel.radius, pieces: vec![[0, steps]], points }
    }

    /// The index of the last point.
    pub fn last(&self) -> usize {
        self.points.len() - 1
    }

    /// Whether the point at an end (0 first, 1 last) is there.
    pub fn reaches(&self, end: usize) -> bool {
        let point = [0, self.last()][end];
        self.pieces.iter().any(|piece| piece.contains(&point))
    }

    /// Takes about `length` off an end, but leaves a piece.
    fn shorten(&mut self, end: usize, length: f64, at_least: usize) {
        let Some(piece) = (if end == 0 { self.pieces.first_mut() } else { self.pieces.last_mut() }) else { return };
        let most = (piece[1] - piece[0] + 1).saturating_sub(LEAST);
        let steps = ((length / self.step).round() as usize).max(at_least).min(most);
        if steps >= at_least {
            piece[end] = if end == 0 { piece[0] + steps } else { piece[1] - steps };
        }
    }
}

/// Damages the vessels: lost and short ends, then junctions in node order, then midway.
pub(crate) fn damage(network: &Network, params: &Breaks, rng: &mut impl Rng) -> Vec<Sampled> {
    let mut vessels: Vec<_> = (0..network.vessel_count()).map(|row| Sampled::of(network, row, params.spacing)).collect();
    let mut at_node = vec![Vec::new(); network.node_count()];
    for (row, (ends, _)) in network.vessels().enumerate() {
        for (end, node) in ends.into_iter().enumerate() {
            at_node[node].push((row, end));
        }
    }
    spoil_ends(network, &at_node, params, &mut vessels, rng);
    for present in &at_node {
        let present: Vec<_> = present.iter().copied().filter(|(row, end)| vessels[*row].reaches(*end)).collect();
        cut_junction(present, params, &mut vessels, rng);
    }
    for vessel in &mut vessels {
        let expected = params.vessel_gaps * vessel.step * vessel.last() as f64 / (200.0 * vessel.radius);
        let gaps = Poisson::new(expected).map_or(0.0, |law| law.sample(rng)) as usize;
        for _ in 0..gaps {
            interrupt(vessel, params, rng);
        }
    }
    vessels
}

/// Loses or shortens the vessels with a free end that is no inlet; a junction keeps two vessels at least.
fn spoil_ends(network: &Network, at_node: &[Vec<(usize, usize)>], params: &Breaks, vessels: &mut [Sampled], rng: &mut impl Rng) {
    let mut degree: Vec<usize> = at_node.iter().map(Vec::len).collect();
    for (row, vessel) in vessels.iter_mut().enumerate() {
        let ends = network.ends(row);
        let Some(free) = (0..2).find(|end| at_node[ends[*end]].len() == 1 && network.node(ends[*end]).role != Some(Role::Inlet))
        else {
            continue;
        };
        let other = ends[1 - free];
        let (lost, short) = (rng.random_bool(params.lost_ends), rng.sample::<f64, _>(Exp1) * params.short_ends);
        if lost && degree[other] > 2 {
            degree[other] -= 1;
            vessel.pieces.clear();
        } else {
            let length = 2.0 * vessel.radius * short;
            vessel.shorten(free, length, 0);
        }
    }
}

/// Cuts the thinnest vessel off a junction, now and then the second thinnest too.
fn cut_junction(mut present: Vec<(usize, usize)>, params: &Breaks, vessels: &mut [Sampled], rng: &mut impl Rng) {
    if present.len() < 3 || !rng.random_bool(params.junction_gaps) {
        return;
    }
    present.sort_by(|a, b| vessels[a.0].radius.total_cmp(&vessels[b.0].radius));
    let lumen = vessels[present[present.len() - 1].0].radius;
    let cuts = if rng.random_bool(params.double_gaps) { 2 } else { 1 };
    for (row, end) in present.into_iter().take(cuts) {
        let length = stretch(&vessels[row], params, rng) + lumen * rng.random::<f64>();
        vessels[row].shorten(end, length, 2);
    }
}

/// Takes a stretch out of a vessel midway, unless too little would be left on either side.
fn interrupt(vessel: &mut Sampled, params: &Breaks, rng: &mut impl Rng) {
    let middle = rng.random_range(0..=vessel.last());
    let steps = ((stretch(vessel, params, rng) / vessel.step).round() as usize).max(2);
    let Some(row) = vessel.pieces.iter().position(|piece| piece[0] <= middle && middle <= piece[1]) else { return };
    let [first, last] = vessel.pieces[row];
    if middle >= first + steps / 2 + LEAST - 1 && middle - steps / 2 + steps + LEAST - 1 <= last {
        let from = middle - steps / 2;
        vessel.pieces.splice(row..=row, [[first, from], [from + steps, last]]);
    }
}

/// The length (m) of a missing stretch.
fn stretch(vessel: &Sampled, params: &Breaks, rng: &mut impl Rng) -> f64 {
    let [least, most] = params.gap_diameters;
    let points = params.spacing * (1.0 + 0.5 * rng.sample::<f64, _>(Exp1));
    let length = points + 2.0 * vessel.radius * rng.random_range(least..=most);
    if rng.random_bool(params.long_gaps) { 2.0 * length } else { length }
}

/// Attempts a bit before the place is given up as too crowded.
const ATTEMPTS: usize = 200;
/// Distance kept between lumens, in point distances: more than jitter can bridge.
const MARGIN: f64 = 2.5;
/// How much further away a bit may lie, in point distances.
const REACH: f64 = 10.0;
/// The turn from step to step, per axis.
const TURN: f64 = 0.25;

/// Up to `wanted` bits (points with radii), clear of the complete vessels in `lumens` and of each other.
pub(crate) fn spurious(lumens: &[(Point, f64)], wanted: usize, params: &Breaks, rng: &mut impl Rng) -> Vec<Vec<(Point, f64)>> {
    if wanted == 0 {
        return Vec::new();
    }
    let mut taken = lumens.to_vec();
    let mut bits = Vec::new();
    for _ in 0..ATTEMPTS * wanted {
        if bits.len() == wanted || lumens.is_empty() {
            break;
        }
        let bit = walk(lumens, params, rng);
        let clear = |(p, r): &(Point, f64)| taken.iter().all(|(q, s)| distance(*p, *q) > r + s + MARGIN * params.spacing);
        if bit.iter().all(clear) {
            taken.extend(&bit);
            bits.push(bit);
        }
    }
    bits
}

/// A persistent random walk whose first point lies beside a random point of the vessels, thinner than these there.
fn walk(lumens: &[(Point, f64)], params: &Breaks, rng: &mut impl Rng) -> Vec<(Point, f64)> {
    let (anchor, lumen) = lumens[rng.random_range(0..lumens.len())];
    let radius = lumen * rng.random_range(0.3..0.8);
    let away = lumen + radius + params.spacing * (MARGIN + REACH * rng.random::<f64>());
    let side: [f64; 3] = rng.sample(UnitSphere);
    let mut heading: [f64; 3] = rng.sample(UnitSphere);
    let mut at = [0, 1, 2].map(|axis| anchor[axis] + away * side[axis]);
    let mut bit = vec![(at, radius)];
    for _ in 0..rng.random_range(params.spurious_steps[0]..=params.spurious_steps[1]) {
        heading = unit(heading.map(|x| x + TURN * rng.sample::<f64, _>(StandardNormal)));
        at = [0, 1, 2].map(|axis| at[axis] + params.spacing * heading[axis]);
        bit.push((at, radius));
    }
    bit
}
