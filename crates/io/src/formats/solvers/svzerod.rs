//! svZeroDSolver's JSON: each vessel as a resistance, an inertance and a compliance, in cm, g and s.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::{Directed, SolverSetting, area};
use willis_core::flow::Tube;
use willis_core::network::waveform::Quantity;
use willis_core::network::{Condition, Network};

/// Pa in dyn/cm², m³ in cm³, Pa s/m³ in dyn s/cm⁵, m³/Pa in cm⁵/dyn.
const PRESSURE: f64 = 10.0;
const VOLUME: f64 = 1e6;
const RESISTANCE: f64 = 1e-5;
const COMPLIANCE: f64 = 1e5;

/// Whether a text begins as a model of svZeroDSolver, which states no positions, so that no network can be made of it.
pub(crate) fn is_svzerod(text: &[u8]) -> bool {
    let head = &text[..text.len().min(1 << 12)];
    let has = |key: &[u8]| head.windows(key.len()).any(|part| part == key);
    text.starts_with(b"{") && has(b"\"boundary_conditions\"") && !has(b"\"markups\"")
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
