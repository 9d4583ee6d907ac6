//! What the mask tells of a pair of branch ends: whether a tube from one to the other lies in the lumen, and how the lumen is shaped there.
//!
//! All features are ratios of lengths or areas, or cosines. R is the radius of the cluster's core, ρ = 1.5 R.

use super::branches::{Branches, Cluster};
use super::features::{Pair, PairTable, pairs_among, sorted};
use super::image::image_features;
use super::lumen::{HALF_WIDTH, INNER, LumenArm, LumenTube};
use super::sections::{Section, across, principal, section};
use willis_core::support::geometry::{Point, cross, distance, dot, lerp, norm, sub};
use willis_core::support::in_order;
use willis_core::support::statistics::median;
use willis_io::masks::{Field, Scene};

/// Rings of points around the middle of the tube, at these shares of its radius.
const RINGS: [f64; 2] = [0.5, 0.9];
const AROUND: usize = 8;
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

impl OfTube {
    fn new(field: &Field, a: &LumenArm, b: &LumenArm, tube: &LumenTube) -> Self {
        let w = sub(b.middle, a.middle);
        let off = |along: Point| norm([0, 1, 2].map(|k| w[k] - dot(w, along) * along[k]));
        let (miss_a, miss_b) = (off(a.along), off(b.along));
        let sum = a.radius + b.radius;
        let normal = cross(a.along, b.along);
        let skew = if norm(normal) > 0.2 { dot(w, normal).abs() / norm(normal) } else { miss_a.min(miss_b) };
        let ring = |share: f64| -> [f64; 2] {
            let inside: Vec<f64> = (0..INNER)
                .map(|n| {
                    let [u, v] = across(tube.tangents[n]);
                    let hit = |k: &usize| {
                        let (s, c) = (*k as f64 * std::f64::consts::TAU / AROUND as f64).sin_cos();
                        let r = share * tube.radii[n];
                        field.signed([0, 1, 2].map(|x| tube.points[n][x] + r * (c * u[x] + s * v[x]))) > 0.0
                    };
                    (0..AROUND).filter(hit).count() as f64 / AROUND as f64
                })
                .collect();
            mean_least(&inside)
        };
        let over = |points: &[Point]| -> Vec<f64> {
            points.iter().zip(&tube.radii).map(|(p, r)| (field.signed(*p) / r).max(-1.0)).collect()
        };
        let (signed, far) = (over(&tube.points), over(&tube.far));
        let depth: Vec<f64> = signed.iter().map(|x| x.max(0.0)).collect();
        let sections: Vec<Section> = (0..INNER)
            .step_by(2)
            .map(|n| section(field, tube.points[n], tube.tangents[n], HALF_WIDTH * tube.radii[n] + field.voxel()))
            .collect();
        let elongations: Vec<f64> = sections.iter().map(Section::elongation).collect();
        let areas: Vec<f64> = sections.iter().map(|s| s.area).collect();
        let fold = |values: &[f64], of: fn(f64, f64) -> f64, from: f64| values.iter().copied().fold(from, of);
        let mean_radius = tube.radii.iter().sum::<f64>() / INNER as f64;
        let shifts: Vec<f64> = sections.iter().map(|s| norm(s.shift)).collect();
        Self {
            miss: sorted([miss_a, miss_b].map(|miss| (miss / sum + 0.1).ln())),
            skew: (skew / sum + 0.1).ln(),
            bend: ((tube.length + 1e-3 * sum) / (distance(b.root, a.root) + 0.1 * sum)).ln(),
            rings: RINGS.map(ring),
            signed: mean_least(&signed),
            depth: mean_least(&depth),
            far: mean_least(&far),
            far_inside: far.iter().filter(|x| **x > 0.0).count() as f64 / INNER as f64,
            sections: [
                (fold(&areas, f64::min, f64::INFINITY) / a.area.min(b.area) + 0.1).ln(),
                (fold(&areas, f64::max, 0.0) / a.area.max(b.area) + 0.1).ln(),
                median(&elongations).unwrap_or(1.0).ln(),
                fold(&elongations, f64::max, 1.0).ln(),
                sections.iter().map(|s| s.second).fold(0.0, f64::max),
                sections.iter().map(|s| s.saddle).fold(1.0, f64::min),
                fold(&shifts, f64::max, 0.0) / mean_radius,
            ],
        }
    }
}

