//! Clusters of fragments that are far from all others: candidates are looked for and judged in each by itself, so that a fragment at the other
//! end of the room changes nothing.

use std::borrow::Cow;
use std::collections::BTreeSet;

use super::network_point::NetworkPoint;
use willis_core::network::{Network, fragments};
use willis_core::support::geometry::{Point, norm_squared};

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
    let groups = groups(&boxes);
    if groups.len() < 2 {
        return vec![whole()];
    }
    let mut group_of = vec![0; parts.count];
    for (group, members) in groups.iter().enumerate() {
        for part in members {
            group_of[*part] = group;
        }
    }
    let mut networks = network.parts(groups.len(), |node| Some(group_of[parts.of_node[node]]));
    let cluster = |group: usize| {
        let (part, nodes, vessels) = std::mem::take(&mut networks[group]);
        let inlets = inlets.iter().filter_map(|inlet| nodes.binary_search(inlet).ok()).collect();
        FragmentCluster { network: Cow::Owned(part), inlets, rows: Some([nodes, vessels]) }
    };
    let mut in_order: Vec<usize> = parts.of_node.iter().map(|part| group_of[*part]).collect();
    let mut seen = BTreeSet::new();
    in_order.retain(|group| seen.insert(*group));
    in_order.into_iter().map(cluster).collect()
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
