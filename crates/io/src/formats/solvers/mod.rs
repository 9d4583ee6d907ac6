//! Writes a network with its conditions for solvers in time: svZeroDSolver (lumped) and openBF (one-dimensional).

pub(in crate::formats) mod openbf;
pub(in crate::formats) mod svzerod;

use std::borrow::Cow;
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;
use std::io;

use crate::formats::tables::reader::plural;
pub(in crate::formats) use openbf::MOST_JOINED;
pub use openbf::{write_openbf, write_openbf_inlet};
pub use svzerod::write_svzerod;

use willis_core::flow::WallLaw;
use willis_core::flow::floating_components::fed;
use willis_core::flow::poiseuille::BLOOD_VISCOSITY;
use willis_core::flow::state::BLOOD_DENSITY;
use willis_core::network::walks::{other_end, vessels_at};
use willis_core::network::waveform::Waveform;
use willis_core::network::{Condition, Network, Node, Origin, Role, Vessel};

/// What a simulation adds to a network for a solver in time.
#[derive(Debug, Clone, PartialEq)]
pub struct SolverSetting {
    /// Blood viscosity, Pa s.
    pub viscosity: f64,
    /// Density of blood, kg/m³.
    pub density: f64,
    /// The period, s.
    pub period: f64,
    /// One period at inlets that pulsate, from 0 to the period, by the ids of their nodes; others are constant in time.
    pub courses: BTreeMap<String, Waveform>,
}

impl Default for SolverSetting {
    fn default() -> Self {
        Self { viscosity: BLOOD_VISCOSITY, density: BLOOD_DENSITY, period: 1.0, courses: BTreeMap::new() }
    }
}

/// Whether blood enters at a node.
pub(in crate::formats) fn enters(network: &Network, node: usize) -> bool {
    match network.node(node).condition {
        Some(Condition::Flow(flow)) => flow > 0.0,
        Some(Condition::Pressure(pressure)) => pressure > 0.0 && network.node(node).role != Some(Role::Outlet),
        Some(Condition::Resistance { .. }) | None => false,
    }
}

/// The network without the parts that no blood enters, with a note that counts them; as it is where there is no inlet at all.
pub(in crate::formats) fn without_unfed(network: &Network) -> (Cow<'_, Network>, Option<String>) {
    let is_fed = fed(network, |node| enters(network, node));
    let left_out = network.vessels().filter(|([a, _], _)| !is_fed[*a]).count();
    if left_out == 0 || !is_fed.contains(&true) {
        return (Cow::Borrowed(network), None);
    }
    let note = format!("{} in parts that no blood enters, left out (`unfed=keep` writes them)", plural(left_out, "vessel"));
    (Cow::Owned(network.part(|node| is_fed[node]).0), Some(note))
}

/// The network with every vessel from a node to itself divided in two, as solvers in time need it, with a note that counts them.
pub(in crate::formats) fn without_loops(network: &Network) -> Option<(Network, String)> {
    let is_loop = |row: usize| network.ends(row)[0] == network.ends(row)[1];
    let loops: Vec<usize> = (0..network.vessel_count()).filter(|row| is_loop(*row)).collect();
    if loops.is_empty() {
        return None;
    }
    let (mut made, _) = network.subgraph(|row| !is_loop(row));
    for row in &loops {
        let (node, vessel) = (network.ends(*row)[0], network.vessel(*row));
        let middle = made.add_node(Node { id: format!("{}-loop-{row}", network.node(node).id), ..Node::default() });
        let resistance = vessel.resistance.map(|whole| whole / 2.0);
        let half = Vessel { length: vessel.length / 2.0, resistance, path: Vec::new(), ..vessel.clone() };
        made.add_vessel([node, middle], half.clone());
        made.add_vessel([middle, node], half);
    }
    Some((made, format!("{} from a node to itself, divided in two", plural(loops.len(), "vessel"))))
}

