//! Neighbours in space, by a k-d tree that halves the widest side, in an order that depends on nothing but distance and point number.

use std::collections::{BinaryHeap, HashSet};
use std::ops::Range;

use willis_core::network::units::as_stored;
use willis_core::network::{Network, Origin, Vessel};
use willis_core::support::geometry::{Point, distance, norm_squared, sub};
use willis_core::support::in_order;

/// Points that are not divided any further.
const LEAF: usize = 12;

/// The nearest points, all at one distance.
pub struct Nearest {
    /// Their distance, m; infinite when there is none.
    pub distance: f64,
    /// Their numbers, in rising order.
    pub points: Vec<usize>,
}

/// Points that can be searched.
///
/// A tree that halves x, y and z in turn does so in vain where many points have a coordinate in common, as along a straight line: the leaves of
/// n points are then n^(2/3) points each.
pub struct PointIndex {
    /// The parts of the tree, each before its two halves.
    parts: Vec<Part>,
    /// The points part by part, and their numbers.
    points: Vec<Point>,
    numbers: Vec<u32>,
}

/// Some of the points, and the box around them.
struct Part {
    low: Point,
    high: Point,
    points: Range<u32>,
    /// The row after its last half; the next row where it is not divided.
    after: u32,
}

impl Part {
    /// The least squared distance of a place in the box. It is rounded as those of points are, so none of its points is nearer.
    fn nearest(&self, p: Point) -> f64 {
        norm_squared([0, 1, 2].map(|axis| (self.low[axis] - p[axis]).max(p[axis] - self.high[axis]).max(0.0)))
    }

    /// The largest one, so none of its points is farther.
    fn farthest(&self, p: Point) -> f64 {
        norm_squared([0, 1, 2].map(|axis| (p[axis] - self.low[axis]).max(self.high[axis] - p[axis])))
    }
}

impl PointIndex {
    /// Indexes finite points, fewer than 2³².
    pub fn new(points: Vec<Point>) -> Self {
        let mut numbers: Vec<u32> = (0..points.len() as u32).collect();
        let mut parts = Vec::with_capacity(4 * points.len() / LEAF + 1);
        divide(&points, &mut numbers, 0, &mut parts);
        let points = numbers.iter().map(|number| points[*number as usize]).collect();
        Self { parts, points, numbers }
    }

    /// The points no further than `reach` from `p`, as (distance, number), nearest first, ties to the lower number.
    pub fn within(&self, p: Point, reach: f64) -> Vec<(f64, usize)> {
        let mut hits = self.squared(p, reach);
        hits.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        distances(hits)
    }

    /// The points no further than `reach` from `p`, as (distance, number), in no order that means anything.
    pub fn around(&self, p: Point, reach: f64) -> Vec<(f64, usize)> {
        distances(self.squared(p, reach))
    }

    /// How many points are no further than `reach` from `p`; parts that are as a whole are not looked into.
    pub fn count(&self, p: Point, reach: f64) -> usize {
        let (limit, mut count) = (reach * reach, 0);
        self.parts_within(p, limit, |part| {
            let all = part.farthest(p) <= limit;
            count += if all { part.points.len() } else { self.measured(part, p).filter(|(d2, _)| *d2 <= limit).count() };
        });
        count
    }

    /// The most points that are not divided: so many are looked at to learn that none is near.
    pub fn largest_leaf(&self) -> usize {
        let leaves = self.parts.iter().enumerate().filter(|(row, part)| part.after as usize == row + 1);
        leaves.map(|(_, part)| part.points.len()).max().unwrap_or(0)
    }

    fn squared(&self, p: Point, reach: f64) -> Vec<(f64, usize)> {
        let (limit, mut hits) = (reach * reach, Vec::new());
        self.parts_within(p, limit, |part| hits.extend(self.measured(part, p).filter(|(d2, _)| *d2 <= limit)));
        hits
    }

    /// The undivided parts that reach into a ball, and those that are inside as a whole.
    fn parts_within(&self, p: Point, limit: f64, mut take: impl FnMut(&Part)) {
        let mut row = 0;
        while let Some(part) = self.parts.get(row) {
            let is_near = part.nearest(p) <= limit;
            let whole = is_near && (part.after as usize == row + 1 || part.farthest(p) <= limit);
            if whole {
                take(part);
            }
            row = if whole || !is_near { part.after as usize } else { row + 1 };
        }
    }

    /// The points of a part as (squared distance, number).
    fn measured(&self, part: &Part, p: Point) -> impl Iterator<Item = (f64, usize)> {
        let rows = part.points.start as usize..part.points.end as usize;
        let points = self.points[rows.clone()].iter().zip(&self.numbers[rows]);
        points.map(move |(point, number)| (norm_squared(sub(*point, p)), *number as usize))
    }

