//! What the skeleton tells of a pair of branch ends at a cluster. All features are ratios of lengths, or cosines.
//!
//! R is the radius of the cluster's core, ρ = 1.5 R. S is the cosine between one end's direction and the other's reversed: 1 where a
//! vessel passes straight through.

use std::collections::{BTreeMap, BTreeSet};

use super::branches::{BranchEnd, Branches, Cluster, Course};
use willis_core::network::paths::{ShortestPaths, lengths_at};
use willis_core::support::geometry::{Point, distance, dot, sub, unit};
use willis_core::support::statistics::median;

/// Directions are taken between these multiples of ρ, near and far.
const NEAR: [f64; 2] = [0.4, 2.2];
const FAR: [f64; 2] = [0.8, 6.0];
/// A direction begins no further along a course than this share of it.
const MOST_START: f64 = 0.2;
/// A search for another way around passes no more than so many clusters.
const MOST_PASSED: usize = 60;
/// A way around is no longer than this many R.
const LONGEST_WAY: f64 = 200.0;

/// The names of the features of a pair.
pub const PAIR_FEATURES: &str = "\
    straight_near straight_far near_margin_least near_margin_most far_margin_least far_margin_most pairing_gain radius_ratio \
    thinner wider murray core_width narrowing ends way_inside length_least length_most free_ends is_short way_around \
    no_way_around way_around_ratio beyond_least beyond_most straight_by_ratio ways_around core_size";
/// Those of the features of a branch as seen from one of its ends.
pub const BRANCH_FEATURES: &str = "\
    length width narrowest free far_straight far_aligned far_wider far_ends here_straight here_aligned here_wider partner \
    bulge winding parallel";

/// The names of all features of the skeleton, in their order.
pub fn skeleton_feature_names() -> Vec<String> {
    let pairs = PAIR_FEATURES.split(' ').map(str::to_owned);
    let branches =
        ["least", "most"].into_iter().flat_map(|of| BRANCH_FEATURES.split(' ').map(move |name| format!("branch_{name}_{of}")));
    pairs.chain(branches).collect()
}

/// All pairs of so many things, the lower first.
pub fn pairs_among(count: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| [i, j]))
}

/// Two values, the lower first.
pub fn sorted([a, b]: [f64; 2]) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

/// The skeleton as a graph of clusters and free ends.
struct Coarse {
    /// Per branch its two nodes: clusters, then free ends.
    nodes: Vec<[usize; 2]>,
    /// Per node its branches: the branch, the node at the other end, the length.
    next: Vec<Vec<(usize, usize, f64)>>,
}

impl Coarse {
    fn new(branches: &Branches) -> Self {
        let mut count = branches.clusters.len();
        let mut nodes = Vec::with_capacity(branches.branches.len());
        for branch in &branches.branches {
            nodes.push(branch.clusters.map(|cluster| {
                cluster.unwrap_or_else(|| {
                    count += 1;
                    count - 1
                })
            }));
        }
        let next = lengths_at(count, nodes.iter().enumerate().map(|(row, ends)| (row, *ends, branches.branches[row].length)));
        Self { nodes, next }
    }

    /// Way lengths (m) from the far end of a branch without passing a cluster, and the length of all branches met, m.
    fn beyond(&self, paths: &mut ShortestPaths, cluster: usize, end: BranchEnd, length: f64) -> (BTreeMap<usize, f64>, f64) {
        let from = self.nodes[end.branch][usize::from(!end.last)];
        if from == cluster {
            return (BTreeMap::new(), length);
        }
        let (mut met, mut used, mut found) = (length, BTreeSet::from([end.branch]), BTreeMap::new());
        let around = |node: usize| self.next[node].iter().copied().filter(|(_, next, _)| *next != cluster);
        paths.search(&[from], f64::INFINITY, around, |lengths, node| {
            found.insert(node, lengths[node]);
            met += self.next[node].iter().filter(|(branch, ..)| used.insert(*branch)).map(|(.., length)| length).sum::<f64>();
            found.len() <= MOST_PASSED
        });
        (found, met)
    }
}

/// The direction of a course from about one length along it to another, m.
fn direction(course: &Course, [from, to]: [f64; 2]) -> Point {
    let length = course.length();
    course.direction(from.min(MOST_START * length), to.min(length))
}

