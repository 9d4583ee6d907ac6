//! The search for candidates: where a free end may be joined to a branch or to another free end.

pub mod point_index;

pub use point_index::{PointIndex, join_nearest};

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

use serde::{Deserialize, Serialize};

use super::features::{Extraction, FreeEnd};
use willis_core::error::{Error, Result, require};
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, distance, dot, sub, unit};
use willis_core::support::in_order;
use willis_core::support::numbered::grouped;
use willis_core::support::ties::{compare, steady};

/// A meeting point so many spacings from a free end of its branch is moved there.
const SNAP_SPACINGS: f64 = 3.0;
/// A vessel that runs along its parent joins it further on: about so many spacings from the nearest point.
const BESIDE_SPACINGS: f64 = 3.5;
const BESIDE_SLACK: f64 = 0.8;
/// What is on the other side of the nearest point is further from the point ahead than so many spacings.
const OPPOSITE_SPACINGS: f64 = 4.0;
/// A kink is looked for up to so many spacings from the nearest point, and is no straighter than this.
const KINK_SPACINGS: f64 = 8.0;
const LEAST_KINK: f64 = 0.15;

/// Meeting points on one fragment are so many spacings from one another, or a radius there where that is more.
const SEPARATION_SPACINGS: f64 = 2.0;
/// A candidate within a fragment saves at least so much: path over gap, and path over width of the end.
const DETOUR: f64 = 4.0;
const DETOUR_WIDTHS: f64 = 6.0;
/// A candidate within a fragment leaves ahead: least cos of its bend.
const LOOP_COS: f64 = 0.3;

/// Points that may be looked at around all free ends together, some ten seconds of work.
const MOST_POINTS: usize = 300_000_000;

/// Free ends that are searched by one thread with one memory for path lengths.
const TOGETHER: usize = 256;

/// How far the search goes.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchOptions {
    /// Nearest branches of other fragments for each free end.
    pub branches: usize,
    /// Nearest free ends of other fragments for each free end.
    pub free_ends: usize,
    /// Branches of the own fragment for each free end.
    pub own_branches: usize,
    /// Of the nearest branches, how many are met elsewhere than at their nearest point and where d (1.3 - cos) is least: also 3.5 spacings from
    /// the nearest point, on the side ahead, ...
    pub ahead: usize,
    /// ... on the side opposite to that, ...
    pub behind: usize,
    /// ... and where they turn away from the end most: a vessel turns away from a branch it gives off.
    pub kinks: usize,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { branches: 5, free_ends: 4, own_branches: 2, ahead: 3, behind: 3, kinks: 3 }
    }
}

/// Where a candidate may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Attach {
    /// On the centerline of any vessel, split there, or on a free end.
    #[default]
    Centerline,
    /// On free ends only.
    Ends,
}

/// How a candidate's radius comes from the radii at its two ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateRadius {
    /// The smaller one.
    #[default]
    Min,
    /// Their mean.
    Mean,
}

/// How candidates are built.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CandidateOptions {
    /// How many of the nearest branches and free ends each free end is joined to, at least 1; by default 6, and with evidence 5 branches and
    /// four free ends beside them.
    pub k: Option<usize>,
    /// The longest candidate, m, positive; without it 20 point spacings + 5 end diameters limit the reach, twice as far straight ahead of an end on
    /// masks and skeletons.
    #[serde(rename = "max_gap_m")]
    pub max_gap: Option<f64>,
    /// Where a candidate may end.
    pub attach: Attach,
    /// How a candidate's radius comes from those at its ends.
    #[serde(rename = "candidate_radius")]
    pub radius: CandidateRadius,
    /// The largest radius of a candidate, m, positive.
    #[serde(rename = "max_candidate_radius_m")]
    pub max_radius: Option<f64>,
    /// The radius rule of the observed vessels, for the parts of a vessel that is split.
    pub radius_rule: willis_core::network::RadiusRule,
}

/// [`CandidateOptions::k`] without evidence, where none is given.
pub const NEAREST: usize = 6;

impl CandidateOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        require(self.k != Some(0), "k", 0, "expected at least 1")?;
        for (name, value) in [("max_gap", self.max_gap), ("max_candidate_radius", self.max_radius)] {
            if let Some(m) = value.filter(|m| !m.is_finite() || *m <= 0.0) {
                return Err(Error::parameter(name, willis_core::network::units::millimetres(m), "expected a positive length"));
            }
        }
        Ok(())
    }

    /// How far the search with evidence goes.
    pub fn search(&self) -> SearchOptions {
        let usual = SearchOptions::default();
        SearchOptions { branches: self.k.unwrap_or(usual.branches), ..usual }
    }

    /// Whether a candidate is no longer than the options allow, and ends where it may.
    pub fn allows(&self, candidate: &EndCandidate, e: &Extraction) -> bool {
        let may_end = self.attach == Attach::Centerline || e.end_at[candidate.point].is_some();
        may_end && self.max_gap.is_none_or(|most| steady(candidate.gap(e)) <= steady(most))
    }
}

