//! The over-connected graph: the observed vessels, split where candidates meet them, and the candidates. These are looked for and judged in each
//! cluster of fragments that are far from all others by itself, so that a fragment at the other end of the room changes nothing.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use super::features::{Extraction, NetworkPoint};
use super::resample::Resampled;
use super::search::{CandidateOptions, CandidateRadius, EndCandidate};
use willis_core::network::path_places::{PathPlace, length_of};
use willis_core::network::{Evidence, Network, Node, Origin, PathPoint, RadiusRule, Vessel, fragments};
use willis_core::support::geometry::{Point, norm_squared};
use willis_core::support::list_of;

/// A fragment keeps those within so many of its largest radii: no search reaches that far (20 spacings, of two radii at most, and 10 radii).
const REACH_RADII: f64 = 50.0;
/// How often boxes are sorted along an axis; what is not apart by then stays together.
const MOST_CUTS: usize = 64;

/// A part of a network that is far from the rest.
pub struct FragmentCluster<'a> {
    /// Its nodes and vessels.
    pub network: Cow<'a, Network>,
    /// The inlets among its nodes, by its own rows.
    pub inlets: Vec<usize>,
    /// The rows of its nodes and vessels in the whole; `None` where it is the whole.
    rows: Option<[Vec<usize>; 2]>,
}

impl<'a> FragmentCluster<'a> {
    /// The whole network.
    pub fn whole(network: &'a Network, inlets: &[usize]) -> Self {
        Self { network: Cow::Borrowed(network), inlets: inlets.to_vec(), rows: None }
    }

    /// The place in the whole network of a place in the cluster.
    pub fn in_whole(&self, place: NetworkPoint) -> NetworkPoint {
        let Some([nodes, vessels]) = &self.rows else { return place };
        match place {
            NetworkPoint::Node(node) => NetworkPoint::Node(nodes[node]),
            NetworkPoint::Along { vessel, point } => NetworkPoint::Along { vessel: vessels[vessel], point },
        }
    }
}

/// The clusters of a network in the order of their first nodes. Two fragments are in one cluster unless a plane across an axis separates
/// them, directly or after others were separated, further than the size and 50 radii of each. One cluster, the whole, where some node has no position.
pub fn clusters<'a>(network: &'a Network, inlets: &[usize]) -> Vec<FragmentCluster<'a>> {
    let whole = || FragmentCluster::whole(network, inlets);
    let parts = fragments(network, |_, _| true);
    let Some(boxes) = boxes(network, &parts.of_node, parts.count) else { return vec![whole()] };
    let mut groups = groups(&boxes);
    // Fragments are numbered in the order of their first nodes.
    groups.sort_by_key(|members| members.iter().copied().min());
    if groups.len() < 2 {
        return vec![whole()];
    }
    let group_of = list_of(parts.count, &groups);
    let networks = network.parts(groups.len(), |node| group_of[parts.of_node[node]]);
    let cluster = |(part, nodes, vessels): (Network, Vec<usize>, Vec<usize>)| {
        let inlets = inlets.iter().filter_map(|inlet| nodes.binary_search(inlet).ok()).collect();
        FragmentCluster { network: Cow::Owned(part), inlets, rows: Some([nodes, vessels]) }
    };
    networks.into_iter().map(cluster).collect()
}

/// A box with the least and the largest coordinate along each axis, m.
pub type Bounds = [[f64; 2]; 3];

/// Per fragment the box around all within its reach; `None` where a node has no position.
fn boxes(network: &Network, of_node: &[usize], count: usize) -> Option<Vec<Bounds>> {
    let mut boxes = vec![[[f64::INFINITY, f64::NEG_INFINITY]; 3]; count];
    let mut widest = vec![0.0_f64; count];
    let mut add = |part: usize, at: Point, radius: f64| {
        for (bounds, x) in boxes[part].iter_mut().zip(at) {
            *bounds = [bounds[0].min(x), bounds[1].max(x)];
        }
        widest[part] = widest[part].max(radius);
    };
    for (node, part) in network.nodes().zip(of_node) {
        add(*part, node.position?, node.radius.unwrap_or(0.0));
    }
    for (ends, vessel) in network.vessels() {
        let part = of_node[ends[0]];
        add(part, network.node(ends[0]).position?, vessel.radius);
        vessel.path.iter().for_each(|point| add(part, point.position, point.radius));
    }
    for (bounds, radius) in boxes.iter_mut().zip(widest) {
        let size = norm_squared([0, 1, 2].map(|axis: usize| bounds[axis][1] - bounds[axis][0])).sqrt();
        let reach = size.max(REACH_RADII * radius);
        *bounds = bounds.map(|[low, high]| [low - reach, high + reach]);
    }
    Some(boxes)
}

