//! Which segments are present where inlets and outlets are known as nodes.
//!
//! A segment is present when blood could flow along it: L-A1 when the outlet of L-A2 reaches the left carotid without passing the right
//! carotid and the posterior arteries, and so on. Where an outlet lies outside the field of view, the next landmark stands for it, or the
//! connection through both segments that meet there.

use petgraph::{graph::NodeIndex, visit::EdgeRef};

use super::arteries::{Artery, ArteryVessels, BodySide, FENESTRATED, Variant};
use super::segments_by_labels::{is_wider, shortest};
use willis_core::network::{Network, walks::Walk};
use willis_core::support::{distinct, numbered::marked};

/// The longest second channel of a fenestration, m. The ring and other detours are longer.
const LONGEST_CHANNEL: f64 = 0.02;
/// The length of P1 from PComm on where its origin from the basilar artery is not known, m.
const LENGTH_OF_P1: f64 = 0.01;

/// The nodes of the landmarks. Pairs are left, right.
#[derive(Debug, Clone, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Points {
    /// Inlets of the carotids.
    pub ica: [Option<usize>; 2],
    /// Outlets of M1, or of the branch of M2 whose landmark is nearest to its end.
    pub m1: [Option<usize>; 2],
    /// Outlets of the other branches of M2.
    pub m2: [Vec<usize>; 2],
    /// Outlets of A2, or where A2 begins.
    pub a2: [Option<usize>; 2],
    /// Outlets of P2, or where P2 begins.
    pub p2: [Option<usize>; 2],
    /// Bifurcations of the carotids.
    pub carotid: [Vec<usize>; 2],
    /// Inlets of the vertebral or basilar arteries.
    pub feeders: Vec<usize>,
    /// End of the basilar artery.
    pub tip: Option<usize>,
    /// Where PComm meets the posterior cerebral artery.
    pub posterior: [Option<usize>; 2],
    /// Where AComm meets the anterior cerebral artery.
    pub anterior: [Option<usize>; 2],
    /// Outlet of a third A2.
    pub third: Option<usize>,
    /// Where M1 divides.
    pub middle: [Option<usize>; 2],
    /// The free ends that landmarks name as outlets.
    pub outlets: Vec<usize>,
    /// The nodes where landmarks say that an artery enters or leaves, but outlets whose vessel is seen to run on.
    pub ends: Vec<usize>,
}

/// The rules in the kept vessels of a network.
struct LandmarkRules<'a, K> {
    network: &'a Network,
    points: &'a Points,
    kept: &'a K,
    /// The vessels that paths may use, as [`Points::between`].
    between: &'a [bool],
    /// The nodes along the carotids.
    trunk: [Vec<usize>; 2],
    /// Whether each carotid is complete from its inlet to its end.
    complete: [bool; 2],
}

impl Points {
    /// Every node of a landmark.
    pub fn nodes(&self) -> impl Iterator<Item = usize> {
        let pairs = [self.ica, self.m1, self.a2, self.p2, self.posterior, self.anterior, self.middle];
        let others = self.carotid.iter().chain(&self.m2).flatten().chain(&self.feeders).chain(&self.tip).chain(&self.third);
        pairs.into_iter().flatten().flatten().chain(others.copied())
    }

    /// Puts another node in the place of each.
    pub fn follow(&mut self, node_now: &[usize]) {
        let Self { ica, m1, m2, a2, p2, carotid, feeders, tip, posterior, anterior, third, middle, outlets, ends } = self;
        let one = [ica, m1, a2, p2, posterior, anterior, middle].into_iter().flatten().chain([tip, third]).flatten();
        let several = m2.iter_mut().chain(carotid).chain([feeders, outlets, ends]).flatten();
        one.chain(several).for_each(|node| *node = node_now[*node]);
    }