/// A connection that may exist, from a free end to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EndCandidate {
    /// The free end it leaves, a row of [`Extraction::ends`].
    pub end: usize,
    /// The point it reaches.
    pub point: usize,
    /// Whether both are in one fragment, so that it closes a loop.
    pub within: bool,
}

impl EndCandidate {
    /// Its two points, that of its free end first.
    pub fn points(self, e: &Extraction) -> [usize; 2] {
        [e.ends[self.end].point, self.point]
    }

    /// Their fragments: the child and the parent.
    pub fn fragments(self, e: &Extraction) -> [usize; 2] {
        self.points(e).map(|point| e.fragment[point])
    }

    /// The distance between them, m.
    pub fn gap(self, e: &Extraction) -> f64 {
        let [from, to] = self.points(e).map(|point| e.position[point]);
        distance(from, to)
    }
}

/// The candidates of an extraction, by free end, other fragments first.
///
/// From each free end to the nearest branches and the nearest free ends of other fragments within 20 spacings + 5 diameters,
/// and to branches of its own fragment that are ahead and much further along the vessels. The choice depends on neither unit,
/// rotation nor the numbers of points; only ties in distance, bend and radius go by number.
///
/// # Errors
///
/// Points that are crowded: far more of them within reach of free ends than vessels have.
pub fn search(extraction: &Extraction, options: &SearchOptions) -> Result<Vec<EndCandidate>> {
    let radius = |end: &FreeEnd| end.radius;
    from_each_end(extraction, radius, f64::INFINITY, |around, paths| {
        let mut points = around.other_fragments(options);
        points.extend(around.own_branches(options, paths));
        points
    })
}

/// The candidates without evidence: from each free end to the k nearest branches and free ends of any fragment within 20 spacings +
/// 5 diameters and `max_gap`, nearest first, ties in the order of the points. A branch is as near as its nearest point, and is met
/// where d (1.3 - cos) is least, or at its free end near there.
///
/// # Errors
///
/// Points that are crowded: far more of them within reach of free ends than vessels have.
pub fn search_nearest(extraction: &Extraction, options: &CandidateOptions) -> Result<Vec<EndCandidate>> {
    let most = options.max_gap.unwrap_or(f64::INFINITY);
    from_each_end(extraction, |end| end.mean_radius, most, |around, _| around.nearest(options))
}

/// Per free end the rows of its candidates.
pub fn rows_by_end(e: &Extraction, candidates: &[EndCandidate]) -> Vec<Vec<usize>> {
    grouped(e.ends.len(), candidates.iter().enumerate().map(|(row, candidate)| (candidate.end, row)))
}

/// How long (m) the path along the vessels is at least, for a candidate within a fragment that bridges this gap (m).
pub fn least_detour(extraction: &Extraction, end: &FreeEnd, gap: f64) -> f64 {
    (DETOUR * gap).max(DETOUR_WIDTHS * (2.0 * end.radius + extraction.spacing))
}