/// The boxes in groups between which a plane across an axis lies, cut again and again.
pub fn groups(boxes: &[Bounds]) -> Vec<Vec<usize>> {
    let mut open: Vec<(Vec<usize>, usize, usize)> = vec![((0..boxes.len()).collect(), 0, 0)];
    let mut done = Vec::new();
    // A group with how many axes in a row did not cut it, and how many were tried.
    while let Some((mut members, whole, tried)) = open.pop() {
        if members.len() < 2 || whole == 3 || tried == MOST_CUTS {
            done.push(members);
            continue;
        }
        let axis = tried % 3;
        members.sort_by(|a, b| boxes[*a][axis][0].total_cmp(&boxes[*b][axis][0]).then(a.cmp(b)));
        let (mut parts, mut reached) = (vec![Vec::new()], f64::NEG_INFINITY);
        for member in members {
            let [low, high] = boxes[member][axis];
            let last = parts.len() - 1;
            if low > reached && !parts[last].is_empty() {
                parts.push(vec![member]);
            } else {
                parts[last].push(member);
            }
            reached = reached.max(high);
        }
        let whole = if parts.len() == 1 { whole + 1 } else { 1 };
        open.extend(parts.into_iter().map(|part| (part, whole, tried + 1)));
    }
    done
}

/// One end of a candidate that becomes a vessel.
pub struct NewEnd {
    /// Where it is in the network.
    pub place: NetworkPoint,
    /// The place on the path of the vessel that is split there; `None` at a node.
    pub on_path: Option<PathPlace>,
}

/// A candidate that becomes a vessel.
pub struct NewVessel {
    /// Its free end and the point it reaches.
    pub ends: [NewEnd; 2],
    /// The radii (m) at its free end and at the point it reaches.
    pub radii: [f64; 2],
    /// What the evidence says of it; `None` without evidence.
    pub evidence: Option<Evidence>,
    /// The points (m) between its ends, from the free end on; none of a straight one.
    pub course: Vec<Point>,
}

impl NewVessel {
    /// A straight candidate of a cluster without evidence, that of the resampled cluster's extraction, as wide as that measures.
    pub fn of(c: EndCandidate, e: &Extraction, resampled: &Resampled, cluster: &FragmentCluster) -> Self {
        let ends = c.points(e).map(|point| {
            let on_path = match e.place[point] {
                NetworkPoint::Along { vessel, point } => Some(resampled.places[vessel][point]),
                NetworkPoint::Node(_) => None,
            };
            NewEnd { place: cluster.in_whole(e.place[point]), on_path }
        });
        Self { ends, radii: c.points(e).map(|point| e.radius_at(point)), evidence: None, course: Vec::new() }
    }
}

/// The new node at every place where a vessel is split.
pub type CutNodes = BTreeMap<NetworkPoint, usize>;

/// The network with candidates between places that no vessel joins yet, each pair once, and the new node at every place where
/// a vessel is split.
pub fn over_connected(network: &Network, mut found: Vec<NewVessel>, options: &CandidateOptions) -> (Network, CutNodes) {
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
        // The search asks that every node has a position, and a cut has one.
        let [from, to] = ends.map(|node| graph.node(node).position.unwrap_or_default());
        let points = std::iter::once(from).chain(new.course).chain([to]);
        let path: Vec<PathPoint> = points.map(|position| PathPoint { position, radius, id: None }).collect();
        let length = length_of(&path);
        let prior = new.evidence.map_or(1.0, |e| e.probability);
        let vessel = Vessel::new(length, radius, Origin::Candidate);
        graph.add_vessel(ends, Vessel { prior, evidence: new.evidence.map(Box::new), path, ..vessel });
    }
    graph.store();
    (graph, node_at)
}

/// The network with its vessels split at the points of `cuts`, given per vessel with their places on its path, and the new node at
/// every cut.
///
/// A new node takes the number of its point as id; where the point has none, or the id is taken, it is called after the
/// vessel's row and the point.
fn split(network: &Network, cuts: &BTreeMap<usize, BTreeMap<usize, PathPlace>>, rule: RadiusRule) -> (Network, CutNodes) {
    let (mut graph, _) = network.subgraph(|_| false);
    let mut taken: BTreeSet<String> = network.nodes().map(|n| n.id.clone()).collect();
    let mut node_at = BTreeMap::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let Some(points) = cuts.get(&row) else {
            graph.add_vessel(ends, vessel.clone());
            continue;
        };
        let cuts: Vec<usize> = points.keys().copied().collect();
        let parts = vessel.parts(ends, &vessel.path, points.values().copied(), rule, |number, at| {
            let point = cuts[number];
            let mut id = at.id.map_or_else(|| format!("{row}:{point}"), |id| id.to_string());
            while !taken.insert(id.clone()) {
                id = format!("{row}:{id}");
            }
            let node = graph.add_node(Node::at(id, at));
            node_at.insert(NetworkPoint::Along { vessel: row, point }, node);
            node
        });
        for (ends, part) in parts {
            graph.add_vessel(ends, part);
        }
    }
    (graph, node_at)
}
