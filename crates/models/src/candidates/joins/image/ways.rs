//! Ways through an image: the cheapest path between two places, and the vessels met first from each free end, wherever they lead.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

use crate::candidates::features::Extraction;
use crate::candidates::search::{EndCandidate, least_detour, snapped};
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, cross, distance, lerp, norm, smooth, sub, unit};
use willis_io::masks::Scene;

/// Paths go through places on cross-sections of the line: cross-sections and places on them lie about so many spacings apart.
const PATH_STEP: f64 = 0.7;
/// A path stays so near to the line: a share of the gap, at least and at most so many spacings.
const WIDTH: f64 = 0.35;
const WIDTH_SPACINGS: [f64; 2] = [2.0, 4.0];
/// Added to the contrast in the denominator of the cost.
const FLOOR: f64 = 0.08;
/// There are no more cross-sections than this.
const MOST_SECTIONS: f64 = 400.0;

/// The cheapest path between two places.
pub struct CheapestPath {
    /// Its points, m, from end to end.
    pub points: Vec<Point>,
    /// Its cost in spacings: its length where the image shows nothing, less than a hundredth of that along a vessel of full contrast.
    pub cost: f64,
}

/// The cheapest path between two ends (m), among those that go forward along the straight line between them; `None` where the image is not known.
/// No vessel counts as another one so near (`own`, m) to each end; `level` is the brightness of background and the contrast of a vessel to it; `h`
/// is the distance between points of the extraction, m.
///
/// The cost of a step is its length times (f/(c + f))², where c is the contrast as a share of that of the vessels, from 0 to 1, and f
/// is 0.08. Inside other vessels c is 0. From one cross-section of the line to the next a path moves by one place along each of two
/// directions at most; among all such paths the cheapest is found, by the Viterbi algorithm.
pub fn cheapest_path(scene: &Scene, [a, b]: [Point; 2], own: [f64; 2], level: [f64; 2], h: f64) -> Option<CheapestPath> {
    let [background, contrast] = level;
    let gap = distance(a, b);
    let sections = (gap / (PATH_STEP * h)).round().clamp(2.0, MOST_SECTIONS);
    let (ahead, step) = (gap / sections, PATH_STEP * h);
    let sections = sections as usize;
    let reach = ((WIDTH * gap).clamp(WIDTH_SPACINGS[0] * h, WIDTH_SPACINGS[1] * h) / step).round() as usize;
    let side = 2 * reach + 1;
    let [e1, e2] = across(unit(sub(b, a)));
    let offset = |at: usize| [at % side, at / side].map(|offset| step * (offset as f64 - reach as f64));
    let place = |section: usize, at: usize| -> Point {
        let (along, [u, v]) = (lerp(a, b, section as f64 / sections as f64), offset(at));
        [0, 1, 2].map(|k| along[k] + u * e1[k] + v * e2[k])
    };
    // The same in indices of the image, which are linear too: one step along the line and along both directions.
    let origin = scene.index(a);
    let to = |p: Point, by: f64| -> [f64; 3] {
        let there = scene.index([0, 1, 2].map(|k| a[k] + by * p[k]));
        [0, 1, 2].map(|axis| there[axis] - origin[axis])
    };
    let (forward, right, up) = (to(sub(b, a), 1.0 / sections as f64), to(e1, step), to(e2, step));
    let price = |section: usize, u: usize, v: usize| -> f32 {
        let (s, u, v) = (section as f64, u as f64 - reach as f64, v as f64 - reach as f64);
        let index = [0, 1, 2].map(|axis| origin[axis] + s * forward[axis] + u * right[axis] + v * up[axis]);
        let Some(x) = scene.brightness_at(index) else { return f32::INFINITY };
        let c = ((x - background) / contrast).clamp(0.0, 1.0);
        let squared = step * step * (u * u + v * v);
        let away = |along: f64, own: f64| along * along + squared > own * own;
        let is_other = || away(s * ahead, own[0]) && away(gap - s * ahead, own[1]);
        let c = if c > 0.0 && scene.is_inside_at(index) && is_other() { 0.0 } else { c };
        price(c)
    };
    // Sections have a rim of places that no path goes through.
    let (wide, rim) = (side + 2, side + 3);
    let row = |u: usize, v: usize| v * wide + u + rim;
    let size = wide * wide;
    let by = |n: isize| {
        let (du, dv) = (n % 3 - 1, n / 3 - 1);
        let length = ahead.hypot(step * (du as f64).hypot(dv as f64));
        (dv * wide as isize + du, (0.5 * length / h) as f32)
    };
    let moves: Vec<(isize, f32)> = (0..9).map(by).collect();
    let middle = row(reach, reach);
    // Per place of a section the least cost so far, the price there, and by which move it was reached.
    let mut least = vec![f32::INFINITY; size];
    let mut here = vec![0.0_f32; size];
    (least[middle], here[middle]) = (0.0, price(0, reach, reach));
    let mut from = vec![u8::MAX; (sections + 1) * size];
    let (mut next_least, mut next_here) = (vec![f32::INFINITY; size], vec![0.0_f32; size]);
    for section in 1..=sections {
        next_least.fill(f32::INFINITY);
        // No further out than moves lead from the one end and to the other.
        let reached = section.min(sections - section).min(reach);
        for v in reach - reached..=reach + reached {
            for u in reach - reached..=reach + reached {
                let at = row(u, v);
                let own_price = price(section, u, v);
                let (mut best, mut by) = (f32::INFINITY, u8::MAX);
                for (way, (move_by, half)) in (0_u8..).zip(&moves) {
                    let before = (at as isize + move_by) as usize;
                    let sum = least[before] + half * (here[before] + own_price);
                    if sum < best {
                        (best, by) = (sum, way);
                    }
                }
                (next_least[at], next_here[at], from[section * size + at]) = (best, own_price, by);
            }
        }
        std::mem::swap(&mut least, &mut next_least);
        std::mem::swap(&mut here, &mut next_here);
    }
    if least[middle].is_infinite() {
        return None;
    }
    let (mut points, mut at) = (vec![b], middle);
    for section in (1..=sections).rev() {
        at = at.checked_add_signed(moves[usize::from(from[section * size + at])].0)?;
        let inner = at - rim;
        points.push(place(section - 1, inner / wide * side + inner % wide));
    }
    points.reverse();
    Some(CheapestPath { points: smooth(&points, 2), cost: f64::from(least[middle]) })
}