/// The features of every branch as seen from each of its ends: first, last.
fn branch_features(branches: &Branches) -> Vec<[Vec<f64>; 2]> {
    let directions = |c: &Cluster| {
        let rho = 1.5 * c.radius;
        let direction = |end: &BranchEnd| direction(&branches.walk(*end, 5.0 * rho), [0.5 * rho, 4.0 * rho]);
        c.ends.iter().map(direction).collect::<Vec<Point>>()
    };
    let directions: Vec<Vec<Point>> = branches.clusters.iter().map(directions).collect();
    let of_branch = |row: usize| {
        let branch = &branches.branches[row];
        let course = &branches.courses[row];
        let typical = median(&course.radii).unwrap_or(branch.radius);
        let mut sides = [[0.0, 0.0, -1.0, 0.0, 0.0]; 2];
        let mut through: [Option<Point>; 2] = [None; 2];
        for last in [false, true] {
            let side = usize::from(last);
            let Some(cluster) = branch.clusters[side] else { continue };
            let ends = &branches.clusters[cluster].ends;
            let own = ends.iter().position(|end| *end == BranchEnd { branch: row, last }).unwrap_or(0);
            let d = &directions[cluster];
            let others: Vec<usize> = (0..ends.len()).filter(|end| *end != own).collect();
            let pairs = pairs_among(others.len()).map(|pair| pair.map(|row| others[row]));
            let found = pairs.map(|[a, b]| (-dot(d[a], d[b]), [a, b]));
            let best = found.reduce(|best, next| if next.0 > best.0 { next } else { best });
            through[side] = best.map(|(_, [a, b])| unit(sub(d[a], d[b])));
            let aligned = match through[side] {
                Some(along) => dot(d[own], along).abs(),
                None => others.iter().map(|a| dot(d[own], d[*a]).abs()).fold(0.0, f64::max),
            };
            let widest = others.iter().map(|a| branches.branches[ends[*a].branch].radius).fold(0.0, f64::max);
            let wider = if widest > 0.0 { (widest / branch.radius).ln() } else { 0.0 };
            let partner = others.iter().map(|a| -dot(d[own], d[*a])).fold(-1.0, f64::max);
            sides[side] = [best.map_or(-1.0, |(s, _)| s), aligned, wider, others.len() as f64, partner];
        }
        let core = branch.clusters.map(|cluster| cluster.map_or(0.0, |c| branches.clusters[c].radius));
        let widest_core = core[0].max(core[1]);
        let parallel = match through {
            [Some(a), Some(b)] => dot(a, b).abs(),
            _ => -0.3,
        };
        let line = &course.points;
        let chord = distance(line[line.len() - 1], line[0]);
        let winding = ((branch.length + 1e-3 * typical) / (chord + 0.1 * typical)).ln();
        let least = course.radii.iter().copied().fold(f64::INFINITY, f64::min);
        let most = course.radii.iter().copied().fold(0.0, f64::max);
        let narrowest = if widest_core > 0.0 { (least / widest_core).ln() } else { 0.0 };
        [0, 1].map(|here| {
            let (h, f) = (sides[here], sides[1 - here]);
            let length = (branch.length / (core[0] + core[1] + 0.3 * typical) + 0.05).ln();
            let width = (typical / widest_core.max(0.3 * typical)).ln();
            let is_free = f64::from(u8::from(branch.clusters[1 - here].is_none()));
            let bulge = (most / typical).ln();
            [&[length, width, narrowest, is_free][..], &f[..4], &[h[0], h[1], h[2], h[4], bulge, winding, parallel]].concat()
        })
    };
    (0..branches.branches.len()).map(of_branch).collect()
}

/// A symmetric table of the pairs of a cluster's ends; `nothing` on the diagonal.
pub struct PairTable {
    size: usize,
    values: Vec<f64>,
}

impl PairTable {
    /// The table of a function of two ends.
    pub fn of(size: usize, nothing: f64, value: impl Fn(usize, usize) -> f64) -> Self {
        Self::over(size, nothing, pairs_among(size).map(|[i, j]| value(i, j)))
    }

    /// The table of so many ends, given the value of every pair of them in order; `nothing` for ends that are no pair.
    pub fn over(size: usize, nothing: f64, of_pairs: impl Iterator<Item = f64>) -> Self {
        let mut table = Self { size, values: vec![nothing; size * size] };
        pairs_among(size).zip(of_pairs).for_each(|(pair, value)| table.set(pair, value));
        table
    }