    /// The outlets of the middle cerebral artery of a side.
    fn middle_outlets(&self, side: usize) -> Vec<usize> {
        self.m1[side].into_iter().chain(self.m2[side].iter().copied()).collect()
    }

    /// The vessels that may lie between landmarks: all but the trees behind a node, which no path from one landmark to another enters.
    pub fn between(&self, network: &Network) -> Vec<bool> {
        let graph = network.graph();
        let stays = marked(network.node_count(), self.nodes());
        let mut left: Vec<usize> = graph.node_indices().map(|node| graph.edges(node).count()).collect();
        let mut between = vec![true; network.vessel_count()];
        let mut open: Vec<usize> = (0..left.len()).filter(|node| left[*node] == 1 && !stays[*node]).collect();
        while let Some(node) = open.pop() {
            let last = graph.edges(NodeIndex::new(node)).find(|edge| between[edge.id().index()]);
            let Some(edge) = last.filter(|_| left[node] == 1) else { continue };
            let next = edge.target().index();
            between[edge.id().index()] = false;
            (left[node], left[next]) = (0, left[next] - 1);
            if left[next] == 1 && !stays[next] {
                open.push(next);
            }
        }
        between
    }

    /// The variant in the vessels that `kept` selects; `between` as [`Points::between`].
    pub fn variant(&self, network: &Network, between: &[bool], kept: &impl Fn(usize) -> bool) -> Variant {
        LandmarkRules::new(network, self, between, kept).variant()
    }

    /// The vessels of each artery, when all vessels are present.
    pub fn artery_vessels(&self, network: &Network) -> ArteryVessels {
        LandmarkRules::new(network, self, &self.between(network), &|_: usize| true).artery_vessels()
    }
}

impl<'a, K: Fn(usize) -> bool> LandmarkRules<'a, K> {
    fn new(network: &'a Network, points: &'a Points, between: &'a [bool], kept: &'a K) -> Self {
        let mut rules = Self { network, points, kept, between, trunk: [Vec::new(), Vec::new()], complete: [false; 2] };
        rules.find_carotids();
        rules
    }

    fn path(&self, from: &[usize], to: &[usize], avoid: &[&[usize]]) -> Option<Walk> {
        let set = |nodes: &[usize]| marked(self.network.node_count(), nodes.iter().copied());
        let avoid = marked(self.network.node_count(), avoid.iter().flat_map(|nodes| nodes.iter().copied()));
        shortest(self.network, [&set(from), &set(to), &avoid], |vessel| self.may_pass(vessel), f64::INFINITY)
    }

    fn may_pass(&self, vessel: usize) -> bool {
        self.between[vessel] && (self.kept)(vessel)
    }

    /// Finds the carotids, the shorter first, so that a detour through the other carotid and the circle does not count as an interrupted
    /// one.
    fn find_carotids(&mut self) {
        let points = self.points;
        let ends = |s: usize| if points.m1[s].is_some() { points.middle_outlets(s) } else { points.carotid[s].clone() };
        let length = |path: &Walk| path.edges.iter().map(|row| self.network.vessel(*row).length).sum::<f64>();
        let find = |s: usize, avoid: &[usize]| {
            let posterior = self.posterior_nodes(&points.feeders);
            self.path(&points.ica[s].into_iter().collect::<Vec<_>>(), &ends(s), &[avoid, &posterior])
        };
        let free = [find(0, &[]), find(1, &[])];
        let lengths = free.each_ref().map(|path| path.as_ref().map_or(f64::INFINITY, length));
        let first = usize::from(lengths[1] < lengths[0]);
        let second = 1 - first;
        let of_first = free[first].as_ref().map(|path| path.nodes.clone()).unwrap_or_default();
        let other = find(second, &of_first);
        for (s, path) in [(first, &free[first]), (second, &other)] {
            let seen = points.ica[s].into_iter().chain(points.middle_outlets(s)).chain(points.carotid[s].iter().copied());
            self.trunk[s] = distinct(path.iter().flat_map(|path| path.nodes.iter().copied()).chain(seen));
        }
        for s in [0, 1] {
            if ends(s).is_empty() {
                let up_to_pcomm = self.up_to_pcomm(s);
                self.trunk[s].extend(up_to_pcomm);
            }
        }
        // A carotid whose end is not known is present when a vessel starts at its inlet.
        let starts = |s: usize| points.ica[s].is_some_and(|node| self.has_vessel(node));
        let found = |s: usize| if s == first { free[first].is_some() } else { other.is_some() };
        self.complete = [0, 1].map(|s| if ends(s).is_empty() { starts(s) } else { found(s) });
    }

