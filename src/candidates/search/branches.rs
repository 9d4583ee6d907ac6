//! The targets of a free end: the nearest branches, each at the point that is close and straight ahead, and the nearest
//! free ends.

use std::collections::BTreeMap;

use super::free_ends::{BEND, FreeEnd, SNAP_SPACINGS, point_spacing, reach};
use super::limits::Looks;
use super::neighbours::PointIndex;
use crate::candidates::{Anchor, Attach, CandidateOptions, NEAREST, NetworkPoint};
use crate::network::{Network, Origin};
use crate::support::geometry::{Point, distance, dot, norm_squared, sub};

/// The search for targets begins this far away, in point spacings, or at this share of the reach, and widens by this factor.
const FIRST_SPACINGS: f64 = 2.0;
const FIRST_SHARE: f64 = 0.02;
const WIDENING: f64 = 1.5;

/// Where a candidate leaves and where it arrives.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The free end, with its mean radius.
    pub from: Anchor,
    /// The place it reaches.
    pub to: Anchor,
}

/// What lies around the free ends of a network.
pub struct Surroundings<'a> {
    network: &'a Network,
    /// The nodes in order, then the inner points of the observed vessels.
    anchors: Vec<Anchor>,
    index: PointIndex,
    /// Per vessel the anchor of its first inner point.
    first_inner: Vec<usize>,
    /// Per node its observed vessels.
    incident: Vec<Vec<usize>>,
    /// The median distance between consecutive points, m.
    pub spacing: f64,
}

