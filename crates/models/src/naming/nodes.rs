//! Centerlines as a chain of nodes about 1 mm apart, in millimetres and RAS, which is what names are given to.

use petgraph::unionfind::UnionFind;

use super::algebra::{Symmetric, outer};
use willis_core::network::walks::{runs_by_node, vessels_at};
use willis_core::network::{Fragments, Frame, Network, Origin, PathPoint, units::millimetres};
use willis_core::support::arc_lengths::{arc_lengths, in_direction, place_at};
use willis_core::support::geometry::{Point, distance, lerp, norm, sub};
use willis_core::support::{numbered::placed, statistics::weighted_quantiles};

/// The distance of nodes, mm.
const STEP: f64 = 1.0;
/// Nodes on either side over which a direction is taken.
const DIRECTION_NODES: usize = 3;
/// The smallest radius that counts, mm.
const LEAST_RADIUS: f64 = 0.1;
/// A bridge is believed no more than this.
const MOST_PROBABLE: f64 = 0.95;
/// One below this is not worth a factor.
const LEAST_PROBABLE: f64 = 0.02;

/// Where a node lies in the network.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VesselPlace {
    /// The row of a vessel.
    pub vessel: usize,
    /// The distance from its first node along it, mm.
    pub along: f64,
}

/// A possible connection of two pieces.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bridge {
    /// The nodes that it joins.
    pub nodes: [usize; 2],
    /// Its length, mm.
    pub gap: f64,
    /// How probable it is, names apart.
    pub probability: f64,
    /// The row of the candidate or contact.
    pub vessel: usize,
}

impl Bridge {
    /// Which of the factors for gaps fits it: below 3 mm, below 6 mm, or longer.
    pub fn length_class(&self) -> usize {
        usize::from(self.gap >= 3.0) + usize::from(self.gap >= 6.0)
    }
}

/// Nodes about 1 mm apart along the observed vessels of a network.
#[derive(Debug, Clone, Default)]
pub struct Nodes {
    /// Positions in mm, RAS.
    pub at: Vec<Point>,
    /// Logarithms of the radii in mm.
    pub log_radius: Vec<f64>,
    /// Scatter of the directions at each node, of trace 1.
    pub direction: Vec<Symmetric>,
    /// The length that each node stands for, mm.
    pub weight: Vec<f64>,
    /// Pairs of neighbours along vessels, the lower first.
    pub links: Vec<[usize; 2]>,
    /// The neighbours of each node along vessels.
    pub neighbours: Vec<Vec<usize>>,
    /// The number of the branch of each node: a run between junctions and free ends.
    pub branch: Vec<usize>,
    /// How many branches there are.
    pub branches: usize,
    /// The number of the connected piece of each node.
    pub piece: Vec<usize>,
    /// How many pieces there are.
    pub pieces: usize,
    /// Where each node lies.
    pub place: Vec<VesselPlace>,
    /// The number of the nearest point of the input, where it has one.
    pub id: Vec<Option<u64>>,
    /// The candidates and contacts of the network.
    pub bridges: Vec<Bridge>,
}

/// Which vessels are traced: the observed ones, or all where none is.
pub fn is_traced(network: &Network) -> Vec<bool> {
    let observed: Vec<bool> = network.vessels().map(|(_, vessel)| vessel.origin == Origin::Observed).collect();
    if observed.contains(&true) { observed } else { vec![true; observed.len()] }
}

/// A point of a branch before it is divided: position (mm, RAS), radius (mm), number, and its place in the network.
#[derive(Debug, Clone, Copy)]
struct BranchPoint {
    at: Point,
    radius: f64,
    id: Option<u64>,
    place: VesselPlace,
}

impl Nodes {
    /// The nodes of a network with positions in a frame; one that is not LPS is taken for RAS.
    pub fn of(network: &Network, frame: Frame) -> Self {
        let traced = is_traced(network);
        let vessels_at = vessels_at(network, |row| traced[row]);
        let mut nodes = Self::default();
        let mut node_at = vec![usize::MAX; network.node_count()];
        for run in runs_by_node(&vessels_at, |row| network.ends(row)) {
            let mut points: Vec<BranchPoint> = Vec::new();
            let mut passed: Vec<(usize, usize)> = vec![(run.nodes[0], 0)];
            for (vessel, ends) in run.edges.iter().copied().zip(run.nodes.windows(2)) {
                points.extend(points_of(network, vessel, ends[0]).into_iter().map(|(p, along)| BranchPoint {
                    at: frame.turn(Frame::Ras, p.position).map(millimetres),
                    radius: millimetres(p.radius),
                    id: p.id,
                    place: VesselPlace { vessel, along },
                }));
                passed.push((ends[1], points.len().saturating_sub(1)));
            }
            nodes.add_branch(&points, &passed, &mut node_at);
        }
        nodes.finish();
        nodes.bridges = bridges(network, &traced, &nodes, &node_at);
        nodes
    }

