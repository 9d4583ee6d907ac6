//! What the mask tells of a pair of branch ends: whether a tube from one to the other lies in the lumen, and how the lumen is shaped there.
//!
//! What an image tells besides: whether it is bright all the way from one to the other, and as bright. All features are ratios of lengths, areas or
//! contrasts, or cosines. Contrast is brightness above the background near the cluster, as a share of that of the dimmer end where nothing else is said.
//! R is the radius of the cluster's core, ρ = 1.5 R.

use super::branches::{Branches, Cluster};
use super::features::{PairTable, pairs_among, sorted};
use super::sections::{AROUND, HALF_WIDTH, INNER, LumenArm, LumenTube, Section, across, principal, section};
use willis_core::support::geometry::{Point, centroid, cross, distance, dot, lerp, norm, sub};
use willis_core::support::statistics::median;
use willis_core::support::ties::steady;
use willis_io::masks::{Field, Scene};

/// Rings of points around the middle of the tube, at these shares of its radius.
const RINGS: [f64; 2] = [0.5, 0.9];
/// A depth profile is parted where it falls below this share of what is on both sides.
const DIP: f64 = 0.85;

/// The names of the features, each behind `mask_`.
pub const MASK_FEATURES: &str = "\
    miss_least miss_most skew axes_straight tube_bend area_ratio area_least area_most elongation_least elongation_most \
    miss_margin_least miss_margin_most ring_half_mean ring_half_least ring_full_mean ring_full_least depth_least depth_mean \
    ring_margin_least ring_margin_most signed_least signed_mean far_least far_mean far_inside signed_margin_least \
    signed_margin_most far_margin_least far_margin_most signed_pairing miss_pairing better_least better_most section_least \
    section_most section_elongation section_elongation_most section_second section_saddle section_shift way_least way_most \
    way_dip way_dips murray_areas volume linear planar core_depth normal_least normal_most cover cover_with_rest \
    cover_without cover_margin";

/// Mean and least of some values.
fn mean_least(values: &[f64]) -> [f64; 2] {
    [values.iter().sum::<f64>() / values.len().max(1) as f64, values.iter().copied().fold(f64::INFINITY, f64::min)]
}

/// What a pair's tube tells by itself, before its rivals.
struct OfTube {
    miss: [f64; 2],
    skew: f64,
    bend: f64,
    rings: [[f64; 2]; 2],
    signed: [f64; 2],
    depth: [f64; 2],
    far: [f64; 2],
    far_inside: f64,
    sections: [f64; 7],
}

fn of_tube(field: &Field, a: &LumenArm, b: &LumenArm, tube: &LumenTube) -> OfTube {
    let w = sub(b.middle, a.middle);
    let off = |along: Point| norm([0, 1, 2].map(|k| w[k] - dot(w, along) * along[k]));
    let (miss_a, miss_b) = (off(a.along), off(b.along));
    let sum = a.radius + b.radius;
    let normal = cross(a.along, b.along);
    let skew = if norm(normal) > 0.2 { dot(w, normal).abs() / norm(normal) } else { miss_a.min(miss_b) };
    let ring = |share: f64| {
        let inside = |n: usize| tube.ring(n, share * tube.radii[n]).into_iter().filter(|p| field.signed(*p) > 0.0).count();
        mean_least(&(0..INNER).map(|n| inside(n) as f64 / AROUND as f64).collect::<Vec<f64>>())
    };
    let over = |points: &[Point]| -> Vec<f64> {
        points.iter().zip(&tube.radii).map(|(p, r)| (field.signed(*p) / r).max(-1.0)).collect()
    };
    let (signed, far) = (over(&tube.points), over(&tube.far));
    let depth: Vec<f64> = signed.iter().map(|x| x.max(0.0)).collect();
    let across = |n: usize| section(field, tube.points[n], tube.tangents[n], HALF_WIDTH * tube.radii[n] + field.voxel());
    let sections: Vec<Section> = (0..INNER).step_by(2).map(across).collect();
    let elongations: Vec<f64> = sections.iter().map(|s| s.elongation).collect();
    let most = |of: &dyn Fn(&Section) -> f64, from: f64| sections.iter().map(of).fold(from, f64::max);
    let mean_radius = tube.radii.iter().sum::<f64>() / INNER as f64;
    OfTube {
        miss: sorted([miss_a, miss_b].map(|miss| (miss / sum + 0.1).ln())),
        skew: (skew / sum + 0.1).ln(),
        bend: ((tube.length + 1e-3 * sum) / (distance(b.root, a.root) + 0.1 * sum)).ln(),
        rings: RINGS.map(ring),
        signed: mean_least(&signed),
        depth: mean_least(&depth),
        far: mean_least(&far),
        far_inside: far.iter().filter(|x| **x > 0.0).count() as f64 / INNER as f64,
        sections: [
            (sections.iter().map(|s| s.area).fold(f64::INFINITY, f64::min) / a.area.min(b.area) + 0.1).ln(),
            (most(&|s| s.area, 0.0) / a.area.max(b.area) + 0.1).ln(),
            median(&elongations).unwrap_or(1.0).ln(),
            most(&|s| s.elongation, 1.0).ln(),
            most(&|s| s.second, 0.0),
            sections.iter().map(|s| s.saddle).fold(1.0, f64::min),
            most(&|s| norm(s.shift), 0.0) / mean_radius,
        ],
    }
}