    /// A carotid without a known end, up to PComm: the first node that P2 reaches of the path to A2 without the basilar artery.
    fn up_to_pcomm(&self, s: usize) -> Vec<usize> {
        let (points, other) = (self.points, &self.trunk[1 - s]);
        let [Some(ica), Some(p2)] = [points.ica[s], points.p2[s]] else { return Vec::new() };
        let opposite: Vec<usize> = points.p2[1 - s].into_iter().collect();
        let a2: Vec<usize> = points.a2[s].or(points.a2[1 - s]).into_iter().collect();
        let Some(carotid) = self.path(&[ica], &a2, &[other, &points.feeders, &opposite, &[p2]]) else { return Vec::new() };
        let reached = self.path(&[p2], &carotid.nodes, &[other, &points.feeders, &opposite]);
        let end = reached.and_then(|path| path.nodes.last().copied());
        let cut = end.and_then(|end| carotid.nodes.iter().position(|node| *node == end));
        cut.map_or_else(Vec::new, |cut| carotid.nodes[..=cut].to_vec())
    }

    fn has_vessel(&self, node: usize) -> bool {
        let graph = self.network.graph();
        graph.edges(NodeIndex::new(node)).any(|edge| (self.kept)(edge.id().index()))
    }

    fn variant(&self) -> Variant {
        let points = self.points;
        let feeders = self.feeders();
        let mut variant =
            Variant { ica: self.complete, ba: feeders.iter().any(|node| self.has_vessel(*node)), ..Variant::default() };
        let posterior = self.posterior_nodes(&feeders);
        let a1 = BodySide::BOTH.map(|side| self.a1(side, &posterior));
        let acomm = self.acomm(&posterior);
        let [p1, pcomm] = self.posterior_segments(&feeders);
        for side in BodySide::BOTH {
            variant.set(Artery::A1(side), a1[side.index()].is_some());
            variant.set(Artery::P1(side), p1[side.index()].is_some());
            variant.set(Artery::PComm(side), pcomm[side.index()].is_some());
        }
        variant.set(Artery::AComm, acomm.is_some());
        let [left, right] = &self.trunk;
        let a2: Vec<usize> = points.a2.into_iter().flatten().collect();
        variant.third_a2 = points.third.is_some_and(|third| self.path(&[third], &a2, &[left, right, &posterior]).is_some());
        let p1 = self.proper_p1(&p1, &pcomm);
        for side in BodySide::BOTH {
            let s = side.index();
            let both = || pcomm[s].as_ref().zip(p1[s].as_ref());
            let wider = |(pcomm, (full, p1)): (&Walk, &(Walk, Walk))| {
                is_wider(self.network, &beyond(pcomm, full, points.posterior[s]).edges, &p1.edges)
            };
            variant.set_fetal(side, || both().is_some_and(wider));
        }
        let a1_proper = [0, 1]
            .map(|s| a1[s].as_ref().map(|path| beyond(path, acomm.as_ref().unwrap_or(&Walk::default()), points.anterior[s])));
        let acomm = acomm.map(|path| between(&path, &a1));
        let blocked = marked(self.network.node_count(), self.trunk.iter().flatten().copied().chain(posterior.iter().copied()));
        for (row, segment) in FENESTRATED.into_iter().enumerate() {
            let path = match segment {
                Artery::A1(side) => a1_proper[side.index()].as_ref(),
                Artery::P1(side) => p1[side.index()].as_ref().map(|(_, proper)| proper),
                _ => acomm.as_ref(),
            };
            variant.fenestration[row] = path.is_some_and(|path| self.has_second_channel(path, &blocked));
        }
        variant
    }

