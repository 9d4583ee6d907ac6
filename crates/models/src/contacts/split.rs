//! Opens contacts: every block of a cluster's ends gets junctions of its own, and contacts join the blocks. Which vessels are one at a contact, and
//! which others might be; cuts that are suggested and not made.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::branches::Branches;
use super::partition::{Blocks, block_count, numbered};
use willis_core::decision::{RECONNECT, reconnected};
use willis_core::network::path_places::{at_even_steps, length_of};
use willis_core::network::paths::ShortestPaths;
use willis_core::network::units::{as_stored, millimetres};
use willis_core::network::{Edit, Evidence, Network, Node, Origin, PathPoint, Vessel};
use willis_core::support::arc_lengths::in_direction;
use willis_core::support::geometry::{Point, distance};
use willis_core::support::numbered::placed;
use willis_core::support::ties::steady;

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
    /// Per vessel at an end of a branch at such a cluster, and its side there, the node that this end has now.
    node_of_vessel: BTreeMap<(usize, usize), usize>,
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
    /// Per node of the network as it was its row now, or that of the junction that stands for it.
    pub node_now: Vec<usize>,
    /// Per contact a junction where it is, a row of the network as it was.
    pub junctions: Vec<usize>,
    /// Per cluster that falls apart, or may well do, how its vessels may be paired.
    pub pairings: Vec<Pairings>,
}

/// The network in which each cluster of several blocks has a copy of its junctions for every block, and contacts between these. Nodes
/// keep their order without those that no vessel needs any more, new ones follow; contacts are the last vessels. `probability` is that of
/// a contact whose blocks are joined so probably by the partitions; half of the latter is what either end has as `attached`.
pub fn split(network: &Network, branches: &Branches, blocks: &[Blocks], probability: impl Fn(f64) -> f64) -> Opened {
    let (mut graph, _) = network.subgraph(|_| false);
    let mut plan = SplitPlan { taken: network.nodes().map(|n| n.id.clone()).collect(), ..SplitPlan::default() };
    let mut paths = ShortestPaths::new(network.node_count());
    for (row, blocks) in blocks.iter().enumerate().filter(|(_, blocks)| blocks.count() > 1) {
        part(&mut graph, branches, row, blocks, &mut paths, &mut plan);
    }
    let mut row_of = vec![0; network.vessel_count()];
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        if let Some(copies) = plan.copies.get(&row) {
            for ends in copies {
                graph.add_vessel(*ends, vessel.clone());
            }
            continue;
        }
        let moved = |side: usize| plan.node_of_candidate.get(&ends[side]).filter(|_| vessel.origin == Origin::Candidate);
        let at_end = |side: usize| plan.node_of_vessel.get(&(row, side));
        let now = [0, 1].map(|side| at_end(side).or_else(|| moved(side)).copied().unwrap_or(ends[side]));
        let mut vessel = vessel.clone();
        // Its points go on to where it ends now; its length stays, as that is inside of the vessels there.
        if let (Some(first), Some(_)) = (vessel.path.first().copied(), moved(0)) {
            vessel.path.insert(0, PathPoint { position: position(&graph, now[0]), ..first });
        }
        if let (Some(last), Some(_)) = (vessel.path.last().copied(), moved(1)) {
            vessel.path.push(PathPoint { position: position(&graph, now[1]), ..last });
        }
        row_of[row] = graph.add_vessel(now, vessel);
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
    let needed = graph.degrees(|_| true);
    let stands_for = |node: usize| plan.node_of_candidate.get(&node).filter(|_| needed[node] == 0);
    let (graph, stay, _) = graph.part(|node| stands_for(node).is_none());
    let row_now = placed(needed.len(), stay);
    let node_now = (0..network.node_count()).map(|node| row_now[*stands_for(node).unwrap_or(&node)]).collect();
    Opened { graph, node_now, junctions, pairings }
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
        let apart = |node: usize| steady(nodes.iter().map(|other| apart(graph, node, *other)).sum());
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
        let (vessel, backwards) = branches.vessel_at(*end);
        let side = usize::from(end.last != backwards);
        plan.node_of_vessel.insert((vessel, side), own[*block].get(&node).copied().unwrap_or(node));
    }
    // A candidate at a junction that no block has goes to the nearest hub.
    let inside = cluster.inner.iter().flat_map(|inner| branches.inner[*inner].nodes.iter().copied());
    for node in cluster.nodes.iter().copied().chain(inside).filter(|node| !used.contains(node)) {
        let nearest = hubs.iter().map(|(hub, _)| *hub);
        let nearest = nearest.min_by(|a, b| apart(graph, *a, node).total_cmp(&apart(graph, *b, node)).then(a.cmp(b)));
        plan.node_of_candidate.extend(nearest.map(|hub| (node, hub)));
    }
    // A contact is the way through the core from one hub to the other.
    for ([a, b], p) in &blocks.joined {
        let [from, to] = [*a, *b].map(|block| hubs[block].0);
        let mut path = vec![PathPoint { position: position(graph, from), radius: cluster.radius, id: None }];
        let mut node = from;
        for inner in ways(branches, row, paths, from, &[to]).concat() {
            let inner = &branches.inner[inner];
            let forward = inner.ends[0] == node;
            node = inner.ends[usize::from(forward)];
            path.extend_from_slice(&in_direction(inner.points.clone(), forward)[1..]);
        }
        let length = as_stored(length_of(&path).max(SHORTEST * cluster.radius));
        if path.len() < 2 {
            // Both hubs are one place.
            path.clear();
        }
        for point in &mut path {
            point.radius = as_stored(point.radius);
            point.position = point.position.map(as_stored);
        }
        let contact = Vessel { prior: *p, path, ..Vessel::new(length, as_stored(cluster.radius), Origin::Contact) };
        plan.contacts.push(([*a, *b].map(|block| own[block][&hubs[block].0]), contact, from));
    }
}

