//! Branches between junctions and their courses, and contact clusters: junctions that lie within each other's lumen, with the branch ends that meet there.

use std::collections::BTreeMap;

use willis_core::network::path_places::{at_even_steps, length_of};
use willis_core::network::walks::{Walk, vessels_at};
use willis_core::network::{Network, Origin, PathPoint};
use willis_core::support::geometry::{Point, centroid, lerp, smooth, straightest, sub, unit};
use willis_core::support::statistics::median;
use willis_core::support::ties::steady;

/// Junctions are one cluster along a branch no longer than the sum of their radii, ...
const REACH: f64 = 1.0;
/// ... until more ends than this meet there. The partitions of so many, 203, are summed exactly; those of more are not.
pub const MOST_ENDS: usize = 6;
/// A branch shorter than this share of the sum joins junctions however many ends meet there.
const NOTHING_BETWEEN: f64 = 0.5;
/// Points of a course are a quarter of the branch's radius apart, and smoothed in so many rounds of (1/4, 1/2, 1/4).
const STEP_RADII: f64 = 0.25;
const ROUNDS: usize = 8;
/// A walk passes no more than this many branches, and goes on in the direction of so many last points.
const HOPS: usize = 4;
const TAIL: usize = 8;

/// One end of a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct BranchEnd {
    /// The branch, by row.
    pub branch: usize,
    /// Whether it is its last point.
    pub last: bool,
}

/// A run of observed vessels between two nodes where not exactly two vessels meet.
#[derive(Debug, Clone)]
pub struct ObservedBranch {
    /// Its nodes, first and last.
    pub ends: [usize; 2],
    /// Rows of its vessels in order, each with whether it is passed backwards.
    pub vessels: Vec<(usize, bool)>,
    /// All its nodes in order, one more than it has vessels.
    pub nodes: Vec<usize>,
    /// Its points, the nodes first and last.
    pub points: Vec<PathPoint>,
    /// Its length, m, with 32 bits: equal ones on a lattice are equal.
    pub length: f64,
    /// The median radius of its points, the ends left out, m.
    pub radius: f64,
    /// The clusters at its ends; `None` at a free end.
    pub clusters: [Option<usize>; 2],
}

/// Junctions that lie within each other's lumen.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Its junctions, rows of nodes, rising.
    pub nodes: Vec<usize>,
    /// The branches inside it, rows of [`Branches::inner`].
    pub inner: Vec<usize>,
    /// The points of its junctions and inner branches.
    pub core: Vec<PathPoint>,
    /// The median radius of these, m.
    pub radius: f64,
    /// The branch ends that meet here.
    pub ends: Vec<BranchEnd>,
}

impl Cluster {
    /// The mean of the core's points.
    pub fn centre(&self) -> Point {
        centroid(self.core.iter().map(|p| p.position))
    }
}

/// The observed vessels as branches between clusters.
#[derive(Debug, Clone, Default)]
pub struct Branches {
    /// Branches between clusters and free ends.
    pub branches: Vec<ObservedBranch>,
    /// Branches within clusters; of theirs, `clusters` is the one they are in.
    pub inner: Vec<ObservedBranch>,
    /// The clusters.
    pub clusters: Vec<Cluster>,
    /// The courses of the branches between clusters, each from its first point on.
    pub courses: Vec<Course>,
}

