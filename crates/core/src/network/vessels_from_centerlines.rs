//! Contracts centerlines to vessels: maximal runs of points between points whose degree is not two. Tells whether the root of a tracing is
//! where its blood comes from: the widest end of one tree that gets narrower from there.

use super::walks::{Walk, edges_at, other_end, runs_by_node, vessels_at};
use super::{Centerlines, Network, Node, Origin, PathPoint, Vessel, is_radius, path_places::length_of};
use crate::error::Fault;
use crate::support::{arc_lengths::arc_lengths, distance};

/// Which single radius a vessel gets from the radii along it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RadiusRule {
    /// The mean over arc length, r = (1/l) ∫ r dz (Moriconi et al. 2019, eq. 1), by the trapezoid rule.
    #[default]
    Mean,
    /// (l / ∫ dz/r⁴)^¼: keeps the series resistance of a tapering vessel, exactly for radii linear between points.
    Effective,
}

/// A network made of centerlines, and what had to be repaired.
#[derive(Debug, Clone, Default)]
pub struct Contraction {
    /// The network; every vessel is observed.
    pub network: Network,
    /// Points whose radius was missing, zero or not finite and was interpolated.
    pub repaired_radii: usize,
    /// Vessels that had no radius at all and took the default.
    pub default_radii: usize,
    /// Vessels whose links have different labels.
    pub mixed_labels: usize,
}

impl RadiusRule {
    /// The word on the command line and in files.
    pub fn name(self) -> &'static str {
        ["mean", "effective"][self as usize]
    }

    /// The single radius (m) of a vessel with these points.
    pub fn radius(self, path: &[PathPoint]) -> f64 {
        let (mut length, mut sum) = (0.0, 0.0);
        for pair in path.windows(2) {
            let (p, q, dz) = (pair[0].radius, pair[1].radius, distance(pair[0].position, pair[1].position));
            length += dz;
            sum += dz
                * match self {
                    Self::Mean => 0.5 * (p + q),
                    Self::Effective => (p * p + p * q + q * q) / (3.0 * (p * q).powi(3)),
                };
        }
        match self {
            _ if length <= 0.0 => path.first().map_or(0.0, |p| p.radius),
            Self::Mean => sum / length,
            Self::Effective => (length / sum).powf(0.25),
        }
    }
}

impl Vessel {
    /// An observed vessel along a centerline.
    pub fn along(path: Vec<PathPoint>, rule: RadiusRule) -> Self {
        let (length, radius) = (length_of(&path), rule.radius(&path));
        Self { path, ..Self::new(length, radius, Origin::Observed) }
    }
}

/// Contracts centerlines to a network of observed vessels.
///
/// Nodes are the points of degree other than two, in point order, and the first point of every pure ring. Missing
/// radii are interpolated linearly over arc length along their vessel. A vessel has the label of its longest part.
///
/// # Errors
///
/// A vessel without any valid radius when `default_radius` (m) is `None`, or without length.
pub fn contract(lines: &Centerlines, rule: RadiusRule, default_radius: Option<f64>) -> Result<Contraction, Fault> {
    let ends = |link: usize| lines.links[link].map(|point| point as usize);
    let at = edges_at(lines.points.len(), (0..lines.links.len()).map(|link| (link, ends(link))));
    let mut is_node: Vec<bool> = at.iter().map(|links| links.len() != 2).collect();
    let runs = runs_by_node(&at, ends);
    for run in &runs {
        is_node[run.nodes[0]] = true;
    }
    let mut out = Contraction::default();
    out.network.frame = lines.frame;
    let mut row_of = vec![usize::MAX; lines.points.len()];
    for point in (0..lines.points.len()).filter(|p| is_node[*p]) {
        row_of[point] = out.network.add_node(Node {
            id: lines.ids[point].to_string(),
            position: Some(lines.points[point]),
            radius: Some(lines.radii[point]).filter(|r| is_radius(*r)),
            at_border: lines.at_border.contains(&lines.ids[point]),
            is_source: lines.sources.contains(&lines.ids[point]),
            ..Node::default()
        });
    }
    for (id, point) in &lines.merged {
        if let Some(row) = row_of.get(*point as usize).filter(|row| **row != usize::MAX) {
            let node = out.network.node_mut(*row);
            node.also.push(id.to_string());
            node.is_source |= lines.sources.contains(id);
        }
    }
    let mut interpolated = vec![false; lines.points.len()];
    for run in runs {
        let (points, ends) = (&run.nodes, run.ends().map(|point| row_of[point]));
        let name = || format!("vessel from point {} to point {}", lines.ids[points[0]], lines.ids[points[points.len() - 1]]);
        let radii = if let Some(radii) = radii_along(points, lines) {
            points.iter().filter(|point| !is_radius(lines.radii[**point])).for_each(|point| interpolated[*point] = true);
            radii
        } else {
            out.default_radii += 1;
            let found = format!("no valid radius on any of its {} points", points.len());
            let accepted = "expected a positive radius, or give `default_radius`";
            vec![default_radius.ok_or_else(|| Fault::item(name(), found, accepted))?; points.len()]
        };
        let path = points.iter().zip(&radii);
        let path = path.map(|(p, r)| PathPoint { position: lines.points[*p], radius: *r, id: Some(lines.ids[*p]) }).collect();
        let (label, mixed) = label(lines, &run);
        out.mixed_labels += usize::from(mixed);
        let vessel = Vessel { label, ..Vessel::along(path, rule) };
        if vessel.length <= 0.0 {
            return Err(Fault::item(name(), "length 0", "expected points at different positions"));
        }
        for (end, radius) in [(ends[0], radii[0]), (ends[1], radii[radii.len() - 1])] {
            out.network.node_mut(end).radius.get_or_insert(radius);
        }
        out.network.add_vessel(ends, vessel);
    }
    let is_root = |point: &usize| is_node[*point] && lines.root == Some(lines.ids[*point]);
    if let Some(root) = (0..lines.points.len()).find(is_root).map(|point| row_of[point]) {
        out.network.node_mut(root).is_source |= falls_from(&out.network, root);
    }
    out.repaired_radii = interpolated.iter().filter(|point| **point).count();
    Ok(out)
}