/// The candidates to the points that `choose` gives for what lies within the reach of a free end, which its radius gives, at most so much (m).
fn from_each_end(
    extraction: &Extraction,
    radius: impl Fn(&FreeEnd) -> f64 + Sync,
    most: f64,
    choose: impl Fn(&Neighbourhood<'_>, &mut ShortestPaths) -> Vec<usize> + Sync,
) -> Result<Vec<EndCandidate>> {
    let reach = |end: &FreeEnd| (REACH_SPACINGS * extraction.spacing + REACH_RADII * radius(end)).min(most);
    let inner = extraction.ends.iter().filter(|end| !extraction.at_border[end.point]);
    let places: Vec<(Point, f64)> = inner.map(|end| (extraction.position[end.point], reach(end))).collect();
    let spent = AtomicUsize::new(0);
    let is_spent = || spent.load(Ordering::Relaxed) > MOST_POINTS;
    let check = || {
        if !is_spent() {
            return Ok(());
        }
        let each = MOST_POINTS / places.len().max(1);
        let given = format!("{}, with more than {MOST_POINTS} points within their reach, or {each} each", places.len());
        Err(Error::parameter("free ends", given, "candidates need vessels further apart than the points along them"))
    };
    // Where they may be too many, they are counted before any is looked at.
    if places.len().saturating_mul(extraction.position.len()) > MOST_POINTS {
        in_order(&places, |_, (place, reach)| {
            if !is_spent() {
                spent.fetch_add(extraction.index.count(*place, *reach), Ordering::Relaxed);
            }
        });
        check()?;
    }
    let parts: Vec<&[FreeEnd]> = extraction.ends.chunks(TOGETHER).collect();
    let found = in_order(&parts, |part, ends| {
        let mut paths = ShortestPaths::new(extraction.graph.nodes());
        let mut candidates = Vec::new();
        for (row, end) in (part * TOGETHER..).zip(*ends) {
            if is_spent() {
                break;
            }
            if extraction.at_border[end.point] {
                continue;
            }
            let mut points = choose(&Neighbourhood::new(extraction, end, reach(end)), &mut paths);
            points.retain(|point| !extraction.at_border[*point]);
            let within = |point: usize| extraction.fragment[point] == end.fragment;
            candidates.extend(points.into_iter().map(|point| EndCandidate { end: row, point, within: within(point) }));
            spent.fetch_add(paths.count(), Ordering::Relaxed);
        }
        candidates
    });
    check()?;
    Ok(found.concat())
}

/// The candidates of one search as pairs of points, both directions together.
#[derive(Debug, Clone, PartialEq)]
pub struct Pairs {
    /// Per candidate its pair.
    pub of: Vec<usize>,
    /// Per pair its points, the lower first.
    pub points: Vec<[usize; 2]>,
    /// Per pair its first candidate.
    pub first: Vec<usize>,
}

impl Pairs {
    /// The pairs, in the order of their first candidates.
    pub fn new(e: &Extraction, candidates: &[EndCandidate]) -> Self {
        let mut number = BTreeMap::new();
        let mut this = Self { of: Vec::with_capacity(candidates.len()), points: Vec::new(), first: Vec::new() };
        for (row, c) in candidates.iter().enumerate() {
            let points = unordered(c.points(e));
            let pair = *number.entry(points).or_insert_with(|| {
                this.points.push(points);
                this.first.push(row);
                this.points.len() - 1
            });
            this.of.push(pair);
        }
        this
    }

    /// The pairs by the two fragments that they join, the lower first.
    pub fn by_fragments(&self, e: &Extraction) -> BTreeMap<[usize; 2], Vec<usize>> {
        let mut found: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        for (pair, points) in self.points.iter().enumerate() {
            found.entry(unordered(points.map(|point| e.fragment[point]))).or_default().push(pair);
        }
        found
    }

    /// Per pair the sum of a quantity over its candidates.
    pub fn sum(&self, of_candidate: &[f64]) -> Vec<f64> {
        let mut sum = vec![0.0; self.points.len()];
        for (pair, x) in self.of.iter().zip(of_candidate) {
            sum[*pair] += x;
        }
        sum
    }

    /// Per pair the mean of a quantity over its candidates.
    pub fn mean(&self, of_candidate: &[f64]) -> Vec<f64> {
        let count = self.sum(&vec![1.0; self.of.len()]);
        self.sum(of_candidate).iter().zip(count).map(|(sum, n)| sum / n).collect()
    }
}

/// Two numbers, the lower first.
pub fn unordered([a, b]: [usize; 2]) -> [usize; 2] {
    [a.min(b), a.max(b)]
}

/// Reach in point spacings and in end radii: independent of any unit.
const REACH_SPACINGS: f64 = 20.0;
const REACH_RADII: f64 = 10.0;
/// So many of the nearest points are sorted first, and so many times as many when those are not enough.
const FIRST: usize = 1024;
const MORE: usize = 8;

/// A branch is met where d (1.3 - cos) is least: d the distance, cos that of the bend.
const BEND: f64 = 1.3;

/// A point within reach of a free end, with what the search compares.
#[derive(Debug, Clone, Copy)]
struct Hit {
    /// The point.
    point: usize,
    /// Distance, m.
    distance: f64,
    /// [`steady`] distance in spacings, BEND - cos, smoothed radius in spacings: the order of hits, whatever their numbers.
    order: [f64; 3],
    /// Cosine of the bend from the end's direction.
    cos: f64,
}

/// What lies within reach of a free end.
struct Neighbourhood<'a> {
    extraction: &'a Extraction,
    end: &'a FreeEnd,
    reach: f64,
    /// Distance (m) and number of the points of its own fragment, in no order.
    own: Vec<(f64, usize)>,
    /// The same of other fragments.
    others: Vec<(f64, usize)>,
}

