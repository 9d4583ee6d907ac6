//! The bridges that may be: from every free end to the branches and free ends around it.

use super::extraction::Extraction;
use super::frame::Frame;
use super::roads::Reached;
use super::steady::steady;
use crate::geometry::{Point, distance, dot, sub};

/// Reach in spacings and in radii of the end: independent of any unit.
const REACH_SPACINGS: f64 = 20.0;
const REACH_RADII: f64 = 10.0;
/// A branch is met where d (1.3 - cos) is least: d the distance, cos that of the bend.
const BEND: f64 = 1.3;
/// A meeting point so many spacings from a free end of its branch is moved there.
const SNAP_SPACINGS: f64 = 3.0;
/// A vessel that runs along its parent joins it further on: so many spacings from the nearest point, give or take.
const AHEAD_SPACINGS: f64 = 3.5;
const AHEAD_SLACK: f64 = 0.8;
/// Meeting points on one fragment are so many spacings apart, or a radius there where that is more.
const APART_SPACINGS: f64 = 2.0;
/// A bridge within a fragment saves at least so much: path over gap, and path over width of the end.
const DETOUR: f64 = 4.0;
const DETOUR_WIDTHS: f64 = 6.0;
/// A bridge within a fragment leaves ahead: least cos of its bend.
const LOOP_COS: f64 = 0.3;

/// How far the search goes.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// Nearest branches, and nearest free ends, of other fragments for each free end.
    pub branches: usize,
    /// Of these, the branches that are also met further ahead.
    pub ahead: usize,
    /// Branches of the own fragment for each free end.
    pub own_branches: usize,
}

impl Default for Search {
    fn default() -> Self {
        Self { branches: 4, ahead: 2, own_branches: 2 }
    }
}

/// A bridge that may be, from a free end to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Bridge {
    /// The free end it leaves, a row of [`Extraction::ends`].
    pub end: usize,
    /// The point it reaches.
    pub point: usize,
    /// Whether both are in one fragment, so that it closes a loop.
    pub inside: bool,
}

/// A point within reach of a free end, with what the search compares.
#[derive(Debug, Clone, Copy)]
struct Hit {
    point: usize,
    /// Distance, m.
    distance: f64,
    /// [`steady`] distance in spacings, then smoothed radius in spacings: the order of hits, whatever their numbers.
    order: [f64; 2],
    /// Cosine of the bend from the end's direction.
    cos: f64,
}

/// The bridges of an extraction, by free end, other fragments first.
///
/// From each free end to the nearest branches and the nearest free ends of other fragments within 20 spacings + 5 diameters,
/// and to branches of its own fragment that are ahead and much further along the vessels. A branch is met at its nearest
/// point, where d (1.3 - cos) is least, and some spacings ahead of its nearest point; near a free end it is met there. What
/// is chosen depends on neither unit, rotation nor the numbers of points; only exact ties in distance and radius go by number.
pub fn search(extraction: &Extraction, params: &Search) -> Vec<Bridge> {
    let mut reached = extraction.roads.room();
    let mut bridges = Vec::new();
    for (row, end) in extraction.ends.iter().enumerate() {
        let around = Around::new(extraction, end);
        for inside in [false, true] {
            let targets = if inside { around.own_branches(params, &mut reached) } else { around.other_fragments(params) };
            bridges.extend(targets.into_iter().map(|point| Bridge { end: row, point, inside }));
        }
    }
    bridges
}

/// What lies within reach of a free end.
struct Around<'a> {
    extraction: &'a Extraction,
    end: &'a Frame,
    reach: f64,
    /// In order.
    hits: Vec<Hit>,
}

/// A place to meet, with the rank of the rule that found it.
type Pick = (u8, usize);

impl<'a> Around<'a> {
    fn new(extraction: &'a Extraction, end: &'a Frame) -> Self {
        let position = extraction.position[end.point];
        let reach = REACH_SPACINGS * extraction.spacing + REACH_RADII * end.radius;
        let hit = |(distance, point): (f64, usize)| Hit {
            point,
            distance,
            order: [distance, extraction.smooth.radius[point]].map(|x| steady(x / extraction.spacing)),
            cos: cosine(sub(extraction.position[point], position), end.direction, distance),
        };
        let mut hits: Vec<Hit> = extraction.index.within(position, reach).into_iter().map(hit).collect();
        hits.sort_by(|a, b| compare(&a.order, &b.order).then(a.point.cmp(&b.point)));
        Self { extraction, end, reach, hits }
    }

    fn other_fragments(&self, params: &Search) -> Vec<usize> {
        let other = |h: &&Hit| self.extraction.fragment[h.point] != self.end.fragment;
        let mut picks = self.meetings(&self.nearest_branches(params.branches, other), params.ahead);
        let free = self.hits.iter().filter(other).filter(|h| self.extraction.end_at[h.point].is_some());
        picks.extend(free.take(params.branches).map(|h| (0, h.point)));
        self.apart(picks)
    }

