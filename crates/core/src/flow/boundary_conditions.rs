//! Boundary conditions: which nodes blood enters and leaves by, as given or as found.

use serde::{Deserialize, Serialize};

use super::free_ends::{FreeEnds, joinable_parts};
use crate::error::{Error, Result};
use crate::network::{Condition, INLET_PRESSURE, Network, Origin, Role, Vessel, fragments, units::cubic_metres_per_second};

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
}

/// A found condition that holds only where none of some connections is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provisional {
    /// The free end.
    pub node: usize,
    /// The rows of the candidates and contacts there.
    pub others: Vec<usize>,
}

impl Boundary {
    /// The conditions given, and where they lack a source or a sink, those found at the free ends: what a file says that an earlier run
    /// found ([`Node::found`](crate::network::Node::found)), else by [`FreeEnds`].
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
        boundary.found_inlets = boundary.found_before(network, Role::Inlet);
        boundary.found_outlets = boundary.found_before(network, Role::Outlet);
        let ends = FreeEnds::of(network, &boundary.roles);
        if !inlets && boundary.found_inlets.is_empty() {
            let inlets = ends.inlets(known, !sinks && boundary.found_outlets.is_empty());
            if inlets.is_empty() {
                return Err(none("inlet", &ends, sinks));
            }
            boundary.find(&inlets, Role::Inlet, |_| Condition::INLET);
            boundary.found_inlets = inlets;
        }
        if !sinks && boundary.found_outlets.is_empty() {
            let found: Vec<usize> = ends.nodes.iter().copied().filter(|n| boundary.roles[*n] == Role::Inner).collect();
            if found.is_empty() {
                return Err(none("outlet", &ends, true));
            }
            let cubes: Vec<f64> = found.iter().map(|n| ends.radius[*n].powi(3)).collect();
            let total: f64 = cubes.iter().sum();
            let pressure = boundary.conditions.iter().filter_map(|(_, c)| c.pressure()).fold(0.0, f64::max);
            let pressure = if pressure > 0.0 { pressure } else { INLET_PRESSURE };
            let mut cubes = cubes.into_iter();
            boundary.find(&found, Role::Outlet, |_| match outlets {
                FoundOutlets::Ground => Condition::GROUND,
                FoundOutlets::Murray(of_all) => {
                    let share = cubes.next().unwrap_or(total) / total;
                    let resistance = match of_all {
                        Total::Flow(flow) => pressure / (flow * share),
                        Total::Resistance(resistance) => resistance / share,
                    };
                    Condition::Resistance { resistance, venous: 0.0 }
                }
            });
            boundary.found_outlets = found.into_iter().filter(|node| !ends.is_named_outlet(*node)).collect();
        }
        boundary.conditions.sort_by_key(|(node, _)| *node);
        for (_, condition) in &mut boundary.conditions {
            *condition = condition.as_stored();
        }
        if boundary.conditions.iter().all(|(_, c)| matches!(c, Condition::Flow(_))) {
            let accepted = "expected a pressure or a resistance at one node at least";
            return Err(Error::parameter("conditions", "are flows only", accepted));
        }
        Ok(boundary)
    }

    /// Takes over the conditions of a role that the file says were found, and returns their nodes.
    fn found_before(&mut self, network: &Network, role: Role) -> Vec<usize> {
        let mut nodes = Vec::new();
        for (node, of) in network.nodes().enumerate().filter(|(_, of)| of.found && of.role == Some(role)) {
            if let Some(condition) = of.condition.filter(|_| self.roles[node] == Role::Inner) {
                self.roles[node] = role;
                self.conditions.push((node, condition));
                nodes.push(node);
            }
        }
        nodes
    }

    /// The found conditions at ends that a candidate or a contact leaves, in node order.
    pub fn provisional(&self, network: &Network) -> Vec<Provisional> {
        let mut at: std::collections::BTreeMap<usize, (bool, Vec<usize>)> =
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
        some.map(|(node, (_, others))| Provisional { node, others }).collect()
    }

    /// The conditions of the topology of the `open` vessels. Found ones at ends that were joined are gone, and so are found outlets of parts
    /// without an inlet. Found terminal resistances are scaled, so that those left conduct as much side by side as all did before.
    #[must_use]
    pub fn held(&self, network: &Network, open: impl Fn(usize) -> bool) -> Self {
        let joined: Vec<usize> =
            self.provisional(network).into_iter().filter(|p| p.others.iter().any(|row| open(*row))).map(|p| p.node).collect();
        let holds = |node: usize| joined.binary_search(&node).is_err();
        let parts = fragments(network, |row, _| open(row));
        let fed = parts.holding(self.inlets().filter(|node| holds(*node)));
        let mut found_outlets = self.found_outlets.clone();
        found_outlets.retain(|node| holds(*node) && fed[*node]);
        let mut found_inlets = self.found_inlets.clone();
        found_inlets.retain(|node| holds(*node));
        let conducts = |nodes: &[usize]| -> f64 {
            let terminal = |node: &usize| match self.condition(*node) {
                Some(Condition::Resistance { resistance, .. }) => 1.0 / resistance,
                _ => 0.0,
            };
            nodes.iter().map(terminal).sum()
        };
        let scale = if found_outlets.len() < self.found_outlets.len() {
            conducts(&found_outlets) / conducts(&self.found_outlets)
        } else {
            1.0
        };
        let mut roles = self.roles.clone();
        let mut conditions = self.conditions.clone();
        conditions.retain_mut(|(node, condition)| {
            if !self.is_found(*node) {
                return true;
            }
            let stays = found_inlets.binary_search(node).is_ok() || found_outlets.binary_search(node).is_ok();
            if !stays {
                roles[*node] = Role::Inner;
            } else if let Condition::Resistance { resistance, .. } = condition {
                *resistance *= scale;
                *condition = condition.as_stored();
            }
            stays
        });
        Self { conditions, roles, found_inlets, found_outlets }
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
            if (node.role, node.condition, node.found) != stated {
                let node = network.node_mut(row);
                (node.role, node.condition, node.found) = stated;
            }
        }
        network
    }

    /// Per node its role, its condition, and whether that was found, as a file states them.
    pub fn stated(&self) -> Vec<(Option<Role>, Option<Condition>, bool)> {
        let of_node = |(node, role): (usize, &Role)| (Some(*role), self.condition(node), self.is_found(node));
        self.roles.iter().enumerate().map(of_node).collect()
    }

    /// Whether the condition of a node was found, not stated.
    pub fn is_found(&self, node: usize) -> bool {
        self.found_inlets.binary_search(&node).is_ok() || self.found_outlets.binary_search(&node).is_ok()
    }

    /// How many nodes have a role.
    pub fn count(&self, role: Role) -> usize {
        self.roles.iter().filter(|r| **r == role).count()
    }

    fn find(&mut self, nodes: &[usize], role: Role, mut condition: impl FnMut(usize) -> Condition) {
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
        let condition = n.condition.filter(|_| !n.found)?;
        Some(Given { node, role: n.role.filter(|r| *r != Role::Inner).unwrap_or_else(|| role(&condition)), condition })
    });
    given.collect()
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
