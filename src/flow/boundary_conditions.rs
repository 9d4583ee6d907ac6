//! Boundary conditions: which nodes blood enters and leaves by, as given or as found.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::network::units::cubic_metres_per_second;
use crate::network::{Condition, INLET_PRESSURE, Network, Origin, Role, Vessel, fragments};

/// The widest free ends of the whole network that become inlets, at the most.
const WIDEST_ENDS: usize = 3;

/// A condition that a person or a file states.
#[derive(Debug, Clone, Copy, PartialEq)]
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

/// The boundary conditions of a network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Boundary {
    /// Node and condition, each node at most once, in node order.
    pub conditions: Vec<(usize, Condition)>,
    /// The role of every node.
    pub roles: Vec<Role>,
    /// Nodes that became inlets because none was given.
    pub found_inlets: Vec<usize>,
    /// Nodes that became outlets because none was given, but those that a landmark names: these are stated.
    pub found_outlets: Vec<usize>,
}

impl Boundary {
    /// The conditions given, and where they lack a source or a sink, those found at the free ends.
    ///
    /// # Errors
    ///
    /// No inlet or no outlet is given and there is no free end to make one of; nothing fixes a pressure.
    pub fn resolve(network: &Network, given: &[Given], outlets: FoundOutlets) -> Result<Self> {
        let mut boundary = Self {
            conditions: given.iter().map(|g| (g.node, g.condition)).collect(),
            roles: vec![Role::Inner; network.node_count()],
            found_inlets: Vec::new(),
            found_outlets: Vec::new(),
        };
        for g in given {
            boundary.roles[g.node] = g.role;
        }
        let inlets = given.iter().any(|g| g.role == Role::Inlet);
        let sinks = given.iter().any(|g| g.role == Role::Outlet);
        let ends = FreeEnds::of(network, &boundary.roles);
        if !inlets {
            let inlets = ends.inlets(!sinks);
            if inlets.is_empty() {
                return Err(none("inlet", &ends, sinks));
            }
            boundary.find(&inlets, Role::Inlet, |_| Condition::INLET);
            boundary.found_inlets = inlets;
        }
        if !sinks {
            let found: Vec<usize> = ends.nodes.iter().copied().filter(|n| boundary.roles[*n] == Role::Inner).collect();
            if found.is_empty() {
                return Err(none("outlet", &ends, true));
            }
            let cubes: Vec<f64> = found.iter().map(|n| ends.radius[*n].powi(3)).collect();
            let total: f64 = cubes.iter().sum();
            let pressure = boundary.conditions.iter().filter_map(|(_, c)| match c {
                Condition::Pressure(p) => Some(*p),
                _ => None,
            });
            let pressure = pressure.fold(0.0, f64::max);
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
            boundary.found_outlets = found.into_iter().filter(|node| !is_named_outlet(network, *node)).collect();
        }
        boundary.conditions.sort_by_key(|(node, _)| *node);
        for (_, condition) in &mut boundary.conditions {
            *condition = condition.as_stored();
        }
        if boundary.conditions.iter().all(|(_, c)| matches!(c, Condition::Flow(_))) {
            return Err(Error::parameter(
                "conditions",
                "are flows only",
                "expected a pressure or a resistance at one node at least",
            ));
        }
        Ok(boundary)
    }

    /// The condition of a node.
    pub fn condition(&self, node: usize) -> Option<Condition> {
        let at = self.conditions.binary_search_by_key(&node, |(n, _)| *n).ok()?;
        Some(self.conditions[at].1)
    }

    /// The same conditions for a network that continues this one with more nodes.
    #[must_use]
    pub fn extended_to(mut self, nodes: usize) -> Self {
        self.roles.resize(nodes, Role::Inner);
        self
    }

    /// The network with these roles and conditions as those that its nodes state, so that a file of it keeps them.
    #[must_use]
    pub fn stated_in(&self, mut network: Network) -> Network {
        for (node, role) in self.roles.iter().enumerate() {
            let stated = network.node_mut(node);
            (stated.role, stated.condition) = (Some(*role), self.condition(node));
        }
        network
    }