impl Branches {
    /// Divides the observed vessels of a network, whose nodes have positions.
    pub fn new(network: &Network) -> Self {
        let runs = runs(network, |_| false);
        let degree = willis_core::support::numbered::counted(network.node_count(), runs.iter().flat_map(|run| run.ends));
        let is_junction = |node: usize| degree[node] > 2;
        let mut radius_at = vec![0.0_f64; network.node_count()];
        for run in &runs {
            for (node, point) in [(run.ends[0], run.points.first()), (run.ends[1], run.points.last())] {
                radius_at[node] = radius_at[node].max(point.map_or(0.0, |p| p.radius));
            }
        }
        let mut union = petgraph::unionfind::UnionFind::<usize>::new(network.node_count());
        let mut count = degree.clone();
        let mut is_inner = vec![false; runs.len()];
        let mut order: Vec<usize> = (0..runs.len()).collect();
        order.sort_by(|a, b| runs[*a].length.total_cmp(&runs[*b].length).then(a.cmp(b)));
        for row in order {
            let [a, b] = runs[row].ends;
            let sum = radius_at[a] + radius_at[b];
            if !is_junction(a) || !is_junction(b) || runs[row].length > steady(REACH * sum) {
                continue;
            }
            let (a, b) = (union.find_mut(a), union.find_mut(b));
            let ends = if a == b { count[a] - 2 } else { count[a] + count[b] - 2 };
            if a != b && ends > MOST_ENDS && runs[row].length > steady(NOTHING_BETWEEN * sum) {
                continue;
            }
            is_inner[row] = true;
            union.union(a, b);
            count[union.find(a)] = ends;
        }
        let mut row_of: BTreeMap<usize, usize> = BTreeMap::new();
        let mut clusters: Vec<Cluster> = Vec::new();
        for node in (0..network.node_count()).filter(|node| is_junction(*node)) {
            let row = *row_of.entry(union.find(node)).or_insert_with(|| {
                clusters.push(Cluster { nodes: Vec::new(), inner: Vec::new(), core: Vec::new(), radius: 0.0, ends: Vec::new() });
                clusters.len() - 1
            });
            clusters[row].nodes.push(node);
            let position = network.node(node).position.unwrap_or_default();
            clusters[row].core.push(PathPoint { position, radius: radius_at[node], id: None });
        }
        let mut cluster_of = |node: usize| is_junction(node).then(|| row_of[&union.find(node)]);
        let mut this = Self::default();
        for (mut run, inside) in runs.into_iter().zip(is_inner) {
            run.clusters = run.ends.map(&mut cluster_of);
            if let (true, Some(cluster)) = (inside, run.clusters[0]) {
                clusters[cluster].inner.push(this.inner.len());
                let between = run.points.len().saturating_sub(1).max(1);
                clusters[cluster].core.extend_from_slice(&run.points[1.min(between)..between]);
                this.inner.push(run);
                continue;
            }
            for (last, cluster) in [(false, run.clusters[0]), (true, run.clusters[1])] {
                if let Some(cluster) = cluster {
                    clusters[cluster].ends.push(BranchEnd { branch: this.branches.len(), last });
                }
            }
            this.branches.push(run);
        }
        for cluster in &mut clusters {
            cluster.radius = median(&cluster.core.iter().map(|p| p.radius).collect::<Vec<f64>>()).unwrap_or(0.0);
        }
        let course = |b: &ObservedBranch| {
            let course = even_course(&b.points, STEP_RADII * b.radius);
            Course { points: smooth(&course.points, ROUNDS), ..course }
        };
        let courses = this.branches.iter().map(course).collect();
        Self { clusters, courses, ..this }
    }

    /// The node where an end is.
    pub fn node(&self, end: BranchEnd) -> usize {
        self.branches[end.branch].ends[usize::from(end.last)]
    }

    /// The vessel at an end, and whether the branch passes it backwards.
    pub fn vessel_at(&self, end: BranchEnd) -> (usize, bool) {
        let vessels = &self.branches[end.branch].vessels;
        vessels[if end.last { vessels.len() - 1 } else { 0 }]
    }

    /// The branches inside a cluster at one of its nodes: row of [`Branches::inner`], node at the other end, length (m).
    pub fn inside(&self, cluster: usize, node: usize) -> impl Iterator<Item = (usize, usize, f64)> {
        self.clusters[cluster].inner.iter().filter_map(move |row| {
            let inner = &self.inner[*row];
            let next = inner.ends.iter().position(|end| *end == node).map(|end| inner.ends[1 - end])?;
            Some((*row, next, inner.length))
        })
    }

    /// The course from an end of a branch at least as far as `reach`, beyond far clusters along the branch that goes on the straightest.
    pub fn walk(&self, from: BranchEnd, reach: f64) -> Course {
        let (mut course, mut end, mut seen) = (Course::default(), from, vec![from.branch]);
        loop {
            let own = &self.courses[end.branch];
            let piece = if end.last { own.reversed() } else { own.clone() };
            course.extend(&piece);
            let Some(cluster) = self.cluster(end.other()) else { break };
            if steady(course.length()) >= steady(reach) || seen.len() >= HOPS {
                break;
            }
            let tail = &piece.points[piece.points.len().saturating_sub(TAIL)..];
            let along = unit(sub(tail[tail.len() - 1], tail[0]));
            let own = self.branches[end.branch].radius;
            let others = self.clusters[cluster].ends.iter().filter(|next| !seen.contains(&next.branch));
            let ways = others.map(|next| {
                let line = &self.courses[next.branch].points;
                let n = TAIL.min(line.len()) - 1;
                let [first, on] = if next.last { [line.len() - 1, line.len() - 1 - n] } else { [0, n] };
                (*next, sub(line[on], line[first]), (self.branches[next.branch].radius / own).ln())
            });
            let Some(next) = straightest(along, ways) else { break };
            end = next;
            seen.push(end.branch);
        }
        course
    }

    /// The cluster at an end; `None` where it is free.
    pub fn cluster(&self, end: BranchEnd) -> Option<usize> {
        self.branches[end.branch].clusters[usize::from(end.last)]
    }
}