fn sorted(hits: impl Iterator<Item = Hit>) -> Vec<Hit> {
    let mut hits: Vec<Hit> = hits.collect();
    hits.sort_unstable_by(|a, b| compare(&a.order, &b.order).then(a.point.cmp(&b.point)));
    hits
}

impl<'a> Neighbourhood<'a> {
    fn new(extraction: &'a Extraction, end: &'a FreeEnd, reach: f64) -> Self {
        let near = extraction.index.around(extraction.position[end.point], reach).into_iter();
        let (own, others) = near.partition(|(_, point)| extraction.fragment[*point] == end.fragment);
        Self { extraction, end, reach, own, others }
    }

    /// The points of other fragments, in order, those at least that are on the nearest `branches` or are the nearest `free_ends`.
    fn others(&self, branches: usize, free_ends: usize) -> Vec<Hit> {
        let e = self.extraction;
        let mut near = self.others.clone();
        let mut first = FIRST;
        while first < near.len() {
            let (_, (distance, _), _) = near.select_nth_unstable_by(first, |a, b| a.0.total_cmp(&b.0));
            let bound = steady(*distance / e.spacing);
            // All that are nearer than the bound are among the first, which makes them the first in order too.
            let hits = sorted(near[..first].iter().map(|near| self.hit(*near)).filter(|hit| hit.order[0] < bound));
            let found: Vec<usize> = self.by_branch(branches, &hits).iter().map(|hits| e.branch[hits[0].point]).collect();
            let is_free = |hit: &&Hit| e.end_at[hit.point].is_some();
            if found.len() == branches && hits.iter().filter(is_free).count() >= free_ends {
                let on_them = |point: usize| found.contains(&e.branch[point]);
                let free = hits.iter().filter(is_free).filter(|hit| !on_them(hit.point)).copied();
                return sorted(near.iter().filter(|(_, point)| on_them(*point)).map(|near| self.hit(*near)).chain(free));
            }
            first *= MORE;
        }
        sorted(near.into_iter().map(|near| self.hit(near)))
    }

    fn hit(&self, (distance, point): (f64, usize)) -> Hit {
        let e = self.extraction;
        let along = dot(sub(e.position[point], e.position[self.end.point]), self.end.direction);
        let cos = if distance > 0.0 { along / distance } else { 0.0 };
        let [away, radius] = [distance, e.smooth.radius[point]].map(|x| steady(x / e.spacing));
        Hit { point, distance, order: [away, steady(BEND - cos), radius], cos }
    }

    fn other_fragments(&self, options: &SearchOptions) -> Vec<usize> {
        let hits = self.others(options.branches, options.free_ends);
        let branches = self.by_branch(options.branches, &hits);
        let mut picks = self.meeting_points(options, &branches);
        let free = hits.iter().filter(|h| self.extraction.end_at[h.point].is_some());
        picks.extend(free.take(options.free_ends).map(|h| (0, h.point)));
        self.separated(picks)
    }

    fn own_branches(&self, options: &SearchOptions, paths: &mut ShortestPaths) -> Vec<usize> {
        let graph = &self.extraction.graph;
        let most = least_detour(self.extraction, self.end, self.reach);
        graph.search(&[self.end.point], most, paths, |_, _| true);
        let wanted = |h: &Hit| {
            let least = least_detour(self.extraction, self.end, h.distance);
            steady(h.cos) > LOOP_COS && steady(graph.to_point(paths.lengths(), h.point)) > steady(least)
        };
        let hits = sorted(self.own.iter().map(|near| self.hit(*near)).filter(wanted));
        self.separated(self.meeting_points(options, &self.by_branch(options.own_branches, &hits)))
    }