    /// The feeders and the outlets of P2.
    fn posterior_nodes(&self, feeders: &[usize]) -> Vec<usize> {
        feeders.iter().copied().chain(self.points.p2.into_iter().flatten()).collect()
    }

    /// The inlets of the posterior circulation, or the end of the basilar artery.
    fn feeders(&self) -> Vec<usize> {
        let points = self.points;
        if points.feeders.is_empty() { points.tip.into_iter().collect() } else { points.feeders.clone() }
    }

    fn artery_vessels(&self) -> ArteryVessels {
        let points = self.points;
        let feeders = self.feeders();
        let posterior = self.posterior_nodes(&feeders);
        let touches = |row: &usize, nodes: &[usize]| self.network.ends(*row).iter().any(|node| nodes.contains(node));
        let at = |nodes: &[usize]| (0..self.network.vessel_count()).filter(|row| touches(row, nodes)).collect::<Vec<usize>>();
        let one = |node: Option<usize>| node.map_or_else(Vec::new, |node| at(&[node]));
        let a1 = BodySide::BOTH.map(|side| self.a1(side, &posterior));
        let acomm = self.acomm(&posterior);
        let [p1, pcomm] = self.posterior_segments(&feeders);
        let [l_a1, r_a1] = [0, 1].map(|s| from_carotid(a1[s].as_ref(), acomm.as_ref(), points.anterior[s]));
        let [l_pcomm, r_pcomm] = [0, 1].map(|s| from_carotid(pcomm[s].as_ref(), p1[s].as_ref(), points.posterior[s]));
        let acomm = acomm.map(|path| between(&path, &a1).edges).unwrap_or_default();
        let p1 = self.proper_p1(&p1, &pcomm).map(|p1| p1.map(|(_, proper)| proper.edges).unwrap_or_default());
        let [l_p1, r_p1] = p1;
        let [[l_a2, r_a2], [l_p2, r_p2]] = [points.a2, points.p2].map(|pair| pair.map(one));
        let [l_m1, r_m1] = [0, 1].map(|side| at(&points.middle_outlets(side)));
        ArteryVessels {
            feeders: [one(points.ica[0]), one(points.ica[1]), at(&feeders)],
            segments: [l_a1, r_a1, acomm, l_p1, r_p1, l_pcomm, r_pcomm],
            territories: [l_a2, r_a2, l_m1, r_m1, l_p2, r_p2],
        }
    }

    fn a1(&self, side: BodySide, posterior: &[usize]) -> Option<Walk> {
        let (s, o) = (side.index(), side.other().index());
        let (own, other) = (&self.trunk[s], &self.trunk[o]);
        match self.points.a2[s].or(self.points.a2[o]) {
            Some(a2) => self.path(&[a2], own, &[other, posterior]),
            None => self.path(other, own, &[other, posterior]),
        }
    }

    fn acomm(&self, posterior: &[usize]) -> Option<Walk> {
        let [left, right] = &self.trunk;
        match self.points.a2 {
            [Some(a), Some(b)] => self.path(&[a], &[b], &[left, right, posterior]),
            [Some(a), None] => self.path(&[a], right, &[left, posterior]),
            [None, Some(b)] => self.path(&[b], left, &[right, posterior]),
            [None, None] => self.path(left, right, &[posterior]),
        }
    }

