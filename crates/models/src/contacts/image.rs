//! What the image tells of a pair of branch ends: whether it is bright all the way from one to the other, and as bright.
//!
//! Contrast is brightness above the background near the cluster, as a share of that of the dimmer end where nothing else is said.

use petgraph::unionfind::UnionFind;

use super::features::{Pair, PairTable, sorted};
use super::lumen::{LumenArm, LumenTube};
use super::sections::across;
use willis_core::support::geometry::{Point, distance};
use willis_core::support::statistics::median;
use willis_io::masks::Scene;

/// The names of the features, each behind `image_`.
pub const IMAGE_FEATURES: &str = "\
    noise dimmer ratio to_brightest_least to_brightest_most tube_least tube_mean tube_most ring_mean ring_least outside_mean \
    outside_most dip bulge bend_along bend_along_most bend_across saddle saddle_noise tube_margin_least tube_margin_most \
    saddle_margin_least saddle_margin_most ratio_margin_least ratio_margin_most tube_pairing saddle_pairing ratio_pairing";

/// The contrast of an end is at least this share of the typical one.
const LEAST_CONTRAST: f64 = 0.2;
/// Rings around the tube inside and outside, in its radii and in voxels beside them.
const INSIDE: f64 = 0.8;
const OUTSIDE: [f64; 2] = [1.0, 1.5];
const AROUND: usize = 8;
/// Bends of the brightness are taken over so many radii and voxels.
const BEND: [f64; 2] = [0.7, 0.5];
/// The lattice on which ways between ends are searched has at most so many steps to each side.
const MOST_STEPS: f64 = 10.0;
/// More ends than this are not paired.
const MOST_PAIRED: usize = 8;

/// What one pair shows along its tube, the least and the mean contrast first.
type PairShown = [f64; 12];

/// The features of the pairs of one cluster, whose arms and tubes are given, a row of [`IMAGE_FEATURES`] each. Lengths in m.
pub fn image_features(
    scene: &Scene,
    voxel: f64,
    centre: Point,
    arms: &[LumenArm],
    tubes: &[LumenTube],
    pairs: &[Pair],
) -> Vec<Vec<f64>> {
    let level = scene.level(centre);
    let contrast = |p: Point| scene.brightness(p).map_or(0.0, |x| x - level.background);
    let least = LEAST_CONTRAST * scene.typical;
    let of_arm =
        |arm: &LumenArm| median(&arm.centres.iter().map(|p| contrast(*p)).collect::<Vec<f64>>()).unwrap_or(least).max(least);
    let bright: Vec<f64> = arms.iter().map(of_arm).collect();
    let brightest = bright.iter().copied().fold(least, f64::max);
    let saddles = saddles(&contrast, voxel, centre, arms);
    let dimmer = |pair: &Pair| bright[pair.ends[0]].min(bright[pair.ends[1]]);
    let see = |(pair, tube): (&Pair, &LumenTube)| {
        let m = dimmer(pair);
        shown(&|p| contrast(p) / m, voxel, pair.ends.map(|end| &arms[end]), tube)
    };
    let shown: Vec<PairShown> = pairs.iter().zip(tubes).map(see).collect();
    let saddle_of = |pair: &Pair| saddles[pair.ends[0] * arms.len() + pair.ends[1]] / dimmer(pair);
    let table = |f: &dyn Fn(usize) -> f64| PairTable::over(pairs, arms.len(), -9.0, f);
    let (tube, saddle) = (table(&|row| shown[row][0] + shown[row][1]), table(&|row| saddle_of(&pairs[row])));
    let ratio = PairTable::of(arms.len(), -9.0, |i, j| -(bright[i] / bright[j]).ln().abs());
    let of_pair = |(pair, shown): (&Pair, &PairShown)| {
        let m = dimmer(pair);
        let [a, b] = pair.ends.map(|end| (bright[end] / brightest).ln());
        let gain = |table: &PairTable| if arms.len() <= MOST_PAIRED { table.pairing_gain(pair.ends) } else { 0.0 };
        let [low, high] = sorted([a, b]);
        let mut out = vec![level.noise / m, (m / scene.typical).ln(), (a - b).abs(), low, high];
        out.extend(shown);
        out.extend([saddle_of(pair), saddle_of(pair) * m / level.noise]);
        out.extend(tube.margins(pair.ends, 0.0));
        out.extend(saddle.margins(pair.ends, 0.0));
        out.extend(ratio.margins(pair.ends, -1.0));
        out.extend([gain(&tube), gain(&saddle), gain(&ratio)]);
        out
    };
    pairs.iter().zip(&shown).map(of_pair).collect()
}