impl<'a> Surroundings<'a> {
    /// Indexes a network whose nodes all have positions.
    pub fn new(network: &'a Network) -> Self {
        let anchors = anchors(network);
        let index = PointIndex::new(anchors.iter().map(|s| s.position).collect());
        let mut first_inner = Vec::with_capacity(network.vessel_count());
        let mut next = network.node_count();
        for (_, vessel) in network.vessels() {
            first_inner.push(next);
            next += if vessel.origin == Origin::Observed { vessel.path.len().saturating_sub(2) } else { 0 };
        }
        let mut incident = vec![Vec::new(); network.node_count()];
        for (vessel, (ends, _)) in network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed) {
            incident[ends[0]].push(vessel);
            incident[ends[1]].push(vessel);
        }
        Self { network, anchors, index, first_inner, incident, spacing: point_spacing(network) }
    }

    /// The k nearest targets of a free end, nearest first, ties in the order of the anchors.
    ///
    /// The search widens until k targets are nearer than anything beyond it, so that its cost goes with k and not with
    /// the reach. The nearest anchor of a branch settles where the branch comes, and every target is the nearest of its branches.
    ///
    /// No targets once `looks` says that there were too many.
    pub fn targets(&self, end: &FreeEnd, params: &CandidateOptions, looks: &Looks) -> Vec<Target> {
        let k = params.k.unwrap_or(NEAREST);
        let reach = reach(self.spacing, end.radius);
        let reach = params.max_gap.map_or(reach, |most| reach.min(most));
        let mut radius = reach.min(FIRST_SPACINGS * self.spacing).max(FIRST_SHARE * reach);
        let mut order = self.found(end, radius, reach, params.attach, looks);
        while order.len() < k && radius < reach {
            radius = reach.min(WIDENING * radius);
            order = self.found(end, radius, reach, params.attach, looks);
        }
        order.truncate(k);
        let from = Anchor { place: NetworkPoint::Node(end.node), position: end.position, radius: end.radius };
        order.into_iter().map(|(_, anchor)| Target { from, to: self.with_end_radius(self.anchors[anchor]) }).collect()
    }

    /// The targets no further than `radius`, by distance and anchor.
    fn found(&self, end: &FreeEnd, radius: f64, reach: f64, attach: Attach, looks: &Looks) -> Vec<(f64, usize)> {
        let own = self.network.ends(end.vessel);
        let is_own = |place: NetworkPoint| match place {
            NetworkPoint::Node(node) => own.contains(&node),
            NetworkPoint::Along { vessel, .. } => vessel == end.vessel,
        };
        if !looks.add(0) {
            return Vec::new();
        }
        let mut hits = self.index.within(end.position, radius);
        looks.add(hits.len());
        hits.retain(|(_, anchor)| !is_own(self.anchors[*anchor].place));
        let mut found: BTreeMap<usize, f64> = BTreeMap::new();
        for (distance, anchor) in &hits {
            if matches!(self.anchors[*anchor].place, NetworkPoint::Node(node) if self.is_free(node)) {
                found.insert(*anchor, *distance);
            }
        }
        if attach == Attach::Centerline {
            for (vessel, nearest) in self.branches(&hits, end.vessel) {
                let anchor = self.snapped(self.meet(vessel, nearest.1, end, reach), vessel, end, reach);
                let distance = found.entry(anchor).or_insert(nearest.0);
                *distance = distance.min(nearest.0);
            }
        }
        let mut order: Vec<(f64, usize)> = found.into_iter().map(|(anchor, distance)| (distance, anchor)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order
    }

    fn is_free(&self, node: usize) -> bool {
        self.incident[node].len() == 1
    }

    /// The vessels that were hit, each with its nearest hit.
    fn branches(&self, hits: &[(f64, usize)], own: usize) -> BTreeMap<usize, (f64, usize)> {
        let mut branches = BTreeMap::new();
        for hit in hits {
            match self.anchors[hit.1].place {
                NetworkPoint::Along { vessel, .. } => {
                    branches.entry(vessel).or_insert(*hit);
                }
                NetworkPoint::Node(node) => {
                    for vessel in self.incident[node].iter().filter(|vessel| **vessel != own) {
                        branches.entry(*vessel).or_insert(*hit);
                    }
                }
            }
        }
        branches
    }

    /// The anchor of a branch within reach that makes d (1.3 - cos) least; none of the nodes of the end's own vessel.
    fn meet(&self, branch: usize, nearest: usize, end: &FreeEnd, reach: f64) -> usize {
        let own = self.network.ends(end.vessel);
        let first = self.first_inner[branch];
        let inner = first..first + self.network.vessel(branch).path.len().saturating_sub(2);
        let nodes = self.network.ends(branch).into_iter().filter(|node| !own.contains(node));
        let mut best = (f64::INFINITY, nearest);
        for anchor in nodes.chain(inner) {
            let ahead = sub(self.anchors[anchor].position, end.position);
            let squared = norm_squared(ahead);
            if squared <= reach * reach {
                let cost = BEND * squared.sqrt() - dot(ahead, end.direction);
                if cost.total_cmp(&best.0).then(anchor.cmp(&best.1)).is_lt() {
                    best = (cost, anchor);
                }
            }
        }
        best.1
    }

    /// The free end of the branch when the meeting point is near it.
    fn snapped(&self, meeting: usize, vessel: usize, from: &FreeEnd, reach: f64) -> usize {
        // The anchors begin with the nodes, in order.
        let within = |node: usize, p: Point, most: f64| distance(self.anchors[node].position, p) <= most;
        let near = |node: usize| {
            within(node, self.anchors[meeting].position, SNAP_SPACINGS * self.spacing) && within(node, from.position, reach)
        };
        let ends = self.network.ends(vessel).into_iter();
        ends.filter(|node| self.is_free(*node) && *node != from.node).find(|node| near(*node)).unwrap_or(meeting)
    }

    /// A free end's radius is the mean over its last points.
    fn with_end_radius(&self, mut anchor: Anchor) -> Anchor {
        if let NetworkPoint::Node(node) = anchor.place
            && (self.is_free(node) || self.network.node(node).radius.is_none())
        {
            let ends = self.incident[node].iter().map(|v| self.network.vessel(*v).end_radius(self.network.ends(*v)[1] == node));
            anchor.radius = ends.reduce(f64::min).unwrap_or(anchor.radius);
        }
        anchor
    }
}

/// The nodes of a network, then the inner points of its observed vessels.
fn anchors(network: &Network) -> Vec<Anchor> {
    let nodes = network.nodes().enumerate().filter_map(|(row, n)| {
        Some(Anchor { place: NetworkPoint::Node(row), position: n.position?, radius: n.radius.unwrap_or(0.0) })
    });
    let mut anchors: Vec<Anchor> = nodes.collect();
    for (vessel, (_, v)) in network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed) {
        let inner = 1..v.path.len().saturating_sub(1);
        anchors.extend(inner.map(|point| Anchor {
            place: NetworkPoint::Along { vessel, point },
            position: v.path[point].position,
            radius: v.path[point].radius,
        }));
    }
    anchors
}
