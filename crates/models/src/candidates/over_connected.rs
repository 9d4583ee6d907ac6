//! The over-connected graph: the observed vessels, split where candidates meet them, and the candidates.

use std::collections::{BTreeMap, BTreeSet};

use super::clusters::FragmentCluster;
use super::features::extraction::Extraction;
use super::network_point::NetworkPoint;
use super::options::{CandidateOptions, CandidateRadius};
use super::resample::Resampled;
use super::search::EndCandidate;
use willis_core::network::path_places::{PathPlace, length_of};
use willis_core::network::units::as_stored;
use willis_core::network::{Evidence, Network, Node, Origin, PathPoint, RadiusRule, Vessel};
use willis_core::support::geometry::Point;

/// One end of a candidate that becomes a vessel.
pub struct NewEnd {
    /// Where it is in the network.
    pub place: NetworkPoint,
    /// The place on the path of the vessel that is split there; `None` at a node.
    pub on_path: Option<PathPlace>,
    /// Its position where its node has none, m.
    pub position: Point,
}

/// A candidate that becomes a vessel.
pub struct NewVessel {
    /// Its free end and the point it reaches.
    pub ends: [NewEnd; 2],
    /// The radii (m) at its free end and at the point it reaches.
    pub radii: [f64; 2],
    /// What the evidence says of it; `None` without evidence.
    pub evidence: Option<Evidence>,
    /// Its course (m) from the free end to the point, where that is known; else it is straight.
    pub course: Option<Vec<Point>>,
}

impl NewVessel {
    /// A straight candidate of a cluster without evidence, that of the resampled cluster's extraction.
    pub fn of(
        candidate: EndCandidate,
        radii: [f64; 2],
        e: &Extraction,
        resampled: &Resampled,
        cluster: &FragmentCluster,
    ) -> Self {
        let ends = candidate.points(e).map(|point| {
            let on_path = match e.place[point] {
                NetworkPoint::Along { vessel, point } => Some(resampled.place(vessel, point)),
                NetworkPoint::Node(_) => None,
            };
            NewEnd { place: cluster.in_whole(e.place[point]), on_path, position: e.position[point] }
        });
        Self { ends, radii, evidence: None, course: None }
    }
}

/// The network with candidates between places that no vessel joins yet, each pair once, and the new node at every place where
/// a vessel is split.
pub fn over_connected(
    network: &Network,
    mut found: Vec<NewVessel>,
    options: &CandidateOptions,
) -> (Network, BTreeMap<NetworkPoint, usize>) {
    let pair = |[a, b]: [NetworkPoint; 2]| [a.min(b), a.max(b)];
    let places = |new: &NewVessel| [new.ends[0].place, new.ends[1].place];
    let mut joined: BTreeSet<[NetworkPoint; 2]> = network.vessels().map(|(ends, _)| pair(ends.map(NetworkPoint::Node))).collect();
    found.retain(|new| joined.insert(pair(places(new))));
    let mut cuts: BTreeMap<usize, BTreeMap<usize, PathPlace>> = BTreeMap::new();
    for end in found.iter().flat_map(|new| &new.ends) {
        if let (NetworkPoint::Along { vessel, point }, Some(on_path)) = (end.place, end.on_path) {
            cuts.entry(vessel).or_default().insert(point, on_path);
        }
    }
    let (mut graph, node_at) = split(network, &cuts, options.radius_rule);
    for new in found {
        let ends = places(&new).map(|place| match place {
            NetworkPoint::Node(node) => node,
            NetworkPoint::Along { .. } => node_at[&place],
        });
        let [a, b] = new.radii;
        let radius = match options.radius {
            CandidateRadius::Min => a.min(b),
            CandidateRadius::Mean => 0.5 * (a + b),
        };
        let radius = options.max_radius.map_or(radius, |most| radius.min(most));
        let [from, to] = [0, 1].map(|end| graph.node(ends[end]).position.unwrap_or(new.ends[end].position));
        let course = new.course.as_deref().unwrap_or_default();
        let inner = course.get(1..course.len().saturating_sub(1)).unwrap_or_default();
        let points = std::iter::once(from).chain(inner.iter().copied()).chain([to]);
        let path: Vec<PathPoint> = points.map(|position| PathPoint { position, radius, id: None }).collect();
        let length = length_of(&path);
        let prior = new.evidence.map_or(1.0, |e| e.probability);
        let vessel = Vessel::new(length, radius, Origin::Candidate);
        graph.add_vessel(ends, Vessel { prior, evidence: new.evidence.map(Box::new), path, ..vessel });
    }
    store(&mut graph);
    (graph, node_at)
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

/// The network with its vessels split at the points of `cuts`, given per vessel with their places on its path, and the new node at
/// every cut.
///
/// A new node takes the number of its point as id; where the point has none, or the id is taken, it is called after the
/// vessel's row and the point.
fn split(
    network: &Network,
    cuts: &BTreeMap<usize, BTreeMap<usize, PathPlace>>,
    rule: RadiusRule,
) -> (Network, BTreeMap<NetworkPoint, usize>) {
    let (mut graph, _) = network.subgraph(|_| false);
    let mut taken: BTreeSet<String> = network.nodes().map(|n| n.id.clone()).collect();
    let mut node_at = BTreeMap::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let Some(points) = cuts.get(&row) else {
            graph.add_vessel(ends, vessel.clone());
            continue;
        };
        let (mut from, mut begun, mut next) = (ends[0], Vec::new(), 0);
        for (point, place) in points {
            let at = place.on(&vessel.path);
            let node = graph.add_node(cut_node(at, row, *point, &mut taken));
            node_at.insert(NetworkPoint::Along { vessel: row, point: *point }, node);
            begun.extend_from_slice(&vessel.path[next..place.point + usize::from(place.share > 0.0)]);
            begun.push(at);
            graph.add_vessel([from, node], part(vessel, &begun, rule));
            (from, begun, next) = (node, vec![at], place.point + 1);
        }
        begun.extend_from_slice(&vessel.path[next..]);
        graph.add_vessel([from, ends[1]], part(vessel, &begun, rule));
    }
    (graph, node_at)
}

fn cut_node(at: PathPoint, row: usize, point: usize, taken: &mut BTreeSet<String>) -> Node {
    let mut id = at.id.map_or_else(|| format!("{row}:{point}"), |id| id.to_string());
    while !taken.insert(id.clone()) {
        id = format!("{row}:{id}");
    }
    Node { id, position: Some(at.position), radius: Some(at.radius), ..Node::default() }
}

fn part(vessel: &Vessel, path: &[PathPoint], rule: RadiusRule) -> Vessel {
    Vessel { label: vessel.label.clone(), prior: vessel.prior, certain: vessel.certain, ..Vessel::along(path.to_vec(), rule) }
}
