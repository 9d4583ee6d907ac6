//! An extraction as a graph of points: what the image showed, before any candidate.

use std::collections::BTreeSet;

use super::branch_graph::BranchGraph;
use super::fragment::{Fragment, Largest};
use super::orientation::set_orientations;
use super::smoothing::{SmoothPoints, smooth};
use super::tangent::{BranchShape, branch_shapes};
use crate::candidates::network_point::NetworkPoint;
use crate::candidates::search::free_ends::{FreeEnd, free_ends};
use crate::candidates::search::limits::check_junctions;
use crate::candidates::search::point_index::PointIndex;
use willis_core::error::{Error, Result};
use willis_core::network::centerlines::is_radius;
use willis_core::network::{Network, Origin, PathPoint, Vessel, fragments};
use willis_core::support::geometry::Point;
use willis_core::support::ties::steady;
use willis_io::masks::ScanCenterlines;

/// The points of the observed vessels of a network with what the search and the features need of them. Lengths in m.
///
/// The first points are the network's nodes, in order; the inner points of the observed vessels follow. A *branch* is an
/// observed vessel, or a node without one. A node belongs to its widest branch, of equally wide ones to the longest.
pub struct Extraction {
    /// Where a point is in the network.
    pub place: Vec<NetworkPoint>,
    /// Positions, m.
    pub position: Vec<Point>,
    /// Radii as measured, m, positive.
    pub radius: Vec<f64>,
    /// Radii (m) and positions (m) averaged along the branch.
    pub smooth: SmoothPoints,
    /// The branch of each point.
    pub branch: Vec<usize>,
    /// The fragment of each point, as [`fragments`] numbers those of the observed vessels.
    pub fragment: Vec<usize>,
    /// Links of each point.
    pub degree: Vec<usize>,
    /// Tangent, kinks and narrowing at each point.
    pub shape: Vec<BranchShape>,
    /// Path length to the nearest free end of the fragment, m; infinite without one.
    pub to_free_end: Vec<f64>,
    /// Path length to the nearest junction of the fragment, m; infinite without one.
    pub to_junction: Vec<f64>,
    /// The points of each branch in order, its nodes among them.
    pub lines: Vec<Vec<usize>>,
    /// The free ends in node order.
    pub ends: Vec<FreeEnd>,
    /// Per point its free end; `None` elsewhere.
    pub end_at: Vec<Option<usize>>,
    /// Whether a point is where a vessel leaves the image, or on that vessel and nearer to the place than it is wide.
    pub at_border: Vec<bool>,
    /// The nodes where blood is known to enter, in rising order.
    pub inlets: Vec<usize>,
    /// The fragments.
    pub fragments: Vec<Fragment>,
    /// The largest figures of its fragments and free ends.
    pub largest: Largest,
    /// The distance between consecutive points, m, positive.
    pub spacing: f64,
    /// The branches as a graph.
    pub graph: BranchGraph,
    pub(crate) index: PointIndex,
}