/// The distance of two nodes.
fn apart(graph: &Network, a: usize, b: usize) -> f64 {
    steady(distance(position(graph, a), position(graph, b)))
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

/// A place that stands for a vessel of a pairing is so far from its end, m, but no further than its middle.
const OUTSIDE: f64 = 0.003;
const STEPS: usize = 64;

/// The vessels that end at a place where vessels touch or, without contacts, may only touch, and the ways to pair them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pairings {
    /// The middle of the place, m.
    pub position: Point,
    /// The vessel of each end, a row of the opened graph.
    pub vessels: Vec<usize>,
    /// The way in which it was opened, as the block of each end.
    pub opened: Vec<usize>,
    /// The most probable ways with their probabilities, the most probable first; none where they are too many to be summed.
    pub ways: Vec<(Vec<usize>, f64)>,
    /// The contacts between two blocks of the way in which it was opened, rows of the opened graph.
    pub contacts: Vec<([usize; 2], usize)>,
}

/// A vessel by its row, its node at a place, and its block there.
pub type PlacedVessel = (usize, usize, usize);

/// What says one way to pair vessels to a run: contacts that are accepted and rejected or, where no contacts say it, an edit.
#[derive(Debug, Default)]
pub struct PairingDecision {
    /// Rows of the graph.
    pub accept: Vec<usize>,
    /// Rows of the graph.
    pub reject: Vec<usize>,
    /// Parts the vessels; the contacts are left to it.
    pub part: Option<Edit>,
}

impl Pairings {
    /// The way that a decision takes: the blocks that kept contacts join are one.
    pub fn taken(&self, kept: &[bool]) -> Vec<usize> {
        let mut blocks = self.opened.clone();
        let mut name: Vec<usize> = (0..blocks.len()).collect();
        for ([a, b], _) in self.contacts.iter().filter(|(_, row)| kept[*row]) {
            let (from, to) = (name[*b], name[*a]);
            name.iter_mut().filter(|block| **block == from).for_each(|block| *block = to);
        }
        for block in &mut blocks {
            *block = name[*block];
        }
        numbered(blocks)
    }

    /// What a person decides who takes a way; `None` where both ends of a vessel are here, which no places tell apart.
    pub fn decision(&self, way: &[usize], graph: &Network) -> Option<PairingDecision> {
        let ends = 0..self.vessels.len();
        let one = |blocks: &[usize], [a, b]: [usize; 2]| blocks[a] == blocks[b];
        if ends.clone().all(|a| ends.clone().all(|b| !one(&self.opened, [a, b]) || one(way, [a, b]))) {
            let of_block = |block: usize| self.opened.iter().position(|of| *of == block).unwrap_or_default();
            let (accept, reject) = self.contacts.iter().partition::<Vec<_>, _>(|(blocks, _)| one(way, blocks.map(of_block)));
            let rows = |contacts: Vec<&([usize; 2], usize)>| contacts.into_iter().map(|(_, row)| *row).collect();
            return Some(PairingDecision { accept: rows(accept), reject: rows(reject), part: None });
        }
        if ends.clone().any(|end| self.vessels[..end].contains(&self.vessels[end])) {
            return None;
        }
        let mut groups = vec![Vec::new(); block_count(way)];
        for (vessel, block) in self.vessels.iter().zip(way) {
            groups[*block].push(self.outside(graph, *vessel).map(|x| (millimetres(x) * 1e3).round() / 1e3));
        }
        Some(PairingDecision { part: Some(Edit::Part(groups)), ..PairingDecision::default() })
    }

