//! The free ends of a network, and which of them blood comes in by: few, true and wide.

use crate::network::{Fragments, Network, Origin, Role, Vessel, fragments, may_be_speck};
use crate::support::ties::{compare, near_zero, steady};
use crate::support::{Point, bounds, centroid, counted, distance, dot, lerp, norm_squared, sub};

/// How far out, as a share of the way from the middle of all ends to the two widest, the third and the fourth inlet lie at least. Blood
/// comes in from one side: by two carotids, and by the basilar artery or two vertebral arteries, which begin as low as the carotids.
const LEAST_OUT: [f64; 2] = [0.25, 0.9];
/// An end that is probably joined to another vessel is the end of a gap, not of the tree.
const PROBABLE: f64 = 0.5;
/// An inlet is at least this share as wide as the widest: vertebral arteries have some 0.6 of the radius of a carotid.
const LEAST_WIDTH: f64 = 0.5;
/// Ends whose radii differ by less than this share are equally wide.
const SAME_WIDTH: f64 = 0.05;
/// No inlet lies in a part that nothing can join to the longest part and that has less than this share of its length: it may be a piece of a
/// sinus. The parts of traced circles that hold a carotid or the basilar artery have at least 0.2.
const LEAST_PART: f64 = 0.1;

/// The free ends of the observed vessels (of all vessels where none is observed) that have no condition. A contact of observed vessels
/// does not make one, and a speck that nothing can join to another part has none.
#[derive(Debug, Clone)]
pub struct FreeEnds<'a> {
    network: &'a Network,
    /// Their nodes, in order.
    pub nodes: Vec<usize>,
    /// By node the mean radius of the vessel over its last points at this end, m.
    pub radius: Vec<f64>,
    /// By node.
    part: Vec<usize>,
    /// By node whether inlets are looked for there: not in a small part that nothing can join to the rest.
    belongs: Vec<bool>,
    /// By node, the sum of the probabilities of the candidates there.
    joined: Vec<f64>,
    /// The mean position of the ends that belong, m.
    middle: Point,
    /// The lowest corner of the box around these, m, and the longest of its sides, m, which is positive.
    extent: (Point, f64),
}

impl<'a> FreeEnds<'a> {
    /// Nodes with one of the `roles` already are not free.
    pub fn of(network: &'a Network, roles: &[Role]) -> Self {
        let any_observed = network.vessels().any(|(_, v)| v.origin == Origin::Observed);
        let counts = |v: &Vessel| !any_observed || v.origin != Origin::Candidate;
        let degree = network.degrees(counts);
        let mut radius = vec![0.0; network.node_count()];
        let mut joined = vec![0.0; network.node_count()];
        for ([a, b], vessel) in network.vessels() {
            if counts(vessel) {
                radius[a] = vessel.end_radius(false);
                radius[b] = vessel.end_radius(true);
            } else {
                let probability = if vessel.certain { 1.0 } else { vessel.evidence().map_or(vessel.prior, |e| e.probability) };
                joined[a] += probability;
                joined[b] += probability;
            }
        }
        // All that can be joined being one part: by part the length, and the length times the width, of its observed vessels; m, m².
        let parts = joinable_parts(network);
        let mut measured = vec![[0.0; 2]; parts.count];
        for ([a, _], vessel) in network.vessels().filter(|(_, v)| v.origin != Origin::Candidate) {
            let [length, area] = &mut measured[parts.of_node[a]];
            *length += vessel.length;
            *area += vessel.length * 2.0 * vessel.radius;
        }
        let longest = measured.iter().map(|[length, _]| *length).fold(0.0, f64::max);
        let is_long = |n: usize| steady(measured[parts.of_node[n]][0]) >= steady(LEAST_PART * longest);
        // A speck is short, and not long beside the others.
        let is_speck = |n: usize| {
            let [length, area] = measured[parts.of_node[n]];
            may_be_speck(length, area / length) && !is_long(n)
        };
        let is_free = |n: &usize| degree[*n] == 1 && roles[*n] == Role::Inner && !is_speck(*n);
        let nodes: Vec<usize> = (0..network.node_count()).filter(is_free).collect();
        let belongs: Vec<bool> = (0..network.node_count()).map(is_long).collect();
        let placed: Vec<Point> = nodes.iter().filter(|n| belongs[**n]).filter_map(|n| network.node(*n).position).collect();
        Self {
            middle: centroid(placed.iter().copied()),
            extent: extent(&placed),
            nodes,
            belongs,
            radius,
            part: fragments(network, |_, v| counts(v)).of_node,
            joined,
            network,
        }
    }

    /// Whether a landmark names a node as an outlet, so that it is one, stated, with the condition of an outlet found.
    pub fn is_named_outlet(&self, node: usize) -> bool {
        self.network.node(node).role == Some(Role::Outlet) && self.network.node(node).condition.is_none()
    }