/// The label of the longest part of a run, and whether there are others.
fn label(lines: &Centerlines, run: &Walk) -> (String, bool) {
    let mut lengths: Vec<(&str, f64)> = Vec::new();
    for (ends, link) in run.nodes.windows(2).zip(&run.edges) {
        let (name, length) = (lines.labels.of(*link), distance(lines.points[ends[0]], lines.points[ends[1]]));
        match lengths.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += length,
            None => lengths.push((name, length)),
        }
    }
    let longest = lengths.iter().fold(("", -1.0), |best, this| if this.1 > best.1 { *this } else { best });
    (longest.0.to_owned(), lengths.len() > 1)
}

/// The radii along some points: missing ones linear over arc length between valid neighbours, level beyond the outermost; `None`
/// when there is no valid one.
fn radii_along(points: &[usize], lines: &Centerlines) -> Option<Vec<f64>> {
    let mut radii: Vec<f64> = points.iter().map(|p| lines.radii[*p]).collect();
    let valid: Vec<usize> = (0..radii.len()).filter(|i| is_radius(radii[*i])).collect();
    let (first, last) = (*valid.first()?, *valid.last()?);
    let arc = arc_lengths(points.iter().map(|point| lines.points[*point]));
    let (head, tail) = (radii[first], radii[last]);
    radii[..first].fill(head);
    radii[last..].fill(tail);
    for pair in valid.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (ra, rb, span) = (radii[a], radii[b], arc[b] - arc[a]);
        for i in a + 1..b {
            let share = if span > 0.0 { (arc[i] - arc[a]) / span } else { 0.5 };
            radii[i] = ra + share * (rb - ra);
        }
    }
    Some(radii)
}

/// The other free ends have at most this share of the radius of the root.
const MOST_WIDTH: f64 = 0.95;
/// No vessel is wider than this many times the narrowest one between it and the root. In a circle of arteries one comes from a carotid by
/// narrow vessels to the next carotid.
const MOST_RISE: f64 = 1.2;

/// Whether the network is one tree, `root` a free end of it and the widest of all, and vessels get narrower from there.
fn falls_from(network: &Network, root: usize) -> bool {
    if network.vessel_count() + 1 != network.node_count() {
        return false;
    }
    let vessels_at = vessels_at(network, |_| true);
    let [first] = vessels_at[root][..] else { return false };
    let end_radius = |row: usize, node: usize| network.vessel(row).end_radius(network.ends(row)[1] == node);
    let most = MOST_WIDTH * end_radius(first, root);
    // The nodes reached, each with the vessel that leads to it and the narrowest radius up to there.
    let (mut open, mut reached) = (vec![(root, first, f64::INFINITY)], 1);
    while let Some((node, from, narrowest)) = open.pop() {
        for row in vessels_at[node].iter().copied().filter(|row| node == root || *row != from) {
            let (next, vessel) = (other_end(network, row, node), network.vessel(row));
            let is_end = vessels_at[next].len() == 1;
            // A ring leads back; it leaves other nodes unreached.
            if next == node || vessel.radius > MOST_RISE * narrowest || (is_end && end_radius(row, next) > most) {
                return false;
            }
            reached += 1;
            if reached > network.node_count() {
                return false;
            }
            open.push((next, row, narrowest.min(vessel.radius)));
        }
    }
    reached == network.node_count()
}