/// The depths along the way from one end over the core to the other: least and most over a radius, the deepest dip, the number of dips.
fn along_the_way(field: &Field, arms: [&LumenArm; 2], core: &[Point]) -> [f64; 4] {
    let [a, b] = arms;
    // The core's points nearest to a few places on the straight line.
    let near = |n: u32| {
        let at = lerp(a.root, b.root, f64::from(n) / 4.0);
        core.iter().copied().min_by(|a, b| steady(distance(*a, at)).total_cmp(&steady(distance(*b, at))))
    };
    let mut way: Vec<Point> = (1..4).filter_map(near).collect();
    way.dedup();
    let mut depth: Vec<f64> = a.depths.iter().rev().copied().collect();
    depth.extend(way.iter().map(|p| field.depth(*p)));
    depth.extend_from_slice(&b.depths);
    let before = depth.clone();
    for n in 1..depth.len() - 1 {
        depth[n] = 0.25 * before[n - 1] + 0.5 * before[n] + 0.25 * before[n + 1];
    }
    let small = 0.1 * field.voxel();
    let most = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
    let beside = |n: usize| most(&depth[..=n]).min(most(&depth[n..]));
    let dips: Vec<f64> = (0..depth.len()).map(|n| (depth[n] + small) / (beside(n) + small)).collect();
    let count = dips.chunk_by(|a, b| (*a < DIP) == (*b < DIP)).filter(|run| run[0] < DIP).count();
    let (least, most) = (depth.iter().copied().fold(f64::INFINITY, f64::min), most(&depth));
    let [thin, wide] = sorted([a.radius, b.radius]);
    [(least / thin + 0.1).ln(), (most / wide + 0.1).ln(), dips.iter().copied().fold(f64::INFINITY, f64::min), count as f64]
}

/// The lumen in a ball around a core: its places; ln of its volume over the expected one, how linear and how planar it is; and the direction
/// in which it is thinnest.
fn around(field: &Field, c: &Cluster, arms: &[LumenArm]) -> (Vec<Point>, [f64; 3], Point) {
    let (centre, rho) = (c.centre(), 1.5 * c.radius);
    let span = c.core.iter().map(|p| distance(p.position, centre)).fold(0.0, f64::max);
    let reach = (1.6 * rho).max(span + 0.8 * rho);
    let places = field.voxels_around(centre, reach);
    let expected: f64 = arms.iter().map(|a| a.area * (reach - 0.5 * span).max(0.3 * reach)).sum();
    let [(least, normal), (middle, _), (most, _)] = principal(&places, centroid(places.iter().copied()));
    let most = most.max(f64::MIN_POSITIVE);
    let volume = (places.len() as f64 * field.voxel_volume() / expected + 0.05).ln();
    (places, [volume, 1.0 - middle / most, (middle - least) / most], normal)
}

/// Share of the places that either of two tubes covers.
fn share(a: &[bool], b: &[bool]) -> f64 {
    a.iter().zip(b).filter(|(x, y)| **x || **y).count() as f64 / a.len().max(1) as f64
}

/// Clusters with more pairs than this are not searched for the best two tubes.
const MOST_PAIRS: usize = 15;

