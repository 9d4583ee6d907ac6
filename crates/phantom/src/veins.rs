//! Veins beside the arteries of a phantom, so near that a mask may join the two.

use rand::{Rng, RngExt};
use rand_distr::{StandardNormal, UnitSphere};

use super::{damage::scattered, tube::DrawnTube};
use willis_core::support::{Point, cross, dot, sub, unit};

/// Attempts for a vein before the space counts as too crowded.
const ATTEMPTS: usize = 100;
/// Space between the walls of a vein and its artery, in voxels: uniform between these.
const SPACE: [f64; 2] = [-0.3, 0.6];
/// The radius of a vein in radii of its artery.
const WIDTH: [f64; 2] = [0.5, 1.0];
/// How far a vein goes either way from where it is nearest, in sums of the two radii.
const REACH: [f64; 2] = [4.0, 10.0];
/// The radius of its curve away from the artery, in sums of the two radii.
const CURVE: [f64; 2] = [5.0, 12.0];

/// Up to `wanted` veins, each beside one artery and clear of all others.
pub(super) fn veins(arteries: &[DrawnTube], wanted: usize, voxel: f64, rng: &mut impl Rng) -> Vec<DrawnTube> {
    let taken = arteries.iter().flat_map(|tube| tube.stations.iter().copied().zip(tube.radii.iter().copied())).collect();
    let draw = || beside(&arteries[rng.random_range(0..arteries.len())], voxel, rng);
    let vein = |(row, points): (usize, Vec<(Point, f64)>)| {
        let (stations, radii) = points.into_iter().unzip();
        DrawnTube { label: format!("vein {}", row + 1), nodes: None, stations, radii, is_free: [true; 2] }
    };
    scattered(taken, [wanted, ATTEMPTS], SPACE[0] * voxel, draw).into_iter().enumerate().map(vein).collect()
}

/// A vein that passes an artery at a random station, and curves away from it.
fn beside(artery: &DrawnTube, voxel: f64, rng: &mut impl Rng) -> Vec<(Point, f64)> {
    let at = rng.random_range(1..artery.stations.len());
    let along = unit(sub(artery.stations[at], artery.stations[at - 1]));
    let side: Point = rng.sample(UnitSphere);
    let side = unit([0, 1, 2].map(|axis| side[axis] - dot(side, along) * along[axis]));
    let (lumen, other) = (artery.radii[at], cross(along, side));
    let radius = lumen * rng.random_range(WIDTH[0]..WIDTH[1]);
    let both = lumen + radius;
    let away = both + voxel * rng.random_range(SPACE[0]..SPACE[1]);
    let reach = [0, 1].map(|_| both * rng.random_range(REACH[0]..REACH[1]));
    let curve = both * rng.random_range(CURVE[0]..CURVE[1]);
    let (twist, tilt): (f64, f64) = (rng.sample(StandardNormal), 0.3 * rng.sample::<f64, _>(StandardNormal));
    // The curve is at most about twice as long as its chord.
    let steps = (2.0 * (reach[0] + reach[1]) / voxel).ceil().max(1.0) as usize;
    let place = |step: usize| {
        let s = (reach[0] + reach[1]) * step as f64 / steps as f64 - reach[0];
        let bend = s * s / (2.0 * curve);
        let (out, turned) = (away + bend, tilt * s + 0.5 * twist * bend);
        [0, 1, 2].map(|axis| artery.stations[at][axis] + s * along[axis] + out * side[axis] + turned * other[axis])
    };
    (0..=steps).map(|step| (place(step), radius)).collect()
}
