//! Skeleton graphs: points, and links between them, as arrays and tables hold them.

use std::collections::HashSet;
use std::io;

use petgraph::unionfind::UnionFind;

use super::polylines::cells;
use crate::network::centerlines::Centerlines;
use crate::network::{Network, PathPoint};
use crate::support::geometry::{Point, distance};

/// The centerlines of a network as one graph of points: first its nodes, then the points between them.
pub(crate) struct Skeleton {
    pub(crate) points: Vec<PathPoint>,
    pub(crate) links: Vec<[usize; 2]>,
    /// The vessel of each link.
    pub(crate) vessel: Vec<usize>,
}

/// Whether no vessel has a course of its own, so that each is one link.
pub(crate) fn is_straight(network: &Network) -> bool {
    network.vessels().all(|(_, vessel)| vessel.path.is_empty())
}

/// The points and links of a network, vessel by vessel.
///
/// # Errors
///
/// A node without a position; a vessel without points between two nodes that another such vessel joins, or from a node to
/// itself, which a reader could not tell apart (`InvalidInput`).
pub(crate) fn skeleton(network: &Network) -> io::Result<Skeleton> {
    let (points, lines) = cells(network)?;
    let mut out = Skeleton { points, links: Vec::new(), vessel: Vec::new() };
    let mut joined = HashSet::new();
    for (row, line) in lines.iter().enumerate() {
        let [a, b] = network.ends(row);
        let inner = line.len() - 2;
        let void = if a == b { inner < 2 } else { inner == 0 && !joined.insert([a.min(b), a.max(b)]) };
        if void {
            let why = "has no points of its own between nodes that are one, or joined by another such vessel";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{} {why}", network.vessel_name(row))));
        }
        out.links.extend(line.windows(2).map(|pair| [pair[0] as usize, pair[1] as usize]));
        out.vessel.resize(out.links.len(), row);
    }
    Ok(out)
}

/// Centerlines of points (m), radii (m; NaN where missing) and links with their names. Each connected part is a strand, so
/// that points in one place are one point only where they belong to different parts.
pub(crate) fn centerlines(points: &[Point], radii: &[f64], links: &[[u32; 2]], label: impl Fn(usize) -> String) -> Centerlines {
    let mut parts = UnionFind::<u32>::new(points.len());
    for [a, b] in links {
        parts.union(*a, *b);
    }
    let mut lines = Centerlines::default();
    for (row, (point, radius)) in points.iter().zip(radii).enumerate() {
        lines.add_point(*point, *radius, row as u64, parts.find(row as u32));
    }
    for (row, link) in links.iter().enumerate().filter(|(_, [a, b])| a != b) {
        lines.add_link(*link, &label(row));
    }
    lines
}

/// The radius of each point from those of its links: their mean over length, which keeps ∫ r dz over the whole skeleton.
pub(crate) fn radii_of_points(points: &[Point], links: &[[u32; 2]], radii: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); points.len()];
    for ([a, b], radius) in links.iter().zip(radii).filter(|(_, r)| crate::network::centerlines::is_radius(**r)) {
        let length = distance(points[*a as usize], points[*b as usize]);
        for end in [*a, *b] {
            let (sum, of) = &mut sums[end as usize];
            (*sum, *of) = (*sum + length * radius, *of + length);
        }
    }
    sums.into_iter().map(|(sum, of)| if of > 0.0 { sum / of } else { f64::NAN }).collect()
}