/// Cover of places by each tube: alone, with the best tube of two other ends, by the best two tubes without it.
fn covers(places: &[Point], pairs: &[[usize; 2]], tubes: &[LumenTube], voxel: f64) -> Vec<[f64; 3]> {
    let covered_by = |tube: &LumenTube| {
        let near = |p: &Point| tube.points.iter().zip(&tube.radii).any(|(q, r)| distance(*p, *q) <= r + 0.4 * voxel);
        places.iter().map(near).collect()
    };
    let covered: Vec<Vec<bool>> = tubes.iter().map(covered_by).collect();
    let disjoint = |a: usize, b: usize| pairs[a].iter().all(|end| !pairs[b].contains(end));
    let searched = if pairs.len() <= MOST_PAIRS { pairs.len() } else { 0 };
    let two = pairs_among(searched).filter(|[a, b]| disjoint(*a, *b));
    let two: Vec<(usize, usize, f64)> = two.map(|[a, b]| (a, b, share(&covered[a], &covered[b]))).collect();
    let of = |n: usize| {
        let alone = share(&covered[n], &covered[n]);
        let rest = (0..pairs.len()).filter(|other| disjoint(n, *other));
        let with = rest.map(|other| share(&covered[n], &covered[other])).reduce(f64::max).unwrap_or(alone);
        let without = if two.is_empty() {
            let others = (0..pairs.len()).filter(|other| *other != n);
            others.map(|other| share(&covered[other], &covered[other])).fold(0.0, f64::max)
        } else {
            two.iter().filter(|(a, b, _)| *a != n && *b != n).map(|(_, _, share)| *share).fold(0.0, f64::max)
        };
        [alone, with, without]
    };
    (0..pairs.len()).map(of).collect()
}

/// More ends than this are not paired.
const MOST_PAIRED: usize = 8;

/// The gains of pairing two ends; zeros where they are too many.
fn pairing_gains(table: &PairTable) -> PairTable {
    if table.ends() <= MOST_PAIRED { table.pairing_gains() } else { PairTable::of(table.ends(), 0.0, |_, _| 0.0) }
}

/// The features of the pairs of ends of each cluster, a row of [`MASK_FEATURES`] each, and of [`IMAGE_FEATURES`] where there is an image.
pub fn mask_features(field: &Field, scene: Option<&Scene>, branches: &Branches) -> Vec<Vec<f64>> {
    willis_core::support::in_order(&branches.clusters, |_, c| of_cluster(field, scene, branches, c)).concat()
}

