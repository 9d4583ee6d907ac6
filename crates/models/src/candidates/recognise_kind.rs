//! Which kind centerlines are: by where they come from, their loops, and where their pieces begin.

use super::kind::CenterlineKind;
use super::resample::Resampled;
use super::search::point_index::PointIndex;
use willis_core::network::{Network, Origin, Vessel, cycles, fragments};

/// Arteries have no more independent loops than this, those of the circle and some to spare.
const MOST_LOOPS: usize = 4;
/// Vessels are drawn one by one where this share of them begins in the lumen of another, ...
const INSIDE: f64 = 2.0 / 3.0;
/// ... and there are so many.
const LEAST_VESSELS: usize = 4;
/// A lumen is looked for within so many radii of an end, for a branch is hardly thinner than its parent over this.
const REACH: f64 = 4.0;

impl CenterlineKind {
    /// The kind of observed vessels: a skeleton where they come from a mask or have more loops than arteries have, which come where vessels
    /// touch; tubes where two thirds of the pieces have a free end inside the lumen of another piece; else a tracing.
    pub fn of(network: &Network, from_mask: bool) -> Self {
        if from_mask || cycles(network) > MOST_LOOPS {
            Self::Skeleton
        } else if begin_in_lumens(network) {
            Self::Tubes
        } else {
            Self::Tracing
        }
    }
}

fn begin_in_lumens(network: &Network) -> bool {
    let observed = fragments(network, |_, vessel| vessel.origin == Origin::Observed);
    if observed.count < LEAST_VESSELS || !network.has_positions() {
        return false;
    }
    let resampled = Resampled::new(network, CenterlineKind::Tubes).network;
    let degree = resampled.degrees(|vessel| vessel.origin == Origin::Observed);
    let (mut points, mut piece, mut radius, mut free) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    // A vessel of a ready graph may have no course.
    let traced = |vessel: &Vessel| vessel.origin == Origin::Observed && !vessel.path.is_empty();
    for (ends, vessel) in resampled.vessels().filter(|(_, vessel)| traced(vessel)) {
        let first = points.len();
        points.extend(vessel.path.iter().map(|at| at.position));
        piece.resize(points.len(), observed.of_node[ends[0]]);
        radius.extend(vessel.path.iter().map(|at| at.radius));
        let at = [first, points.len().max(1) - 1];
        free.extend(ends.iter().zip(at).filter(|(node, _)| degree[**node] == 1).map(|(_, point)| point));
    }
    let index = PointIndex::new(points.clone());
    // Per piece with a free end whether one is inside another piece.
    let mut inside: Vec<Option<bool>> = vec![None; observed.count];
    for end in free {
        let around = index.around(points[end], REACH * radius[end]);
        let found = around.iter().any(|(away, point)| piece[*point] != piece[end] && *away <= radius[*point]);
        let of_piece = inside[piece[end]].get_or_insert(false);
        *of_piece |= found;
    }
    let known: Vec<bool> = inside.into_iter().flatten().collect();
    let begun_inside = known.iter().filter(|inside| **inside).count();
    known.len() >= LEAST_VESSELS && begun_inside as f64 >= INSIDE * known.len() as f64
}
