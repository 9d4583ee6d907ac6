//! openBF's YAML: each vessel as an elastic tube, in SI units.

use std::io::{self, Write};

use super::{Directed, SolverSetting, area};
use willis_core::network::waveform::{Quantity, Waveform};
use willis_core::network::{Condition, Network, Wall, Windkessel};

/// Walls that are not stated have a thickness of this share of the radius.
const THICKNESS: f64 = 0.1;
/// The least share of an outlet's resistance that R1 and R2 get: openBF divides by them.
const LEAST: f64 = 1e-3;
/// openBF has equations for a conjunction, a bifurcation and an anastomosis.
pub(in crate::formats) const MOST_JOINED: usize = 3;

/// Whether a text begins as a model of openBF, which states no positions, so that no network can be made of it.
pub(crate) fn is_openbf(text: &[u8]) -> bool {
    let head = &text[..text.len().min(1 << 12)];
    [&b"\nblood:"[..], b"\nnetwork:"].iter().all(|key| head.windows(key.len()).any(|part| part == *key))
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
/// The keys of openBF changed with version 2: up to 1.5, which has several inlets, `project name`, `convergence tolerance` (%) and an
/// `inlet` at its vessel are read; from 2 on `project_name`, `convergence_tolerance` (mmHg) and the one `inlet_file` of node 1. The file has both,
/// and each version passes over those of the other. Nodes where blood enters come first.
///
/// # Errors
///
/// As [`write_svzerod`](super::write_svzerod); a node of more than three vessels, a vessel to which no inlet leads, an outlet of fixed pressure or
/// flow that is not zero (`InvalidInput`).
pub fn write_openbf(out: &mut impl Write, network: &Network, setting: &SolverSetting) -> io::Result<Vec<String>> {
    let refused = |why: String| Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    let ends = Directed::of(network, setting)?;
    let begins = |node: usize| ends.turned.iter().any(|[first, _]| *first == node);
    if let Some(row) = ends.unfed {
        return refused(format!("no inlet leads to {}; openBF has no vessel without one", network.vessel_name(row)));
    }
    if let Some(node) = (0..network.node_count()).find(|node| ends.at[*node].len() > MOST_JOINED) {
        let (id, count) = (&network.node(node).id, ends.at[node].len());
        return refused(format!("node {id} joins {count} vessels; openBF joins at most {MOST_JOINED}"));
    }
    let is_inlet = |node: usize| ends.at[node].len() == 1 && begins(node);
    let mut number = vec![0; network.node_count()];
    let (inner, first): (Vec<usize>, Vec<usize>) = (0..network.node_count()).partition(|node| !is_inlet(*node));
    for (place, node) in first.into_iter().chain(inner).enumerate() {
        number[node] = place + 1;
    }
    writeln!(out, "project name: willis\nproject_name: willis\ninlet_file: inlet-1.dat\nwrite_results: [\"P\", \"Q\"]")?;
    writeln!(out, "blood:\n  rho: {}\n  mu: {}", number_of(setting.density), number_of(setting.viscosity))?;
    writeln!(out, "solver:\n  Ccfl: 0.9\n  cycles: 100\n  jump: 100")?;
    writeln!(out, "  convergence tolerance: 1.0\n  convergence_tolerance: 1.0")?;
    writeln!(out, "network:")?;
    let mut inlets = Vec::new();
    for (row, [begins, stops]) in ends.turned.iter().enumerate() {
        let vessel = network.vessel(row);
        let thickness =
            if let Some(Wall::Elastic { thickness, .. }) = vessel.wall { thickness } else { THICKNESS * vessel.radius };
        // A JSON string is a YAML string; two vessels may have one label.
        let label = serde_json::to_string(&format!("{row}-{}", vessel.label))?;
        writeln!(out, "  - label: {label}\n    sn: {}\n    tn: {}", number[*begins], number[*stops])?;
        writeln!(out, "    L: {}\n    R0: {}", number_of(vessel.length), number_of(vessel.radius))?;
        // A wall that keeps its volume has C' = (3/2) A r/(Eh).
        let stiffness = 1.5 * area(vessel) * vessel.radius / ends.distensibility[row];
        writeln!(out, "    E: {}\n    h0: {}", number_of(stiffness / thickness), number_of(thickness))?;
        if let Some(condition) = ends.condition(*begins) {
            inlets.push(network.node(*begins).id.clone());
            let is_pressure =
                ends.course(*begins).map_or(matches!(condition, Condition::Pressure(_)), |c| c.quantity == Quantity::Pressure);
            let (quantity, number) = (if is_pressure { "P" } else { "Q" }, inlets.len());
            writeln!(out, "    inlet: {quantity}\n    inlet file: inlet-{number}.dat\n    inlet number: {number}")?;
        }
        match ends.condition(*stops) {
            None => {}
            Some(Condition::Resistance { resistance, venous }) => {
                let compliance = network.node(*stops).windkessel().compliance.unwrap_or(Windkessel::TIME_CONSTANT / resistance);
                let least = LEAST * resistance;
                let proximal = ends.proximal(*stops, resistance, row).clamp(least, resistance - least);
                let distal = resistance - proximal;
                let [proximal, distal, compliance] = [proximal, distal, compliance].map(number_of);
                writeln!(out, "    outlet: wk3\n    R1: {proximal}\n    R2: {distal}\n    Cc: {compliance}")?;
                if venous != 0.0 {
                    writeln!(out, "    Pout: {}", number_of(venous))?;
                }
            }
            // Its ends without a Windkessel reflect by a coefficient: 1 where nothing passes, -1 where the pressure stays at rest.
            Some(Condition::Flow(0.0)) => writeln!(out, "    outlet: reflection\n    Rt: 1.0")?,
            Some(Condition::Pressure(0.0)) => writeln!(out, "    outlet: reflection\n    Rt: -1.0")?,
            Some(Condition::Pressure(_) | Condition::Flow(_)) => {
                let node = &network.node(*stops).id;
                let known = "openBF has resistances, ground and closed ends";
                return refused(format!("node {node} is an outlet of fixed pressure or flow; {known}"));
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