    /// Sets the value of two ends.
    pub fn set(&mut self, [i, j]: [usize; 2], value: f64) {
        (self.values[i * self.size + j], self.values[j * self.size + i]) = (value, value);
    }

    /// How many ends there are.
    pub fn ends(&self) -> usize {
        self.size
    }

    /// The value of two ends.
    pub fn get(&self, i: usize, j: usize) -> f64 {
        self.values[i * self.size + j]
    }

    /// The value of a pair less the best of each end's other partners, the least first; `alone` stands for an end without another.
    pub fn margins(&self, [i, j]: [usize; 2], alone: f64) -> [f64; 2] {
        let others = || (0..self.size).filter(|q| *q != i && *q != j);
        let best = |end: usize| others().map(|q| self.get(end, q)).reduce(f64::max).unwrap_or(alone);
        sorted([i, j].map(|end| self.get(i, j) - best(end)))
    }

    /// What pairing two ends, and the best two of the rest, gains on the best pairing that parts them, for every two; zeros with fewer than four
    /// ends.
    #[must_use]
    pub fn pairing_gains(&self) -> Self {
        let mut best_first: Vec<[usize; 2]> = pairs_among(self.size).collect();
        best_first.sort_by(|[a, b], [c, d]| self.get(*c, *d).total_cmp(&self.get(*a, *b)));
        let gain = |i: usize, j: usize| {
            let is_other = |end: &usize| *end != i && *end != j;
            let together = best_first.iter().find(|pair| pair.iter().all(is_other)).map_or(0.0, |[p, q]| self.get(*p, *q));
            // Of the rest the best partner of an end, with its value, and the value of the second.
            let partners = |end: usize| {
                let (mut best, mut second) = ((f64::NEG_INFINITY, end), f64::NEG_INFINITY);
                for (value, other) in (0..self.size).filter(is_other).map(|other| (self.get(end, other), other)) {
                    if value > best.0 {
                        (best, second) = ((value, other), best.0);
                    } else {
                        second = second.max(value);
                    }
                }
                (best, second)
            };
            let [((of_i, p), next_of_i), ((of_j, q), next_of_j)] = [i, j].map(partners);
            let apart = if p == q { (next_of_i + of_j).max(of_i + next_of_j) } else { of_i + of_j };
            self.get(i, j) + together - apart
        };
        Self::of(self.size, 0.0, |i, j| if self.size < 4 { 0.0 } else { gain(i, j) })
    }
}

/// The features of the pairs of ends of each cluster, a row of [`skeleton_feature_names`] each.
pub fn skeleton_features(branches: &Branches) -> Vec<Vec<f64>> {
    let coarse = Coarse::new(branches);
    let of_branch = branch_features(branches);
    let all: Vec<f64> = branches.branches.iter().flat_map(|b| b.points.iter().map(|p| p.radius)).collect();
    let typical = median(&all).unwrap_or(1.0);
    let mut paths = ShortestPaths::new(coarse.next.len());
    let nodes = branches.clusters.iter().flat_map(|c| c.nodes.iter().map(|node| node + 1)).max().unwrap_or(0);
    let mut inside = ShortestPaths::new(nodes);
    let mut out = Vec::new();
    for (cluster, c) in branches.clusters.iter().enumerate().filter(|(_, c)| c.ends.len() > 1) {
        let of_pairs = of_cluster(branches, &coarse, [&mut paths, &mut inside], cluster, typical);
        for (pair, mut row) in pairs_among(c.ends.len()).zip(of_pairs) {
            let [a, b] = pair.map(|end| &of_branch[c.ends[end].branch][usize::from(c.ends[end].last)]);
            row.extend((0..a.len()).map(|k| a[k].min(b[k])));
            row.extend((0..a.len()).map(|k| a[k].max(b[k])));
            out.push(row);
        }
    }
    out
}