fn shown(contrast: &dyn Fn(Point) -> f64, voxel: f64, [a, b]: [&LumenArm; 2], tube: &LumenTube) -> PairShown {
    let along: Vec<f64> = tube.points.iter().map(|p| contrast(*p)).collect();
    let least = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let most = |x: &[f64]| x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    let (mut bend_along, mut bend_across) = (Vec::new(), Vec::new());
    for (n, p) in tube.points.iter().enumerate() {
        let (r, t) = (tube.radii[n], tube.tangents[n]);
        let [u, v] = across(t);
        let ring = |reach: f64| {
            let at = |k: usize| {
                let (s, c) = (k as f64 * std::f64::consts::TAU / AROUND as f64).sin_cos();
                contrast([0, 1, 2].map(|x| p[x] + reach * (c * u[x] + s * v[x])))
            };
            (0..AROUND).map(at).sum::<f64>() / AROUND as f64
        };
        inside.push(ring(INSIDE * r));
        outside.push(ring(OUTSIDE[0] * r + OUTSIDE[1] * voxel));
        let step = BEND[0] * r + BEND[1] * voxel;
        let bend = |d: Point| {
            let beside = |sign: f64| contrast([0, 1, 2].map(|x| p[x] + sign * step * d[x]));
            beside(1.0) + beside(-1.0) - 2.0 * along[n]
        };
        bend_along.push(bend(t));
        bend_across.push(0.5 * (bend(u) + bend(v)));
    }
    // From the middle of one end to that of the other.
    let way: Vec<f64> = [a.middle, a.root].iter().map(|p| contrast(*p)).chain(along.iter().copied()).collect();
    let way: Vec<f64> = way.into_iter().chain([b.root, b.middle].iter().map(|p| contrast(*p))).collect();
    let before = |n: usize| most(&way[..=n]);
    let after = |n: usize| most(&way[n..]);
    let dip = (0..way.len()).map(|n| before(n).min(after(n)) - way[n]).fold(0.0, f64::max);
    let bulge = most(&along) - contrast(a.middle).max(contrast(b.middle));
    [
        least(&along),
        mean(&along),
        most(&along),
        mean(&inside),
        least(&inside),
        mean(&outside),
        most(&outside),
        dip,
        bulge,
        mean(&bend_along),
        most(&bend_along),
        mean(&bend_across),
    ]
}

/// Per pair of arms the highest contrast that a way from the middle of one to that of the other need not fall below, near the cluster.
fn saddles(contrast: &dyn Fn(Point) -> f64, voxel: f64, centre: Point, arms: &[LumenArm]) -> Vec<f64> {
    let reach = arms.iter().map(|arm| distance(arm.middle, centre)).fold(voxel, f64::max) + 2.0 * voxel;
    let steps = (reach / voxel).ceil().min(MOST_STEPS);
    let (step, half) = (reach / steps, steps as isize);
    let side = 2 * half + 1;
    let offset = |row: isize| [row % side - half, row / side % side - half, row / (side * side) - half];
    let value: Vec<f64> = (0..side * side * side)
        .map(|row| {
            let o = offset(row);
            let p = [0, 1, 2].map(|k| centre[k] + step * o[k] as f64);
            contrast(p)
        })
        .collect();
    let nearest = |p: Point| {
        let o = [0, 1, 2].map(|k| (((p[k] - centre[k]) / step).round() as isize).clamp(-half, half) + half);
        ((o[2] * side + o[1]) * side + o[0]) as usize
    };
    let mut order: Vec<usize> = (0..value.len()).collect();
    order.sort_by(|a, b| value[*b].total_cmp(&value[*a]).then(a.cmp(b)));
    let mut trees = UnionFind::<usize>::new(value.len());
    let mut reached = vec![false; value.len()];
    // The arms whose middles lie in the tree of each root.
    let mut of_root: Vec<Vec<usize>> = vec![Vec::new(); value.len()];
    for (arm, of) in arms.iter().enumerate() {
        of_root[nearest(of.middle)].push(arm);
    }
    let count = arms.len();
    let mut out = vec![0.0; count * count];
    let mut met = |a: usize, b: usize, value: f64| {
        out[a * count + b] = value;
        out[b * count + a] = value;
    };
    let mut open = count;
    for at in order {
        reached[at] = true;
        // Several middles in one place.
        for (n, a) in of_root[at].iter().enumerate() {
            of_root[at][n + 1..].iter().for_each(|b| met(*a, *b, value[at]));
        }
        open -= of_root[at].len().saturating_sub(1);
        let o = offset(at as isize);
        for n in 0..27 {
            let next = [o[0] + n % 3 - 1, o[1] + n / 3 % 3 - 1, o[2] + n / 9 - 1];
            if next.iter().any(|x| x.abs() > half) {
                continue;
            }
            let next = (((next[2] + half) * side + next[1] + half) * side + next[0] + half) as usize;
            if !reached[next] {
                continue;
            }
            let [a, b] = [at, next].map(|place| trees.find_mut(place));
            if !trees.union(a, b) {
                continue;
            }
            let (from, root) = if trees.find(a) == a { (b, a) } else { (a, b) };
            let moved = std::mem::take(&mut of_root[from]);
            for i in &moved {
                of_root[root].iter().for_each(|j| met(*i, *j, value[at]));
            }
            open -= usize::from(!moved.is_empty() && !of_root[root].is_empty());
            of_root[root].extend(moved);
        }
        if open <= 1 {
            break;
        }
    }
    out
}