/// The cost of a step as a share of its length, by the contrast as a share of that of the vessels.
fn price(contrast: f64) -> f32 {
    let share = (FLOOR / (contrast + FLOOR)) as f32;
    share * share
}

/// Two directions across a unit vector.
pub(super) fn across(d: Point) -> [Point; 2] {
    let other = if d[0].abs() < 0.9 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let e1 = unit(cross(d, other));
    [e1, cross(d, e1)]
}

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
    /// The cost of the way there, as [`CheapestPath::cost`].
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
        let met = willis_core::support::in_order(&parts, |_, part| {
            let mut front = Front::new(e.spacing);
            let from = |end: &usize| if e.at_border[e.ends[*end].point] { Vec::new() } else { front.met(scene, e, *end) };
            part.iter().map(from).collect::<Vec<Vec<Met>>>()
        });
        Self { met: met.concat() }
    }

    /// The candidates that are not among those found before, and their ways, by free end.
    pub fn candidates(&self, e: &Extraction, found: &[EndCandidate]) -> Vec<(EndCandidate, &[Point])> {
        // What a candidate is to its free end, and to that which it reaches.
        let both = |end: usize, point: usize| {
            let back = e.end_at[point].map(|other| (other, e.ends[end].point));
            std::iter::once((end, point)).chain(back)
        };
        let mut known = willis_core::support::numbered::grouped(e.ends.len(), found.iter().flat_map(|c| both(c.end, c.point)));
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
                for (end, point) in both(row, met.point) {
                    known[end].push(point);
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

    fn met(&mut self, scene: &Scene, e: &Extraction, row: usize) -> Vec<Met> {
        for at in self.touched.drain(..) {
            (self.cost[at], self.price[at]) = (f32::INFINITY, -1.0);
        }
        self.open.clear();
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