impl BranchEnd {
    /// The other end of the same branch.
    #[must_use]
    pub fn other(self) -> Self {
        Self { branch: self.branch, last: !self.last }
    }
}

/// The runs of observed vessels between nodes where not exactly two of them meet, or where runs end besides. A ring without such a node
/// is none.
pub fn runs(network: &Network, ends_runs: impl Fn(usize) -> bool) -> Vec<ObservedBranch> {
    let is_observed = |row: usize| network.vessel(row).origin == Origin::Observed;
    let at = vessels_at(network, is_observed);
    let mut done = vec![false; network.vessel_count()];
    let mut out = Vec::new();
    for start in (0..network.vessel_count()).filter(|row| is_observed(*row)) {
        let ends = network.ends(start);
        let Some(from) = ends.into_iter().find(|node| at[*node].len() != 2 || ends_runs(*node)) else { continue };
        if done[start] {
            continue;
        }
        let run = Walk::along(from, start, &at, |row| network.ends(row), |node| !ends_runs(node));
        run.edges.iter().for_each(|row| done[*row] = true);
        out.extend(branch(network, run));
    }
    out
}

/// The branch of a run; `None` where it has no length.
fn branch(network: &Network, run: Walk) -> Option<ObservedBranch> {
    let (ends, points) = (run.ends(), run.points(network));
    let vessels = run.edges.iter().zip(&run.nodes).map(|(row, node)| (*row, network.ends(*row)[0] != *node)).collect();
    let (length, nodes) = (steady(length_of(&points)), run.nodes);
    let inside = if points.len() > 4 { &points[1..points.len() - 1] } else { &points[..] };
    let radius = median(&inside.iter().map(|p| p.radius).collect::<Vec<f64>>())?;
    (length > 0.0 && radius > 0.0).then_some(ObservedBranch { ends, vessels, nodes, points, length, radius, clusters: [None; 2] })
}

/// A course has no fewer and no more steps.
const LEAST_STEPS: usize = 2;
const MOST_STEPS: usize = 20_000;

/// A line with the length along it.
#[derive(Debug, Clone, Default)]
pub struct Course {
    /// Length from the beginning to each point, m, not falling.
    pub arc: Vec<f64>,
    /// The points.
    pub points: Vec<Point>,
    /// Their radii, m.
    pub radii: Vec<f64>,
}

impl Course {
    /// The whole length, m.
    pub fn length(&self) -> f64 {
        self.arc.last().copied().unwrap_or(0.0)
    }

    /// The place at a length from the beginning, no further than the line goes.
    pub fn at(&self, arc: f64) -> Point {
        let after = self.arc.partition_point(|s| *s < arc);
        if after == 0 || after >= self.arc.len() {
            return self.points.get(after.min(self.points.len().saturating_sub(1))).copied().unwrap_or_default();
        }
        let (from, to) = (self.arc[after - 1], self.arc[after]);
        lerp(self.points[after - 1], self.points[after], (arc - from) / (to - from).max(f64::MIN_POSITIVE))
    }

    /// The direction from one length along it to another; zero where they are one place.
    pub fn direction(&self, from: f64, to: f64) -> Point {
        unit(sub(self.at(to), self.at(from)))
    }

    /// Radii of the points between two lengths, in order of the points.
    pub fn radii_between(&self, from: f64, to: f64) -> Vec<f64> {
        let between = steady(from)..=steady(to);
        self.arc.iter().zip(&self.radii).filter(|(s, _)| between.contains(&steady(**s))).map(|(_, r)| *r).collect()
    }

    /// The same from its other end.
    fn reversed(&self) -> Self {
        let length = self.length();
        Self {
            arc: self.arc.iter().rev().map(|s| length - s).collect(),
            points: self.points.iter().rev().copied().collect(),
            radii: self.radii.iter().rev().copied().collect(),
        }
    }

    /// Goes on along another line.
    fn extend(&mut self, other: &Self) {
        let length = self.length();
        self.arc.extend(other.arc.iter().map(|s| s + length));
        self.points.extend_from_slice(&other.points);
        self.radii.extend_from_slice(&other.radii);
    }
}

/// A line through points at even steps of about `step`.
pub fn even_course(path: &[PathPoint], step: f64) -> Course {
    let length = length_of(path);
    let steps = (steady(length / step).ceil() as usize).clamp(LEAST_STEPS, MOST_STEPS);
    let mut course = Course::default();
    for (n, place) in at_even_steps(path, steps).into_iter().enumerate() {
        let point = place.on(path);
        course.arc.push(length * n as f64 / steps as f64);
        course.points.push(point.position);
        course.radii.push(point.radius);
    }
    course
}