/// The depths along the way from one end over the core to the other: least and most over a radius, the deepest dip, the number of dips.
fn along_the_way(field: &Field, arms: [&LumenArm; 2], core: &[Point]) -> [f64; 4] {
    let [a, b] = arms;
    let mut depth: Vec<f64> = a.depths.iter().rev().copied().collect();
    depth.extend(core.iter().map(|p| field.depth(*p)));
    depth.extend_from_slice(&b.depths);
    let before = depth.clone();
    for n in 1..depth.len() - 1 {
        depth[n] = 0.25 * before[n - 1] + 0.5 * before[n] + 0.25 * before[n + 1];
    }
    let small = 0.1 * field.voxel();
    let running = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        let most = values.scan(0.0_f64, |most, x| {
            *most = most.max(x);
            Some(*most)
        });
        most.collect()
    };
    let forward = running(&mut depth.iter().copied());
    let mut backward = running(&mut depth.iter().rev().copied());
    backward.reverse();
    let dips: Vec<f64> = (0..depth.len()).map(|n| (depth[n] + small) / (forward[n].min(backward[n]) + small)).collect();
    let low: Vec<bool> = dips.iter().map(|x| *x < DIP).collect();
    let count = (0..low.len()).filter(|n| low[*n] && (*n == 0 || !low[n - 1])).count();
    let [least, most] = [depth.iter().copied().fold(f64::INFINITY, f64::min), depth.iter().copied().fold(0.0, f64::max)];
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
    let n = places.len().max(1) as f64;
    let sum = places.iter().fold([0.0; 3], |sum, p| [0, 1, 2].map(|k| sum[k] + p[k]));
    let [(least, normal), (middle, _), (most, _)] = principal(&places, sum.map(|x| x / n));
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
fn covers(places: &[Point], pairs: &[Pair], tubes: &[LumenTube], voxel: f64) -> Vec<[f64; 3]> {
    let covered_by = |tube: &LumenTube| {
        let near = |p: &Point| tube.points.iter().zip(&tube.radii).any(|(q, r)| distance(*p, *q) <= r + 0.4 * voxel);
        places.iter().map(near).collect()
    };
    let covered: Vec<Vec<bool>> = tubes.iter().map(covered_by).collect();
    let disjoint = |a: usize, b: usize| pairs[a].ends.iter().all(|end| !pairs[b].ends.contains(end));
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

/// The features of pairs, each a row of [`MASK_FEATURES`], and of [`IMAGE_FEATURES`](super::image::IMAGE_FEATURES) where there is an image.
pub fn mask_features(field: &Field, scene: Option<&Scene>, branches: &Branches, pairs: &[Pair]) -> Vec<Vec<f64>> {
    let clusters: Vec<&[Pair]> = pairs.chunk_by(|a, b| a.cluster == b.cluster).collect();
    in_order(&clusters, |_, pairs| of_cluster(field, scene, branches, pairs)).concat()
}

fn of_cluster(field: &Field, scene: Option<&Scene>, branches: &Branches, pairs: &[Pair]) -> Vec<Vec<f64>> {
    let cluster = pairs[0].cluster;
    let c = &branches.clusters[cluster];
    let arms: Vec<LumenArm> = (0..c.ends.len()).map(|end| LumenArm::new(field, branches, cluster, end)).collect();
    let tubes: Vec<LumenTube> = pairs.iter().map(|p| LumenTube::new(&arms[p.ends[0]], &arms[p.ends[1]])).collect();
    let found: Vec<OfTube> =
        pairs.iter().zip(&tubes).map(|(p, tube)| OfTube::new(field, &arms[p.ends[0]], &arms[p.ends[1]], tube)).collect();
    let (places, shape, across_it) = around(field, c, &arms);
    let cover = covers(&places, pairs, &tubes, field.voxel());
    let table = |f: &dyn Fn(&OfTube) -> f64| PairTable::over(pairs, arms.len(), -9.0, |row| f(&found[row]));
    let straight = table(&|t| -t.miss[1]);
    let signed = table(&|t| t.signed[1]);
    let far = table(&|t| t.far[0]);
    let ring = table(&|t| t.rings[1][0]);
    let fit = table(&|t| t.signed[0] + t.signed[1]);
    let mut areas: Vec<f64> = arms.iter().map(|a| a.area).collect();
    let widest = areas.iter().copied().fold(0.0, f64::max);
    areas.sort_by(|a, b| b.total_cmp(a));
    let others: f64 = areas.iter().skip(1).map(|a| a.powf(1.5)).sum();
    let murray = (areas[0].powf(1.5) / others.max(f64::MIN_POSITIVE)).ln();
    let deepest = c.core.iter().map(|p| field.depth(p.position)).fold(0.0, f64::max);
    let most_radius = arms.iter().map(|a| a.radius).fold(0.0, f64::max);
    let rivals = (arms.len() - 1) as f64;
    let better =
        |end: usize, value: f64| (0..arms.len()).filter(|q| *q != end && fit.get(end, *q) > value).count() as f64 / rivals;
    let core: Vec<Point> = c.core.iter().map(|p| p.position).collect();
    let of_pair = |n: usize| -> Vec<f64> {
        let ends = pairs[n].ends;
        let [a, b] = ends.map(|end| &arms[end]);
        let t = &found[n];
        let to_widest = sorted([a, b].map(|arm| (arm.area / widest).ln()));
        let elongation = sorted([a.elongation, b.elongation]);
        let miss_margin = straight.margins(ends, -1.5);
        let ring_margin = ring.margins(ends, 0.0);
        let signed_margin = signed.margins(ends, 0.0);
        let far_margin = far.margins(ends, 0.0);
        let own = fit.get(ends[0], ends[1]);
        let behind = sorted(ends.map(|end| better(end, own)));
        let gain = |table: &PairTable| if arms.len() <= 8 { table.pairing_gain(ends) } else { 0.0 };
        let way = way_through(&core, a.root, b.root);
        let way = along_the_way(field, [a, b], &way);
        let normal = sorted([a, b].map(|arm| dot(arm.along, across_it).abs()));
        let [alone, with, without] = cover[n];
        let mut row = t.miss.to_vec();
        row.extend([t.skew, -dot(a.along, b.along), t.bend, (a.area / b.area).ln().abs()]);
        row.extend([to_widest, elongation, miss_margin, t.rings[0], t.rings[1]].concat());
        row.extend([t.depth[1], t.depth[0], ring_margin[0], ring_margin[1], t.signed[1], t.signed[0], t.far[1], t.far[0]]);
        row.push(t.far_inside);
        row.extend([signed_margin, far_margin, [gain(&fit), gain(&straight)], behind].concat());
        row.extend(t.sections);
        row.extend(way);
        row.push(murray);
        row.extend(shape);
        row.push((deepest / most_radius + 0.1).ln());
        row.extend([normal[0], normal[1], alone, with, without, with - without]);
        row
    };
    let mut rows: Vec<Vec<f64>> = (0..pairs.len()).map(of_pair).collect();
    if let Some(scene) = scene {
        let shown = image_features(scene, field.voxel(), c.centre(), &arms, &tubes, pairs);
        rows.iter_mut().zip(shown).for_each(|(row, shown)| row.extend(shown));
    }
    rows
}

/// Places on the core's way from one arm to the other: the core's points nearest to a few places on the straight line.
fn way_through(core: &[Point], from: Point, to: Point) -> Vec<Point> {
    let near = |n: u32| {
        let at = lerp(from, to, f64::from(n) / 4.0);
        core.iter().copied().min_by(|a, b| distance(*a, at).total_cmp(&distance(*b, at)))
    };
    let mut way: Vec<Point> = (1..4).filter_map(near).collect();
    way.dedup();
    way
}
