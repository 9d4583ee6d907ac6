//! What the image shows ahead of each free end: the vessels met first along what looks like a vessel, wherever it leads.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use super::path::price;
use crate::candidates::features::Extraction;
use crate::candidates::search::meeting_points::snapped;
use crate::candidates::search::{EndCandidate, least_detour};
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, distance, norm, smooth};
use willis_core::support::in_order;
use willis_io::masks::Scene;

/// Places lie on a lattice so many spacings apart, so many of them to each side of the free end.
const STEP: f64 = 0.8;
const REACH: i32 = 48;
const SIDE: i32 = 2 * REACH + 1;
/// The search ends at this cost (in spacings of background), after so many places, and with so many vessels met.
pub(super) const MOST_COST: f64 = 3.0;
const MOST_PLACES: usize = 8000;
pub(super) const MOST_MET: usize = 6;
/// The contrast of a free end is at least this share of the typical one.
const LEAST_CONTRAST: f64 = 0.2;
/// The vessel whose lumen is entered has its centerline within so many times the own width.
const WIDTHS: f64 = 6.0;
/// A candidate so near (spacings) to another of the same free end is not new.
const SAME: f64 = 1.5;
/// Free ends that are searched with one memory.
const TOGETHER: usize = 32;

/// A vessel met from a free end.
#[derive(Debug, Clone)]
pub struct Met {
    /// Its point that is nearest to where it was entered, or its free end near there.
    pub point: usize,
    /// The cost of the way there, as [`super::path::CheapestPath::cost`].
    pub cost: f64,
    /// The way, m, from the free end to that point.
    pub path: Vec<Point>,
}

/// Per free end the vessels met from it, one a branch, the cheapest first. Nothing is met from ends at the border of the image.
pub struct Ahead {
    /// A list a free end.
    pub met: Vec<Vec<Met>>,
}

impl Ahead {
    /// Searches from every free end: from place to place, the cheapest first, through the image but not through another lumen.
    ///
    /// The cost of a step is that of the cheapest path between two places, with one standard deviation of the noise taken off the contrast.
    pub fn new(scene: &Scene, e: &Extraction) -> Self {
        let rows: Vec<usize> = (0..e.ends.len()).collect();
        let parts: Vec<&[usize]> = rows.chunks(TOGETHER).collect();
        let met = in_order(&parts, |_, part| {
            let mut front = Front::new(e.spacing);
            let from = |end: &usize| if e.at_border[e.ends[*end].point] { Vec::new() } else { front.met(scene, e, *end) };
            part.iter().map(from).collect::<Vec<Vec<Met>>>()
        });
        Self { met: met.concat() }
    }

    /// The candidates that are not among those found before, and their ways, by free end.
    pub fn candidates(&self, e: &Extraction, found: &[EndCandidate]) -> Vec<(EndCandidate, &[Point])> {
        let mut known: Vec<Vec<usize>> = vec![Vec::new(); e.ends.len()];
        for c in found {
            known[c.end].push(c.point);
            if let Some(other) = e.end_at[c.point] {
                known[other].push(e.ends[c.end].point);
            }
        }
        let mut paths = ShortestPaths::new(e.graph.nodes());
        let mut more = Vec::new();
        for (row, met) in self.met.iter().enumerate() {
            let end = &e.ends[row];
            for met in met.iter().filter(|met| !e.at_border[met.point]) {
                let near = |other: &usize| distance(e.position[*other], e.position[met.point]) <= SAME * e.spacing;
                let within = e.fragment[met.point] == end.fragment;
                if known[row].iter().any(near) || within && !saves(e, row, met.point, &mut paths) {
                    continue;
                }
                known[row].push(met.point);
                if let Some(other) = e.end_at[met.point] {
                    known[other].push(end.point);
                }
                more.push((EndCandidate { end: row, point: met.point, within }, met.path.as_slice()));
            }
        }
        more
    }

    /// The rank and cost with which a point, or its branch near it, was met from another point, and the least cost of the other vessels met from
    /// there; `None` where it was not.
    pub fn of(&self, e: &Extraction, [from, to]: [usize; 2]) -> Option<(usize, f64, Option<f64>)> {
        let met = &self.met[e.end_at[from]?];
        let near = (3.0 * e.spacing).max(e.smooth.radius[to]);
        let is_it = |met: &Met| e.branch[met.point] == e.branch[to] && distance(e.position[met.point], e.position[to]) <= near;
        let rank = met.iter().position(is_it)?;
        let other = met.iter().enumerate().find(|(other, _)| *other != rank).map(|(_, met)| met.cost);
        Some((rank, met[rank].cost, other))
    }
}

/// Whether a candidate within a fragment saves a detour along the vessels.
fn saves(e: &Extraction, row: usize, point: usize, paths: &mut ShortestPaths) -> bool {
    let end = &e.ends[row];
    let least = least_detour(e, end, distance(e.position[end.point], e.position[point]));
    e.graph.search(&[end.point], least, paths, |_, _| true);
    e.graph.to_point(paths.lengths(), point) > least
}

