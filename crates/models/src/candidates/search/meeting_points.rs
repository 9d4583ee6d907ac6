//! Where a candidate may meet a branch: the points that a lost branch could have left from.

use super::free_ends::FreeEnd;
use super::neighbourhood::{BEND, Hit};
use crate::candidates::features::extraction::Extraction;
use willis_core::support::geometry::{distance, dot, sub, unit};
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

/// Of the nearest branches, how many are met elsewhere than at their nearest point and where d (1.3 - cos) is least.
#[derive(Debug, Clone, PartialEq)]
pub struct MeetingPoints {
    /// Also 3.5 spacings from the nearest point, on the side ahead.
    pub ahead: usize,
    /// Also 3.5 spacings from the nearest point, on the side opposite to that.
    pub behind: usize,
    /// Also where they turn away from the end most: a vessel turns away from a branch it gives off.
    pub kinks: usize,
}

impl Default for MeetingPoints {
    fn default() -> Self {
        Self { ahead: 3, behind: 3, kinks: 3 }
    }
}

impl MeetingPoints {
    /// The points where branches are met, each branch given by its hits in order, with the rank of the rule that found the point.
    pub fn choose(&self, extraction: &Extraction, end: &FreeEnd, branches: &[Vec<Hit>]) -> Vec<(u8, usize)> {
        let mut picks = Vec::new();
        for (rank, hits) in branches.iter().enumerate() {
            picks.push((0, least_bent(extraction, hits).point));
            picks.push((1, hits[0].point));
            let beside: Vec<&Hit> = if rank < self.ahead.max(self.behind) { beside(extraction, hits) } else { Vec::new() };
            // By bend, then by radius and distance.
            let ahead = beside.iter().min_by(|a, b| compare(&a.order[1..], &b.order[1..]));
            picks.extend(ahead.filter(|_| rank < self.ahead).map(|h| (2, h.point)));
            let opposite = beside.iter().filter(|h| ahead.is_some_and(|ahead| opposite(extraction, ahead, h)));
            let behind = opposite.min_by(|a, b| compare(&a.order[1..], &b.order[1..]));
            picks.extend(behind.filter(|_| rank < self.behind).map(|h| (3, h.point)));
            if rank < self.kinks {
                picks.extend(kinked(extraction, end, hits).map(|h| (1, h.point)));
            }
        }
        for (_, point) in &mut picks {
            *point = snapped(extraction, *point);
        }
        picks
    }
}

/// The hit of a branch where d (1.3 - cos) is least.
pub fn least_bent(extraction: &Extraction, hits: &[Hit]) -> Hit {
    let cost = |h: &Hit| steady(h.distance / extraction.spacing * (BEND - h.cos));
    let better = |a: Hit, b: &Hit| if cost(b).total_cmp(&cost(&a)).then(compare(&b.order, &a.order)).is_lt() { *b } else { a };
    hits.iter().fold(hits[0], better)
}

/// The hits at about 3.5 spacings from the first one.
fn beside<'a>(extraction: &Extraction, hits: &'a [Hit]) -> Vec<&'a Hit> {
    let nearest = extraction.position[hits[0].point];
    let off = |h: &&Hit| {
        let off = steady(distance(extraction.position[h.point], nearest) / extraction.spacing);
        (off - BESIDE_SPACINGS).abs() < BESIDE_SLACK
    };
    hits.iter().filter(off).collect()
}

/// Whether a hit is on the other side of the nearest point than the one ahead.
fn opposite(extraction: &Extraction, ahead: &Hit, hit: &Hit) -> bool {
    let between = distance(extraction.position[ahead.point], extraction.position[hit.point]);
    steady(between / extraction.spacing) > OPPOSITE_SPACINGS
}

/// The hit near to the first one where the branch turns away from the end most, if it does.
fn kinked<'a>(extraction: &Extraction, end: &FreeEnd, hits: &'a [Hit]) -> Option<&'a Hit> {
    let (from, nearest) = (extraction.position[end.point], extraction.position[hits[0].point]);
    let off = |h: &Hit| steady(distance(extraction.position[h.point], nearest) / extraction.spacing);
    let kink = |h: &Hit| dot(extraction.shape[h.point].kink, unit(sub(extraction.position[h.point], from)));
    let near = hits.iter().filter(|h| off(h) < KINK_SPACINGS).map(|h| (steady(kink(h)), h));
    near.filter(|(kink, _)| *kink > LEAST_KINK)
        .max_by(|(a, g), (b, h)| a.total_cmp(b).then(compare(&h.order, &g.order)))
        .map(|(_, h)| h)
}

/// The nearest free end of a point's branch where that is near, else the point.
pub fn snapped(extraction: &Extraction, point: usize) -> usize {
    let e = extraction;
    let line = &e.lines[e.branch[point]];
    let away = |end: usize| steady(distance(e.position[end], e.position[point]) / e.spacing);
    let order = |end: usize| [away(end), steady(e.smooth.radius[end] / e.spacing)];
    let free = [line[0], line[line.len() - 1]].into_iter().filter(|p| e.end_at[*p].is_some());
    let near = free.filter(|end| away(*end) <= SNAP_SPACINGS);
    near.min_by(|a, b| compare(&order(*a), &order(*b))).unwrap_or(point)
}