    /// The ends by which blood comes in, in node order: those that are `known`, as by the names of arteries, and are no ends of gaps;
    /// where there is none, those that the input states as its source ([`Node::is_source`](crate::network::Node::is_source)); where there is
    /// none either, the first two of [`FreeEnds::ranked`], and up to two more that lie on the same side (`LEAST_OUT`). With `spare` every
    /// part, and the whole, keeps an end that can be an outlet.
    pub fn inlets(&self, known: &[usize], spare: bool) -> Vec<usize> {
        let only = |is_member: &dyn Fn(usize) -> bool| -> Vec<usize> {
            self.nodes.iter().copied().filter(|node| is_member(*node) && self.joined[*node] < PROBABLE).collect()
        };
        let mut known = only(&|node| known.contains(&node));
        if known.is_empty() {
            known = only(&|node| self.network.node(node).is_source && !self.is_named_outlet(node));
        }
        let are_known = !known.is_empty();
        let ranked = if are_known { known } else { self.ranked() };
        let mut free = counted(self.part.len(), self.nodes.iter().map(|node| self.part[*node]));
        let mut inlets = Vec::new();
        for node in &ranked {
            let left = &mut free[self.part[*node]];
            if (are_known || self.goes_with(*node, &inlets)) && (!spare || *left > 1) {
                *left -= 1;
                inlets.push(*node);
            }
        }
        if inlets.is_empty() && (!spare || self.nodes.len() > 1) {
            inlets.extend(ranked.first());
        }
        inlets.sort_unstable();
        inlets
    }

    /// Whether one more end is an inlet beside those found before it. Without positions three are.
    fn goes_with(&self, node: usize, before: &[usize]) -> bool {
        let [first, second, others @ ..] = before else { return true };
        let Some(least) = LEAST_OUT.get(others.len()) else { return false };
        let out = || {
            let from_middle = |node: usize| Some(sub(self.network.node(node).position?, self.middle));
            let outward = lerp(from_middle(*first)?, from_middle(*second)?, 0.5);
            let size = self.extent.1;
            let far = norm_squared(outward) / (size * size);
            (near_zero(far) > 0.0).then_some(near_zero(dot(from_middle(node)?, outward) / (size * size) / far))
        };
        out().map_or(others.is_empty(), |out| out >= *least)
    }

    /// The ends that may be inlets, the likeliest first. Of all ends those count that do not lie in a small part of their own (`LEAST_PART`);
    /// of these the ones that probably are no ends of gaps; of these the ones where a vessel leaves the image; where up is known, the ones in the lower half; and of these the ones at least half as wide as the widest. A
    /// group without a member is passed over. Wide ends come before narrow ones; of equally wide ones the lower comes first, then the one
    /// farther from the middle of all, then by place along the axes; the number of a node decides only where two are at one place.
    /// Rounding decides nothing: what differs in the last digits is equal.
    pub fn ranked(&self) -> Vec<usize> {
        let mut ends: Vec<usize> = self.nodes.iter().copied().filter(|node| !self.is_named_outlet(*node)).collect();
        let mut only = |is_member: &dyn Fn(usize) -> bool| {
            if ends.iter().any(|node| is_member(*node)) {
                ends.retain(|node| is_member(*node));
            }
        };
        let (low, size) = self.extent;
        // Where it is along an axis, as a share of the extent of all.
        let position = |node: usize| self.network.node(node).position;
        let along = |node: usize, axis: usize| position(node).map_or(0.0, |p| near_zero((p[axis] - low[axis]) / size));
        only(&|node| self.belongs[node]);
        only(&|node| steady(self.joined[node]) < PROBABLE);
        only(&|node| self.network.node(node).at_border);
        // The third axis points to the head, and blood comes in from below.
        if self.network.frame.is_known() {
            let placed = || self.nodes.iter().filter(|node| self.belongs[**node] && position(**node).is_some());
            let half = 0.5 * placed().map(|node| along(*node, 2)).fold(0.0, f64::max);
            only(&|node| position(node).is_some() && along(node, 2) <= half);
        }
        let widest = ends.iter().map(|node| self.radius[*node]).fold(0.0, f64::max);
        let width = |node: usize| steady(self.radius[node] / widest);
        ends.retain(|node| width(*node) >= LEAST_WIDTH);
        let far = |node: usize| position(node).map_or(0.0, |p| near_zero(distance(p, self.middle) / size));
        let order = |node: usize| [along(node, 2), -far(node), along(node, 0), along(node, 1)];
        ends.sort_by(|a, b| width(*b).total_cmp(&width(*a)));
        // Groups of equal width, each measured from its widest.
        let mut ranked = Vec::with_capacity(ends.len());
        while let Some(widest) = ends.first().map(|node| width(*node)) {
            let same = ends.iter().take_while(|node| steady(width(**node) / widest) > 1.0 - SAME_WIDTH).count();
            let mut group: Vec<usize> = ends.drain(..same.max(1)).collect();
            group.sort_by(|a, b| compare(&order(*a), &order(*b)).then(a.cmp(b)));
            ranked.extend(group);
        }
        ranked
    }
}

/// The lowest corner of the box around points, and the longest of its sides, or 1 where that is none.
fn extent(points: &[Point]) -> (Point, f64) {
    let [low, high] = bounds(points.iter().copied());
    let sides = sub(high, low);
    let size = sides[0].max(sides[1]).max(sides[2]);
    (low, if size > 0.0 { size } else { 1.0 })
}

/// The parts that the vessels make which can be open.
pub fn joinable_parts(network: &Network) -> Fragments {
    fragments(network, |_, v| v.prior > 0.0 || v.certain || v.origin == Origin::Observed)
}
