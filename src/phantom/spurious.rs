//! Spurious bits: short random walks near the vessels that touch nothing.

use rand::{Rng, RngExt};
use rand_distr::{StandardNormal, UnitSphere};

use super::Breaks;
use crate::geometry::{Point, distance, unit};

/// Attempts a bit before the place is given up as too crowded.
const ATTEMPTS: usize = 200;
/// Distance kept between lumens, in point distances: more than jitter can bridge.
const MARGIN: f64 = 2.5;
/// How much further away a bit may lie, in point distances.
const REACH: f64 = 10.0;
/// The turn from step to step, per axis.
const TURN: f64 = 0.25;

/// Up to `wanted` bits (points with radii), clear of the complete vessels in `lumens` and of each other.
pub(super) fn spurious(lumens: &[(Point, f64)], wanted: usize, params: &Breaks, rng: &mut impl Rng) -> Vec<Vec<(Point, f64)>> {
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
