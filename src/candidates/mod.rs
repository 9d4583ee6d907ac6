//! Candidate connections: from fragments to the over-connected graph.

mod by_evidence;
pub mod features;
pub mod model;
pub mod search;
mod split;

pub use by_evidence::build_probable;

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::network::units::{as_stored, millimetres};
use crate::network::{Evidence, Network, Origin, PathPoint, RadiusRule, Vessel};
use crate::support::geometry::{Point, distance};
use crate::support::parallel::in_order;
use search::branches::{Surroundings, Target};
use search::free_ends::free_ends;
use search::limits::{Looks, check_junctions};
use split::{Cuts, split};

/// Where a candidate may end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Attach {
    /// On the centerline of any vessel, split there, or on a free end.
    #[default]
    Centerline,
    /// On free ends only.
    Ends,
}

/// How a candidate's radius comes from the radii at its two ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CandidateRadius {
    /// The smaller one.
    #[default]
    Min,
    /// Their mean.
    Mean,
}

/// How candidates are built.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CandidateOptions {
    /// Nearest branches and free ends that every free end is joined to, at least 1; by default 6, by evidence 5 branches and four free ends
    /// beside them.
    pub k: Option<usize>,
    /// The longest gap to bridge, m, positive; without it 20 point spacings + 5 end diameters alone limit the reach.
    #[serde(rename = "max_gap_m")]
    pub max_gap: Option<f64>,
    /// Where a candidate may end.
    pub attach: Attach,
    /// How its radius comes about.
    #[serde(rename = "candidate_radius")]
    pub radius: CandidateRadius,
    /// The largest radius of a candidate, m, positive.
    #[serde(rename = "max_candidate_radius_m")]
    pub max_radius: Option<f64>,
    /// The radius rule of the observed vessels, for the parts of a vessel that is split.
    pub radius_rule: RadiusRule,
}

/// [`CandidateOptions::k`] without evidence, where none is given.
pub const NEAREST: usize = 6;

impl CandidateOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the option, its value and the range.
    pub fn validate(&self) -> Result<()> {
        if self.k == Some(0) {
            return Err(Error::parameter("k", 0, "expected at least 1"));
        }
        for (name, value) in [("max_gap", self.max_gap), ("max_candidate_radius", self.max_radius)] {
            if let Some(m) = value.filter(|m| !m.is_finite() || *m <= 0.0) {
                return Err(Error::parameter(name, millimetres(m), "expected a positive length"));
            }
        }
        Ok(())
    }
}

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

/// A point of a network where a candidate may hold, with its position (m) and local radius (m).
#[derive(Debug, Clone, Copy)]
pub struct Anchor {
    place: NetworkPoint,
    position: Point,
    radius: f64,
}

/// Joins every free end of the observed vessels to its nearest branches and free ends by candidate vessels.
///
/// The nodes of `network` keep their rows; nodes where a vessel is split follow. The parts of the observed vessels come
/// first, in order, then the candidates by free end and distance. Every length is one that a file in millimetres holds
/// exactly.
///
/// # Errors
///
/// A parameter out of its range, a node without position or with more than 1000 vessels, or points that are crowded.
pub fn build(network: &Network, params: &CandidateOptions) -> Result<Network> {
    params.validate()?;
    if let Some(node) = network.nodes().find(|n| n.position.is_none()) {
        return Err(Error::parameter(
            format!("node {}", node.id),
            "without coordinates",
            "candidates need the position of every node",
        ));
    }
    check_junctions(network)?;
    let around = Surroundings::new(network);
    let ends = free_ends(network, around.spacing);
    let looks = Looks::around(ends.len());
    let targets = in_order(&ends, |_, end| around.targets(end, params, &looks));
    looks.check()?;
    let found = targets.into_iter().flatten().map(|target| (target, None)).collect();
    Ok(with_candidates(network, found, params).0)
}

/// The network with candidates between places that no vessel joins yet, each pair once, and the new node at every place where
/// a vessel is split.
fn with_candidates(
    network: &Network,
    mut found: Vec<(Target, Option<Evidence>)>,
    params: &CandidateOptions,
) -> (Network, BTreeMap<NetworkPoint, usize>) {
    let mut joined: BTreeSet<[NetworkPoint; 2]> =
        network.vessels().map(|(ends, _)| pair(NetworkPoint::Node(ends[0]), NetworkPoint::Node(ends[1]))).collect();
    found.retain(|(target, _)| joined.insert(pair(target.from.place, target.to.place)));
    let mut cuts = Cuts::new();
    for (target, _) in &found {
        for anchor in [&target.from, &target.to] {
            if let NetworkPoint::Along { vessel, point } = anchor.place {
                cuts.entry(vessel).or_default().insert(point);
            }
        }
    }
    let (mut graph, node_at) = split(network, &cuts, params.radius_rule);
    for (target, evidence) in found {
        let ends = [&target.from, &target.to].map(|anchor| match anchor.place {
            NetworkPoint::Node(node) => node,
            place @ NetworkPoint::Along { .. } => node_at[&place],
        });
        let prior = evidence.map_or(1.0, |e| e.probability);
        graph.add_vessel(ends, Vessel { prior, evidence, ..candidate(&target, params) });
    }
    store(&mut graph);
    (graph, node_at)
}

fn pair(a: NetworkPoint, b: NetworkPoint) -> [NetworkPoint; 2] {
    [a.min(b), a.max(b)]
}

fn candidate(target: &Target, params: &CandidateOptions) -> Vessel {
    let (a, b) = (target.from.radius, target.to.radius);
    let radius = match params.radius {
        CandidateRadius::Min => a.min(b),
        CandidateRadius::Mean => 0.5 * (a + b),
    };
    let radius = params.max_radius.map_or(radius, |most| radius.min(most));
    let length = distance(target.from.position, target.to.position);
    let path = [&target.from, &target.to].map(|s| PathPoint { position: s.position, radius, id: None }).to_vec();
    Vessel { path, ..Vessel::new(length, radius, Origin::Candidate) }
}

/// Makes every length one that survives being written in millimetres.
fn store(network: &mut Network) {
    for row in 0..network.vessel_count() {
        let vessel = network.vessel_mut(row);
        vessel.length = as_stored(vessel.length);
        vessel.radius = as_stored(vessel.radius);
        for point in &mut vessel.path {
            point.radius = as_stored(point.radius);
            point.position = point.position.map(as_stored);
        }
    }
    for row in 0..network.node_count() {
        let node = network.node_mut(row);
        node.radius = node.radius.map(as_stored);
        node.position = node.position.map(|p| p.map(as_stored));
    }
}
