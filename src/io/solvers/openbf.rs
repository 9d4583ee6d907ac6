//! openBF's YAML: each vessel as an elastic tube, in SI units.

use std::io::{self, Write};

use super::{DENSITY, Directed, THICKNESS, VISCOSITY, stiffness, windkessel};
use crate::network::{Condition, Network, Wall};

/// Writes a network for openBF. Walls are those of the vessels, or Olufsen's law with a thickness of a tenth of the radius. Each inlet names
/// the file that it expects beside this one, `inlet-N.dat` (time in s, flow in m³/s), N in the order of the nodes.
///
/// # Errors
///
/// As [`write_svzerod`](super::write_svzerod); an outlet that is neither a resistance nor closed (`InvalidInput`).
pub fn write_openbf(out: &mut impl Write, network: &Network) -> io::Result<()> {
    let ends = Directed::of(network)?;
    writeln!(out, "project_name: willis")?;
    writeln!(out, "blood:\n  rho: {DENSITY:?}\n  mu: {VISCOSITY:?}")?;
    writeln!(out, "solver:\n  Ccfl: 0.9\n  cycles: 100\n  jump: 100\n  convergence tolerance: 1.0")?;
    writeln!(out, "network:")?;
    let mut inlets = 0;
    for (row, [begins, stops]) in ends.turned.iter().enumerate() {
        let vessel = network.vessel(row);
        let thickness = match vessel.wall {
            Some(Wall::Elastic { thickness, .. }) => thickness,
            _ => THICKNESS * vessel.radius,
        };
        // A JSON string is a YAML string; two vessels may have one label.
        let label = serde_json::to_string(&format!("{row}-{}", vessel.label))?;
        writeln!(out, "  - label: {label}\n    sn: {}\n    tn: {}", begins + 1, stops + 1)?;
        writeln!(out, "    L: {:?}\n    R0: {:?}", vessel.length, vessel.radius)?;
        writeln!(out, "    E: {:?}\n    h0: {thickness:?}", stiffness(vessel) / thickness)?;
        if let Some(condition) = ends.condition(*begins) {
            inlets += 1;
            let quantity = if matches!(condition, Condition::Pressure(_)) { "P" } else { "Q" };
            writeln!(out, "    inlet: {quantity}\n    inlet file: inlet-{inlets}.dat\n    inlet number: {inlets}")?;
        }
        match ends.condition(*stops) {
            None => {}
            Some(Condition::Resistance { resistance, venous }) => {
                match windkessel(network, *stops, resistance) {
                    Some([proximal, distal, compliance]) => {
                        writeln!(out, "    outlet: wk3\n    R1: {proximal:?}\n    R2: {distal:?}\n    Cc: {compliance:?}")?;
                    }
                    None => writeln!(out, "    outlet: wk2\n    R1: {resistance:?}\n    Cc: 0.0")?,
                }
                if venous != 0.0 {
                    writeln!(out, "    Pout: {venous:?}")?;
                }
            }
            Some(Condition::Pressure(_) | Condition::Flow(_)) => {
                // Its ends without a Windkessel reflect by a coefficient: 1 where nothing passes, -1 where the pressure is fixed.
                let closed = matches!(ends.condition(*stops), Some(Condition::Flow(_)));
                writeln!(out, "    outlet: reflection\n    Rt: {}", if closed { "1.0" } else { "-1.0" })?;
            }
        }
    }
    Ok(())
}