/// The network with no more than `most` vessels at a node, with a note that counts those that had more: such a node becomes several in a row, the
/// widest vessels at the first two places, joined by vessels as wide as the widest there and as long as its radius.
pub(in crate::formats) fn with_few_at_a_node(network: &Network, most: usize) -> Option<(Network, String)> {
    let mut at = vec![Vec::new(); network.node_count()];
    for (row, (ends, _)) in network.vessels().enumerate() {
        (0..2).for_each(|side| at[ends[side]].push((row, side)));
    }
    let crowded: Vec<usize> = (0..network.node_count()).filter(|node| at[*node].len() > most).collect();
    if crowded.is_empty() {
        return None;
    }
    let mut ends: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
    let (mut made, _) = network.subgraph(|_| false);
    let mut links = Vec::new();
    for node in &crowded {
        let here = &mut at[*node];
        let radius = |row: usize| network.vessel(row).radius;
        here.sort_by(|a, b| radius(b.0).total_cmp(&radius(a.0)));
        let widest = radius(here[0].0);
        let mut last = *node;
        // One place for each vessel but the last, which shares that of the one before it.
        for (number, (row, side)) in here[most - 1..].iter().enumerate() {
            if number + most < here.len() {
                let id = format!("{}-part-{}", network.node(*node).id, number + 1);
                let next = made.add_node(Node { id, position: network.node(*node).position, ..Node::default() });
                links.push(([last, next], Vessel::new(widest, widest, Origin::Observed)));
                last = next;
            }
            ends[*row][*side] = last;
        }
    }
    let count = links.len();
    let all = network.vessels().zip(&ends).map(|((_, vessel), ends)| (*ends, vessel.clone())).chain(links);
    for (ends, vessel) in all {
        made.add_vessel(ends, vessel);
    }
    let nodes = plural(crowded.len(), "node");
    Some((made, format!("{nodes} of more than {most} vessels divided, by {} one radius long", plural(count, "vessel"))))
}

/// A network with vessels along the way from inlets to outlets, and what holds at their ends.
struct Directed<'a> {
    network: &'a Network,
    setting: &'a SolverSetting,
    /// By row the node where the vessel begins and that where it ends.
    turned: Vec<[usize; 2]>,
    /// By node its vessels.
    at: Vec<Vec<usize>>,
    /// A vessel to which no inlet leads, if there is one.
    unfed: Option<usize>,
    /// By row C' = dA/dP of the wall, as it is stated, else by Olufsen's law, m²/Pa.
    distensibility: Vec<f64>,
}

impl<'a> Directed<'a> {
    /// Turns the vessels so that each node between them has one that comes and one that goes: the shortest way from each inlet to an end, or to
    /// a way that is there already, and then the same from the nodes on these ways, until all vessels are turned.
    ///
    /// # Errors
    ///
    /// No condition at all, a condition in the middle of vessels, a self-loop, a wall that does not give (`InvalidInput`).
    fn of(network: &'a Network, setting: &'a SolverSetting) -> io::Result<Self> {
        let refused = |why: String| io::Error::new(io::ErrorKind::InvalidInput, why);
        if let Some(row) = network.vessels().position(|(ends, _)| ends[0] == ends[1]) {
            return Err(refused(format!("{} joins a node to itself", network.vessel_name(row))));
        }
        let at = vessels_at(network, |_| true);
        let enters = |node: usize| enters(network, node);
        let stated: Vec<usize> = (0..network.node_count()).filter(|node| network.node(*node).condition.is_some()).collect();
        if let Some(inner) = stated.iter().find(|node| at[**node].len() > 1) {
            return Err(refused(format!("the condition of node {} is not at a free end", network.node(*inner).id)));
        }
        let inlets: Vec<usize> = stated.into_iter().filter(|node| enters(*node)).collect();
        if inlets.is_empty() {
            return Err(refused("no node states an inlet; state conditions in the file".to_owned()));
        }
        let mut way =
            Ways { network, at: &at, turned: vec![None; network.vessel_count()], reached: Vec::new(), is_target: Vec::new() };
        way.is_target = (0..network.node_count()).map(|node| at[node].len() == 1 && !enters(node)).collect();
        for inlet in inlets {
            way.reach(inlet);
            way.lead_on(inlet);
        }
        let mut place = 0;
        while place < way.reached.len() {
            way.lead_on(way.reached[place]);
            place += 1;
        }
        // What no blood reaches begins where it does in the file, unless that is a free end.
        let as_it_stands = |row: usize| {
            let [a, b] = network.ends(row);
            if at[a].len() == 1 { [b, a] } else { [a, b] }
        };
        let unfed = way.turned.iter().position(Option::is_none);
        let turned = way.turned.into_iter().enumerate();
        let ends = turned.map(|(row, ends)| ends.unwrap_or_else(|| as_it_stands(row))).collect();
        let wall = |row: usize| {
            let vessel = network.vessel(row);
            let law = if vessel.wall.is_some() { WallLaw::Stated } else { WallLaw::OLUFSEN };
            let given = law.compliance(vessel.radius, vessel.wall, setting.density, &network.vessel_name(row));
            given.map_err(|error| refused(error.to_string()))
        };
        let distensibility = (0..network.vessel_count()).map(wall).collect::<io::Result<_>>()?;
        Ok(Self { network, setting, turned: ends, at, unfed, distensibility })
    }