    /// A place on a vessel a little outside of where it meets the others. Contacts are looked for only where every node has a position.
    fn outside(&self, graph: &Network, vessel: usize) -> Point {
        let path = graph.path_of(vessel);
        let [first, last] = [path[0], path[path.len() - 1]].map(|end| distance(end.position, self.position));
        let path = in_direction(path, first <= last);
        let step = ((OUTSIDE / graph.vessel(vessel).length * STEPS as f64) as usize).clamp(1, STEPS / 2);
        at_even_steps(&path, STEPS)[step].on(&path).position
    }

    /// Where one line may show two vessels: the probability that it does, and the vessels with their nodes here and their blocks in the most probable way.
    pub fn doubt(&self, graph: &Network) -> Option<(f64, Vec<PlacedVessel>)> {
        let apart = |way: &Vec<usize>| way.iter().any(|block| *block > 0);
        let (way, _) = self.ways.iter().find(|(way, _)| self.contacts.is_empty() && apart(way))?;
        let chance = self.ways.iter().filter(|(way, _)| apart(way)).map(|(_, p)| p).sum();
        let near = |row: usize| {
            let away = |node: &usize| graph.node(*node).position.map_or(f64::INFINITY, |at| distance(at, self.position));
            let [a, b] = graph.ends(row);
            if away(&b) < away(&a) { b } else { a }
        };
        Some((chance, self.vessels.iter().zip(way).map(|(row, block)| (*row, near(*row), *block)).collect()))
    }

    /// A way in words: vessels of one block with a plus between them, blocks with a bar, as in `12+45 | 31+46`.
    pub fn told(&self, way: &[usize]) -> String {
        let block = |which: usize| {
            let own = self.vessels.iter().zip(way).filter(|(_, block)| **block == which);
            own.map(|(vessel, _)| vessel.to_string()).collect::<Vec<String>>().join("+")
        };
        (0..block_count(way)).map(block).collect::<Vec<String>>().join(" | ")
    }

    /// The vessels at this place once some were divided: of both parts the nearer one. `divided` are pairs of rows.
    pub fn follow(&mut self, graph: &Network, divided: &[[usize; 2]]) {
        let away = |row: usize| {
            let ends = graph.ends(row).map(|node| graph.node(node).position);
            let [a, b] = ends.map(|at| at.map_or(f64::INFINITY, |at| distance(at, self.position)));
            a.min(b)
        };
        for [row, other] in divided {
            if away(*other) < away(*row) {
                self.vessels.iter_mut().filter(|vessel| *vessel == row).for_each(|vessel| *vessel = *other);
            }
        }
    }
}

/// A place where two vessels may only touch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SuggestedCut {
    /// The id of a junction there.
    pub node: String,
    /// The middle of the contact, m.
    pub position: Point,
    /// The radius there, m.
    pub radius: f64,
    /// How probably the two are one vessel all the same.
    pub probability: f64,
}

/// The contacts of a network that stay cut when they are opened ([`reconnected()`]), the least probable to be one vessel first.
pub fn suggested_cuts(network: &Network, opened: &Opened) -> Vec<SuggestedCut> {
    let Opened { graph, junctions, .. } = opened;
    let kept = reconnected(graph, RECONNECT);
    let contacts = graph.vessels().zip(kept).filter(|((_, vessel), _)| vessel.origin == Origin::Contact);
    let cut = contacts.zip(junctions).filter(|((_, kept), _)| !kept);
    let suggested = cut.map(|(((ends, vessel), _), junction)| SuggestedCut {
        node: network.node(*junction).id.clone(),
        position: graph.middle_of(ends, vessel),
        radius: vessel.radius,
        probability: vessel.prior,
    });
    let mut suggested: Vec<SuggestedCut> = suggested.collect();
    suggested.sort_by(|a, b| a.probability.total_cmp(&b.probability));
    suggested
}
