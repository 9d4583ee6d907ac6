//! Writes a network with its conditions for solvers in time: openBF (one-dimensional; YAML, each vessel as an elastic tube, in SI units) and
//! svZeroDSolver (lumped; JSON, each vessel as a resistance, an inertance and a compliance, in cm, g and s).

use std::collections::{BTreeMap, HashMap, VecDeque, hash_map::Entry};
use std::io::{self, Write};
use std::{f64::consts::PI, iter::successors};

use serde_json::{Value, json};

use crate::formats::{Network, Node, ensure, find, other_end, plural, refused, vessels_at};
use willis_core::flow::{
    Boundary, Tube, WallLaw, floating_components::fed, poiseuille::BLOOD_VISCOSITY, state::BLOOD_DENSITY, state::State,
};
use willis_core::network::{Condition, Origin, Role, Vessel, Wall, Windkessel, waveform::Quantity, waveform::Waveform};
use willis_core::support::numbered::{grouped, marked, placed};

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
pub(crate) fn enters(network: &Network, node: usize) -> bool {
    match network.node(node).condition {
        Some(Condition::Flow(flow)) => flow > 0.0,
        Some(Condition::Pressure(pressure)) => pressure > 0.0 && network.node(node).role != Some(Role::Outlet),
        Some(Condition::Resistance { .. }) | None => false,
    }
}

/// The network without the parts that no blood enters, with a note that counts them; none where there are none, or no vessel has an inlet.
pub(crate) fn without_unfed(network: &Network) -> Option<(Network, String)> {
    let is_fed = fed(network, |node| enters(network, node));
    let left_out = network.vessels().filter(|([a, _], _)| !is_fed[*a]).count();
    if left_out == 0 || left_out == network.vessel_count() {
        return None;
    }
    let note = format!("{} in parts that no blood enters, left out (`unfed=keep` writes them)", plural(left_out, "vessel"));
    Some((network.part(|node| is_fed[node]).0, note))
}