    /// Whether the condition of a node was found, not stated.
    pub fn is_found(&self, node: usize) -> bool {
        self.found_inlets.contains(&node) || self.found_outlets.contains(&node)
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

/// The conditions that the nodes of a network state themselves.
///
/// A pressure without a role belongs to an inlet when it lies in the upper half of all stated pressures; equal
/// pressures are inlets, unless they are ground. A flow into the network is an inlet.
pub fn stated(network: &Network) -> Vec<Given> {
    let pressure = |c: &Condition| if let Condition::Pressure(p) = c { Some(*p) } else { None };
    let pressures = || network.nodes().filter_map(|n| n.condition.as_ref().and_then(pressure));
    let (low, high) = (pressures().fold(f64::INFINITY, f64::min), pressures().fold(f64::NEG_INFINITY, f64::max));
    let role = |condition: &Condition| match condition {
        Condition::Pressure(p) if *p != 0.0 && 2.0 * p >= low + high => Role::Inlet,
        Condition::Flow(q) => Role::of_flow(*q),
        _ => Role::Outlet,
    };
    let given = network.nodes().enumerate().filter_map(|(node, n)| {
        let condition = n.condition?;
        Some(Given { node, role: n.role.filter(|r| *r != Role::Inner).unwrap_or_else(|| role(&condition)), condition })
    });
    given.collect()
}

/// Whether a landmark names a node as an outlet, so that it is one, stated, with the condition of an outlet found.
fn is_named_outlet(network: &Network, node: usize) -> bool {
    let node = network.node(node);
    node.role == Some(Role::Outlet) && node.condition.is_none()
}

fn none(what: &str, ends: &FreeEnds, other: bool) -> Error {
    let ends = ends.nodes.len();
    let what_is_missing = if other { format!("no {what}") } else { format!("no {what} and no outlet") };
    Error::parameter(
        what_is_missing,
        format!("is given or can be found among {ends} free ends"),
        format!("give `{what}` NODE (an id, a label or x,y,z in mm){}", if other { "" } else { " and `outlet` NODE" }),
    )
}

/// The free ends of the observed vessels (of all vessels where none is observed), each with the mean radius over its
/// last points.
struct FreeEnds {
    nodes: Vec<usize>,
    radius: Vec<f64>,
    part: Vec<usize>,
    at_border: Vec<bool>,
    named_outlet: Vec<bool>,
}

impl FreeEnds {
    /// Nodes with a role already are not free.
    fn of(network: &Network, roles: &[Role]) -> Self {
        let any_observed = network.vessels().any(|(_, v)| v.origin == Origin::Observed);
        let counts = |v: &Vessel| !any_observed || v.origin == Origin::Observed;
        let degree = network.degrees(counts);
        let mut radius = vec![0.0; network.node_count()];
        for ([a, b], vessel) in network.vessels().filter(|(_, v)| counts(v)) {
            radius[a] = vessel.end_radius(false);
            radius[b] = vessel.end_radius(true);
        }
        let nodes: Vec<usize> = (0..network.node_count()).filter(|n| degree[*n] == 1 && roles[*n] == Role::Inner).collect();
        let at_border = network.nodes().map(|node| node.at_border).collect();
        let named_outlet = (0..network.node_count()).map(|node| is_named_outlet(network, node)).collect();
        Self { nodes, radius, part: fragments(network, |_, v| counts(v)).of_node, at_border, named_outlet }
    }

    /// The widest ends, up to three, and the widest of each part with two or more; `spare` leaves every part, and the
    /// whole, an end that can be an outlet. Ends where a vessel leaves the image come before all others. Ties go to the lower node.
    fn inlets(&self, spare: bool) -> Vec<usize> {
        let mut free = std::collections::BTreeMap::new();
        for node in &self.nodes {
            *free.entry(self.part[*node]).or_insert(0_usize) += 1;
        }
        let many: std::collections::BTreeSet<usize> = free.iter().filter(|(_, n)| **n > 1).map(|(part, _)| *part).collect();
        let mut widest: Vec<usize> = self.nodes.iter().copied().filter(|node| !self.named_outlet[*node]).collect();
        let by_width = |a: &usize, b: &usize| self.radius[*b].total_cmp(&self.radius[*a]).then(a.cmp(b));
        widest.sort_by(|a, b| self.at_border[*b].cmp(&self.at_border[*a]).then_with(|| by_width(a, b)));
        let mut inlets = Vec::new();
        let mut started = std::collections::BTreeSet::new();
        for node in &widest {
            let part = self.part[*node];
            let left = free.entry(part).or_default();
            let wanted = inlets.len() < WIDEST_ENDS || (many.contains(&part) && !started.contains(&part));
            if wanted && (!spare || *left > 1) {
                *left -= 1;
                started.insert(part);
                inlets.push(*node);
            }
        }
        if inlets.is_empty() && (!spare || widest.len() > 1) {
            inlets.extend(widest.first());
        }
        inlets.sort_unstable();
        inlets
    }
}
