//! Opens contacts: every block of a cluster's ends gets junctions of its own, and contacts join the blocks.

use std::collections::{BTreeMap, BTreeSet};

use super::branches::{BranchEnd, Branches};
use super::pairings::Pairings;
use super::partition::Blocks;
use willis_core::network::path_places::length_of;
use willis_core::network::paths::ShortestPaths;
use willis_core::network::units::as_stored;
use willis_core::network::{Evidence, Network, Node, Origin, PathPoint, Vessel};
use willis_core::support::arc_lengths::in_direction;
use willis_core::support::geometry::{Point, distance};

/// A contact is no shorter than this share of the core's radius: where two vessels share one junction, its length would be nothing, and
/// a resistance must not be.
const SHORTEST: f64 = 0.05;

/// A cluster that is left as it is may be two vessels from this probability on.
const DOUBTFUL: f64 = 0.1;

/// What becomes of the nodes and vessels of the clusters that fall apart.
#[derive(Default)]
struct SplitPlan {
    /// The ids that nodes have.
    taken: BTreeSet<String>,
    /// Per branch end at such a cluster its node.
    node_of_end: BTreeMap<BranchEnd, usize>,
    /// Per vessel inside such a cluster its copies, each by its nodes.
    copies: BTreeMap<usize, Vec<[usize; 2]>>,
    /// Per node of such a cluster the node that a candidate there goes to.
    node_of_candidate: BTreeMap<usize, usize>,
    /// The contacts, each with its nodes and a junction where it is.
    contacts: Vec<([usize; 2], Vessel, usize)>,
}

/// A network whose contacts are opened.
pub struct Opened {
    /// The network; its last vessels are the contacts.
    pub graph: Network,
    /// Per contact a junction where it is, a row of the network as it was.
    pub junctions: Vec<usize>,
    /// Per cluster that falls apart, or may well do, how its vessels may be paired.
    pub pairings: Vec<Pairings>,
}

/// The network in which each cluster of several blocks has a copy of its junctions for every block, and contacts between these. Nodes
/// keep their rows, new ones follow; contacts are the last vessels. `probability` is that of a contact whose blocks are joined so
/// probably by the partitions; half of the latter is what either end has as `attached`.
pub fn split(network: &Network, branches: &Branches, blocks: &[Blocks], probability: impl Fn(f64) -> f64) -> Opened {
    let (mut graph, _) = network.subgraph(|_| false);
    let mut plan = SplitPlan { taken: network.nodes().map(|n| n.id.clone()).collect(), ..SplitPlan::default() };
    let mut paths = ShortestPaths::new(network.node_count());
    for (row, blocks) in blocks.iter().enumerate().filter(|(_, blocks)| blocks.count() > 1) {
        part(&mut graph, branches, row, blocks, &mut paths, &mut plan);
    }
    // Per vessel at an end of a branch the node that this end has now.
    let mut node_of_vessel: BTreeMap<(usize, usize), usize> = BTreeMap::new();
    for (end, node) in &plan.node_of_end {
        let (vessel, backwards) = branches.vessel_at(*end);
        node_of_vessel.insert((vessel, usize::from(end.last != backwards)), *node);
    }
    let mut row_of = vec![0; network.vessel_count()];
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        if let Some(copies) = plan.copies.get(&row) {
            for ends in copies {
                graph.add_vessel(*ends, vessel.clone());
            }
            continue;
        }
        let ends = [0, 1].map(|side| {
            let at_end = node_of_vessel.get(&(row, side)).copied();
            let moved = || plan.node_of_candidate.get(&ends[side]).copied().filter(|_| vessel.origin == Origin::Candidate);
            at_end.or_else(moved).unwrap_or(ends[side])
        });
        row_of[row] = graph.add_vessel(ends, vessel.clone());
    }
    let mut next = graph.vessel_count();
    let pairings =
        blocks.iter().enumerate().filter(|(_, blocks)| blocks.count() > 1 || blocks.apart() >= DOUBTFUL).map(|(row, blocks)| {
            let cluster = &branches.clusters[row];
            let first = next;
            next += blocks.joined.len();
            Pairings {
                position: cluster.centre(),
                vessels: cluster.ends.iter().map(|end| row_of[branches.vessel_at(*end).0]).collect(),
                opened: blocks.of_end.clone(),
                ways: blocks.ways.clone(),
                contacts: blocks.joined.iter().zip(first..).map(|((pair, _), row)| (*pair, row)).collect(),
            }
        });
    let pairings = pairings.collect();
    let mut junctions = Vec::with_capacity(plan.contacts.len());
    for (ends, contact, junction) in plan.contacts {
        let (joined, p) = (contact.prior, probability(contact.prior));
        let evidence = Evidence { attached: [0.5 * joined; 2], ..Evidence::undirected(p) };
        graph.add_vessel(ends, Vessel { prior: p, evidence: Some(Box::new(evidence)), ..contact });
        junctions.push(junction);
    }
    Opened { graph, junctions, pairings }
}

/// The inner branches on the shortest way from a node of a cluster to each of some others, in order from the first.
fn ways(branches: &Branches, cluster: usize, paths: &mut ShortestPaths, from: usize, to: &[usize]) -> Vec<Vec<usize>> {
    paths.search(&[from], f64::INFINITY, |node| branches.inside(cluster, node), |_, _| true);
    to.iter().map(|node| paths.path_to(*node).edges).collect()
}

