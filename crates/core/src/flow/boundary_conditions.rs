//! Boundary conditions: which nodes blood enters and leaves by, as given or as found. They are found at the free ends of a network; few of
//! these, true and wide ones, are those that blood comes in by.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result, ensure, require};
use crate::network::units::cubic_metres_per_second;
use crate::network::{
    Condition, ConditionFrom, Fragments, INLET_PRESSURE, Network, Origin, Role, Vessel, fragments, may_be_speck,
};
use crate::support::ties::{compare, near_zero, steady};
use crate::support::{Point, bounds, centroid, counted, distance, dot, lerp, marked, norm_squared, sub};

/// A condition that a person or a file states.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Given {
    /// The node's row.
    pub node: usize,
    /// Inlet or outlet.
    pub role: Role,
    /// What holds there.
    pub condition: Condition,
}

/// What outlets that willis finds by itself are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FoundOutlets {
    /// Zero pressure, as in the paper.
    Ground,
    /// Terminal resistances in proportion to 1/r³ (Murray's law), to zero venous pressure.
    Murray(Total),
}

impl FoundOutlets {
    /// The outlets of a brain when nothing is stated: 700 mL/min in all.
    pub const CEREBRAL: Self = Self::Murray(Total::Flow(cubic_metres_per_second(700.0)));
}

/// What the terminal resistances of all outlets found come to, side by side.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Total {
    /// They let this flow pass at the highest pressure of any condition, m³/s.
    #[serde(rename = "flow_m3_per_s")]
    Flow(f64),
    /// Pa s/m³.
    #[serde(rename = "resistance_Pa_s_per_m3")]
    Resistance(f64),
}

/// The boundary conditions of a network. One that was found belongs to a free end: it does not hold where a candidate or contact joins that
/// end ([`Boundary::provisional`]), because the end of a gap neither feeds nor drains the vessel that it was joined to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Boundary {
    /// Node and condition, each node at most once, in node order.
    pub conditions: Vec<(usize, Condition)>,
    /// The role of every node.
    pub roles: Vec<Role>,
    /// Nodes that became inlets because none was given, in node order.
    pub found_inlets: Vec<usize>,
    /// Nodes that became outlets because none was given, in node order, but those that a landmark names: these are stated.
    pub found_outlets: Vec<usize>,
    /// Outlets that landmarks name, in node order: stated, but with resistances that are shares of the total as those of outlets found.
    pub named_outlets: Vec<usize>,
}

/// The conditions found that hold only where no other connection is there: per free end the rows of the candidates and contacts there.
pub type Provisional = BTreeMap<usize, Vec<usize>>;

impl Boundary {
    /// The conditions given, and where they lack a source or a sink, those found at the free ends: what a file says that an earlier run
    /// found ([`Node::condition_from`](crate::network::Node::condition_from)), else by [`FreeEnds`].
    ///
    /// # Errors
    ///
    /// No inlet or no outlet is given and there is no free end to make one of; nothing fixes a pressure.
    pub fn resolve(network: &Network, given: &[Given], outlets: FoundOutlets) -> Result<Self> {
        Self::resolve_knowing(network, given, outlets, &[])
    }