    /// P1 and PComm of both sides.
    fn posterior_segments(&self, feeders: &[usize]) -> [[Option<Walk>; 2]; 2] {
        let [left, right] = &self.trunk;
        let both = BodySide::BOTH.map(|side| {
            let (s, o) = (side.index(), side.other().index());
            let opposite: Vec<usize> = self.points.p2[o].into_iter().collect();
            let Some(p2) = self.points.p2[s] else {
                let through = self.path(feeders, &self.trunk[s], &[&self.trunk[o], &opposite]);
                return (through.clone(), through);
            };
            let sources = if feeders.is_empty() { &opposite } else { feeders };
            let p1 = self.path(&[p2], sources, &[left, right, &opposite]);
            (p1, self.path(&[p2], &self.trunk[s], &[&self.trunk[o], &opposite, feeders]))
        });
        let [(p1_left, pcomm_left), (p1_right, pcomm_right)] = both;
        [[p1_left, p1_right], [pcomm_left, pcomm_right]]
    }

    /// For each side the path from the outlet of P2 to the basilar artery, and P1 itself: from PComm to the end of the basilar artery.
    fn proper_p1(&self, p1: &[Option<Walk>; 2], pcomm: &[Option<Walk>; 2]) -> [Option<(Walk, Walk)>; 2] {
        let empty = Walk::default();
        let tip = self.points.tip.map(|node| Walk { nodes: vec![node], edges: Vec::new() });
        [0, 1].map(|s| {
            let full = p1[s].as_ref()?;
            let path = beyond(full, pcomm[s].as_ref().unwrap_or(&empty), self.points.posterior[s]);
            let ends = |end: &Walk| end.nodes.iter().any(|node| path.nodes.contains(node));
            let end = [tip.as_ref(), p1[1 - s].as_ref()].into_iter().flatten().find(|end| ends(end));
            let proper = end.map_or_else(|| path.start(self.network, LENGTH_OF_P1), |end| path.before(end));
            Some((full.clone(), proper))
        })
    }

    /// Whether a second, short path leaves a segment and returns to it.
    fn has_second_channel(&self, path: &Walk, blocked: &[bool]) -> bool {
        let off = |vessel: usize| self.may_pass(vessel) && !path.edges.contains(&vessel);
        (0..path.nodes.len().saturating_sub(1)).any(|at| {
            let from = marked(self.network.node_count(), [path.nodes[at]]);
            let to = marked(self.network.node_count(), path.nodes[at + 1..].iter().copied());
            shortest(self.network, [&from, &to, blocked], off, LONGEST_CHANNEL).is_some()
        })
    }
}

/// The part of the path from A2 to A2 between the two A1.
fn between(acomm: &Walk, a1: &[Option<Walk>; 2]) -> Walk {
    let path = a1[0].as_ref().map_or_else(|| acomm.clone(), |left| acomm.after(left));
    a1[1].as_ref().map_or_else(|| path.clone(), |right| path.before(right))
}

/// The part of a path beyond its junction: a landmark, or where it leaves the other path from the same outlet.
fn beyond(path: &Walk, other: &Walk, junction: Option<usize>) -> Walk {
    let landmark = junction.filter(|node| path.nodes.contains(node));
    landmark.map_or_else(|| path.after(other), |node| path.after(&Walk { nodes: vec![node], edges: Vec::new() }))
}

/// The vessels of the segment that leaves a carotid, by the path to it from an outlet: those from its junction on, where the other segment that
/// begins there or a landmark tells it; else the vessel at the carotid.
fn from_carotid(path: Option<&Walk>, other: Option<&Walk>, junction: Option<usize>) -> Vec<usize> {
    let Some(path) = path else { return Vec::new() };
    let is_known = other.is_some() || junction.is_some_and(|node| path.nodes.contains(&node));
    let proper = if is_known { beyond(path, other.unwrap_or(&Walk::default()), junction).edges } else { Vec::new() };
    if proper.is_empty() { path.edges.last().copied().into_iter().collect() } else { proper }
}
