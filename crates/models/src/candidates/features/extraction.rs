//! An extraction as a graph of points: what the image showed, before any candidate.

use super::branch_graph::BranchGraph;
use crate::candidates::search::point_index::PointIndex;
use willis_core::error::{Error, Result};
use willis_core::network::centerlines::is_radius;
use willis_core::network::paths::ShortestPaths;
use willis_core::network::{Network, Origin, PathPoint, Vessel, fragments, may_be_speck};
use willis_core::support::distinct;
use willis_core::support::geometry::{Point, distance, dot, sub, unit};
use willis_core::support::ties::steady;
use willis_io::masks::ScanCenterlines;

/// Vessels that may meet at one node: work grows with the square of their number.
const MOST_VESSELS: usize = 1000;

/// A point of a network: a node, or a point along a vessel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum NetworkPoint {
    /// A node, by row.
    Node(usize),
    /// A point of a vessel's path.
    Along {
        /// The vessel's row.
        vessel: usize,
        /// The point's place in its path.
        point: usize,
    },
}

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
    /// The length of the longest fragment, m.
    pub longest: f64,
    /// The radius of the widest free end, m; zero without one.
    pub widest_end: f64,
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

    /// The distance of two points in spacings, [`steady`].
    pub fn spacings(&self, a: usize, b: usize) -> f64 {
        steady(distance(self.position[a], self.position[b]) / self.spacing)
    }

    /// The points of a network's observed vessels, which lie so far (m, positive) apart; `inlets` are nodes where blood is known to enter.
    ///
    /// # Errors
    ///
    /// A node without a position, or where more than a thousand observed vessels meet.
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
        let mut degree = network.degrees(|v| v.origin == Origin::Observed);
        if let Some((node, degree)) = degree.iter().enumerate().find(|(_, degree)| **degree > MOST_VESSELS) {
            let (what, accepted) = (format!("where {degree} vessels meet"), format!("junctions of at most {MOST_VESSELS}"));
            return Err(Error::parameter(format!("node {}", network.node(node).id), what, format!("candidates need {accepted}")));
        }
        let junctions: Vec<usize> = (0..network.node_count()).filter(|n| degree[*n] > 2).collect();
        let observed = network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed);
        let parts = fragments(network, |_, v| v.origin == Origin::Observed);
        let mut place: Vec<NetworkPoint> = (0..network.node_count()).map(NetworkPoint::Node).collect();
        let mut radius: Vec<f64> = network.nodes().map(|n| n.radius.filter(|r| is_radius(*r)).unwrap_or(f64::NAN)).collect();
        let mut fragment = parts.of_node.clone();
        let (mut lines, mut vessels) = (Vec::new(), Vec::new());
        for (vessel, (ends, v)) in observed {
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
            vessels.push(v);
        }
        let graph = BranchGraph::new(network.node_count(), &lines, &position);
        // A node that no vessel reaches is a branch of its own, as thin as its surroundings can show.
        for node in (0..network.node_count()).filter(|node| degree[*node] == 0) {
            radius[node] = if radius[node] > 0.0 { radius[node] } else { 0.5 * spacing };
            lines.push(vec![node]);
        }
        let mut this = Self {
            branch: owners(&lines, &radius, &graph, place.len()),
            smooth: smooth(&lines, &degree, &position, &radius),
            shape: Vec::new(),
            to_junction: graph.to_nearest(&junctions),
            to_free_end: Vec::new(),
            ends: Vec::new(),
            end_at: vec![None; place.len()],
            at_border: vec![false; place.len()],
            inlets: distinct(inlets.iter().copied()),
            fragments: Vec::new(),
            longest: 0.0,
            widest_end: 0.0,
            index: PointIndex::new(position.clone()),
            place,
            position,
            radius,
            fragment,
            degree,
            lines,
            spacing,
            graph,
        };
        this.shape = this.branch_shapes();
        this.ends = this.free_ends(&vessels);
        for (row, end) in this.ends.iter().enumerate() {
            this.end_at[end.point] = Some(row);
        }
        this.to_free_end = this.graph.to_nearest(&this.ends.iter().map(|e| e.point).collect::<Vec<_>>());
        for node in (0..network.node_count()).filter(|node| network.node(*node).at_border) {
            let near = this.index.around(this.position[node], this.radius[node].max(spacing));
            for (_, point) in near.into_iter().filter(|(_, point)| this.fragment[*point] == this.fragment[node]) {
                this.at_border[point] = true;
            }
        }
        this.fragments = this.measured_fragments(parts.count);
        this.longest = this.fragments.iter().map(|f| f.length).fold(0.0, f64::max);
        this.widest_end = this.ends.iter().map(|end| end.radius).fold(0.0, f64::max);
        Ok(this)
    }

    /// The fragments, so many.
    fn measured_fragments(&self, count: usize) -> Vec<Fragment> {
        let mut out = vec![Fragment::default(); count];
        for (line, length) in self.lines.iter().zip(&self.graph.length) {
            out[self.fragment[line[0]]].length += length;
        }
        // Per fragment the mean over its points.
        let mean = |of: &dyn Fn(usize) -> f64| {
            let mut sums = vec![(0.0, 0.0); count];
            for (point, part) in self.fragment.iter().enumerate() {
                let (sum, points) = sums[*part];
                sums[*part] = (sum + of(point), points + 1.0);
            }
            sums.into_iter().map(|(sum, points)| sum / f64::max(points, 1.0)).collect::<Vec<f64>>()
        };
        let [radius, middle] = [&self.radius, &self.smooth.radius].map(|radius| mean(&|point| radius[point].ln()));
        let spread = mean(&|point| (self.smooth.radius[point].ln() - middle[self.fragment[point]]).powi(2));
        for (row, part) in out.iter_mut().enumerate() {
            (part.radius, part.radius_spread) = (radius[row].exp(), spread[row].sqrt());
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

    /// The free ends in node order. `vessels` are those of the first lines.
    fn free_ends(&self, vessels: &[&Vessel]) -> Vec<FreeEnd> {
        let arms: Vec<Vec<JunctionArm>> = (0..self.graph.nodes()).map(|node| self.arms(node)).collect();
        let mut paths = ShortestPaths::new(self.graph.nodes());
        let mut ends: Vec<FreeEnd> = Vec::new();
        for (branch, (line, vessel)) in self.lines.iter().zip(vessels).enumerate() {
            for last in [false, true] {
                let inwards = willis_core::support::arc_lengths::in_direction(line.clone(), !last);
                let point = inwards[0];
                if self.degree[point] != 1 {
                    continue;
                }
                let upto = |n: usize| &inwards[..n.min(inwards.len())];
                let mean = |n: usize| mean_log(&self.radius, upto(n)).exp();
                let direction = |n: usize| outwards(&upto(n).iter().map(|p| self.position[*p]).collect::<Vec<_>>());
                let radii = FIT_RADII * mean(FIT_SPACINGS as usize) / self.spacing;
                let n = steady(radii).round_ties_even().clamp(FIT_SPACINGS, FIT_POINTS) as usize;
                ends.push(FreeEnd {
                    point,
                    branch,
                    fragment: self.fragment[point],
                    direction: direction(n),
                    far_direction: direction(2 * n),
                    radius: mean(n),
                    mean_radius: vessel.end_radius(last),
                    orientation: self.orientation(point, &arms, &mut paths),
                });
            }
        }
        ends.sort_by_key(|end| end.point);
        ends
    }

    /// The orientation of the free end at a point: the mean, in [-1.5, 1.5], over the twelve junctions nearest along the vessels (and those as
    /// near as the twelfth) of how much better blood divides there if it comes from this end; 0 without a junction.
    fn orientation(&self, point: usize, arms: &[Vec<JunctionArm>], paths: &mut ShortestPaths) -> f64 {
        let (mut sum, mut count, mut last) = (0.0, 0, 0.0);
        self.graph.search(&[point], f64::INFINITY, paths, |length, node| {
            let away = steady(length[node] / self.spacing);
            let by = |(other, own, _): &JunctionArm| steady((length[*other] + own) / self.spacing);
            let order = |a: &JunctionArm, b: &JunctionArm| by(a).total_cmp(&by(b)).then(a.2.total_cmp(&b.2));
            if count >= JUNCTIONS && away > last {
                return false;
            }
            if let Some((_, _, preference)) = arms[node].iter().min_by(|a, b| order(a, b)) {
                (sum, count, last) = (sum + preference, count + 1, away);
            }
            true
        });
        if count > 0 { (sum / count as f64).clamp(-MOST, MOST) } else { 0.0 }
    }

    /// The branches at a junction; none at another node.
    fn arms(&self, node: usize) -> Vec<JunctionArm> {
        let headings = self.graph.headings(&self.lines, node);
        if headings.len() < 3 {
            return Vec::new();
        }
        let position = |point: usize| self.smooth.position[point];
        let steps = self.steps(ARM, node);
        let directions: Vec<Point> =
            headings.iter().map(|heading| unit(sub(position(heading.walk(steps)), position(node)))).collect();
        let others = |own: usize| (0..headings.len()).filter(move |other| *other != own);
        let least = |own| others(own).map(|other| -dot(directions[own], directions[other])).fold(f64::INFINITY, f64::min);
        let forwards: Vec<f64> = (0..headings.len()).map(least).collect();
        let arm = |own: usize| {
            let preference = forwards[own] - others(own).map(|other| forwards[other]).fold(f64::NEG_INFINITY, f64::max);
            (headings[own].walk(usize::MAX / 2), self.graph.length[headings[own].branch], preference)
        };
        (0..headings.len()).map(arm).collect()
    }

    /// So many radii at a point in points, within bounds.
    fn steps(&self, (radii, [least, most]): (f64, [f64; 2]), point: usize) -> usize {
        steady(radii * self.smooth.radius[point] / self.spacing).round_ties_even().clamp(least, most) as usize
    }

    /// The shape of the branches at each point.
    fn branch_shapes(&self) -> Vec<BranchShape> {
        let mut out = vec![BranchShape::default(); self.radius.len()];
        let direction = |from: usize, to: usize| unit(sub(self.smooth.position[to], self.smooth.position[from]));
        for line in &self.lines {
            for (at, point) in line.iter().enumerate().take(line.len() - 1).skip(1) {
                let [near, side] = [NEAR, SIDE].map(|window| {
                    let steps = self.steps(window, *point);
                    [at.saturating_sub(steps), (at + steps).min(line.len() - 1)]
                });
                let [[from, onwards], [far_from, far_onwards]] =
                    [near, side].map(|[first, last]| [direction(line[first], *point), direction(*point, line[last])]);
                // A side of one point has but that one.
                let behind = mean_log(&self.radius, &line[side[0]..(at - 1).max(side[0] + 1)]);
                let ahead = mean_log(&self.radius, &line[(at + 2).min(side[1])..=side[1]]);
                out[*point] = BranchShape {
                    tangent: unit([0, 1, 2].map(|axis| from[axis] + onwards[axis])),
                    kink: sub(onwards, from),
                    far_kink: sub(far_onwards, far_from),
                    narrowing: (behind - ahead).clamp(-1.0, 1.0),
                };
            }
        }
        out
    }
}

/// The branch of each point: of the branches at a node the widest by mean radius, then the longest, then the first.
fn owners(lines: &[Vec<usize>], radius: &[f64], graph: &BranchGraph, points: usize) -> Vec<usize> {
    let mut owner = vec![usize::MAX; points];
    let mut best = vec![[f64::NEG_INFINITY; 2]; points];
    for (branch, line) in lines.iter().enumerate() {
        let rank = [steady(mean_log(radius, line).exp()), graph.length.get(branch).map_or(0.0, |l| steady(*l))];
        for point in line {
            if owner[*point] == usize::MAX || rank > best[*point] {
                (owner[*point], best[*point]) = (branch, rank);
            }
        }
    }
    owner
}

/// The mean of ln of the radii (m) of some points.
pub fn mean_log(radius: &[f64], points: &[usize]) -> f64 {
    points.iter().map(|p| radius[*p].ln()).sum::<f64>() / points.len() as f64
}

/// What may be a speck is joined over no gap wider than so many of its lengths.
const SPECK_REACH: f64 = 2.0;

/// A connected part of what the image showed.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fragment {
    /// The length of its vessels, m.
    pub length: f64,
    /// The geometric mean of its points' radii, m.
    pub radius: f64,
    /// The radius of its widest free end, m.
    pub widest_end: Option<f64>,
    /// The standard deviation of ln of its points' radii, averaged along the branches.
    pub radius_spread: f64,
    /// How many free ends it has.
    pub free_ends: usize,
    /// How many junctions it has.
    pub junctions: usize,
    /// Whether it holds an inlet.
    pub fed: bool,
}