    /// As [`Boundary::resolve`]. Where inlets are found, those among the `known` nodes come before all others: where arteries with such names
    /// enter.
    ///
    /// # Errors
    ///
    /// As [`Boundary::resolve`].
    pub fn resolve_knowing(network: &Network, given: &[Given], outlets: FoundOutlets, known: &[usize]) -> Result<Self> {
        let mut boundary = Self {
            conditions: given.iter().map(|g| (g.node, g.condition)).collect(),
            roles: vec![Role::Inner; network.node_count()],
            ..Self::default()
        };
        for g in given {
            boundary.roles[g.node] = g.role;
        }
        let inlets = given.iter().any(|g| g.role == Role::Inlet);
        let sinks = given.iter().any(|g| g.role == Role::Outlet);
        // They stand beside those that are stated, such as the outlets that landmarks named.
        boundary.found_inlets = boundary.found_before(network, Role::Inlet, ConditionFrom::FreeEnd);
        boundary.found_outlets = boundary.found_before(network, Role::Outlet, ConditionFrom::FreeEnd);
        boundary.named_outlets = boundary.found_before(network, Role::Outlet, ConditionFrom::Landmark);
        let sinks = sinks || boundary.count(Role::Outlet) > 0;
        let ends = FreeEnds::of(network, &boundary.roles);
        if !inlets && boundary.found_inlets.is_empty() {
            let inlets = ends.inlets(known, !sinks);
            ensure(!inlets.is_empty(), || none("inlet", &ends, sinks))?;
            boundary.find(&inlets, Role::Inlet, |_| Condition::INLET);
            boundary.found_inlets = inlets;
        }
        if !sinks {
            let found: Vec<usize> = ends.nodes.iter().copied().filter(|n| boundary.roles[*n] == Role::Inner).collect();
            ensure(!found.is_empty(), || none("outlet", &ends, true))?;
            let cube = |node: usize| ends.radius[node].powi(3);
            let total: f64 = found.iter().map(|node| cube(*node)).sum();
            let pressure = boundary.conditions.iter().filter_map(|(_, c)| c.pressure()).fold(0.0, f64::max);
            let pressure = if pressure > 0.0 { pressure } else { INLET_PRESSURE };
            boundary.find(&found, Role::Outlet, |node| match outlets {
                FoundOutlets::Ground => Condition::GROUND,
                FoundOutlets::Murray(of_all) => {
                    let share = cube(node) / total;
                    let resistance = match of_all {
                        Total::Flow(flow) => pressure / (flow * share),
                        Total::Resistance(resistance) => resistance / share,
                    };
                    Condition::Resistance { resistance, venous: 0.0 }
                }
            });
            (boundary.named_outlets, boundary.found_outlets) = found.into_iter().partition(|node| ends.is_named_outlet(*node));
        }
        boundary.conditions.sort_by_key(|(node, _)| *node);
        for (_, condition) in &mut boundary.conditions {
            *condition = condition.as_stored();
        }
        let are_flows = boundary.conditions.iter().all(|(_, c)| matches!(c, Condition::Flow(_)));
        require(!are_flows, "conditions", "are flows only", "expected a pressure or a resistance at one node at least")?;
        Ok(boundary)
    }

    /// Takes over the conditions of a role that the file says an earlier run worked out so, and returns their nodes.
    fn found_before(&mut self, network: &Network, role: Role, from: ConditionFrom) -> Vec<usize> {
        let mut nodes = Vec::new();
        for (node, of) in network.nodes().enumerate().filter(|(_, of)| of.condition_from == from && of.role == Some(role)) {
            if let Some(condition) = of.condition.filter(|_| self.roles[node] == Role::Inner) {
                self.roles[node] = role;
                self.conditions.push((node, condition));
                nodes.push(node);
            }
        }
        nodes
    }

    /// The found conditions at ends that a candidate or a contact leaves.
    pub fn provisional(&self, network: &Network) -> Provisional {
        let mut at: BTreeMap<usize, (bool, Vec<usize>)> =
            self.found_inlets.iter().chain(&self.found_outlets).map(|node| (*node, (false, Vec::new()))).collect();
        for (row, ([a, b], vessel)) in network.vessels().enumerate() {
            for node in if a == b { vec![a] } else { vec![a, b] } {
                if let Some((is_end, others)) = at.get_mut(&node) {
                    if vessel.origin == Origin::Observed { *is_end = true } else { others.push(row) }
                }
            }
        }
        // Where nothing is observed, the vessel of a free end is one of the others.
        let some = at.into_iter().filter(|(_, (is_end, others))| *is_end && !others.is_empty());
        some.map(|(node, (_, others))| (node, others)).collect()
    }