    fn nearest(&self, options: &CandidateOptions) -> Vec<usize> {
        let e = self.extraction;
        let from = e.position[self.end.point];
        let own: BTreeSet<usize> = e.lines[self.end.branch].iter().copied().collect();
        let off_branch = self.own.iter().filter(|(_, point)| !own.contains(point)).chain(&self.others);
        let hits = sorted(off_branch.map(|near| self.hit(*near)));
        let free = hits.iter().filter(|hit| e.end_at[hit.point].is_some());
        let mut places: Vec<(f64, usize)> = free.map(|hit| (hit.distance, hit.point)).collect();
        if options.attach == Attach::Centerline {
            places.extend(self.by_branch(usize::MAX, &hits).iter().map(|hits| {
                let met = least_bent(e, hits).point;
                let end = Some(snapped(e, met)).filter(|end| distance(e.position[*end], from) <= self.reach);
                (hits[0].distance, end.unwrap_or(met))
            }));
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut chosen = BTreeSet::new();
        let distinct = places.into_iter().map(|(_, point)| point).filter(|point| chosen.insert(*point));
        distinct.take(options.k.unwrap_or(NEAREST)).collect()
    }

    /// The points where branches are met, each branch given by its hits in order, with the rank of the rule that found the point.
    fn meeting_points(&self, options: &SearchOptions, branches: &[Vec<Hit>]) -> Vec<(u8, usize)> {
        let e = self.extraction;
        let mut picks = Vec::new();
        for (rank, hits) in branches.iter().enumerate() {
            let nearest = hits[0].point;
            picks.extend([(0, least_bent(e, hits).point), (1, nearest)]);
            if rank < options.ahead.max(options.behind) {
                let off = |h: &Hit| (e.spacings(h.point, nearest) - BESIDE_SPACINGS).abs();
                let beside = || hits.iter().filter(|h| off(h) < BESIDE_SLACK);
                // By bend, then by radius and distance.
                let order = |a: &&Hit, b: &&Hit| compare(&a.order[1..], &b.order[1..]);
                let ahead = beside().min_by(order);
                picks.extend(ahead.filter(|_| rank < options.ahead).map(|h| (2, h.point)));
                let is_opposite = |h: &&Hit| ahead.is_some_and(|ahead| e.spacings(ahead.point, h.point) > OPPOSITE_SPACINGS);
                let behind = beside().filter(is_opposite).min_by(order);
                picks.extend(behind.filter(|_| rank < options.behind).map(|h| (3, h.point)));
            }
            if rank < options.kinks {
                let across = |h: &Hit| unit(sub(e.position[h.point], e.position[self.end.point]));
                let kink = |h: &Hit| steady(dot(e.shape[h.point].kink, across(h)));
                let near = hits.iter().filter(|h| e.spacings(h.point, nearest) < KINK_SPACINGS && kink(h) > LEAST_KINK);
                let most = near.max_by(|g, h| kink(g).total_cmp(&kink(h)).then(compare(&h.order, &g.order)));
                picks.extend(most.map(|h| (1, h.point)));
            }
        }
        picks.into_iter().map(|(rule, point)| (rule, snapped(e, point))).collect()
    }

    /// The hits of the nearest branches, branch by branch, in order.
    fn by_branch(&self, count: usize, of: &[Hit]) -> Vec<Vec<Hit>> {
        let mut place: BTreeMap<usize, usize> = BTreeMap::new();
        let mut hits: Vec<Vec<Hit>> = Vec::new();
        for hit in of {
            let branch = self.extraction.branch[hit.point];
            if let Some(at) = place.get(&branch) {
                hits[*at].push(*hit);
            } else if hits.len() < count {
                place.insert(branch, hits.len());
                hits.push(vec![*hit]);
            }
        }
        hits
    }

    /// The picks by rule, without those close to an earlier one on the same fragment, which a free end replaces.
    fn separated(&self, mut picks: Vec<(u8, usize)>) -> Vec<usize> {
        let e = self.extraction;
        picks.sort_by_key(|(rule, _)| *rule);
        let mut chosen: Vec<usize> = Vec::new();
        for (_, point) in picks.into_iter().filter(|(_, point)| *point != self.end.point) {
            let gap = steady((SEPARATION_SPACINGS * e.spacing).max(e.smooth.radius[point]) / e.spacing);
            let near = |other: &usize| e.fragment[*other] == e.fragment[point] && e.spacings(*other, point) < gap;
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

/// The hit of a branch where d (1.3 - cos) is least.
fn least_bent(extraction: &Extraction, hits: &[Hit]) -> Hit {
    let cost = |h: &Hit| steady(h.distance / extraction.spacing * (BEND - h.cos));
    let better = |a: Hit, b: &Hit| if cost(b).total_cmp(&cost(&a)).then(compare(&b.order, &a.order)).is_lt() { *b } else { a };
    hits.iter().fold(hits[0], better)
}

/// The nearest free end of a point's branch where that is near, else the point.
pub fn snapped(extraction: &Extraction, point: usize) -> usize {
    let e = extraction;
    let line = &e.lines[e.branch[point]];
    let away = |end: usize| e.spacings(end, point);
    let order = |end: usize| [away(end), steady(e.smooth.radius[end] / e.spacing)];
    let free = [line[0], line[line.len() - 1]].into_iter().filter(|p| e.end_at[*p].is_some());
    let near = free.filter(|end| away(*end) <= SNAP_SPACINGS);
    near.min_by(|a, b| compare(&order(*a), &order(*b))).unwrap_or(point)
}