    /// The condition of a free end; `None` of an inner node, a flow of zero of an end that states nothing.
    fn condition(&self, node: usize) -> Option<Condition> {
        (self.at[node].len() == 1).then(|| self.network.node(node).condition.unwrap_or(Condition::Flow(0.0)))
    }

    /// What happens in time at an inlet that pulsates.
    fn course(&self, node: usize) -> Option<&'a Waveform> {
        self.setting.courses.get(&self.network.node(node).id)
    }

    /// R1 (Pa s/m³) of a terminal resistance at the end of a vessel: as the node states it, else the wave impedance √(ρ/(A C')) of the
    /// vessel, as in `willis simulate --pulse`; at most the resistance.
    fn proximal(&self, node: usize, resistance: f64, row: usize) -> f64 {
        let matched = (self.setting.density / (area(self.network.vessel(row)) * self.distensibility[row])).sqrt();
        self.network.node(node).windkessel().proximal.unwrap_or(matched).min(resistance)
    }
}

/// Ways along the vessels while they are found.
struct Ways<'a> {
    network: &'a Network,
    at: &'a [Vec<usize>],
    /// By row where the vessel begins and ends, once it lies on a way.
    turned: Vec<Option<[usize; 2]>>,
    /// The nodes on ways, in the order in which they were reached.
    reached: Vec<usize>,
    /// By node whether a way may end there: on another way, or where blood leaves.
    is_target: Vec<bool>,
}

impl Ways<'_> {
    fn reach(&mut self, node: usize) {
        self.reached.push(node);
        self.is_target[node] = true;
    }

    /// Turns every vessel at a node on a way that is not turned yet, with a way behind it.
    fn lead_on(&mut self, from: usize) {
        for row in self.at[from].iter().copied() {
            if self.turned[row].is_some() {
                continue;
            }
            for [begins, row, stops] in self.way(from, row) {
                self.turned[row] = Some([begins, stops]);
                if !self.is_target[stops] {
                    self.reach(stops);
                }
            }
        }
    }

    /// The shortest way by a vessel to a target, as node, row and node for each vessel from the last to the first. From where there is none the way
    /// is that vessel alone: blood comes back by itself, and what follows finds this way.
    fn way(&self, from: usize, first: usize) -> Vec<[usize; 3]> {
        let other = |row: usize, node: usize| other_end(self.network, row, node);
        let mut came: HashMap<usize, (usize, usize)> = HashMap::from([(other(first, from), (from, first))]);
        let mut next = vec![other(first, from)];
        let mut place = 0;
        while place < next.len() {
            let mut node = next[place];
            place += 1;
            if self.is_target[node] {
                let mut way = Vec::new();
                loop {
                    let (before, row) = came[&node];
                    way.push([before, row, node]);
                    if row == first {
                        return way;
                    }
                    node = before;
                }
            }
            for row in self.at[node].iter().copied().filter(|row| *row != first && self.turned[*row].is_none()) {
                let to = other(row, node);
                if let Entry::Vacant(free) = came.entry(to) {
                    free.insert((node, row));
                    next.push(to);
                }
            }
        }
        vec![[from, first, other(first, from)]]
    }
}

/// The cross-section of a vessel, m².
fn area(vessel: &Vessel) -> f64 {
    PI * vessel.radius * vessel.radius
}
