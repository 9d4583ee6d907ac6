//! The targets of a free end: the nearest branches, each at the point that is close and straight ahead, and the nearest
//! free ends.

use std::collections::BTreeMap;

use super::ends::{BEND, FreeEnd, SNAP_SPACINGS, point_spacing, reach};
use super::knn::PointIndex;
use super::{Attach, Looks, Params, Place, Site};
use crate::geometry::{Point, distance, dot, norm_squared, sub};
use crate::network::{Network, Origin};

/// The search for targets begins this far away, in point spacings, or at this share of the reach, and widens by this factor.
const FIRST_SPACINGS: f64 = 2.0;
const FIRST_SHARE: f64 = 0.02;
const WIDENING: f64 = 1.5;

/// Where a candidate leaves and where it arrives.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// The free end, with its mean radius.
    pub from: Site,
    /// The place it reaches.
    pub site: Site,
}

/// What lies around the free ends of a network.
pub struct Surroundings<'a> {
    network: &'a Network,
    /// The nodes in order, then the inner points of the observed vessels.
    sites: Vec<Site>,
    index: PointIndex,
    /// Per vessel the site of its first inner point.
    first_inner: Vec<usize>,
    /// Per node its observed vessels.
    incident: Vec<Vec<usize>>,
    /// The median distance between consecutive points, m.
    pub spacing: f64,
}

impl<'a> Surroundings<'a> {
    /// Indexes a network whose nodes all have positions.
    pub fn new(network: &'a Network) -> Self {
        let sites = sites(network);
        let index = PointIndex::new(sites.iter().map(|s| s.position).collect());
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
        Self { network, sites, index, first_inner, incident, spacing: point_spacing(network) }
    }

    /// The k nearest targets of a free end, nearest first, ties in the order of the sites.
    ///
    /// The search widens until k targets are nearer than anything beyond it, so that its cost goes with k and not with
    /// the reach. The nearest site of a branch settles where the branch comes, and every target is the nearest of its branches.
    ///
    /// No targets once `looks` says that there were too many.
    pub fn targets(&self, end: &FreeEnd, params: &Params, looks: &Looks) -> Vec<Target> {
        let reach = reach(self.spacing, end.radius);
        let reach = params.max_gap.map_or(reach, |most| reach.min(most));
        let mut radius = reach.min(FIRST_SPACINGS * self.spacing).max(FIRST_SHARE * reach);
        let mut order = self.found(end, radius, reach, params.attach, looks);
        while order.len() < params.k && radius < reach {
            radius = reach.min(WIDENING * radius);
            order = self.found(end, radius, reach, params.attach, looks);
        }
        order.truncate(params.k);
        let from = Site { place: Place::Node(end.node), position: end.position, radius: end.radius };
        order.into_iter().map(|(_, site)| Target { from, site: self.with_end_radius(self.sites[site]) }).collect()
    }

    /// The targets no further than `radius`, by distance and site.
    fn found(&self, end: &FreeEnd, radius: f64, reach: f64, attach: Attach, looks: &Looks) -> Vec<(f64, usize)> {
        let own = self.network.ends(end.vessel);
        let is_own = |place: Place| match place {
            Place::Node(node) => own.contains(&node),
            Place::Along { vessel, .. } => vessel == end.vessel,
        };
        if !looks.add(0) {
            return Vec::new();
        }
        let mut hits = self.index.within(end.position, radius);
        looks.add(hits.len());
        hits.retain(|(_, site)| !is_own(self.sites[*site].place));
        let mut found: BTreeMap<usize, f64> = BTreeMap::new();
        for (distance, site) in &hits {
            if matches!(self.sites[*site].place, Place::Node(node) if self.is_free(node)) {
                found.insert(*site, *distance);
            }
        }
        if attach == Attach::Centerline {
            for (vessel, nearest) in self.branches(&hits, end.vessel) {
                let site = self.snapped(self.meet(vessel, nearest.1, end, reach), vessel, end, reach);
                let distance = found.entry(site).or_insert(nearest.0);
                *distance = distance.min(nearest.0);
            }
        }
        let mut order: Vec<(f64, usize)> = found.into_iter().map(|(site, distance)| (distance, site)).collect();
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
            match self.sites[hit.1].place {
                Place::Along { vessel, .. } => {
                    branches.entry(vessel).or_insert(*hit);
                }
                Place::Node(node) => {
                    for vessel in self.incident[node].iter().filter(|vessel| **vessel != own) {
                        branches.entry(*vessel).or_insert(*hit);
                    }
                }
            }
        }
        branches
    }

    /// The site of a branch within reach that makes d (1.3 - cos) least; none of the nodes of the end's own vessel.
    fn meet(&self, branch: usize, nearest: usize, end: &FreeEnd, reach: f64) -> usize {
        let own = self.network.ends(end.vessel);
        let first = self.first_inner[branch];
        let inner = first..first + self.network.vessel(branch).path.len().saturating_sub(2);
        let nodes = self.network.ends(branch).into_iter().filter(|node| !own.contains(node));
        let mut best = (f64::INFINITY, nearest);
        for site in nodes.chain(inner) {
            let ahead = sub(self.sites[site].position, end.position);
            let squared = norm_squared(ahead);
            if squared <= reach * reach {
                let cost = BEND * squared.sqrt() - dot(ahead, end.direction);
                if cost.total_cmp(&best.0).then(site.cmp(&best.1)).is_lt() {
                    best = (cost, site);
                }
            }
        }
        best.1
    }

    /// The free end of the branch when the meeting point is near it.
    fn snapped(&self, meeting: usize, vessel: usize, from: &FreeEnd, reach: f64) -> usize {
        // The sites begin with the nodes, in order.
        let within = |node: usize, p: Point, most: f64| distance(self.sites[node].position, p) <= most;
        let near = |node: usize| {
            within(node, self.sites[meeting].position, SNAP_SPACINGS * self.spacing) && within(node, from.position, reach)
        };
        let ends = self.network.ends(vessel).into_iter();
        ends.filter(|node| self.is_free(*node) && *node != from.node).find(|node| near(*node)).unwrap_or(meeting)
    }

    /// A free end's radius is the mean over its last points.
    fn with_end_radius(&self, mut site: Site) -> Site {
        if let Place::Node(node) = site.place
            && (self.is_free(node) || self.network.node(node).radius.is_none())
        {
            let ends = self.incident[node].iter().map(|v| self.network.vessel(*v).end_radius(self.network.ends(*v)[1] == node));
            site.radius = ends.reduce(f64::min).unwrap_or(site.radius);
        }
        site
    }
}

/// The nodes of a network, then the inner points of its observed vessels.
fn sites(network: &Network) -> Vec<Site> {
    let nodes = network
        .nodes()
        .enumerate()
        .filter_map(|(row, n)| Some(Site { place: Place::Node(row), position: n.position?, radius: n.radius.unwrap_or(0.0) }));
    let mut sites: Vec<Site> = nodes.collect();
    for (vessel, (_, v)) in network.vessels().enumerate().filter(|(_, (_, v))| v.origin == Origin::Observed) {
        let inner = 1..v.path.len().saturating_sub(1);
        sites.extend(inner.map(|point| Site {
            place: Place::Along { vessel, point },
            position: v.path[point].position,
            radius: v.path[point].radius,
        }));
    }
    sites
}
