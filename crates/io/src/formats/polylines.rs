//! A network as lines of points, and as one graph of points and links, for the formats that hold these.

use std::io;

use crate::formats::{Centerlines, Frame, Network, Node, PathPoint, Point, distance, ensure, other_end, refused, vessels_at};
use willis_core::network::{Origin, Role, Vessel};

/// The rows of items that each have a parent or none, parents first; the row of an item on a cycle where there is one.
pub(crate) fn parents_first(up: &[Option<usize>]) -> Result<Vec<usize>, usize> {
    let mut order = Vec::with_capacity(up.len());
    let mut reached_from = vec![None; up.len()];
    for start in 0..up.len() {
        let (first, mut at) = (order.len(), Some(start));
        while let Some(row) = at.filter(|row| reached_from[*row].is_none_or(|from| from == start)) {
            ensure(reached_from[row].replace(start).is_none(), || row)?;
            order.push(row);
            at = up[row];
        }
        order[first..].reverse();
    }
    Ok(order)
}

/// A step of a walk over a network: the vessel and the node from which it is walked, none where a walk begins; the node that is reached, and
/// whether for the first time.
type WalkStep = (Option<(usize, usize)>, usize, bool);

/// Walks every vessel once: from each inlet, then from the first node of every part without one; depth first or breadth first.
pub(crate) fn steps_from_inlets(network: &Network, is_depth_first: bool) -> Vec<WalkStep> {
    let vessels_at = vessels_at(network, |_| true);
    let mut is_walked = vec![false; network.vessel_count()];
    let mut is_reached = vec![false; network.node_count()];
    let mut steps = Vec::with_capacity(network.vessel_count());
    let inlets = (0..network.node_count()).filter(|node| network.node(*node).role == Some(Role::Inlet));
    for root in inlets.chain(0..network.node_count()) {
        if std::mem::replace(&mut is_reached[root], true) {
            continue;
        }
        steps.push((None, root, true));
        let mut open = std::collections::VecDeque::from([root]);
        while let Some(node) = if is_depth_first { open.pop_back() } else { open.pop_front() } {
            for row in vessels_at[node].iter().copied() {
                if std::mem::replace(&mut is_walked[row], true) {
                    continue;
                }
                let to = other_end(network, row, node);
                let is_new = !std::mem::replace(&mut is_reached[to], true);
                steps.push((Some((row, node)), to, is_new));
                if is_new {
                    open.push_back(to);
                }
            }
        }
    }
    steps
}

/// Each node as a point. A node without radius takes that of its widest vessel, or NaN without any vessel.
pub(crate) fn node_points(network: &Network) -> io::Result<Vec<PathPoint>> {
    let mut widest = vec![f64::NAN; network.node_count()];
    for (ends, vessel) in network.vessels() {
        for end in ends {
            widest[end] = widest[end].max(vessel.radius);
        }
    }
    let radii = network.nodes().zip(widest).map(|(node, widest)| node.radius.unwrap_or(widest));
    Ok(positions(network)?.into_iter().zip(radii).map(|(position, radius)| PathPoint { position, radius, id: None }).collect())
}

/// The position of each node, m.
///
/// # Errors
///
/// A node without position (`InvalidInput`).
pub(crate) fn positions(network: &Network) -> io::Result<Vec<Point>> {
    let missing = |node: &Node| refused(format!("node {} has no position", node.id));
    network.nodes().map(|node| node.position.ok_or_else(|| missing(node))).collect()
}

