//! What the formats of polylines share: a network's nodes as points, and the points between them.

use std::io;

use crate::network::{Network, Node, PathPoint, Vessel};
use crate::support::geometry::{Point, distance};

/// Each node as a point; one without radius has that of its widest vessel, or NaN where it has no vessel.
pub(crate) fn node_points(network: &Network) -> io::Result<Vec<PathPoint>> {
    let mut widest = vec![f64::NAN; network.node_count()];
    for (ends, vessel) in network.vessels() {
        for end in ends {
            widest[end] = widest[end].max(vessel.radius);
        }
    }
    let point = |((position, node), widest): ((Point, &Node), f64)| PathPoint {
        position,
        radius: node.radius.unwrap_or(widest),
        id: None,
    };
    Ok(positions(network)?.into_iter().zip(network.nodes()).zip(widest).map(point).collect())
}

/// Where each node is, m.
///
/// # Errors
///
/// A node without position (`InvalidInput`).
pub(crate) fn positions(network: &Network) -> io::Result<Vec<Point>> {
    let missing = |node: &Node| io::Error::new(io::ErrorKind::InvalidInput, format!("node {} has no position", node.id));
    network.nodes().map(|node| node.position.ok_or_else(|| missing(node))).collect()
}

/// Every vessel from node to node: along its path, or straight where it has none.
pub(crate) fn polylines(network: &Network) -> io::Result<Vec<Vec<PathPoint>>> {
    let at = node_points(network)?;
    let line = |([a, b], vessel): ([usize; 2], &Vessel)| {
        let inner = between(&vessel.path, at[a].position, at[b].position, true);
        [at[a]].into_iter().chain(inner).chain([at[b]]).collect()
    };
    Ok(network.vessels().map(line).collect())
}

/// The points of a network, nodes first, and the rows of each vessel's from node to node.
pub(crate) fn cells(network: &Network) -> io::Result<(Vec<PathPoint>, Vec<Vec<i64>>)> {
    let mut points = node_points(network)?;
    let mut lines = Vec::with_capacity(network.vessel_count());
    for ([a, b], vessel) in network.vessels() {
        let mut line = vec![a as i64];
        for point in between(&vessel.path, points[a].position, points[b].position, true) {
            line.push(points.len() as i64);
            points.push(point);
        }
        line.push(b as i64);
        lines.push(line);
    }
    Ok((points, lines))
}

/// The points of a path without those that its two nodes are, in the sense asked for.
pub(crate) fn between(path: &[PathPoint], from: Point, to: Point, forward: bool) -> Vec<PathPoint> {
    let mut points = path.to_vec();
    if !forward {
        points.reverse();
    }
    if points.last().is_some_and(|p| distance(p.position, to) <= 0.0) {
        points.pop();
    }
    if points.first().is_some_and(|p| distance(p.position, from) <= 0.0) {
        points.remove(0);
    }
    points
}