fn of_cluster(field: &Field, scene: Option<&Scene>, branches: &Branches, c: &Cluster) -> Vec<Vec<f64>> {
    let pairs: Vec<[usize; 2]> = pairs_among(c.ends.len()).collect();
    if pairs.is_empty() {
        return Vec::new();
    }
    let arms: Vec<LumenArm> = c.ends.iter().map(|end| LumenArm::new(field, branches, c, *end)).collect();
    let tubes: Vec<LumenTube> = pairs.iter().map(|[i, j]| LumenTube::new(&arms[*i], &arms[*j])).collect();
    let found: Vec<OfTube> = pairs.iter().zip(&tubes).map(|([i, j], tube)| of_tube(field, &arms[*i], &arms[*j], tube)).collect();
    let (places, shape, across_it) = around(field, c, &arms);
    let cover = covers(&places, &pairs, &tubes, field.voxel());
    let table = |f: fn(&OfTube) -> f64| PairTable::over(arms.len(), -9.0, found.iter().map(f));
    let straight = table(|t| -t.miss[1]);
    let signed = table(|t| t.signed[1]);
    let far = table(|t| t.far[0]);
    let ring = table(|t| t.rings[1][0]);
    let fit = table(|t| t.signed[0] + t.signed[1]);
    let mut areas: Vec<f64> = arms.iter().map(|a| a.area).collect();
    let widest = areas.iter().copied().fold(0.0, f64::max);
    areas.sort_by(|a, b| b.total_cmp(a));
    let others: f64 = areas.iter().skip(1).map(|a| a.powf(1.5)).sum();
    let murray = (areas[0].powf(1.5) / others.max(f64::MIN_POSITIVE)).ln();
    let deepest = c.core.iter().map(|p| field.depth(p.position)).fold(0.0, f64::max);
    let most_radius = arms.iter().map(|a| a.radius).fold(0.0, f64::max);
    let rivals = (arms.len() - 1) as f64;
    let better = |end: usize, own: f64| (0..arms.len()).filter(|q| *q != end && fit.get(end, *q) > own).count() as f64 / rivals;
    let core: Vec<Point> = c.core.iter().map(|p| p.position).collect();
    let gains = [&fit, &straight].map(pairing_gains);
    let of_pair = |n: usize| -> Vec<f64> {
        let ends = pairs[n];
        let [a, b] = ends.map(|end| &arms[end]);
        let t = &found[n];
        let to_widest = sorted([a, b].map(|arm| (arm.area / widest).ln()));
        let elongation = sorted([a.elongation, b.elongation]);
        let miss_margin = straight.margins(ends, -1.5);
        let [ring_margin, signed_margin, far_margin] = [&ring, &signed, &far].map(|table| table.margins(ends, 0.0));
        let own = fit.get(ends[0], ends[1]);
        let behind = sorted(ends.map(|end| better(end, own)));
        let way = along_the_way(field, [a, b], &core);
        let normal = sorted([a, b].map(|arm| dot(arm.along, across_it).abs()));
        let [alone, with, without] = cover[n];
        let mut row = t.miss.to_vec();
        row.extend([t.skew, -dot(a.along, b.along), t.bend, (a.area / b.area).ln().abs()]);
        row.extend([to_widest, elongation, miss_margin, t.rings[0], t.rings[1]].concat());
        row.extend([t.depth[1], t.depth[0], ring_margin[0], ring_margin[1], t.signed[1], t.signed[0], t.far[1], t.far[0]]);
        row.push(t.far_inside);
        row.extend([signed_margin, far_margin, gains.each_ref().map(|table| table.get(ends[0], ends[1])), behind].concat());
        row.extend(t.sections);
        row.extend(way);
        row.extend([murray, shape[0], shape[1], shape[2], (deepest / most_radius + 0.1).ln()]);
        row.extend([normal[0], normal[1], alone, with, without, with - without]);
        row
    };
    let mut rows: Vec<Vec<f64>> = (0..pairs.len()).map(of_pair).collect();
    if let Some(scene) = scene {
        let shown = of_image(scene, field, c, &arms, &tubes);
        rows.iter_mut().zip(shown).for_each(|(row, shown)| row.extend(shown));
    }
    rows
}

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
/// Bends of the brightness are taken over so many radii and voxels.
const BEND: [f64; 2] = [0.7, 0.5];
/// The lattice on which ways between ends are searched has at most so many steps to each side.
const MOST_STEPS: f64 = 10.0;

/// The features of the pairs of one cluster, whose arms and tubes are given, a row of [`IMAGE_FEATURES`] each. Lengths in m.
fn of_image(scene: &Scene, field: &Field, c: &Cluster, arms: &[LumenArm], tubes: &[LumenTube]) -> Vec<Vec<f64>> {
    let (voxel, centre) = (field.voxel(), c.centre());
    let pairs = || pairs_among(arms.len());
    let level = scene.level(centre);
    let contrast = |p: Point| scene.brightness(p).map_or(0.0, |x| x - level.background);
    let least = LEAST_CONTRAST * scene.typical;
    let of_arm =
        |arm: &LumenArm| median(&arm.centres.iter().map(|p| contrast(*p)).collect::<Vec<f64>>()).unwrap_or(least).max(least);
    let bright: Vec<f64> = arms.iter().map(of_arm).collect();
    let brightest = bright.iter().copied().fold(least, f64::max);
    let saddles = saddles(&contrast, voxel, centre, arms);
    let dimmer = |[i, j]: [usize; 2]| bright[i].min(bright[j]);
    let see = |(pair, tube): ([usize; 2], &LumenTube)| {
        let m = dimmer(pair);
        shown(&|p| contrast(p) / m, voxel, pair.map(|end| &arms[end]), tube)
    };
    let shown: Vec<Vec<f64>> = pairs().zip(tubes).map(see).collect();
    let tube = PairTable::over(arms.len(), -9.0, shown.iter().map(|shown| shown[0] + shown[1]));
    let saddle = PairTable::of(arms.len(), -9.0, |i, j| saddles.get(i, j) / dimmer([i, j]));
    let ratio = PairTable::of(arms.len(), -9.0, |i, j| -(bright[i] / bright[j]).ln().abs());
    let gains = [&tube, &saddle, &ratio].map(pairing_gains);
    let of_pair = |([i, j], shown): ([usize; 2], &Vec<f64>)| {
        let m = dimmer([i, j]);
        let [a, b] = [i, j].map(|end| (bright[end] / brightest).ln());
        let [low, high] = sorted([a, b]);
        let mut out = vec![level.noise / m, (m / scene.typical).ln(), (a - b).abs(), low, high];
        out.extend_from_slice(shown);
        out.extend([saddle.get(i, j), saddle.get(i, j) * m / level.noise]);
        out.extend(tube.margins([i, j], 0.0));
        out.extend(saddle.margins([i, j], 0.0));
        out.extend(ratio.margins([i, j], -1.0));
        out.extend(gains.each_ref().map(|table| table.get(i, j)));
        out
    };
    pairs().zip(&shown).map(of_pair).collect()
}

