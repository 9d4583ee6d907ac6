//! What speaks for leaving a fragment alone when a forest is decided.

use std::collections::BTreeMap;

use crate::candidates::features::extraction::Extraction;
use crate::candidates::search::by_evidence::FoundBridge;
use crate::forest_posterior::Marginals;
use crate::support::geometry::distance;

/// A fragment that blood enters is no false one, so leaving it alone can only lose a connection.
const FED: f64 = 0.3;
/// With so many fragments half of the probability of being alone counts: in a circle of few fragments one lost connection
/// changes the whole, in a brain of a hundred one false twig more joins it.
const HALF: f64 = 10.0;
/// Where no inlet is given, so many of the widest free ends are taken for inlets ...
const LIKELY_INLETS: usize = 3;
/// ... and the others that nobody marked make every fragment somewhat more likely to lead to one.
const UNMARKED: f64 = 0.7;

/// Per fragment P(root) times 0.3 where blood enters it, times n/(n + 10) elsewhere, n the number of fragments; times 0.7 when no
/// inlet is given.
pub fn alone(extraction: &Extraction, marginals: &Marginals) -> Vec<f64> {
    let n = extraction.fragments.len() as f64;
    let mut fed = vec![false; extraction.fragments.len()];
    for point in entries(extraction) {
        fed[extraction.fragment[point]] = true;
    }
    let unmarked = if extraction.inlets.is_empty() { UNMARKED } else { 1.0 };
    marginals.roots.iter().zip(fed).map(|(p, fed)| p * unmarked * if fed { FED } else { n / (n + HALF) }).collect()
}

/// The points where blood enters: the inlets given, without any the three widest free ends.
pub fn entries(extraction: &Extraction) -> Vec<usize> {
    if !extraction.inlets.is_empty() {
        return extraction.inlets.clone();
    }
    let mut ends: Vec<_> = extraction.ends.iter().collect();
    ends.sort_by(|a, b| b.radius.total_cmp(&a.radius).then(a.point.cmp(&b.point)));
    ends.iter().take(LIKELY_INLETS).map(|end| end.point).collect()
}

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
