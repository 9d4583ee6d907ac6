//! Vessels that are known by their nodes alone, given a line that keeps their radius.

use std::collections::HashSet;
use std::io;

use crate::io::polylines::{between, node_points};
use crate::network::{Network, PathPoint, RadiusRule};
use crate::support::geometry::lerp;

/// How far from its nodes, as a share of its length, a straight vessel takes the radius that is its own.
const TAPER: f64 = 0.01;

/// A network as lines.
pub(crate) struct Drawn {
    /// Every vessel has a line of its own.
    pub(crate) network: Network,
    /// How many lines had to be made.
    pub(crate) made: usize,
}

/// Whether a vessel runs from a node to itself without points between, so that it cannot be drawn.
pub(crate) fn has_no_course(network: &Network, row: usize) -> bool {
    let [a, b] = network.ends(row);
    a == b && network.vessel(row).path.len() < 4
}

/// The network with a line for every vessel, without those that cannot have one.
///
/// Nodes are points of several vessels, so the radius of a vessel without a line is that of two points near its ends,
/// chosen such that the mean over its arc length is the vessel's radius. A vessel that runs straight between two nodes that
/// another such vessel joins gets a point midway.
///
/// # Errors
///
/// A node without position (`InvalidInput`).
pub(crate) fn with_lines(network: &Network) -> io::Result<Drawn> {
    let at = node_points(network)?;
    let (mut drawn, _) = network.subgraph(|row| !has_no_course(network, row));
    let (mut joined, mut made) = (HashSet::new(), 0);
    for row in 0..drawn.vessel_count() {
        let rows = drawn.ends(row);
        let [a, b] = rows.map(|end| at[end]);
        let vessel = drawn.vessel_mut(row);
        let inner = between(&vessel.path, a.position, b.position, true);
        if !inner.is_empty() {
            continue;
        }
        let first = joined.insert([rows[0].min(rows[1]), rows[0].max(rows[1])]);
        let point = |share: f64, radius: f64| PathPoint { position: lerp(a.position, b.position, share), radius, id: None };
        let radius = (vessel.radius - TAPER * f64::midpoint(a.radius, b.radius)) / (1.0 - TAPER);
        let tapers = (RadiusRule::Mean.radius(&[a, b]) - vessel.radius).abs() > f64::EPSILON * vessel.radius;
        if vessel.path.is_empty() && tapers && radius > 0.0 && a.position != b.position {
            vessel.path = vec![a, point(TAPER, radius), point(1.0 - TAPER, radius), b];
            made += 1;
        } else if !first {
            vessel.path = vec![a, point(0.5, f64::midpoint(a.radius, b.radius)), b];
            made += 1;
        }
    }
    Ok(Drawn { network: drawn, made })
}