    /// How many nodes there are.
    pub fn len(&self) -> usize {
        self.at.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.at.is_empty()
    }

    /// The number of neighbours of a node.
    pub fn degree(&self, node: usize) -> usize {
        self.neighbours[node].len()
    }

    /// The length of everything, mm.
    pub fn length(&self) -> f64 {
        self.weight.iter().sum()
    }

    /// The median of the logarithms of the radii, by length times `share`.
    pub fn median_log_radius(&self, share: impl Fn(usize) -> f64) -> f64 {
        let weighted = (0..self.len()).map(|n| (self.log_radius[n], self.weight[n] * share(n)));
        weighted_quantiles(weighted, [0.5])[0].unwrap_or(0.0)
    }

    /// Adds the nodes of a branch; `passed` are the network's nodes along it with the number of their point.
    fn add_branch(&mut self, points: &[BranchPoint], passed: &[(usize, usize)], node_at: &mut [usize]) {
        let (Some(first), Some(last)) = (passed.first(), passed.last()) else { return };
        if points.len() < 2 {
            return;
        }
        let arc = arc_lengths(points.iter().map(|point| point.at));
        let length = arc[points.len() - 1];
        // Two at the least: never one junction beside another.
        let pieces = ((length / STEP).round() as usize).max(2);
        let at: Vec<f64> = (0..=pieces).map(|k| length * k as f64 / pieces as f64).collect();
        let at_length = |s: &f64| {
            let (k, share) = place_at(&arc, *s);
            between(&points[k], &points[k + 1], share)
        };
        let sampled: Vec<BranchPoint> = at.iter().map(at_length).collect();
        let radius = |j: usize| {
            if pieces < 4 {
                return sampled[j].radius;
            }
            let near = |d: isize| sampled[j.saturating_add_signed(d).min(pieces)].radius;
            (-2..=2).map(near).sum::<f64>() / 5.0
        };
        let mut before = None;
        let mut rows = Vec::with_capacity(pieces + 1);
        for (j, point) in sampled.iter().enumerate() {
            let at_end = [(0, first.0), (pieces, last.0)].into_iter().find(|(at, _)| *at == j).map(|(_, node)| node);
            let known = at_end.map(|node| node_at[node]).filter(|row| *row != usize::MAX);
            let row = known.unwrap_or_else(|| {
                self.at.push(point.at);
                self.log_radius.push(radius(j).max(LEAST_RADIUS).ln());
                self.direction.push([0.0; 6]);
                self.neighbours.push(Vec::new());
                self.branch.push(self.branches);
                self.place.push(point.place);
                self.id.push(point.id);
                self.at.len() - 1
            });
            if let Some(node) = at_end {
                node_at[node] = row;
            }
            let (low, high) = (j.saturating_sub(DIRECTION_NODES), (j + DIRECTION_NODES).min(pieces));
            let step = sub(sampled[high].at, sampled[low].at);
            let long = norm(step) + 1e-9;
            for (sum, d) in self.direction[row].iter_mut().zip(outer(step.map(|x| x / long))) {
                *sum += d;
            }
            if let Some(before) = before.filter(|before| *before != row) {
                self.links.push([row.min(before), row.max(before)]);
            }
            before = Some(row);
            rows.push(row);
        }
        for (node, point) in &passed[1..passed.len() - 1] {
            let nearest = ((arc[*point] / length.max(1e-9) * pieces as f64).round() as usize).min(pieces);
            node_at[*node] = rows[nearest];
        }
        self.branches += 1;
    }

    /// Neighbours, weights and pieces from the links.
    fn finish(&mut self) {
        self.links.sort_unstable();
        self.links.dedup();
        self.weight = vec![0.0; self.len()];
        for [a, b] in &self.links {
            self.neighbours[*a].push(*b);
            self.neighbours[*b].push(*a);
            let half = 0.5 * distance(self.at[*a], self.at[*b]);
            self.weight[*a] += half;
            self.weight[*b] += half;
        }
        for d in &mut self.direction {
            *d = [d[0] + 1e-6, d[1] + 1e-6, d[2] + 1e-6, d[3], d[4], d[5]];
            let trace = d[0] + d[1] + d[2];
            *d = d.map(|x| x / trace);
        }
        let parts = Fragments::over(self.len(), self.links.iter().copied());
        (self.piece, self.pieces) = (parts.of_node, parts.count);
    }

