//! The search for candidates: where a free end may be joined to a branch or to another free end.

pub(crate) mod free_ends;
pub(crate) mod limits;
pub(crate) mod meeting_points;
mod neighbourhood;
pub mod point_index;

pub use meeting_points::MeetingPoints;
pub use point_index::join_nearest;

use std::collections::{BTreeMap, BTreeSet};

use super::features::extraction::Extraction;
use super::options::{Attach, CandidateOptions, NEAREST};
use free_ends::FreeEnd;
use limits::SearchBudget;
use meeting_points::{least_bent, snapped};
use neighbourhood::{Hit, Neighbourhood, reach};
use willis_core::error::Result;
use willis_core::network::paths::ShortestPaths;
use willis_core::support::geometry::{Point, distance};
use willis_core::support::in_order;
use willis_core::support::ties::steady;

/// Meeting points on one fragment are so many spacings from one another, or a radius there where that is more.
const SEPARATION_SPACINGS: f64 = 2.0;
/// A candidate within a fragment saves at least so much: path over gap, and path over width of the end.
const DETOUR: f64 = 4.0;
const DETOUR_WIDTHS: f64 = 6.0;
/// A candidate within a fragment leaves ahead: least cos of its bend.
const LOOP_COS: f64 = 0.3;

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
    /// Where a branch is met.
    pub meeting_points: MeetingPoints,
}

impl Default for SearchOptions {
    fn default() -> Self {
        Self { branches: 5, free_ends: 4, own_branches: 2, meeting_points: MeetingPoints::default() }
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
    let reach = |end: &FreeEnd| reach(extraction.spacing, end.radius);
    from_each_end(extraction, reach, |around, paths| {
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
    let reach = |end: &FreeEnd| reach(extraction.spacing, end.mean_radius).min(options.max_gap.unwrap_or(f64::INFINITY));
    from_each_end(extraction, reach, |around, _| around.nearest(options))
}

/// Per free end the rows of its candidates.
pub fn rows_by_end(e: &Extraction, candidates: &[EndCandidate]) -> Vec<Vec<usize>> {
    let mut rows = vec![Vec::new(); e.ends.len()];
    for (row, candidate) in candidates.iter().enumerate() {
        rows[candidate.end].push(row);
    }
    rows
}

/// How long (m) the path along the vessels is at least, for a candidate within a fragment that bridges this gap (m).
pub fn least_detour(extraction: &Extraction, end: &FreeEnd, gap: f64) -> f64 {
    (DETOUR * gap).max(DETOUR_WIDTHS * (2.0 * end.radius + extraction.spacing))
}

/// The candidates to the points that `choose` gives for what lies within the reach (m) of a free end.
fn from_each_end(
    extraction: &Extraction,
    reach: impl Fn(&FreeEnd) -> f64 + Sync,
    choose: impl Fn(&Neighbourhood<'_>, &mut ShortestPaths) -> Vec<usize> + Sync,
) -> Result<Vec<EndCandidate>> {
    let inner = extraction.ends.iter().filter(|end| !extraction.at_border[end.point]);
    let places: Vec<(Point, f64)> = inner.map(|end| (extraction.position[end.point], reach(end))).collect();
    let budget = SearchBudget::new(&extraction.index, &places)?;
    let parts: Vec<&[FreeEnd]> = extraction.ends.chunks(TOGETHER).collect();
    let found = in_order(&parts, |part, ends| {
        let mut paths = ShortestPaths::new(extraction.graph.nodes());
        let mut candidates = Vec::new();
        for (row, end) in (part * TOGETHER..).zip(*ends) {
            if budget.is_spent() {
                break;
            }
            if extraction.at_border[end.point] {
                continue;
            }
            let mut points = choose(&Neighbourhood::new(extraction, end, reach(end)), &mut paths);
            points.retain(|point| !extraction.at_border[*point]);
            let within = |point: usize| extraction.fragment[point] == end.fragment;
            candidates.extend(points.into_iter().map(|point| EndCandidate { end: row, point, within: within(point) }));
            budget.spend(paths.count());
        }
        candidates
    });
    budget.check()?;
    Ok(found.concat())
}

impl Neighbourhood<'_> {
    fn other_fragments(&self, options: &SearchOptions) -> Vec<usize> {
        let hits = self.others(options.branches, options.free_ends);
        let branches = self.by_branch(options.branches, &hits);
        let mut picks = options.meeting_points.choose(self.extraction, self.end, &branches);
        let free = hits.iter().filter(|h| self.extraction.end_at[h.point].is_some());
        picks.extend(free.take(options.free_ends).map(|h| (0, h.point)));
        self.separated(picks)
    }

    fn own_branches(&self, options: &SearchOptions, paths: &mut ShortestPaths) -> Vec<usize> {
        let graph = &self.extraction.graph;
        let most = least_detour(self.extraction, self.end, self.reach);
        graph.search(&[self.end.point], most, paths, |_, _| true);
        let hits = self.own(|h| {
            let least = least_detour(self.extraction, self.end, h.distance);
            steady(h.cos) > LOOP_COS && steady(graph.to_point(paths.lengths(), h.point)) > steady(least)
        });
        let branches = self.by_branch(options.own_branches, &hits);
        self.separated(options.meeting_points.choose(self.extraction, self.end, &branches))
    }

    fn nearest(&self, options: &CandidateOptions) -> Vec<usize> {
        let e = self.extraction;
        let from = e.position[self.end.point];
        let hits = self.off_branch();
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