impl Fragment {
    /// The widest gap (m) over which an automatic skeleton's fragment may be joined; infinite but for what may be a speck.
    pub fn reach(&self) -> f64 {
        if may_be_speck(self.length, 2.0 * self.radius) { SPECK_REACH * self.length } else { f64::INFINITY }
    }

    /// The radius (m) of its widest free end, half a spacing at least.
    pub fn end_radius(&self, spacing: f64) -> f64 {
        self.widest_end.unwrap_or(0.0).max(0.5 * spacing)
    }
}

/// The direction is fitted over so many points at least, so many radii, and so many points at most.
const FIT_SPACINGS: f64 = 6.0;
const FIT_RADII: f64 = 3.0;
const FIT_POINTS: f64 = 40.0;

/// A free end.
pub struct FreeEnd {
    /// Its point, a node.
    pub point: usize,
    /// Its branch.
    pub branch: usize,
    /// Its fragment.
    pub fragment: usize,
    /// Unit vector out of the vessel, fitted over the larger of 6 spacings and 3 radii; zero where the vessel gives none.
    pub direction: Point,
    /// The same over twice that length.
    pub far_direction: Point,
    /// Geometric mean of the radii over the fit, m: the width that the evidence measures with.
    pub radius: f64,
    /// [`Vessel::end_radius`], m: the width of candidates that are built without evidence.
    pub mean_radius: f64,
    /// How much better blood divides at the fragment's junctions if it comes from this end, in [-1.5, 1.5]: positive where the
    /// fragment is fed through this end. 0 without a junction.
    pub orientation: f64,
}

