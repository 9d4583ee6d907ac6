//! The damage of an extraction: its options, and which points of every vessel it misses at junctions, midway and at ends.

use rand::{Rng, RngExt};
use rand_distr::{Distribution, Exp1, Poisson, StandardNormal, UnitSphere};

use willis_core::network::path_places::{at_even_steps, length_of};
use willis_core::network::{Network, Role, metres};
use willis_core::support::{Point, distance, grouped, unit};

/// How an extraction differs from the complete network. The defaults give an extraction of average quality.
#[derive(Debug, Clone, PartialEq)]
pub struct Breaks {
    /// The seed; the same seed gives the same extraction.
    pub seed: u64,
    /// Distance between centerline points, m, positive.
    pub spacing: f64,
    /// Probability that the thinnest vessel of a junction loses the stretch next to it, 0 to 1.
    pub junction_gaps: f64,
    /// Probability that the second thinnest vessel of such a junction loses it too, 0 to 1.
    pub double_gaps: f64,
    /// Expected gaps along a vessel per 100 of its diameters, so that thin vessels break more often; 0 to 100.
    pub vessel_gaps: f64,
    /// Probability that a vessel with a free end is missing completely, 0 to 1. Inlets stay.
    pub lost_ends: f64,
    /// Displacement of points in point distances: normal, root mean square over the three axes together, 0 to 1.
    pub jitter: f64,
    /// Standard deviation of ln radius from point to point, 0 to 1.
    pub radius_noise: f64,
    /// Standard deviation of ln radius from fragment to fragment, 0 to 1.
    pub radius_bias: f64,
    /// Spurious fragments per true fragment, 0 to 10. They are random walks near the vessels that touch nothing.
    pub spurious: f64,
}

impl Default for Breaks {
    fn default() -> Self {
        Self {
            seed: 0,
            spacing: metres(0.5),
            junction_gaps: 0.6,
            double_gaps: 0.05,
            vessel_gaps: 0.5,
            lost_ends: 0.05,
            jitter: 0.3,
            radius_noise: 0.1,
            radius_bias: 0.05,
            spurious: 0.3,
        }
    }
}

/// Points with radii.
pub type Lumens = Vec<(Point, f64)>;

/// Length of a missing stretch in diameters of its vessel: uniform between these two.
///
/// Each stretch is longer by the distance of points, by an exponential with half that mean, and at a junction by a uniform share
/// of the widest vessel's radius.
const GAP_DIAMETERS: std::ops::RangeInclusive<f64> = 0.5..=3.0;
/// Probability that a missing stretch is twice as long.
const LONG_GAPS: f64 = 0.1;
/// The smallest and largest number of steps of a spurious fragment.
const SPURIOUS_STEPS: std::ops::RangeInclusive<u32> = 5..=20;
/// The smallest number of points in a piece of a vessel.
const LEAST: usize = 3;

/// A vessel resampled at equal steps, and the pieces of it that are left.
pub(crate) struct SampledVessel {
    /// Points with radii, both nodes included.
    pub points: Lumens,
    /// The step, m.
    pub step: f64,
    /// Mean radius, m.
    pub radius: f64,
    /// The inclusive ranges of points that are left, in order; empty for a lost vessel.
    pub pieces: Vec<[usize; 2]>,
}

impl SampledVessel {
    /// The vessel of a row at a number of equal steps, at least one, that `steps` computes from its length (m). A vessel without a path
    /// is straight.
    pub fn at(network: &Network, row: usize, steps: impl FnOnce(f64) -> usize) -> Self {
        let vessel = network.vessel(row);
        let path = network.path_of(row);
        let length = length_of(&path);
        let steps = steps(length);
        let places = at_even_steps(&path, steps).into_iter().map(|place| place.on(&path));
        let points = places.map(|point| (point.position, point.radius)).collect();
        Self { step: length / steps as f64, radius: vessel.radius, pieces: vec![[0, steps]], points }
    }

    /// The index of the last point.
    pub fn last(&self) -> usize {
        self.points.len() - 1
    }

    /// Whether the point at an end (0 first, 1 last) is left.
    pub fn reaches(&self, end: usize) -> bool {
        let point = [0, self.last()][end];
        self.pieces.iter().any(|piece| piece.contains(&point))
    }

    /// Shortens an end by about `length` (m) and at least `at_least` steps, as long as enough points are left.
    fn shorten(&mut self, end: usize, length: f64, at_least: usize) {
        let Some(piece) = (if end == 0 { self.pieces.first_mut() } else { self.pieces.last_mut() }) else { return };
        let most = (piece[1] - piece[0] + 1).saturating_sub(LEAST);
        let steps = ((length / self.step).round() as usize).max(at_least).min(most);
        if steps >= at_least {
            piece[end] = if end == 0 { piece[0] + steps } else { piece[1] - steps };
        }
    }
}

