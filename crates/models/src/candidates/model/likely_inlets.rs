//! Where blood enters an extraction: at its inlets, or where none is given probably at its widest free ends.

use crate::candidates::features::extraction::Extraction;
use crate::candidates::search::free_ends::FreeEnd;
use willis_core::support::geometry::{centroid, distance, sub};
use willis_core::support::ties::{compare, near_zero, steady};

/// So many of the widest free ends are taken for inlets.
const LIKELY_INLETS: usize = 3;

/// The points where blood enters: the inlets given, without any the three widest free ends, of equally wide ones those farthest from the middle
/// of all.
pub fn known_or_likely_inlets(extraction: &Extraction) -> Vec<usize> {
    if !extraction.inlets.is_empty() {
        return extraction.inlets.clone();
    }
    let mut ends: Vec<_> = extraction.ends.iter().collect();
    let at = |end: &FreeEnd| extraction.position[end.point];
    let middle = centroid(ends.iter().map(|end| at(end)));
    let order = |end: &FreeEnd| {
        let [x, y, z] = sub(at(end), middle).map(|x| near_zero(x / extraction.spacing));
        [-steady(end.radius / extraction.spacing), -near_zero(distance(at(end), middle) / extraction.spacing), z, y, x]
    };
    ends.sort_by(|a, b| compare(&order(a), &order(b)).then(a.point.cmp(&b.point)));
    ends.iter().take(LIKELY_INLETS).map(|end| end.point).collect()
}