    /// The `count` points nearest to `p`, as (distance, number), nearest first, ties to the lower number.
    pub fn first(&self, p: Point, count: usize) -> Vec<(f64, usize)> {
        let mut found = First { count, hits: BinaryHeap::new() };
        self.descend(p, &mut found);
        let hits = found.hits.into_sorted_vec().into_iter().map(|Hit(d2, number)| (d2, number));
        distances(hits.collect())
    }

    /// The points nearest to `p` of those no further than `reach`; those that only rounding parts are all nearest.
    pub fn nearest(&self, p: Point, reach: f64) -> Nearest {
        let most = reach * (1.0 + 1e-9);
        let mut least = Least(most * most * (1.0 + 1e-9));
        self.descend(p, &mut least);
        let distance = least.0.sqrt();
        let near = if distance <= most { self.within(p, distance * (1.0 + 1e-9)) } else { Vec::new() };
        let mut points: Vec<usize> = near.into_iter().map(|(_, point)| point).collect();
        points.sort_unstable();
        Nearest { distance: if points.is_empty() { f64::INFINITY } else { distance }, points }
    }

    /// Shows points to a search, near parts first, but those of no part that is too far.
    fn descend(&self, p: Point, search: &mut impl Search) {
        // Of every pair of halves one waits here.
        let mut waiting = vec![0];
        while let Some(row) = waiting.pop() {
            let Some(part) = self.parts.get(row).filter(|part| part.nearest(p) <= search.most()) else { continue };
            if part.after as usize == row + 1 {
                self.measured(part, p).for_each(|(d2, number)| search.see(d2, number));
                continue;
            }
            let halves = [row + 1, self.parts[row + 1].after as usize];
            let [first, second] = halves.map(|half| self.parts[half].nearest(p));
            waiting.extend(if first <= second { [halves[1], halves[0]] } else { halves });
        }
    }
}

/// Halves points across the widest side of their box until they are few or at one place.
fn divide(points: &[Point], numbers: &mut [u32], first: u32, parts: &mut Vec<Part>) {
    let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for point in numbers.iter().map(|number| points[*number as usize]) {
        low = [0, 1, 2].map(|axis| low[axis].min(point[axis]));
        high = [0, 1, 2].map(|axis| high[axis].max(point[axis]));
    }
    let row = parts.len();
    let [x, y, z] = sub(high, low);
    let (widest, side) = if x >= y && x >= z { (0, x) } else { [(1, y), (2, z)][usize::from(z > y)] };
    parts.push(Part { low, high, points: first..first + numbers.len() as u32, after: 0 });
    if numbers.len() > LEAF && side > 0.0 {
        let middle = numbers.len() / 2;
        let along = |number: &u32| points[*number as usize][widest];
        numbers.select_nth_unstable_by(middle, |a, b| along(a).total_cmp(&along(b)));
        let (lower, upper) = numbers.split_at_mut(middle);
        divide(points, lower, first, parts);
        divide(points, upper, first + middle as u32, parts);
    }
    parts[row].after = parts.len() as u32;
}

fn distances(hits: Vec<(f64, usize)>) -> Vec<(f64, usize)> {
    hits.into_iter().map(|(d2, number)| (d2.sqrt(), number)).collect()
}

/// What a search has found so far.
trait Search {
    /// Only points within this squared distance matter.
    fn most(&self) -> f64;
    fn see(&mut self, squared: f64, number: usize);
}

/// The least squared distance.
struct Least(f64);

impl Search for Least {
    fn most(&self) -> f64 {
        self.0
    }

    fn see(&mut self, squared: f64, _: usize) {
        self.0 = self.0.min(squared);
    }
}

/// The first points by distance and number.
struct First {
    count: usize,
    hits: BinaryHeap<Hit>,
}

impl Search for First {
    fn most(&self) -> f64 {
        let last = self.hits.peek().filter(|_| self.hits.len() == self.count);
        last.map_or(f64::INFINITY, |Hit(d2, _)| *d2)
    }

    fn see(&mut self, squared: f64, number: usize) {
        self.hits.push(Hit(squared, number));
        if self.hits.len() > self.count {
            self.hits.pop();
        }
    }
}

/// A squared distance and a number, in that order.
#[derive(PartialEq)]
struct Hit(f64, usize);

impl Eq for Hit {}

impl Ord for Hit {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0).then(self.1.cmp(&other.1))
    }
}

impl PartialOrd for Hit {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
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
    let near: Vec<Vec<usize>> = in_order(&ends, |_, end| {
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