/// Damages the vessels: first ends, then junctions in node order, then gaps along the vessels.
pub(crate) fn damage(network: &Network, params: &Breaks, rng: &mut impl Rng) -> Vec<SampledVessel> {
    let steps = |length: f64| ((length / params.spacing).round() as usize).max(LEAST - 1);
    let mut vessels: Vec<_> = (0..network.vessel_count()).map(|row| SampledVessel::at(network, row, steps)).collect();
    let ends = network.vessels().enumerate().flat_map(|(row, (ends, _))| [(ends[0], (row, 0)), (ends[1], (row, 1))]);
    let at_node = grouped(network.node_count(), ends);
    // A vessel with a free end that is not an inlet is removed or shortened; a junction keeps at least two vessels.
    let mut degree: Vec<usize> = at_node.iter().map(Vec::len).collect();
    for (row, vessel) in vessels.iter_mut().enumerate() {
        let ends = network.ends(row);
        let Some(free) = (0..2).find(|end| at_node[ends[*end]].len() == 1 && network.node(ends[*end]).role != Some(Role::Inlet))
        else {
            continue;
        };
        let other = ends[1 - free];
        let (lost, short) = (rng.random_bool(params.lost_ends), rng.sample::<f64, _>(Exp1));
        if lost && degree[other] > 2 {
            degree[other] -= 1;
            vessel.pieces.clear();
        } else {
            let length = 2.0 * vessel.radius * short;
            vessel.shorten(free, length, 0);
        }
    }
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

/// Disconnects the thinnest vessel from a junction, sometimes the second thinnest too.
fn cut_junction(mut present: Vec<(usize, usize)>, params: &Breaks, vessels: &mut [SampledVessel], rng: &mut impl Rng) {
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

/// Removes a stretch from a vessel, unless too little would be left on either side.
fn interrupt(vessel: &mut SampledVessel, params: &Breaks, rng: &mut impl Rng) {
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
fn stretch(vessel: &SampledVessel, params: &Breaks, rng: &mut impl Rng) -> f64 {
    let points = params.spacing * (1.0 + 0.5 * rng.sample::<f64, _>(Exp1));
    let length = points + 2.0 * vessel.radius * rng.random_range(GAP_DIAMETERS);
    if rng.random_bool(LONG_GAPS) { 2.0 * length } else { length }
}

/// Attempts per spurious fragment before the space counts as too crowded.
const ATTEMPTS: usize = 200;
/// Distance between lumens, in distances of points: more than jitter can close.
const MARGIN: f64 = 2.5;
/// How much farther from its vessel a spurious fragment may lie, in distances of points.
const REACH: f64 = 10.0;
/// The turn between two steps, per axis.
const TURN: f64 = 0.25;

/// Up to `wanted` spurious fragments (points with radii) that touch neither the complete vessels in `lumens` nor each other.
pub(crate) fn spurious(lumens: &[(Point, f64)], wanted: usize, params: &Breaks, rng: &mut impl Rng) -> Vec<Lumens> {
    if lumens.is_empty() {
        return Vec::new();
    }
    scattered(lumens.to_vec(), [wanted, ATTEMPTS], MARGIN * params.spacing, || walk(lumens, params, rng))
}

/// Up to so many lines (points with radii) as `draw` makes them, with so many attempts for each, whose lumens are more than `apart` from those
/// in `taken` and from each other.
pub fn scattered(mut taken: Lumens, [wanted, attempts]: [usize; 2], apart: f64, mut draw: impl FnMut() -> Lumens) -> Vec<Lumens> {
    let mut found = Vec::new();
    for _ in 0..attempts * wanted {
        if found.len() == wanted {
            break;
        }
        let line = draw();
        let clear = |(p, r): &(Point, f64)| taken.iter().all(|(q, s)| distance(*p, *q) > r + s + apart);
        if line.iter().all(clear) {
            taken.extend(&line);
            found.push(line);
        }
    }
    found
}

/// A random walk that tends to go straight. It begins near a random point of the vessels and is thinner than the vessel there.
fn walk(lumens: &[(Point, f64)], params: &Breaks, rng: &mut impl Rng) -> Lumens {
    let (anchor, lumen) = lumens[rng.random_range(0..lumens.len())];
    let radius = lumen * rng.random_range(0.3..0.8);
    let away = lumen + radius + params.spacing * (MARGIN + REACH * rng.random::<f64>());
    let side: [f64; 3] = rng.sample(UnitSphere);
    let mut heading: [f64; 3] = rng.sample(UnitSphere);
    let mut at = [0, 1, 2].map(|axis| anchor[axis] + away * side[axis]);
    let mut points = vec![(at, radius)];
    for _ in 0..rng.random_range(SPURIOUS_STEPS) {
        heading = unit(heading.map(|x| x + TURN * rng.sample::<f64, _>(StandardNormal)));
        at = [0, 1, 2].map(|axis| at[axis] + params.spacing * heading[axis]);
        points.push((at, radius));
    }
    points
}
