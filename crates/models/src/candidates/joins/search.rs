//! More candidates on a skeleton: far along the direction of a free end, and within a fragment, where gaps lie too once vessels touch.

use std::collections::{BTreeMap, BTreeSet};

use super::course::EndCourse;
use crate::candidates::features::Extraction;
use crate::candidates::search::{EndCandidate, SearchOptions, search};
use willis_core::error::Result;
use willis_core::support::geometry::{dot, sub};
use willis_core::support::in_order;
use willis_core::support::ties::{compare, steady};

/// The reach along a direction, in spacings and radii of the end.
const REACH_SPACINGS: f64 = 40.0;
const REACH_RADII: f64 = 20.0;
/// So many free ends ahead, each within these cosines of the two directions, ...
const ENDS: usize = 4;
const END_COS: f64 = 0.75;
const BACK_COS: f64 = 0.3;
/// ... and so many branches within this one.
const BRANCHES: usize = 2;
const BRANCH_COS: f64 = 0.9;

/// The candidates of a skeleton, by free end: those of [`search`], and further ones in the direction of each free end.
///
/// # Errors
///
/// Points that are crowded: far more of them within reach of free ends than vessels have.
pub fn search_joins(e: &Extraction, courses: &[EndCourse], branches: usize) -> Result<Vec<EndCandidate>> {
    let near = search(e, &SearchOptions { branches, ..SearchOptions::default() })?;
    let mut of_end: Vec<Vec<EndCandidate>> = vec![Vec::new(); e.ends.len()];
    for candidate in near {
        of_end[candidate.end].push(candidate);
    }
    let rows: Vec<usize> = (0..e.ends.len()).collect();
    let far = in_order(&rows, |_, end| if e.at_border[e.ends[*end].point] { Vec::new() } else { ahead(e, courses, *end) });
    for (candidates, far) in of_end.iter_mut().zip(far) {
        let there: BTreeSet<usize> = candidates.iter().map(|c| c.point).collect();
        let fits = |c: &EndCandidate| !there.contains(&c.point) && !e.at_border[c.point];
        candidates.extend(far.into_iter().filter(fits));
    }
    Ok(of_end.concat())
}

/// The free ends and branches of other fragments that lie ahead of a free end.
fn ahead(e: &Extraction, courses: &[EndCourse], row: usize) -> Vec<EndCandidate> {
    let (end, course) = (&e.ends[row], &courses[row]);
    let from = e.position[end.point];
    let reach = REACH_SPACINGS * e.spacing + REACH_RADII * end.radius;
    let mut free: Vec<([f64; 2], usize)> = Vec::new();
    let mut branches: BTreeMap<usize, ([f64; 2], usize)> = BTreeMap::new();
    for (gap, point) in e.index.around(from, reach) {
        if e.fragment[point] == end.fragment || gap <= 0.0 {
            continue;
        }
        let u = sub(e.position[point], from).map(|x| x / gap);
        let cos = dot(u, course.directions[1]).max(dot(u, course.directions[2]));
        let width = steady(e.smooth.radius[point] / e.spacing);
        if let Some(other) = e.end_at[point] {
            let back = -dot(u, courses[other].directions[1]);
            if steady(cos) > END_COS && steady(back) > BACK_COS {
                free.push(([steady(gap / e.spacing * (1.6 - cos - 0.5 * back)), width], point));
            }
        }
        if steady(cos) > BRANCH_COS {
            let order = [steady(gap / e.spacing * (1.3 - cos)), width];
            let best = branches.entry(e.branch[point]).or_insert((order, point));
            if compare(&order, &best.0).then(point.cmp(&best.1)).is_lt() {
                *best = (order, point);
            }
        }
    }
    let by_order = |list: &mut Vec<([f64; 2], usize)>| list.sort_by(|a, b| compare(&a.0, &b.0).then(a.1.cmp(&b.1)));
    let mut branches: Vec<([f64; 2], usize)> = branches.into_values().collect();
    by_order(&mut free);
    by_order(&mut branches);
    let found = free.iter().take(ENDS).chain(branches.iter().take(BRANCHES));
    let points: BTreeSet<usize> = found.map(|(_, point)| *point).collect();
    points.into_iter().map(|point| EndCandidate { end: row, point, within: false }).collect()
}