    fn own_branches(&self, params: &Search, reached: &mut Reached) -> Vec<usize> {
        let (roads, own) = (&self.extraction.roads, self.end.fragment);
        let width = 2.0 * self.end.radius + self.extraction.spacing;
        let most = (DETOUR * self.reach).max(DETOUR_WIDTHS * width);
        roads.reach(&[self.end.point], most, reached);
        let saves = |h: &&Hit| {
            self.extraction.fragment[h.point] == own
                && steady(h.cos) > LOOP_COS
                && steady(roads.to_point(reached, h.point)) > steady((DETOUR * h.distance).max(DETOUR_WIDTHS * width))
        };
        let picks = self.meetings(&self.nearest_branches(params.own_branches, saves), params.ahead);
        self.apart(picks)
    }

    /// The nearest branches, each with its hits, in order.
    fn nearest_branches(&self, count: usize, wanted: impl Fn(&&Hit) -> bool) -> Vec<Vec<Hit>> {
        let mut order: Vec<usize> = Vec::new();
        let mut hits: Vec<Vec<Hit>> = Vec::new();
        for hit in self.hits.iter().filter(wanted) {
            let branch = self.extraction.branch[hit.point];
            match order.iter().position(|b| *b == branch) {
                Some(at) => hits[at].push(*hit),
                None if order.len() < count => {
                    order.push(branch);
                    hits.push(vec![*hit]);
                }
                None => {}
            }
        }
        hits
    }

    /// Where branches are met: first where distance and bend are least, then at the nearest points, then ahead of these.
    fn meetings(&self, branches: &[Vec<Hit>], ahead: usize) -> Vec<Pick> {
        let spacing = self.extraction.spacing;
        let mut picks = Vec::new();
        for (rank, hits) in branches.iter().enumerate() {
            let cost = |h: &Hit| [steady(h.distance / spacing * (BEND - h.cos)), h.order[0], h.order[1]];
            let bent = hits.iter().min_by(|a, b| compare(&cost(a), &cost(b)));
            picks.extend(bent.map(|h| (0, self.snapped(h.point))));
            picks.push((1, self.snapped(hits[0].point)));
            if rank < ahead {
                let nearest = self.extraction.position[hits[0].point];
                let off = |h: &&Hit| {
                    let off = steady(distance(self.extraction.position[h.point], nearest) / spacing);
                    (off - AHEAD_SPACINGS).abs() < AHEAD_SLACK
                };
                let bend = |h: &Hit| [steady(BEND - h.cos), h.order[0], h.order[1]];
                let on = hits.iter().filter(off).min_by(|a, b| compare(&bend(a), &bend(b)));
                picks.extend(on.map(|h| (2, self.snapped(h.point))));
            }
        }
        picks
    }

    /// The nearest free end of a point's branch where that is near, else the point.
    fn snapped(&self, point: usize) -> usize {
        let e = self.extraction;
        let line = &e.lines[e.branch[point]];
        let away = |end: usize| steady(distance(e.position[end], e.position[point]) / e.spacing);
        let order = |end: usize| [away(end), steady(e.smooth.radius[end] / e.spacing)];
        let free = [line[0], line[line.len() - 1]].into_iter().filter(|p| e.end_at[*p].is_some());
        let near = free.filter(|end| away(*end) <= SNAP_SPACINGS);
        near.min_by(|a, b| compare(&order(*a), &order(*b))).unwrap_or(point)
    }

    /// The picks by rule, without those close to an earlier one on the same fragment, which a free end replaces.
    fn apart(&self, mut picks: Vec<Pick>) -> Vec<usize> {
        let e = self.extraction;
        picks.sort_by_key(|(rule, _)| *rule);
        let mut chosen: Vec<usize> = Vec::new();
        for (_, point) in picks.into_iter().filter(|(_, point)| *point != self.end.point) {
            let gap = steady((APART_SPACINGS * e.spacing).max(e.smooth.radius[point]) / e.spacing);
            let near = |other: &usize| {
                e.fragment[*other] == e.fragment[point]
                    && steady(distance(e.position[*other], e.position[point]) / e.spacing) < gap
            };
            match chosen.iter().position(near) {
                None => chosen.push(point),
                Some(at) if e.end_at[point].is_some() && e.end_at[chosen[at]].is_none() && !chosen.contains(&point) => {
                    chosen[at] = point;
                }
                Some(_) => {}
            }
        }
        chosen
    }
}

/// The cosine between a displacement of a length and a unit vector; zero without a length.
fn cosine(displacement: Point, direction: Point, length: f64) -> f64 {
    if length > 0.0 { dot(displacement, direction) / length } else { 0.0 }
}

/// Lexicographic order.
fn compare(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
}
