//! Neighbours in space, by kiddo's k-d tree, in an order that depends on nothing but distance and point number.

use std::collections::HashSet;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use willis_core::network::units::as_stored;
use willis_core::network::{Network, Origin, Vessel};
use willis_core::support::distinct;
use willis_core::support::geometry::{Point, distance, dot, norm, norm_squared, sub};

/// The nearest points, all at one distance.
pub struct NearestPoints {
    /// Their distance, m; infinite when there is none.
    pub distance: f64,
    /// Their numbers, in rising order.
    pub points: Vec<usize>,
}

/// Points that can be searched.
///
/// The tree halves x, y and z in turn, in vain where many points have a coordinate in common, as along a straight line: then its leaves are
/// n^(2/3) points each. So it holds the points turned by angles that no line of a file has. What it finds is measured again as it stands.
pub struct PointIndex {
    points: Vec<Point>,
    tree: Option<ImmutableKdTree<f64, 3>>,
    /// How far turning may move a point by rounding, m.
    rounding: f64,
}

/// The axes of the tree: a turn by acos(.6) about z, then about x, then about z.
const AXES: [Point; 3] = [[-0.024, -0.768, 0.64], [0.768, -0.424, -0.48], [0.64, 0.48, 0.6]];
/// The share of the largest coordinate by which rounding moves a turned point at most, with room to spare.
const ROUNDING: f64 = 1e-14;

fn turned(p: Point) -> Point {
    AXES.map(|axis| dot(axis, p))
}

impl PointIndex {
    /// Indexes finite points.
    pub fn new(points: Vec<Point>) -> Self {
        let held: Vec<Point> = points.iter().map(|p| turned(*p)).collect();
        let tree = (!held.is_empty()).then(|| ImmutableKdTree::new_from_slice(&held).ok()).flatten();
        let rounding = ROUNDING * points.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        Self { points, tree, rounding }
    }

    /// The points no further than `reach` from `p`, as (distance, number), nearest first, ties to the lower number.
    pub fn within(&self, p: Point, reach: f64) -> Vec<(f64, usize)> {
        let mut hits: Vec<(f64, usize)> = self.squared(p, reach).collect();
        hits.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        hits.into_iter().map(|(d2, i)| (d2.sqrt(), i)).collect()
    }

    /// The points no further than `reach` from `p`, as (distance, number), in no order that means anything.
    pub fn around(&self, p: Point, reach: f64) -> Vec<(f64, usize)> {
        self.squared(p, reach).map(|(d2, i)| (d2.sqrt(), i)).collect()
    }

    /// How many points are no further than `reach` from `p`.
    pub fn count(&self, p: Point, reach: f64) -> usize {
        self.squared(p, reach).count()
    }

    fn squared(&self, p: Point, reach: f64) -> impl Iterator<Item = (f64, usize)> {
        let limit = reach * reach;
        // The tree rounds another way: ask for a little more, then measure again.
        let wide = (reach * (1.0 + 1e-9) + self.rounding + ROUNDING * norm(p)).powi(2);
        let numbers: Vec<usize> = match &self.tree {
            Some(tree) => {
                let hits = tree.query(&turned(p)).within::<SquaredEuclidean<f64>>(wide).unsorted().execute();
                hits.into_iter().map(|hit| hit.item as usize).collect()
            }
            None => (0..self.points.len()).collect(),
        };
        let measured = numbers.into_iter().map(move |i| (norm_squared(sub(self.points[i], p)), i));
        measured.filter(move |(d2, _)| *d2 <= limit)
    }

    /// The `count` points nearest to `p`, as (distance, number), nearest first, ties to the lower number.
    pub fn first(&self, p: Point, count: usize) -> Vec<(f64, usize)> {
        let Some(count) = std::num::NonZero::new(count) else { return Vec::new() };
        let numbers = self.tree.as_ref().map(|tree| tree.query(&turned(p)).nearest_n::<SquaredEuclidean<f64>>(count).execute());
        let farthest = numbers.into_iter().flatten().map(|hit| norm_squared(sub(self.points[hit.item as usize], p)));
        // As many may lie at that distance, of which the tree took any.
        let reach = farthest.fold(0.0, f64::max).sqrt() * (1.0 + 1e-9);
        let mut hits = self.within(p, reach);
        hits.truncate(count.get());
        hits
    }

    /// The points nearest to `p` of those no further than `reach`; those that only rounding parts are all nearest.
    pub fn nearest(&self, p: Point, reach: f64) -> NearestPoints {
        let first = self.tree.as_ref().map(|tree| tree.query(&turned(p)).nearest_one::<SquaredEuclidean<f64>>().execute());
        let found = first.map_or(f64::INFINITY, |hit| norm_squared(sub(self.points[hit.item as usize], p)).sqrt());
        // Another may be nearer by what turning rounds.
        let near = if found <= reach * (1.0 + 1e-9) + 2.0 * (self.rounding + ROUNDING * norm(p)) {
            self.within(p, found * (1.0 + 1e-9))
        } else {
            Vec::new()
        };
        let distance = near.first().map_or(f64::INFINITY, |(distance, _)| *distance);
        let is_nearest = |hit: &&(f64, usize)| distance <= reach * (1.0 + 1e-9) && hit.0 <= distance * (1.0 + 1e-9);
        let points = distinct(near.iter().filter(is_nearest).map(|(_, point)| *point));
        let distance = if points.is_empty() { f64::INFINITY } else { distance };
        NearestPoints { distance, points }
    }
}

/// Joins every node of `ends` to the `k` nodes nearest to it by straight candidates of prior 1, without limit of distance.
///
/// Left out are nodes without position, the node itself, those that a vessel joins to it already, and
/// the second of a pair that comes twice. Candidates follow in the order of `ends`, nearest first, ties in node order. Their radius is the
/// smaller of the two nodes', m.
pub fn join_nearest(network: &mut Network, ends: &[usize], k: usize) {
    let rows: Vec<usize> = (0..network.node_count()).filter(|row| network.node(*row).position.is_some()).collect();
    let index = PointIndex::new(rows.iter().filter_map(|row| network.node(*row).position).collect());
    let ends: Vec<usize> = ends.iter().copied().filter(|end| network.node(*end).position.is_some()).collect();
    let ordered = |a: usize, b: usize| [a.min(b), a.max(b)];
    let among: HashSet<usize> = ends.iter().copied().collect();
    let vessels = network.vessels().map(|(ends, _)| ends).filter(|ends| ends.iter().any(|end| among.contains(end)));
    let mut joined: HashSet<[usize; 2]> = vessels.map(|[a, b]| ordered(a, b)).collect();
    let degree = network.degrees(|_| true);
    let near: Vec<Vec<usize>> = willis_core::support::in_order(&ends, |_, end| {
        let hits = index.first(network.node(*end).position.unwrap_or_default(), k + 1 + degree[*end]);
        let others = hits.into_iter().map(|(_, hit)| rows[hit]).filter(|row| row != end);
        others.filter(|row| !joined.contains(&ordered(*end, *row))).take(k).collect()
    });
    for (end, near) in ends.into_iter().zip(near) {
        for other in near.into_iter().filter(|other| joined.insert(ordered(end, *other))) {
            let (a, b) = (network.node(end), network.node(other));
            let length = distance(a.position.unwrap_or_default(), b.position.unwrap_or_default());
            let radius = a.radius.unwrap_or(f64::INFINITY).min(b.radius.unwrap_or(f64::INFINITY));
            let vessel = Vessel::new(as_stored(length), as_stored(radius), Origin::Candidate);
            network.add_vessel([end, other], vessel);
        }
    }
}