/// The network with every vessel from a node to itself divided in two, as solvers in time need it, with a note that counts them.
pub(crate) fn without_loops(network: &Network) -> Option<(Network, String)> {
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

/// The network with no more vessels at a node than openBF takes, with a note that counts those that had more: such a node becomes several in a row, the
/// widest vessels at the first two places, joined by vessels as wide as the widest there and as long as its radius.
pub(crate) fn with_few_at_a_node(network: &Network) -> Option<(Network, String)> {
    let sides = network.vessels().enumerate().flat_map(|(row, (ends, _))| [0, 1].map(|side| (ends[side], (row, side))));
    let mut at = grouped(network.node_count(), sides);
    let crowded: Vec<usize> = (0..network.node_count()).filter(|node| at[*node].len() > MOST_JOINED).collect();
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
        for (number, (row, side)) in here[MOST_JOINED - 1..].iter().enumerate() {
            if number + MOST_JOINED < here.len() {
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
    Some((made, format!("{nodes} of more than {MOST_JOINED} vessels divided, by {} one radius long", plural(count, "vessel"))))
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
    /// a way that is there already, and then the same from the nodes on these ways, until all vessels are turned. Where every end is an inlet,
    /// blood leaves at the one that is nearest to the first.
    ///
    /// # Errors
    ///
    /// No condition at all, a condition in the middle of vessels, a self-loop, a wall that does not give (`InvalidInput`).
    fn of(network: &'a Network, setting: &'a SolverSetting) -> io::Result<Self> {
        if let Some(row) = network.vessels().position(|(ends, _)| ends[0] == ends[1]) {
            return Err(refused(format!("{} joins a node to itself", network.vessel_name(row))));
        }
        let at = vessels_at(network, |_| true);
        let enters = |node: usize| enters(network, node);
        let states = |node: &usize| network.node(*node).condition.is_some() && !at[*node].is_empty();
        let stated: Vec<usize> = (0..network.node_count()).filter(states).collect();
        if let Some(inner) = stated.iter().find(|node| at[**node].len() > 1) {
            return Err(refused(format!("the condition of node {} is not at a free end", network.node(*inner).id)));
        }
        let inlets: Vec<usize> = stated.into_iter().filter(|node| enters(*node)).collect();
        ensure(!inlets.is_empty(), || refused("no node states an inlet of a vessel; state conditions in the file"))?;
        let mut turned = vec![None; network.vessel_count()];
        // A way may end where blood leaves, or on another way.
        let mut is_target: Vec<bool> = (0..network.node_count()).map(|node| at[node].len() == 1 && !enters(node)).collect();
        let mut open = VecDeque::from(inlets);
        while let Some(from) = open.pop_front() {
            is_target[from] = true;
            for row in at[from].iter().copied() {
                if turned[row].is_some() {
                    continue;
                }
                let way_to =
                    |is_target: &dyn Fn(usize) -> bool| way(network, &at, (from, row), |row| turned[row].is_none(), is_target);
                let steps = way_to(&|node| is_target[node]).or_else(|| way_to(&enters));
                // Where blood only comes back by itself, what follows finds this way.
                let steps = steps.unwrap_or_else(|| vec![[from, row, other_end(network, row, from)]]);
                for [begins, row, stops] in steps {
                    turned[row] = Some([begins, stops]);
                    if !std::mem::replace(&mut is_target[stops], true) {
                        open.push_back(stops);
                    }
                }
            }
        }
        // What no blood reaches begins where it does in the file, unless that is a free end.
        let as_it_stands = |row: usize| {
            let [a, b] = network.ends(row);
            if at[a].len() == 1 { [b, a] } else { [a, b] }
        };
        let unfed = turned.iter().position(Option::is_none);
        let turned = turned.into_iter().enumerate().map(|(row, ends)| ends.unwrap_or_else(|| as_it_stands(row))).collect();
        let wall = |row: usize| {
            let vessel = network.vessel(row);
            let law = if vessel.wall.is_some() { WallLaw::Stated } else { WallLaw::OLUFSEN };
            let given = law.compliance(vessel.radius, vessel.wall, setting.density, &network.vessel_name(row));
            given.map_err(|error| refused(error.to_string()))
        };
        let distensibility = (0..network.vessel_count()).map(wall).collect::<io::Result<_>>()?;
        Ok(Self { network, setting, turned, at, unfed, distensibility })
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

    /// The pressure at which radii hold, Pa: that of the flow at rest, the mean over the length of the vessels. 0 where an outlet is at ground.
    fn operating_pressure(&self) -> f64 {
        let network = self.network;
        let stated = network.nodes().enumerate().filter_map(|(node, of)| Some((node, of.condition?)));
        let conditions: Vec<(usize, Condition)> = stated.collect();
        if conditions.iter().any(|(_, condition)| *condition == Condition::GROUND) {
            return 0.0;
        }
        let boundary = Boundary { conditions, roles: vec![Role::Inner; network.node_count()], ..Boundary::default() };
        let viscosity = self.setting.viscosity;
        let state = State::solve(network, &boundary, &Tube::at_rest(network, viscosity), viscosity);
        let Ok(State { pressure, .. }) = state else { return 0.0 };
        let along = |[a, b]: [usize; 2]| Some(f64::midpoint(pressure[a]?, pressure[b]?));
        let sums = network.vessels().filter_map(|(ends, vessel)| Some((along(ends)? * vessel.length, vessel.length)));
        let [sum, length] = sums.fold([0.0; 2], |[sum, length], (part, l)| [sum + part, length + l]);
        if length > 0.0 { sum / length } else { 0.0 }
    }
}

/// The shortest way from a node by one of its vessels to a target, as node, row and node for each vessel from the last to the first; over vessels
/// that are free.
fn way(
    network: &Network,
    at: &[Vec<usize>],
    (from, first): (usize, usize),
    is_free: impl Fn(usize) -> bool,
    is_target: impl Fn(usize) -> bool,
) -> Option<Vec<[usize; 3]>> {
    let start = other_end(network, first, from);
    let mut came: HashMap<usize, (usize, usize)> = HashMap::from([(start, (from, first))]);
    let mut open = VecDeque::from([start]);
    while let Some(node) = open.pop_front() {
        if is_target(node) {
            let step = |to: usize| [came[&to].0, came[&to].1, to];
            return Some(successors(Some(step(node)), |[before, row, _]| (*row != first).then(|| step(*before))).collect());
        }
        for row in at[node].iter().copied().filter(|row| *row != first && is_free(*row)) {
            let to = other_end(network, row, node);
            if let Entry::Vacant(free) = came.entry(to) {
                free.insert((node, row));
                open.push_back(to);
            }
        }
    }
    None
}

/// The cross-section of a vessel, m².
fn area(vessel: &Vessel) -> f64 {
    PI * vessel.radius * vessel.radius
}

/// Walls that are not stated have a thickness of this share of the radius.
const THICKNESS: f64 = 0.1;
/// The least share of an outlet's resistance that R1 and R2 get: openBF divides by them.
const LEAST: f64 = 1e-3;
/// openBF has equations for a conjunction, a bifurcation and an anastomosis.
const MOST_JOINED: usize = 3;

/// Whether a text begins as a model of openBF, which states no positions, so that no network can be made of it.
pub(crate) fn is_openbf(text: &[u8]) -> bool {
    let head = &text[..text.len().min(1 << 12)];
    find(head, b"\nblood:").is_some() && find(head, b"\nnetwork:").is_some()
}

/// Writes an inlet file of openBF: rows of a time (s) and a flow (m³/s) or a pressure (Pa).
///
/// # Errors
///
/// The writer's own.
pub fn write_openbf_inlet(out: &mut impl Write, course: &Waveform) -> io::Result<()> {
    course.times.iter().zip(&course.values).try_for_each(|(t, x)| writeln!(out, "{} {}", number_of(*t), number_of(*x)))
}

/// Writes a network for openBF, and returns the ids of the nodes of its inlets, in the order of their numbers. Walls are those of the vessels, or Olufsen's law with a thickness of a tenth of the radius. Each inlet names
/// the file that it expects beside this one, `inlet-N.dat` (time in s; flow in m³/s or pressure in Pa), N in the order of the vessels.
///
/// Friction is that of a parabolic profile, which openBF up to 1.5 takes for one only if it is told. The one external pressure of all is what its
/// tubes have at R0, so that vessels are as wide under pressure as the network says.
///
/// The keys of openBF changed with version 2: up to 1.5, which has several inlets, `project name`, `convergence tolerance` (%) and an
/// `inlet` at its vessel are read; from 2 on `project_name`, `convergence_tolerance` (mmHg) and the one `inlet_file` of node 1. The file has both,
/// and each version passes over those of the other. Nodes where blood enters come first.
///
/// # Errors
///
/// As [`write_svzerod`]; a node of more than three vessels, a vessel to which no inlet leads, an outlet of fixed pressure or
/// flow that is not zero (`InvalidInput`).
pub fn write_openbf(out: &mut impl Write, network: &Network, setting: &SolverSetting) -> io::Result<Vec<String>> {
    let ends = Directed::of(network, setting)?;
    let begins = marked(network.node_count(), ends.turned.iter().map(|[first, _]| *first));
    if let Some(row) = ends.unfed {
        return Err(refused(format!("no inlet leads to {}; openBF has no vessel without one", network.vessel_name(row))));
    }
    if let Some(node) = (0..network.node_count()).find(|node| ends.at[*node].len() > MOST_JOINED) {
        let (id, count) = (&network.node(node).id, ends.at[node].len());
        return Err(refused(format!("node {id} joins {count} vessels; openBF joins at most {MOST_JOINED}")));
    }
    let is_inlet = |node: usize| ends.at[node].len() == 1 && begins[node];
    let (first, inner): (Vec<usize>, Vec<usize>) = (0..network.node_count()).partition(|node| is_inlet(*node));
    let place = placed(network.node_count(), first.into_iter().chain(inner));
    writeln!(out, "project name: willis\nproject_name: willis\ninlet_file: inlet-1.dat\nwrite_results: [\"P\", \"Q\"]")?;
    writeln!(out, "blood:\n  rho: {}\n  mu: {}", number_of(setting.density), number_of(setting.viscosity))?;
    writeln!(out, "solver:\n  Ccfl: 0.9\n  cycles: 100\n  jump: 100")?;
    writeln!(out, "  convergence tolerance: 1.0\n  convergence_tolerance: 1.0")?;
    writeln!(out, "network:")?;
    let (mut inlets, operating) = (Vec::new(), number_of(ends.operating_pressure()));
    for (row, [begins, stops]) in ends.turned.iter().enumerate() {
        let vessel = network.vessel(row);
        let thickness =
            if let Some(Wall::Elastic { thickness, .. }) = vessel.wall { thickness } else { THICKNESS * vessel.radius };
        // A JSON string is a YAML string; two vessels may have one label.
        let label = serde_json::to_string(&format!("{row}-{}", vessel.label))?;
        writeln!(out, "  - label: {label}\n    sn: {}\n    tn: {}", place[*begins] + 1, place[*stops] + 1)?;
        writeln!(out, "    L: {}\n    R0: {}", number_of(vessel.length), number_of(vessel.radius))?;
        // A wall that keeps its volume has C' = (3/2) A r/(Eh).
        let stiffness = 1.5 * area(vessel) * vessel.radius / ends.distensibility[row];
        writeln!(out, "    E: {}\n    h0: {}", number_of(stiffness / thickness), number_of(thickness))?;
        writeln!(out, "    Pext: {operating}\n    gamma_profile: 2")?;
        if let Some(condition) = ends.condition(*begins) {
            inlets.push(network.node(*begins).id.clone());
            let is_pressure =
                ends.course(*begins).map_or(matches!(condition, Condition::Pressure(_)), |c| c.quantity == Quantity::Pressure);
            let (quantity, number) = (if is_pressure { "P" } else { "Q" }, inlets.len());
            writeln!(out, "    inlet: {quantity}\n    inlet file: inlet-{number}.dat\n    inlet number: {number}")?;
        }
        match ends.condition(*stops) {
            None => {}
            Some(Condition::Resistance { resistance, .. }) => {
                let compliance = network.node(*stops).windkessel().compliance.unwrap_or(Windkessel::TIME_CONSTANT / resistance);
                let least = LEAST * resistance;
                let proximal = ends.proximal(*stops, resistance, row).clamp(least, resistance - least);
                let distal = resistance - proximal;
                let [proximal, distal, compliance] = [proximal, distal, compliance].map(number_of);
                writeln!(out, "    outlet: wk3\n    R1: {proximal}\n    R2: {distal}\n    Cc: {compliance}")?;
            }
            // Its ends without a Windkessel reflect by a coefficient: 1 where nothing passes, -1 where the pressure stays at rest.
            Some(Condition::Flow(0.0)) => writeln!(out, "    outlet: reflection\n    Rt: 1.0")?,
            Some(Condition::Pressure(0.0)) => writeln!(out, "    outlet: reflection\n    Rt: -1.0")?,
            Some(Condition::Pressure(_) | Condition::Flow(_)) => {
                let node = &network.node(*stops).id;
                let known = "openBF has resistances, ground and closed ends";
                return Err(refused(format!("node {node} is an outlet of fixed pressure or flow; {known}")));
            }
        }
    }
    Ok(inlets)
}

/// A number as YAML 1.1 knows one: with a point, and a sign in its exponent. Without, it is a text.
fn number_of(x: f64) -> String {
    let text = format!("{x:?}");
    let Some((digits, exponent)) = text.split_once('e') else { return text };
    let point = if digits.contains('.') { "" } else { ".0" };
    let sign = if exponent.starts_with('-') { "" } else { "+" };
    format!("{digits}{point}e{sign}{exponent}")
}

/// The units of svZeroDSolver: Pa in dyn/cm², m³ in cm³, Pa s/m³ in dyn s/cm⁵, m³/Pa in cm⁵/dyn.
const PRESSURE: f64 = 10.0;
const VOLUME: f64 = 1e6;
const RESISTANCE: f64 = 1e-5;
const COMPLIANCE: f64 = 1e5;

/// Whether a text begins as a model of svZeroDSolver, which states no positions, so that no network can be made of it.
pub(crate) fn is_svzerod(text: &[u8]) -> bool {
    let head = &text[..text.len().min(1 << 12)];
    text.starts_with(b"{") && find(head, b"\"boundary_conditions\"").is_some() && find(head, b"\"markups\"").is_none()
}

/// Writes a network for svZeroDSolver. R is Poiseuille's or what the vessel states, L = ρl/A, C = (3/2) A r l/(Eh).
///
/// # Errors
///
/// A network without an inlet, with a condition that is not at a free end, or with a self-loop (`InvalidInput`); the writer's own.
pub fn write_svzerod(out: &mut impl Write, network: &Network, setting: &SolverSetting) -> io::Result<()> {
    let ends = Directed::of(network, setting)?;
    let mut conditions = Vec::new();
    let mut name = |node: usize, row: usize, is_inlet: bool| -> Option<String> {
        let condition = ends.condition(node)?;
        let name = format!("{}_{}", if is_inlet { "INLET" } else { "OUTLET" }, network.node(node).id);
        let (kind, values) = values(&ends, node, row, condition, is_inlet);
        conditions.push(json!({ "bc_name": name, "bc_type": kind, "bc_values": values }));
        Some(name)
    };
    let mut vessels = Vec::new();
    for (row, [begins, stops]) in ends.turned.iter().enumerate() {
        let vessel = network.vessel(row);
        let mut entry = json!({
            "vessel_id": row,
            "vessel_name": format!("branch{row}_seg0"),
            "vessel_length": vessel.length * 100.0,
            "zero_d_element_type": "BloodVessel",
            "zero_d_element_values": {
                "R_poiseuille": Tube::of(vessel, setting.viscosity).resistance * RESISTANCE,
                "L": setting.density * vessel.length / area(vessel) * RESISTANCE,
                "C": ends.distensibility[row] * vessel.length * COMPLIANCE,
                "stenosis_coefficient": 0.0,
            },
        });
        let named = [("inlet", name(*begins, row, true)), ("outlet", name(*stops, row, false))];
        let named = named.into_iter().filter_map(|(end, name)| Some((end.to_owned(), json!(name?))));
        let at: serde_json::Map<String, Value> = named.collect();
        if !at.is_empty() {
            entry["boundary_conditions"] = Value::Object(at);
        }
        vessels.push(entry);
    }
    let junction = |node: usize| {
        let of =
            |side: usize| ends.at[node].iter().copied().filter(|row| ends.turned[*row][side] == node).collect::<Vec<usize>>();
        json!({
            "junction_name": format!("J{node}"),
            "junction_type": "NORMAL_JUNCTION",
            "inlet_vessels": of(1),
            "outlet_vessels": of(0),
        })
    };
    let inner = (0..network.node_count()).filter(|node| ends.at[*node].len() > 1);
    let all = json!({
        "simulation_parameters": { "number_of_cardiac_cycles": 20, "number_of_time_pts_per_cardiac_cycle": 1000 },
        "boundary_conditions": conditions,
        "junctions": inner.map(junction).collect::<Vec<Value>>(),
        "vessels": vessels,
    });
    serde_json::to_writer_pretty(&mut *out, &all)?;
    writeln!(out)
}

/// The kind of a condition at the end of a vessel, and its values.
fn values(ends: &Directed<'_>, node: usize, row: usize, condition: Condition, is_inlet: bool) -> (&'static str, Value) {
    if let Some(course) = ends.course(node) {
        let (kind, key, unit) = match course.quantity {
            Quantity::Pressure => ("PRESSURE", "P", PRESSURE),
            // A flow into the network; out of an outlet it is positive there.
            Quantity::Flow => ("FLOW", "Q", if is_inlet { VOLUME } else { -VOLUME }),
        };
        let values: Vec<f64> = course.values.iter().map(|x| x * unit).collect();
        return (kind, json!({ key: values, "t": course.times }));
    }
    let constant = |key: &str, value: f64| json!({ key: [value, value], "t": [0.0, ends.setting.period] });
    match condition {
        Condition::Pressure(pressure) => ("PRESSURE", constant("P", pressure * PRESSURE)),
        Condition::Flow(flow) => ("FLOW", constant("Q", if is_inlet { flow } else { -flow } * VOLUME)),
        Condition::Resistance { resistance, venous } => match ends.network.node(node).windkessel().compliance {
            Some(compliance) => {
                let proximal = ends.proximal(node, resistance, row);
                (
                    "RCR",
                    json!({
                        "Rp": proximal * RESISTANCE, "Rd": (resistance - proximal) * RESISTANCE,
                        "C": compliance * COMPLIANCE, "Pd": venous * PRESSURE,
                    }),
                )
            }
            None => ("RESISTANCE", json!({ "R": resistance * RESISTANCE, "Pd": venous * PRESSURE })),
        },
    }
}
