//! The bridges that may be: from every free end to the branches and free ends around it.

use super::directions::Frame;
use super::limits::Looks;
use super::meeting_points::{Hit, Meetings};
use super::neighbourhood::Around;
use crate::candidates::features::extraction::Extraction;
use crate::candidates::features::path_lengths::Reached;
use crate::candidates::features::smoothing::steady;
use crate::error::Result;
use crate::support::geometry::distance;
use crate::support::in_order;

/// Meeting points on one fragment are so many spacings apart, or a radius there where that is more.
const APART_SPACINGS: f64 = 2.0;
/// A bridge within a fragment saves at least so much: path over gap, and path over width of the end.
const DETOUR: f64 = 4.0;
const DETOUR_WIDTHS: f64 = 6.0;
/// A bridge within a fragment leaves ahead: least cos of its bend.
const LOOP_COS: f64 = 0.3;

/// Free ends that are searched by one thread with one room for path lengths.
const TOGETHER: usize = 256;

/// How far the search goes.
#[derive(Debug, Clone, PartialEq)]
pub struct Search {
    /// Nearest branches of other fragments for each free end.
    pub branches: usize,
    /// Nearest free ends of other fragments for each free end.
    pub free_ends: usize,
    /// Branches of the own fragment for each free end.
    pub own_branches: usize,
    /// Where a branch is met.
    pub meetings: Meetings,
}

impl Default for Search {
    fn default() -> Self {
        Self { branches: 5, free_ends: 4, own_branches: 2, meetings: Meetings::default() }
    }
}

/// A bridge that may be, from a free end to a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FoundBridge {
    /// The free end it leaves, a row of [`Extraction::ends`].
    pub end: usize,
    /// The point it reaches.
    pub point: usize,
    /// Whether both are in one fragment, so that it closes a loop.
    pub inside: bool,
}

/// The bridges of an extraction, by free end, other fragments first.
///
/// From each free end to the nearest branches and the nearest free ends of other fragments within 20 spacings + 5 diameters,
/// and to branches of its own fragment that are ahead and much further along the vessels. What is chosen depends on neither unit,
/// rotation nor the numbers of points; only ties in distance, bend and radius go by number.
///
/// # Errors
///
/// Points that are crowded: far more of them within reach of free ends than vessels have.
pub fn search(extraction: &Extraction, params: &Search) -> Result<Vec<FoundBridge>> {
    let looks = Looks::around(extraction.ends.len());
    let parts: Vec<&[Frame]> = extraction.ends.chunks(TOGETHER).collect();
    let found = in_order(&parts, |part, ends| {
        let mut reached = extraction.roads.room();
        let mut bridges = Vec::new();
        for (row, end) in (part * TOGETHER..).zip(*ends) {
            if !looks.add(0) {
                break;
            }
            let around = Around::new(extraction, end);
            for inside in [false, true] {
                let targets = if inside { around.own_branches(params, &mut reached) } else { around.other_fragments(params) };
                bridges.extend(targets.into_iter().map(|point| FoundBridge { end: row, point, inside }));
            }
            looks.add(around.count() + reached.count());
        }
        bridges
    });
    looks.check()?;
    Ok(found.concat())
}

impl Around<'_> {
    fn width(&self) -> f64 {
        2.0 * self.end.radius + self.extraction.spacing
    }

    fn other_fragments(&self, params: &Search) -> Vec<usize> {
        let hits = self.others(params.branches, params.free_ends);
        let branches = self.nearest_branches(params.branches, &hits);
        let mut picks = params.meetings.of(self.extraction, self.end, &branches);
        let free = hits.iter().filter(|h| self.extraction.end_at[h.point].is_some());
        picks.extend(free.take(params.free_ends).map(|h| (0, h.point)));
        self.apart(picks)
    }

    fn own_branches(&self, params: &Search, reached: &mut Reached) -> Vec<usize> {
        let roads = &self.extraction.roads;
        let most = (DETOUR * self.reach).max(DETOUR_WIDTHS * self.width());
        roads.reach(&[self.end.point], most, reached);
        let hits = self.own(|h| {
            let least = (DETOUR * h.distance).max(DETOUR_WIDTHS * self.width());
            steady(h.cos) > LOOP_COS && steady(roads.to_point(reached, h.point)) > steady(least)
        });
        let branches = self.nearest_branches(params.own_branches, &hits);
        self.apart(params.meetings.of(self.extraction, self.end, &branches))
    }

    /// The nearest branches, each with its hits, in order.
    fn nearest_branches(&self, count: usize, of: &[Hit]) -> Vec<Vec<Hit>> {
        let mut order: Vec<usize> = Vec::new();
        let mut hits: Vec<Vec<Hit>> = Vec::new();
        for hit in of {
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

    /// The picks by rule, without those close to an earlier one on the same fragment, which a free end replaces.
    fn apart(&self, mut picks: Vec<(u8, usize)>) -> Vec<usize> {
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