/// What one pair shows along its tube, the least and the mean contrast first.
fn shown(contrast: &dyn Fn(Point) -> f64, voxel: f64, [a, b]: [&LumenArm; 2], tube: &LumenTube) -> Vec<f64> {
    let along: Vec<f64> = tube.points.iter().map(|p| contrast(*p)).collect();
    let least = |x: &[f64]| x.iter().copied().fold(f64::INFINITY, f64::min);
    let most = |x: &[f64]| x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (mut inside, mut outside) = (Vec::new(), Vec::new());
    let (mut bend_along, mut bend_across) = (Vec::new(), Vec::new());
    for (n, p) in tube.points.iter().enumerate() {
        let (r, t) = (tube.radii[n], tube.tangents[n]);
        let [u, v] = across(t);
        let ring = |reach: f64| tube.ring(n, reach).map(contrast).iter().sum::<f64>() / AROUND as f64;
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
        [least(&along), mean(&along), most(&along)],
        [mean(&inside), least(&inside), mean(&outside)],
        [most(&outside), dip, bulge],
        [mean(&bend_along), most(&bend_along), mean(&bend_across)],
    ]
    .concat()
}

/// Per pair of arms the highest contrast that a way from the middle of one to that of the other need not fall below, near the cluster.
fn saddles(contrast: &dyn Fn(Point) -> f64, voxel: f64, centre: Point, arms: &[LumenArm]) -> PairTable {
    let reach = arms.iter().map(|arm| distance(arm.middle, centre)).fold(voxel, f64::max) + 2.0 * voxel;
    let steps = (reach / voxel).ceil().min(MOST_STEPS);
    let (step, half) = (reach / steps, steps as isize);
    let side = 2 * half + 1;
    let offset = |row: isize| [row % side - half, row / side % side - half, row / (side * side) - half];
    let at = |o: [isize; 3]| contrast([0, 1, 2].map(|k| centre[k] + step * o[k] as f64));
    let value: Vec<f64> = (0..side * side * side).map(|row| at(offset(row))).collect();
    let nearest = |p: Point| {
        let o = [0, 1, 2].map(|k| (((p[k] - centre[k]) / step).round() as isize).clamp(-half, half) + half);
        ((o[2] * side + o[1]) * side + o[0]) as usize
    };
    let mut order: Vec<usize> = (0..value.len()).collect();
    order.sort_by(|a, b| value[*b].total_cmp(&value[*a]).then(a.cmp(b)));
    let mut trees = petgraph::unionfind::UnionFind::<usize>::new(value.len());
    let mut reached = vec![false; value.len()];
    // The arms whose middles lie in the tree of each root.
    let mut of_root: Vec<Vec<usize>> = vec![Vec::new(); value.len()];
    for (arm, of) in arms.iter().enumerate() {
        of_root[nearest(of.middle)].push(arm);
    }
    let (mut out, mut open) = (PairTable::of(arms.len(), 0.0, |_, _| 0.0), arms.len());
    for at in order {
        reached[at] = true;
        // Several middles in one place.
        for (n, a) in of_root[at].iter().enumerate() {
            of_root[at][n + 1..].iter().for_each(|b| out.set([*a, *b], value[at]));
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
                of_root[root].iter().for_each(|j| out.set([*i, *j], value[at]));
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