    /// The conditions of the topology of the `open` vessels. Found ones at ends that were joined are gone, and so are found outlets of parts
    /// without an inlet. Terminal resistances that are shares of a total are scaled as if all outlets' were, so that those left conduct as much side by
    /// side as all did before; what a person or a file states stays.
    #[must_use]
    pub fn held(&self, network: &Network, open: impl Fn(usize) -> bool) -> Self {
        let provisional = self.provisional(network);
        let holds = |node: usize| provisional.get(&node).is_none_or(|others| !others.iter().any(|row| open(*row)));
        let parts = fragments(network, |row, _| open(row));
        let fed = parts.holding(self.inlets().filter(|node| holds(*node)));
        let found_outlets: Vec<usize> = self.found_outlets.iter().copied().filter(|node| holds(*node) && fed[*node]).collect();
        let found_inlets: Vec<usize> = self.found_inlets.iter().copied().filter(|node| holds(*node)).collect();
        let stays = |node: usize| {
            !self.is_found(node) || found_inlets.binary_search(&node).is_ok() || found_outlets.binary_search(&node).is_ok()
        };
        let conducts = |counts: &dyn Fn(usize) -> bool| -> f64 {
            let outlets = self.conditions.iter().filter(|(node, _)| self.roles[*node] == Role::Outlet && counts(*node));
            outlets.filter_map(|(_, condition)| condition.conductance()).sum()
        };
        let scale = if found_outlets.len() < self.found_outlets.len() {
            conducts(&|node| stays(node) && fed[node]) / conducts(&|_| true)
        } else {
            1.0
        };
        let mut roles = self.roles.clone();
        let mut conditions = self.conditions.clone();
        conditions.retain_mut(|(node, condition)| {
            if !stays(*node) {
                roles[*node] = Role::Inner;
                return false;
            }
            if let Condition::Resistance { resistance, .. } = condition
                && self.from(*node) != ConditionFrom::Statement
                && fed[*node]
            {
                *resistance *= scale;
                *condition = condition.as_stored();
            }
            true
        });
        Self { conditions, roles, found_inlets, found_outlets, named_outlets: self.named_outlets.clone() }
    }

    /// The nodes with a condition where blood enters.
    fn inlets(&self) -> impl Iterator<Item = usize> {
        self.conditions.iter().map(|(node, _)| *node).filter(|node| self.roles[*node] == Role::Inlet)
    }

    /// The condition of a node.
    pub fn condition(&self, node: usize) -> Option<Condition> {
        let at = self.conditions.binary_search_by_key(&node, |(n, _)| *n).ok()?;
        Some(self.conditions[at].1)
    }

    /// The network with these roles and conditions as those that its nodes state, so that a file of it keeps them.
    #[must_use]
    pub fn stated_in(&self, mut network: Network) -> Network {
        for (row, stated) in self.stated().into_iter().enumerate() {
            let node = network.node(row);
            // Nodes that state it are shared with the network that they are of.
            if (node.role, node.condition, node.condition_from) != stated {
                let node = network.node_mut(row);
                (node.role, node.condition, node.condition_from) = stated;
            }
        }
        network
    }

    /// Per node its role, its condition, and where that is from, as a file states them.
    pub fn stated(&self) -> Vec<(Option<Role>, Option<Condition>, ConditionFrom)> {
        let of_node = |(node, role): (usize, &Role)| (Some(*role), self.condition(node), self.from(node));
        self.roles.iter().enumerate().map(of_node).collect()
    }

    /// Whether the condition of a node was found, not stated.
    pub fn is_found(&self, node: usize) -> bool {
        self.found_inlets.binary_search(&node).is_ok() || self.found_outlets.binary_search(&node).is_ok()
    }

    fn from(&self, node: usize) -> ConditionFrom {
        if self.is_found(node) {
            ConditionFrom::FreeEnd
        } else if self.named_outlets.binary_search(&node).is_ok() {
            ConditionFrom::Landmark
        } else {
            ConditionFrom::Statement
        }
    }

    /// How many nodes have a role.
    pub fn count(&self, role: Role) -> usize {
        self.roles.iter().filter(|r| **r == role).count()
    }

    fn find(&mut self, nodes: &[usize], role: Role, condition: impl Fn(usize) -> Condition) {
        for node in nodes {
            self.roles[*node] = role;
            self.conditions.push((*node, condition(*node)));
        }
    }
}

/// The conditions that the nodes of a network state themselves, without those that an earlier run found.
///
/// A pressure without a role belongs to an inlet when it lies in the upper half of all stated pressures; equal
/// pressures are inlets, unless they are ground. A flow into the network is an inlet.
pub fn stated(network: &Network) -> Vec<Given> {
    let pressures = || network.nodes().filter_map(|n| n.condition?.pressure());
    let (low, high) = (pressures().fold(f64::INFINITY, f64::min), pressures().fold(f64::NEG_INFINITY, f64::max));
    let role = |condition: &Condition| match condition {
        Condition::Pressure(p) if *p != 0.0 && 2.0 * p >= low + high => Role::Inlet,
        Condition::Flow(q) => Role::of_flow(*q),
        _ => Role::Outlet,
    };
    let given = network.nodes().enumerate().filter_map(|(node, n)| {
        let condition = n.condition.filter(|_| n.condition_from == ConditionFrom::Statement)?;
        Some(Given { node, role: n.role.filter(|r| *r != Role::Inner).unwrap_or_else(|| role(&condition)), condition })
    });
    given.collect()
}