/// The features of the pairs of one cluster, in the order of [`PAIR_FEATURES`]; `usual` is the radius of most points, m.
fn of_cluster(branches: &Branches, coarse: &Coarse, paths: [&mut ShortestPaths; 2], cluster: usize, usual: f64) -> Vec<Vec<f64>> {
    let [paths, inside] = paths;
    let c = &branches.clusters[cluster];
    let rho = 1.5 * c.radius;
    let (mut along, mut radius): (Vec<[Point; 2]>, Vec<f64>) = (Vec::new(), Vec::new());
    for end in &c.ends {
        let course = branches.walk(*end, 8.0 * rho);
        let length = course.length();
        along.push([NEAR, FAR].map(|between| direction(&course, between.map(|n| n * rho))));
        let radii = course.radii_between(rho.min(0.3 * length), (5.0 * rho).min(length));
        radius.push(median(&radii).unwrap_or(branches.branches[end.branch].radius));
    }
    let count = c.ends.len();
    let [near, far] = [0, 1].map(|of: usize| PairTable::of(count, -9.0, |i, j| -dot(along[i][of], along[j][of])));
    let pairing_gains = far.pairing_gains();
    let length: Vec<f64> = c.ends.iter().map(|end| branches.branches[end.branch].length).collect();
    let beyond: Vec<(BTreeMap<usize, f64>, f64)> =
        c.ends.iter().zip(&length).map(|(end, length)| coarse.beyond(paths, cluster, *end, *length)).collect();
    let around = PairTable::of(count, f64::INFINITY, |i, j| {
        if c.ends[i].branch == c.ends[j].branch {
            return length[i];
        }
        let ways = beyond[i].0.iter().filter_map(|(node, d)| beyond[j].0.get(node).map(|e| d + e));
        ways.fold(f64::INFINITY, f64::min) + length[i] + length[j]
    });
    let ways = pairs_among(count).filter(|[i, j]| around.get(*i, *j).is_finite()).count() as f64;
    let mut wide = radius.clone();
    wide.sort_by(|a, b| b.total_cmp(a));
    let others: f64 = wide.iter().skip(1).map(|r| r.powi(3)).sum();
    let murray = wide.first().map_or(0.0, |r| (r.powi(3) / others.max(f64::MIN_POSITIVE)).ln());
    let entry_radius = |end: &BranchEnd| {
        let points = &branches.branches[end.branch].points;
        points[if end.last { points.len() - 1 } else { 0 }].radius
    };
    // Per two ends the way inside the core (m) and the least radius on it.
    let mut within: Vec<Vec<(f64, f64)>> = Vec::new();
    for from in &c.ends {
        inside.search(&[branches.node(*from)], f64::INFINITY, |node| branches.inside(cluster, node), |_, _| true);
        let to = |end: &BranchEnd| {
            let way = inside.path_to(branches.node(*end)).edges;
            let narrowest = way.iter().flat_map(|row| branches.inner[*row].points.iter().map(|p| p.radius));
            let low = narrowest.chain([entry_radius(from), entry_radius(end)]).fold(f64::INFINITY, f64::min);
            (inside.lengths()[branches.node(*end)], low)
        };
        within.push(c.ends.iter().map(to).collect());
    }
    let core = c.radius.max(f64::MIN_POSITIVE);
    let widest = radius.iter().copied().fold(0.0, f64::max).ln();
    let is_free = |end: &&usize| branches.cluster(c.ends[**end].other()).is_none();
    let of_pair = |ends: [usize; 2]| {
        let [i, j] = ends;
        let radii = ends.map(|end| radius[end].ln());
        let [thin, wide] = sorted(radii);
        let lengths = sorted(ends.map(|end| (length[end] / core + 0.1).ln()));
        let met = sorted(ends.map(|end| (beyond[end].1 / core + 0.1).ln()));
        let around = around.get(i, j);
        let way = around.min(LONGEST_WAY * core);
        let (inside, low) = within[i][j];
        let step = (radii[0] - radii[1]).abs();
        let mut row = vec![near.get(i, j), far.get(i, j)];
        row.extend([near.margins(ends, -1.0), far.margins(ends, -1.0)].concat());
        row.extend([pairing_gains.get(i, j), step, thin - widest, wide - widest, murray, core.ln() - wide, low.ln() - thin]);
        row.extend([radius.len() as f64, inside / core, lengths[0], lengths[1], ends.iter().filter(is_free).count() as f64]);
        row.extend([f64::from(u8::from(lengths[0] < 1.0)), (way / core).ln()]);
        row.extend([f64::from(u8::from(around > LONGEST_WAY * core)), (way / (length[i] + length[j] + core)).ln()]);
        row.extend([met[0], met[1], near.get(i, j) * step, ways, (core / usual).ln()]);
        row
    };
    pairs_among(count).map(of_pair).collect()
}