/// Plans the copies of one cluster.
fn part(graph: &mut Network, branches: &Branches, row: usize, blocks: &Blocks, paths: &mut ShortestPaths, plan: &mut SplitPlan) {
    let cluster = &branches.clusters[row];
    // Per block the junctions of its ends, and the one that is nearest to all of them.
    let hub_of = |block: usize| {
        let ends = cluster.ends.iter().zip(&blocks.of_end).filter(|(_, of)| **of == block);
        let nodes: Vec<usize> = ends.map(|(end, _)| branches.node(*end)).collect();
        let apart = |node: usize| nodes.iter().map(|other| apart(graph, node, *other)).sum::<f64>();
        let hub = nodes.iter().copied().min_by(|a, b| apart(*a).total_cmp(&apart(*b)).then(a.cmp(b)));
        (hub.unwrap_or(cluster.nodes[0]), nodes)
    };
    let hubs: Vec<(usize, Vec<usize>)> = (0..blocks.count()).map(hub_of).collect();
    let inside = cluster.inner.iter().flat_map(|inner| &branches.inner[*inner].vessels);
    plan.copies.extend(inside.map(|(vessel, _)| (*vessel, Vec::new())));
    // Per block its own junctions; the first block that needs one keeps it.
    let mut used: BTreeSet<usize> = BTreeSet::new();
    let mut own: Vec<BTreeMap<usize, usize>> = vec![BTreeMap::new(); hubs.len()];
    for (block, (hub, nodes)) in hubs.iter().enumerate() {
        let needed: BTreeSet<usize> = ways(branches, row, paths, *hub, nodes).into_iter().flatten().collect();
        let mut node_of = |graph: &mut Network, node: usize| {
            *own[block].entry(node).or_insert_with(|| {
                if used.insert(node) {
                    return node;
                }
                let copy = copied(graph.node(node), block, &mut plan.taken);
                graph.add_node(copy)
            })
        };
        node_of(graph, *hub);
        for inner in needed {
            let inner = &branches.inner[inner];
            let nodes: Vec<usize> = inner.nodes.iter().map(|node| node_of(graph, *node)).collect();
            for ((vessel, backwards), pair) in inner.vessels.iter().zip(nodes.windows(2)) {
                let ends = if *backwards { [pair[1], pair[0]] } else { [pair[0], pair[1]] };
                plan.copies.entry(*vessel).or_default().push(ends);
            }
        }
    }
    for (end, block) in cluster.ends.iter().zip(&blocks.of_end) {
        let node = branches.node(*end);
        plan.node_of_end.insert(*end, own[*block].get(&node).copied().unwrap_or(node));
    }
    // A candidate at a junction that no block has goes to the nearest hub.
    let inside = cluster.inner.iter().flat_map(|inner| branches.inner[*inner].nodes.iter().copied());
    for node in cluster.nodes.iter().copied().chain(inside).filter(|node| !used.contains(node)) {
        let nearest = hubs.iter().map(|(hub, _)| *hub);
        let nearest = nearest.min_by(|a, b| apart(graph, *a, node).total_cmp(&apart(graph, *b, node)).then(a.cmp(b)));
        plan.node_of_candidate.extend(nearest.map(|hub| (node, hub)));
    }
    for ([a, b], p) in &blocks.joined {
        let ends = [*a, *b].map(|block| own[block][&hubs[block].0]);
        let between = [hubs[*a].0, hubs[*b].0];
        plan.contacts.push((ends, contact(graph, branches, row, paths, between, *p), between[0]));
    }
}

/// The distance of two nodes.
fn apart(graph: &Network, a: usize, b: usize) -> f64 {
    distance(position(graph, a), position(graph, b))
}

fn position(graph: &Network, node: usize) -> Point {
    graph.node(node).position.unwrap_or_default()
}

/// Another junction at the place of a node, for a block.
fn copied(node: &Node, block: usize, taken: &mut BTreeSet<String>) -> Node {
    let mut id = format!("{}:{block}", node.id);
    while !taken.insert(id.clone()) {
        id = format!("{id}:{block}");
    }
    Node { id, position: node.position, radius: node.radius, ..Node::default() }
}

/// The contact of two blocks, joined so probably: the way through the core from one hub to the other.
fn contact(
    graph: &Network,
    branches: &Branches,
    row: usize,
    paths: &mut ShortestPaths,
    [from, to]: [usize; 2],
    p: f64,
) -> Vessel {
    let cluster = &branches.clusters[row];
    let mut path = vec![PathPoint { position: position(graph, from), radius: cluster.radius, id: None }];
    let mut node = from;
    for inner in ways(branches, row, paths, from, &[to]).concat() {
        let inner = &branches.inner[inner];
        let forward = inner.ends[0] == node;
        node = inner.ends[usize::from(forward)];
        path.extend_from_slice(&in_direction(inner.points.clone(), forward)[1..]);
    }
    let length = length_of(&path);
    let length = as_stored(length.max(SHORTEST * cluster.radius));
    if path.len() < 2 {
        // Both hubs are one place.
        path.clear();
    }
    for point in &mut path {
        point.radius = as_stored(point.radius);
        point.position = point.position.map(as_stored);
    }
    let vessel = Vessel::new(length, as_stored(cluster.radius), Origin::Contact);
    Vessel { prior: p, path, ..vessel }
}