/// Every vessel from node to node: along its path, or straight where it has none.
pub(crate) fn polylines(network: &Network) -> io::Result<Vec<Vec<PathPoint>>> {
    let (points, lines) = cells(network)?;
    Ok(lines.into_iter().map(|line| line.into_iter().map(|row| points[row as usize]).collect()).collect())
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

/// The points of a path between its two nodes, without the nodes themselves; from the last to the first unless `forward`.
pub(crate) fn between(path: &[PathPoint], from: Point, to: Point, forward: bool) -> Vec<PathPoint> {
    let mut points = willis_core::support::arc_lengths::in_direction(path.to_vec(), forward);
    if points.last().is_some_and(|p| distance(p.position, to) <= 0.0) {
        points.pop();
    }
    if points.first().is_some_and(|p| distance(p.position, from) <= 0.0) {
        points.remove(0);
    }
    points
}

/// Whether every vessel is known by its two nodes alone, so that each is one link.
pub(crate) fn is_straight(network: &Network) -> bool {
    network.vessels().all(|(_, vessel)| vessel.path.is_empty())
}

/// A network as one graph of points: first its nodes, then the points between them.
pub(crate) struct PointLinks {
    /// m.
    pub(crate) points: Vec<Point>,
    pub(crate) links: Vec<[usize; 2]>,
    /// Whether each link is a vessel.
    pub(crate) is_straight: bool,
    /// Those of the vessels where each is a link, else those of the points, m.
    pub(crate) radii: Vec<f64>,
    /// The vessel of each link.
    pub(crate) vessel: Vec<usize>,
}

impl PointLinks {
    /// The points and links of a network, vessel by vessel.
    ///
    /// # Errors
    ///
    /// A node without a position; where any vessel has points of its own, one without between two nodes that another such vessel joins, or from a
    /// node to itself, which a reader could not distinguish (`InvalidInput`).
    pub(crate) fn of(network: &Network) -> io::Result<Self> {
        if is_straight(network) {
            let (links, radii) = network.vessels().map(|(ends, vessel)| (ends, vessel.radius)).unzip();
            let vessel = (0..network.vessel_count()).collect();
            return Ok(Self { points: positions(network)?, links, is_straight: true, radii, vessel });
        }
        let (points, lines) = cells(network)?;
        let (points, radii) = points.into_iter().map(|point| (point.position, point.radius)).unzip();
        let mut out = Self { points, links: Vec::new(), is_straight: false, radii, vessel: Vec::new() };
        let mut joined = std::collections::HashSet::new();
        for (row, line) in lines.iter().enumerate() {
            let [a, b] = network.ends(row);
            let inner = line.len() - 2;
            let void = if a == b { inner < 2 } else { inner == 0 && !joined.insert([a.min(b), a.max(b)]) };
            let why = "has no points of its own between nodes that are one, or joined by another such vessel";
            ensure(!void, || refused(format!("{} {why}", network.vessel_name(row))))?;
            out.links.extend(line.windows(2).map(|pair| [pair[0] as usize, pair[1] as usize]));
            out.vessel.resize(out.links.len(), row);
        }
        Ok(out)
    }

    /// The labels of the links.
    pub(crate) fn labels<'a>(&self, network: &'a Network) -> impl Iterator<Item = &'a str> {
        self.vessel.iter().map(|row| network.vessel(*row).label.as_str())
    }
}

/// Makes centerlines of points (m), radii (m; NaN where missing) and links with their labels, and with their radii where these are stated. Each
/// connected part is one strand, so that coincident points are merged only where they belong to different parts.
pub(crate) fn centerlines(
    points: &[Point],
    radii: &[f64],
    links: &[[u32; 2]],
    link_radii: &[f64],
    label: impl Fn(usize) -> String,
) -> Centerlines {
    let mut lines = Centerlines::default();
    for (row, (point, radius)) in points.iter().zip(radii).enumerate() {
        lines.add_point(*point, *radius, row as u64, 0);
    }
    lines.strand = parts_of(points.len(), links);
    for (row, link) in links.iter().enumerate().filter(|(_, [a, b])| a != b) {
        lines.add_link(*link, &label(row));
        lines.link_radii.extend(link_radii.get(row));
    }
    lines
}

/// The connected part of each point, by one of its points.
pub(crate) fn parts_of(points: usize, links: &[[u32; 2]]) -> Vec<u32> {
    let mut parts = petgraph::unionfind::UnionFind::<u32>::new(points);
    for [a, b] in links {
        parts.union(*a, *b);
    }
    parts.into_labeling()
}

/// The radius of each point from those of its links: their mean over length, which keeps ∫ r dz over the whole skeleton.
pub(crate) fn radii_of_points(points: &[Point], links: &[[u32; 2]], radii: &[f64]) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); points.len()];
    for ([a, b], radius) in links.iter().zip(radii).filter(|(_, r)| willis_core::network::is_radius(**r)) {
        let length = distance(points[*a as usize], points[*b as usize]);
        for end in [*a, *b] {
            let (sum, of) = &mut sums[end as usize];
            (*sum, *of) = (*sum + length * radius, *of + length);
        }
    }
    sums.into_iter().map(|(sum, of)| if of > 0.0 { sum / of } else { f64::NAN }).collect()
}

/// A network of nodes in these places, m, called by their rows, without vessels.
pub(crate) fn network_of_points(points: &[Point]) -> Network {
    let node = |(row, point): (usize, &Point)| Node { id: row.to_string(), position: Some(*point), ..Node::default() };
    Network::of(Frame::Unknown, points.iter().enumerate().map(node).collect(), Vec::new())
}

/// Adds an observed vessel between two nodes, without points in between.
///
/// Where `length` is NaN, the length is the distance between the nodes.
pub(crate) fn add_straight(network: &mut Network, ends: [usize; 2], length: f64, radius: f64, label: &str) -> Option<()> {
    let length = if length.is_nan() {
        let [a, b] = ends.map(|end| network.node(end).position);
        distance(a?, b?)
    } else {
        length
    };
    if !(length > 0.0 && length.is_finite() || length == 0.0 && ends[0] == ends[1]) {
        return None;
    }
    let vessel = Vessel { label: label.to_owned(), ..Vessel::new(length, radius, Origin::Observed) };
    network.add_vessel(ends, vessel);
    Some(())
}
