//! What lies around a free end, nearest first, without sorting what is too far away to be chosen.

use std::collections::BTreeSet;

use super::free_ends::FreeEnd;
use crate::candidates::features::extraction::Extraction;
use willis_core::support::geometry::{dot, sub};
use willis_core::support::ties::{compare, steady};

/// Reach in point spacings and in end radii: independent of any unit.
const REACH_SPACINGS: f64 = 20.0;
const REACH_RADII: f64 = 10.0;
/// So many of the nearest points are sorted first, and so many times as many when those are not enough.
const FIRST: usize = 1024;
const MORE: usize = 8;

/// A branch is met where d (1.3 - cos) is least: d the distance, cos that of the bend.
pub const BEND: f64 = 1.3;

/// How far (m) a free end of a radius (m) may reach.
pub fn reach(spacing: f64, radius: f64) -> f64 {
    REACH_SPACINGS * spacing + REACH_RADII * radius
}

/// A point within reach of a free end, with what the search compares.
#[derive(Debug, Clone, Copy)]
pub struct Hit {
    /// The point.
    pub point: usize,
    /// Distance, m.
    pub distance: f64,
    /// [`steady`] distance in spacings, BEND - cos, smoothed radius in spacings: the order of hits, whatever their numbers.
    pub order: [f64; 3],
    /// Cosine of the bend from the end's direction.
    pub cos: f64,
}

/// What lies within reach of a free end.
pub struct Neighbourhood<'a> {
    pub extraction: &'a Extraction,
    pub end: &'a FreeEnd,
    pub reach: f64,
    /// Distance (m) and number of the points of its own fragment, in no order.
    own: Vec<(f64, usize)>,
    /// The same of other fragments.
    others: Vec<(f64, usize)>,
}

impl<'a> Neighbourhood<'a> {
    pub fn new(extraction: &'a Extraction, end: &'a FreeEnd, reach: f64) -> Self {
        let near = extraction.index.around(extraction.position[end.point], reach).into_iter();
        let (own, others) = near.partition(|(_, point)| extraction.fragment[*point] == end.fragment);
        Self { extraction, end, reach, own, others }
    }

    /// The points of the end's own fragment that are wanted, in order.
    pub fn own(&self, wanted: impl Fn(&Hit) -> bool) -> Vec<Hit> {
        in_order(self.own.iter().map(|near| self.hit(*near)).filter(wanted))
    }

    /// All points but those of the end's own branch, in order.
    pub fn off_branch(&self) -> Vec<Hit> {
        let own: BTreeSet<usize> = self.extraction.lines[self.end.branch].iter().copied().collect();
        let near = self.own.iter().filter(|(_, point)| !own.contains(point)).chain(&self.others);
        in_order(near.map(|near| self.hit(*near)))
    }

    /// The points of other fragments, in order, those at least that are on the nearest `branches` or are the nearest `free_ends`.
    pub fn others(&self, branches: usize, free_ends: usize) -> Vec<Hit> {
        let e = self.extraction;
        let mut near = self.others.clone();
        let mut first = FIRST;
        while first < near.len() {
            let (_, (distance, _), _) = near.select_nth_unstable_by(first, |a, b| a.0.total_cmp(&b.0));
            let bound = steady(*distance / e.spacing);
            // All that are nearer than the bound are among the first, which makes them the first in order too.
            let hits = in_order(near[..first].iter().map(|near| self.hit(*near)).filter(|hit| hit.order[0] < bound));
            let mut found: Vec<usize> = Vec::new();
            for hit in &hits {
                let branch = e.branch[hit.point];
                if found.len() < branches && !found.contains(&branch) {
                    found.push(branch);
                }
            }
            let is_free = |hit: &&Hit| e.end_at[hit.point].is_some();
            if found.len() == branches && hits.iter().filter(is_free).count() >= free_ends {
                let on_them = |point: usize| found.contains(&e.branch[point]);
                let free = hits.iter().filter(is_free).filter(|hit| !on_them(hit.point)).copied();
                return in_order(near.iter().filter(|(_, point)| on_them(*point)).map(|near| self.hit(*near)).chain(free));
            }
            first *= MORE;
        }
        in_order(near.into_iter().map(|near| self.hit(near)))
    }

    fn hit(&self, (distance, point): (f64, usize)) -> Hit {
        let e = self.extraction;
        let along = dot(sub(e.position[point], e.position[self.end.point]), self.end.direction);
        let cos = if distance > 0.0 { along / distance } else { 0.0 };
        let [away, radius] = [distance, e.smooth.radius[point]].map(|x| steady(x / e.spacing));
        Hit { point, distance, order: [away, steady(BEND - cos), radius], cos }
    }
}

fn in_order(hits: impl Iterator<Item = Hit>) -> Vec<Hit> {
    let mut hits: Vec<Hit> = hits.collect();
    hits.sort_unstable_by(|a, b| compare(&a.order, &b.order).then(a.point.cmp(&b.point)));
    hits
}
