//! What speaks for hanging one fragment on another when a forest is decided.

use std::collections::BTreeMap;

use crate::candidates::evidence::{Extraction, FoundBridge};
use crate::geometry::distance;
use crate::posterior::Marginals;

/// Bridges from one end to one fragment are nearly equal where they meet it within the largest of so many spacings, ...
const NEAR_SPACINGS: f64 = 3.0;
/// ... so many radii there, ...
const NEAR_RADII: f64 = 2.0;
/// ... and so many gaps: closer, no image tells them apart.
const NEAR_GAPS: f64 = 0.75;
/// A bridge stands for two fragments in place of a more probable one where it has so much more probability around it, ...
const MUCH_MORE: f64 = 0.25;
/// ... and itself at least so much of the other's.
const NOT_MUCH_LESS: f64 = 0.5;

/// Per bridge what speaks for hanging its child by it: its marginal, and for the one bridge that stands for its child and
/// parent those of the bridges nearly equal to it. A search offers several meeting points a few voxels apart, which share the
/// probability of one connection.
pub fn hangs(extraction: &Extraction, bridges: &[FoundBridge], marginals: &Marginals) -> Vec<f64> {
    let own = &marginals.bridges;
    let parent = |b: &FoundBridge| extraction.fragment[b.point];
    let mut alike: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (row, bridge) in bridges.iter().enumerate() {
        alike.entry((bridge.end, parent(bridge))).or_default().push(row);
    }
    let at = |row: usize| extraction.position[bridges[row].point];
    let mass = |row: usize| {
        let bridge = &bridges[row];
        let gap = distance(at(row), extraction.position[extraction.ends[bridge.end].point]);
        let near = (NEAR_SPACINGS * extraction.spacing).max(NEAR_RADII * extraction.smooth.radius[bridge.point]);
        // A hair's breadth, so that no rounding decides on voxel grids.
        let near = near.max(NEAR_GAPS * gap) * (1.0 + 1e-9);
        let rows = alike[&(bridge.end, parent(bridge))].iter();
        rows.filter(|other| distance(at(**other), at(row)) <= near).map(|other| own[*other]).sum::<f64>().min(1.0)
    };
    let masses: Vec<f64> = (0..own.len()).map(mass).collect();
    let mut order: Vec<usize> = (0..own.len()).collect();
    order.sort_by(|a, b| own[*b].total_cmp(&own[*a]).then(a.cmp(b)));
    let mut best: BTreeMap<[usize; 2], usize> = BTreeMap::new();
    for row in order {
        let bridge = &bridges[row];
        let stands = best.entry([extraction.ends[bridge.end].fragment, parent(bridge)]).or_insert(row);
        if masses[row] * (1.0 - MUCH_MORE) > masses[*stands] && own[row] > NOT_MUCH_LESS * own[*stands] {
            *stands = row;
        }
    }
    let mut hangs = own.clone();
    for row in best.into_values() {
        hangs[row] = masses[row];
    }
    hangs
}