/// The direction of the least-squares line through points taken as equally spaced, towards the first.
fn outwards(points: &[Point]) -> Point {
    let middle = 0.5 * (points.len() as f64 - 1.0);
    let mut v = [0.0; 3];
    for (i, p) in points.iter().enumerate() {
        let from_first = sub(*p, points[0]);
        for axis in 0..3 {
            v[axis] += (middle - i as f64) * from_first[axis];
        }
    }
    unit(v)
}

/// The branches at a junction are followed over so many of its radii, within so many points.
const ARM: (f64, [f64; 2]) = (3.0, [4.0, 12.0]);
/// The orientation is the mean over so many junctions, the nearest along the vessels.
const JUNCTIONS: usize = 12;
/// Bound of the orientation.
const MOST: f64 = 1.5;

/// A branch at a junction: the node at its other end, its length (m), and J of it less the largest J of the others; J, if blood came by this
/// branch, is the least cosine between the direction it came in and those it leaves by.
type JunctionArm = (usize, f64, f64);

/// Rounds of averaging: a kernel of so many points to either side.
const RADIUS_ROUNDS: usize = 3;
const POSITION_ROUNDS: usize = 2;

/// Radii and positions averaged along the branches, against the jitter of single points.
pub struct SmoothPoints {
    /// Geometric means over three neighbours to either side, through junctions, m.
    pub radius: Vec<f64>,
    /// Means over two neighbours to either side; junctions and ends stay, m.
    pub position: Vec<Point>,
}