/// A network that was decided on, with the conditions that an earlier run found in it found again where its free ends are others by now: inlets stay where
/// their ends are free, and outlets conduct as much side by side as they did.
#[must_use]
pub fn find_again(network: Network) -> Network {
    let found = || network.nodes().enumerate().filter(|(_, node)| node.condition_from != ConditionFrom::Statement);
    if found().next().is_none() {
        return network;
    }
    let conducts: f64 = found().filter_map(|(_, node)| node.condition?.conductance()).sum();
    let outlets = if conducts > 0.0 { FoundOutlets::Murray(Total::Resistance(1.0 / conducts)) } else { FoundOutlets::Ground };
    let mut inlets: Vec<usize> = found().filter(|(_, node)| node.role == Some(Role::Inlet)).map(|(row, _)| row).collect();
    let ends = FreeEnds::of(&network, &vec![Role::Inner; network.node_count()]).inlets(&inlets, false);
    inlets.retain(|row| ends.contains(row));
    let mut left = network.clone();
    for (row, node) in found().filter(|(row, _)| !inlets.contains(row)) {
        let role = node.role.filter(|_| node.condition_from == ConditionFrom::Landmark);
        let node = left.node_mut(row);
        (node.role, node.condition, node.condition_from) = (role, None, ConditionFrom::Statement);
    }
    let was = || network.nodes().map(|node| node.role.unwrap_or(Role::Inner));
    match Boundary::resolve(&left, &stated(&left), outlets) {
        Ok(boundary) if was().eq(boundary.roles.iter().copied()) => network,
        Ok(boundary) => boundary.stated_in(left),
        Err(_) => left,
    }
}

fn none(what: &str, ends: &FreeEnds, other: bool) -> Error {
    let (no_other, give_other) = if other { ("", "") } else { (" and no outlet", " and `outlet=NODE`") };
    let found = format!("is given or can be found among {} free ends", ends.nodes.len());
    let accepted = format!("give `{what}=NODE` (an id, a label or x,y,z in mm){give_other}");
    Error::parameter(format!("no {what}{no_other}"), found, accepted)
}

/// How many parts of the observed vessels can be joined to no inlet, whatever candidates are open: no blood flows there.
pub fn unfed_fragments(network: &Network, boundary: &Boundary) -> usize {
    let fed = joinable_parts(network).holding(boundary.inlets());
    let observed = |v: &Vessel| v.origin != Origin::Candidate;
    let parts = fragments(network, |_, v| observed(v));
    let mut unfed = vec![false; parts.count];
    for ([a, _], _) in network.vessels().filter(|(_, v)| observed(v)) {
        unfed[parts.of_node[a]] = !fed[a];
    }
    unfed.into_iter().filter(|unfed| *unfed).count()
}

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
    /// By node, all that is one or probably joined being one part.
    part: Vec<usize>,
    /// By node whether a candidate probably joins it.
    is_joined: Vec<bool>,
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
        let probability = |v: &Vessel| if v.certain { 1.0 } else { v.evidence().map_or(v.prior, |e| e.probability) };
        let joins = |v: &Vessel| !counts(v) && probability(v) >= PROBABLE;
        let is_joined = marked(network.node_count(), network.vessels().filter(|(_, v)| joins(v)).flat_map(|(ends, _)| ends));
        for ([a, b], vessel) in network.vessels() {
            if counts(vessel) {
                radius[a] = vessel.end_radius(false);
                radius[b] = vessel.end_radius(true);
            } else {
                joined[a] += probability(vessel);
                joined[b] += probability(vessel);
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
            part: fragments(network, |_, v| counts(v) || joins(v)).of_node,
            is_joined,
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
        // An end that a candidate probably joins can be no outlet.
        let can_be_outlet = |node: &usize| !self.is_joined[*node];
        let spared = self.nodes.iter().filter(|node| can_be_outlet(node));
        let mut free = counted(self.part.len(), spared.map(|node| self.part[*node]));
        let mut inlets = Vec::new();
        for node in &ranked {
            let (left, taken) = (&mut free[self.part[*node]], usize::from(can_be_outlet(node)));
            if (are_known || self.goes_with(*node, &inlets)) && (!spare || *left > taken) {
                *left -= taken;
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
