//! The columns of nodes.csv and edges.csv of a forward simulation.

use super::simulated::Simulated;
use super::tables::condition_columns;
use crate::formats::{Column, axis};
use crate::network::Network;
use crate::state::{State, VesselState};
use crate::units::{millimetres, ml_per_min, mmhg, mmhg_s_per_ml};

/// What ends the header of a figure of the perturbed network.
pub const PERTURBED: &str = "_perturbed";

/// The columns of nodes.csv.
pub fn node_columns(simulated: &Simulated<'_>) -> Vec<Column> {
    let (network, boundary, result) = (simulated.network, simulated.boundary, simulated.result);
    let place = |of_axis: usize| network.nodes().map(move |n| axis(n.position, of_axis));
    let pressure = |name, state: &State| Column::real(name, state.pressure.iter().map(|p| p.map_or(f64::NAN, mmhg)));
    let mut columns = vec![
        Column::whole("node", 0..network.node_count()),
        Column::text("id", network.nodes().map(|n| n.id.clone())),
        Column::real("x_mm", place(0)),
        Column::real("y_mm", place(1)),
        Column::real("z_mm", place(2)),
        Column::text("label", network.nodes().map(|n| n.label.clone())),
        Column::text("role", boundary.roles.iter().map(|r| r.name().to_owned())),
        pressure("pressure_mmHg", &result.unperturbed),
    ];
    columns.extend(result.perturbed.as_ref().map(|state| pressure("pressure_mmHg_perturbed", state)));
    columns.extend(condition_columns(network, boundary));
    columns
}

/// The columns of edges.csv.
pub fn vessel_columns(simulated: &Simulated<'_>) -> Vec<Column> {
    let (network, result) = (simulated.network, simulated.result);
    let mut columns = places(network);
    columns.extend(flow_columns(&result.unperturbed, ""));
    if let Some(perturbed) = &result.perturbed {
        columns.extend(flow_columns(perturbed, PERTURBED));
        let pairs = result.unperturbed.vessels.iter().zip(&perturbed.vessels);
        columns.push(Column::real("flow_change", pairs.map(|(before, after)| ml_per_min(after.flow) - ml_per_min(before.flow))));
    }
    columns
}

fn places(network: &Network) -> Vec<Column> {
    let vessels = || network.vessels();
    vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::whole("node_a", vessels().map(|(ends, _)| ends[0])),
        Column::whole("node_b", vessels().map(|(ends, _)| ends[1])),
        Column::text("label", vessels().map(|(_, v)| v.label.clone())),
        Column::real("length_mm", vessels().map(|(_, v)| millimetres(v.length))),
        Column::real("radius_mm", vessels().map(|(_, v)| millimetres(v.radius))),
    ]
}

/// What flow does in each vessel; `suffix` ends the headers.
fn flow_columns(state: &State, suffix: &str) -> Vec<Column> {
    let figure = |name: &str, of: fn(&VesselState) -> f64| Column::real(format!("{name}{suffix}"), state.vessels.iter().map(of));
    vec![
        figure("resistance_mmHg_s_per_mL", |v| mmhg_s_per_ml(v.resistance)),
        figure("drop_mmHg", |v| mmhg(v.drop)),
        figure("flow_mL_per_min", |v| ml_per_min(v.flow)),
        figure("velocity_mm_per_s", |v| millimetres(v.velocity)),
        figure("wall_shear_Pa", |v| v.wall_shear),
        figure("reynolds", |v| v.reynolds),
        figure("resilience_W_per_m3", |v| v.resilience),
        Column::whole(format!("diffused{suffix}"), state.vessels.iter().map(|v| usize::from(v.diffused))),
    ]
}