/// The places around one free end, by what it costs to reach them.
struct Front {
    spacing: f64,
    /// Per place the least cost so far, the price there (negative where not known yet), and by which move it was reached.
    cost: Vec<f32>,
    price: Vec<f32>,
    by: Vec<u8>,
    /// The places to be cleared.
    touched: Vec<usize>,
    /// The bits of a cost, which are ordered as it is, before a place.
    open: BinaryHeap<Reverse<(u32, usize)>>,
    /// Offsets, places and half their lengths in spacings.
    moves: Vec<([i32; 3], isize, f32)>,
}

fn row_of(o: [i32; 3]) -> usize {
    (((o[2] + REACH) * SIDE + o[1] + REACH) * SIDE + o[0] + REACH) as usize
}

fn offset_of(row: usize) -> [i32; 3] {
    let row = row as i32;
    [row % SIDE - REACH, row / SIDE % SIDE - REACH, row / (SIDE * SIDE) - REACH]
}

impl Front {
    fn new(spacing: f64) -> Self {
        let size = (SIDE * SIDE * SIDE) as usize;
        let offsets = (0..27).map(|n| [n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1]).filter(|o| *o != [0; 3]);
        let middle = row_of([0; 3]) as isize;
        let moves = offsets.map(|o| (o, row_of(o) as isize - middle, (0.5 * STEP * norm(o.map(f64::from))) as f32)).collect();
        let (cost, price, by) = (vec![f32::INFINITY; size], vec![-1.0; size], vec![0; size]);
        Self { spacing, cost, price, by, touched: Vec::new(), open: BinaryHeap::new(), moves }
    }

    fn clear(&mut self) {
        for at in self.touched.drain(..) {
            self.cost[at] = f32::INFINITY;
            self.price[at] = -1.0;
        }
        self.open.clear();
    }

    fn met(&mut self, scene: &Scene, e: &Extraction, row: usize) -> Vec<Met> {
        self.clear();
        let end = &e.ends[row];
        let from = e.position[end.point];
        let own = end.radius + self.spacing;
        let level = scene.level(from);
        let contrast = scene.contrast[end.point].clamp(LEAST_CONTRAST * scene.typical, scene.typical);
        let background = level.background + level.noise;
        let step = STEP * self.spacing;
        let origin = scene.index(from);
        let columns = [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step]].map(|d| {
            let there = scene.index([0, 1, 2].map(|k| from[k] + d[k]));
            [0, 1, 2].map(|k| there[k] - origin[k])
        });
        let index =
            |o: [i32; 3]| [0, 1, 2].map(|k| origin[k] + (0..3).map(|axis| f64::from(o[axis]) * columns[axis][k]).sum::<f64>());
        let place = |o: [i32; 3]| -> Point { [0, 1, 2].map(|k| from[k] + step * f64::from(o[k])) };
        let start = row_of([0; 3]);
        (self.cost[start], self.price[start]) = (0.0, 0.0);
        self.touched.push(start);
        self.open.push(Reverse((0, start)));
        let (mut met, mut branches, mut places) = (Vec::new(), BTreeSet::from([end.branch]), 0);
        while let Some(Reverse((cost, at))) = self.open.pop() {
            let cost = f32::from_bits(cost);
            if cost > self.cost[at] {
                continue;
            }
            places += 1;
            if places > MOST_PLACES {
                break;
            }
            let o = offset_of(at);
            let here = place(o);
            if distance(here, from) > own && scene.is_inside_at(index(o)) {
                // The vessel whose wall is farthest out.
                let wall = |(away, point): &(f64, usize)| away - e.smooth.radius[*point];
                let near = e.index.around(here, WIDTHS * own).into_iter();
                let vessel = near.min_by(|a, b| wall(a).total_cmp(&wall(b)).then(a.1.cmp(&b.1)));
                if let Some((_, point)) = vessel.filter(|(_, point)| branches.insert(e.branch[*point])) {
                    let point = snapped(e, point);
                    met.push(Met { point, cost: f64::from(cost), path: self.path(at, &place, [from, e.position[point]]) });
                    if met.len() == MOST_MET {
                        break;
                    }
                }
                continue;
            }
            for (way, (by, move_by, half)) in (0_u8..).zip(&self.moves) {
                let next = [o[0] + by[0], o[1] + by[1], o[2] + by[2]];
                if next.iter().any(|x| x.abs() > REACH) {
                    continue;
                }
                let to = (at as isize + move_by) as usize;
                if self.price[to] < 0.0 {
                    let seen = scene.brightness_at(index(next));
                    self.price[to] = seen.map_or(f32::INFINITY, |x| price(((x - background) / contrast).clamp(0.0, 1.0)));
                    self.touched.push(to);
                }
                let sum = cost + half * (self.price[at] + self.price[to]);
                if sum < self.cost[to] && f64::from(sum) <= MOST_COST {
                    (self.cost[to], self.by[to]) = (sum, way);
                    self.open.push(Reverse((sum.to_bits(), to)));
                }
            }
        }
        met
    }

    /// The way back from a place, turned round, from one end to the other.
    fn path(&self, mut at: usize, place: &impl Fn([i32; 3]) -> Point, [from, to]: [Point; 2]) -> Vec<Point> {
        let (mut points, start) = (vec![to], row_of([0; 3]));
        while at != start {
            points.push(place(offset_of(at)));
            at = (at as isize - self.moves[usize::from(self.by[at])].1) as usize;
        }
        points.push(from);
        points.reverse();
        smooth(&points, 2)
    }
}