/// Averages points with their neighbours: x ← x/2 + (mean over the neighbours)/2, round by round.
fn smooth(lines: &[Vec<usize>], degree: &[usize], position: &[Point], radius: &[f64]) -> SmoothPoints {
    let averaged = |mut x: Vec<Point>, rounds: usize, moves: fn(usize) -> bool| {
        for _ in 0..rounds {
            let mut sum = vec![[0.0; 3]; x.len()];
            for pair in lines.iter().flat_map(|line| line.windows(2)) {
                for (to, from) in [(pair[0], pair[1]), (pair[1], pair[0])] {
                    for axis in 0..3 {
                        sum[to][axis] += x[from][axis];
                    }
                }
            }
            for point in (0..x.len()).filter(|p| moves(degree[*p])) {
                for axis in 0..3 {
                    x[point][axis] = 0.5 * x[point][axis] + 0.5 * sum[point][axis] / degree[point] as f64;
                }
            }
        }
        x
    };
    let logs = averaged(radius.iter().map(|r| [r.ln(), 0.0, 0.0]).collect(), RADIUS_ROUNDS, |degree| degree > 0);
    let position = averaged(position.to_vec(), POSITION_ROUNDS, |degree| degree == 2);
    SmoothPoints { radius: logs.into_iter().map(|[log, ..]| log.exp()).collect(), position }
}

/// Tangents and kinks are taken over so many radii to either side, within so many points ...
const NEAR: (f64, [f64; 2]) = (1.5, [2.0, 12.0]);
/// ... and what the two sides are as a whole over so many.
const SIDE: (f64, [f64; 2]) = (4.0, [5.0, 14.0]);

/// How a branch runs at a point; all zero at its nodes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BranchShape {
    /// Unit tangent towards the last node of the branch.
    pub tangent: Point,
    /// The unit direction onwards minus the unit direction from behind, in [0, 2]: it points to the inside of the bend. Taken
    /// over 1.5 radii, 2 to 12 points.
    pub kink: Point,
    /// The same over 4 radii, 5 to 14 points.
    pub far_kink: Point,
    /// ln of the mean radius on the side of the branch's first node over that on the other, in [-1, 1]: over 4 radii, without
    /// the points next to this one.
    pub narrowing: f64,
}