impl Extraction {
    /// What an image is measured by: positions, averaged radii, branches.
    pub fn centerlines(&self) -> ScanCenterlines<'_> {
        ScanCenterlines { position: &self.position, radius: &self.smooth.radius, lines: &self.lines, spacing: self.spacing }
    }

    /// The radius (m) at a point that the evidence measures with: that of the free end there, else the averaged one.
    pub fn radius_at(&self, point: usize) -> f64 {
        self.end_at[point].map_or(self.smooth.radius[point], |end| self.ends[end].radius)
    }

    /// The points of a network's observed vessels, which lie so far (m, positive) apart; `inlets` are nodes where blood is known to enter.
    ///
    /// # Errors
    ///
    /// A node without a position.
    ///
    /// # Panics
    ///
    /// When an inlet is no node.
    pub fn new(network: &Network, inlets: &[usize], spacing: f64) -> Result<Self> {
        let mut position = Vec::with_capacity(network.node_count());
        for node in network.nodes() {
            position.push(node.position.ok_or_else(|| {
                let what = "candidates need the position of every node";
                Error::parameter(format!("node {}", node.id), "without coordinates", what)
            })?);
        }
        check_junctions(network)?;
        let observed: Vec<(usize, ([usize; 2], &Vessel))> =
            network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed).collect();
        let parts = fragments(network, |_, v| v.origin == Origin::Observed);
        let mut degree = network.degrees(|v| v.origin == Origin::Observed);
        let mut place: Vec<NetworkPoint> = (0..network.node_count()).map(NetworkPoint::Node).collect();
        let mut radius: Vec<f64> = network.nodes().map(|n| n.radius.filter(|r| is_radius(*r)).unwrap_or(f64::NAN)).collect();
        let mut fragment = parts.of_node.clone();
        let mut lines = Vec::with_capacity(observed.len());
        for (vessel, (ends, v)) in observed.iter().copied() {
            let mut line = vec![ends[0]];
            for (point, at) in v.path.iter().enumerate().take(v.path.len().saturating_sub(1)).skip(1) {
                line.push(place.len());
                place.push(NetworkPoint::Along { vessel, point });
                position.push(at.position);
                radius.push(at.radius);
                fragment.push(parts.of_node[ends[0]]);
                degree.push(2);
            }
            line.push(ends[1]);
            for (node, at) in [(ends[0], v.path.first()), (ends[1], v.path.last())] {
                if radius[node].is_nan() {
                    radius[node] = at.map_or(v.radius, |p: &PathPoint| p.radius);
                }
            }
            lines.push(line);
        }
        let graph = BranchGraph::new(network.node_count(), &lines, &position);
        // A node that no vessel reaches is a branch of its own, as thin as its surroundings can show.
        for node in (0..network.node_count()).filter(|node| degree[*node] == 0) {
            radius[node] = if radius[node] > 0.0 { radius[node] } else { 0.5 * spacing };
            lines.push(vec![node]);
        }
        let branch = owners(&lines, &radius, &graph, place.len());
        let smooth = smooth(&lines, &degree, &position, &radius);
        let vessels: Vec<&Vessel> = observed.iter().map(|(_, (_, vessel))| *vessel).collect();
        let mut ends = free_ends(&lines, &vessels, [&fragment, &degree], &position, &radius, spacing);
        set_orientations(&mut ends, &graph, &lines, &smooth, spacing);
        let mut end_at = vec![None; place.len()];
        for (row, end) in ends.iter().enumerate() {
            end_at[end.point] = Some(row);
        }
        let junctions: Vec<usize> = (0..network.node_count()).filter(|n| degree[*n] > 2).collect();
        let shape = branch_shapes(&lines, &smooth, &radius, spacing);
        let inlets: Vec<usize> = inlets.iter().copied().collect::<BTreeSet<_>>().into_iter().collect();
        let mut this = Self {
            to_free_end: graph.to_nearest(&ends.iter().map(|e| e.point).collect::<Vec<_>>()),
            to_junction: graph.to_nearest(&junctions),
            fragments: Vec::new(),
            largest: Largest::default(),
            at_border: vec![false; place.len()],
            inlets,
            index: PointIndex::new(position.clone()),
            place,
            position,
            radius,
            smooth,
            branch,
            fragment,
            degree,
            shape,
            lines,
            ends,
            end_at,
            spacing,
            graph,
        };
        this.mark_border(network);
        this.fragments = this.measured_fragments(parts.count);
        this.largest = Largest::of(&this.fragments, &this.ends, spacing);
        Ok(this)
    }

    /// Marks the points at the ends where vessels leave the image.
    fn mark_border(&mut self, network: &Network) {
        for node in (0..network.node_count()).filter(|node| network.node(*node).at_border) {
            let near = self.index.around(self.position[node], self.radius[node].max(self.spacing));
            for (_, point) in near.into_iter().filter(|(_, point)| self.fragment[*point] == self.fragment[node]) {
                self.at_border[point] = true;
            }
        }
    }

    /// The fragments, so many.
    fn measured_fragments(&self, count: usize) -> Vec<Fragment> {
        let mut out = vec![Fragment::default(); count];
        for (line, length) in self.lines.iter().zip(&self.graph.length) {
            out[self.fragment[line[0]]].length += length;
        }
        let mut points = vec![0.0; count];
        for (part, radius) in self.fragment.iter().zip(&self.radius) {
            out[*part].radius += radius.ln();
            points[*part] += 1.0;
        }
        for ((part, points), spread) in out.iter_mut().zip(&points).zip(self.radius_spreads(&points)) {
            (part.radius, part.radius_spread) = (f64::exp(part.radius / f64::max(*points, 1.0)), spread);
        }
        for (node, degree) in self.degree.iter().enumerate() {
            out[self.fragment[node]].junctions += usize::from(*degree > 2);
        }
        for end in &self.ends {
            let widest = &mut out[end.fragment].widest_end;
            *widest = Some(widest.map_or(end.radius, |r: f64| r.max(end.radius)));
            out[end.fragment].free_ends += 1;
        }
        for inlet in &self.inlets {
            out[self.fragment[*inlet]].fed = true;
        }
        out
    }

    /// Per fragment the standard deviation of ln of the smooth radii of its so many points.
    fn radius_spreads(&self, points: &[f64]) -> Vec<f64> {
        let mean = |of: &dyn Fn(usize, f64) -> f64| {
            let mut sum = vec![0.0; points.len()];
            for (part, radius) in self.fragment.iter().zip(&self.smooth.radius) {
                sum[*part] += of(*part, radius.ln());
            }
            sum.iter().zip(points).map(|(sum, points)| sum / f64::max(*points, 1.0)).collect::<Vec<f64>>()
        };
        let middle = mean(&|_, log| log);
        mean(&|part, log| (log - middle[part]).powi(2)).into_iter().map(f64::sqrt).collect()
    }
}

/// The branch of each point: of the branches at a node the widest by mean radius, then the longest, then the first.
fn owners(lines: &[Vec<usize>], radius: &[f64], graph: &BranchGraph, points: usize) -> Vec<usize> {
    let mut owner = vec![usize::MAX; points];
    let mut best = vec![[f64::NEG_INFINITY; 2]; points];
    for (branch, line) in lines.iter().enumerate() {
        let mean = line.iter().map(|p| radius[*p].ln()).sum::<f64>() / line.len() as f64;
        let rank = [steady(mean.exp()), graph.length.get(branch).map_or(0.0, |l| steady(*l))];
        for point in line {
            if owner[*point] == usize::MAX || rank > best[*point] {
                (owner[*point], best[*point]) = (branch, rank);
            }
        }
    }
    owner
}