    /// The bridges that join the pieces that `counts` admits to a forest, the most probable first; none onto a junction, which would get a
    /// fourth arm.
    pub fn spanning_bridges(&self, counts: impl Fn(usize) -> bool) -> Vec<usize> {
        let may_join = |n: &usize| self.degree(*n) <= 2 && counts(self.piece[*n]);
        let may_be = |bridge: &Bridge| bridge.probability >= LEAST_PROBABLE && bridge.nodes.iter().all(may_join);
        let mut order: Vec<usize> = (0..self.bridges.len()).filter(|b| may_be(&self.bridges[*b])).collect();
        order.sort_by(|a, b| self.bridges[*b].probability.total_cmp(&self.bridges[*a].probability).then(a.cmp(b)));
        let mut parts = UnionFind::<usize>::new(self.pieces);
        order.retain(|b| {
            let [x, y] = self.bridges[*b].nodes.map(|n| self.piece[n]);
            parts.union(x, y)
        });
        order
    }

    /// The nodes that `keeps` admits, without pieces of less than `least` mm, with the links and bridges between them.
    #[must_use]
    pub fn part(&self, keeps: impl Fn(usize) -> bool, least: f64) -> Self {
        let kept: Vec<bool> = (0..self.len()).map(keeps).collect();
        let part = self.selected(&kept);
        let mut length = vec![0.0; part.pieces];
        part.piece.iter().zip(&part.weight).for_each(|(piece, w)| length[*piece] += w);
        let long: Vec<bool> = part.piece.iter().map(|piece| length[*piece] >= least).collect();
        if long.contains(&false) { part.selected(&long) } else { part }
    }

    fn selected(&self, kept: &[bool]) -> Self {
        let rows: Vec<usize> = (0..self.len()).filter(|n| kept[*n]).collect();
        let new = placed(self.len(), rows.iter().copied());
        let both = |[a, b]: [usize; 2]| (kept[a] && kept[b]).then(|| [new[a], new[b]]);
        let mut part = Self {
            at: rows.iter().map(|n| self.at[*n]).collect(),
            log_radius: rows.iter().map(|n| self.log_radius[*n]).collect(),
            direction: rows.iter().map(|n| self.direction[*n]).collect(),
            neighbours: vec![Vec::new(); rows.len()],
            branch: rows.iter().map(|n| self.branch[*n]).collect(),
            branches: self.branches,
            place: rows.iter().map(|n| self.place[*n]).collect(),
            id: rows.iter().map(|n| self.id[*n]).collect(),
            links: self.links.iter().filter_map(|link| both(*link)).collect(),
            ..Self::default()
        };
        part.finish();
        part.bridges = self.bridges.iter().filter_map(|b| both(b.nodes).map(|nodes| Bridge { nodes, ..*b })).collect();
        part
    }
}

/// The points of a vessel from one of its nodes on, with their distance (mm) from its first.
fn points_of(network: &Network, row: usize, from: usize) -> Vec<(PathPoint, f64)> {
    let mut points = network.path_of(row);
    if network.vessel(row).path.len() < 2 {
        for (point, node) in points.iter_mut().zip(network.ends(row)) {
            point.id = network.node(node).id.parse().ok();
        }
    }
    let (mut before, mut along) = (None, 0.0);
    let placed = points.into_iter().map(|point| {
        along += before.replace(point.position).map_or(0.0, |before| millimetres(distance(before, point.position)));
        (point, along)
    });
    in_direction(placed.collect(), network.ends(row)[0] == from)
}

/// The point at a share of the way between two points.
fn between(a: &BranchPoint, b: &BranchPoint, share: f64) -> BranchPoint {
    let near = if share < 0.5 { a } else { b };
    let along =
        if a.place.vessel == b.place.vessel { a.place.along + share * (b.place.along - a.place.along) } else { near.place.along };
    BranchPoint {
        at: lerp(a.at, b.at, share),
        radius: a.radius + share * (b.radius - a.radius),
        id: near.id,
        place: VesselPlace { vessel: near.place.vessel, along },
    }
}

/// The candidates and contacts between traced vessels.
fn bridges(network: &Network, traced: &[bool], nodes: &Nodes, node_at: &[usize]) -> Vec<Bridge> {
    let untraced = network.vessels().enumerate().filter(|(row, _)| !traced[*row]);
    let found = untraced.filter_map(|(row, (ends, vessel))| {
        let [a, b] = ends.map(|end| node_at[end]);
        let probability = vessel.evidence().map_or(vessel.prior, |evidence| evidence.probability).min(MOST_PROBABLE);
        let bridge = || Bridge { nodes: [a, b], gap: distance(nodes.at[a], nodes.at[b]), probability, vessel: row };
        (a != usize::MAX && b != usize::MAX && a != b).then(bridge)
    });
    found.collect()
}
