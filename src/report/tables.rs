//! The columns of nodes.csv and edges.csv, which GraphML and VTP carry as attributes under the same names.

use super::outcome::Outcome;
use crate::formats::{Column, Values};
use crate::geometry::Point;
use crate::hemodynamics::Boundary;
use crate::network::{Condition, Network, fragments};
use crate::units::{millimetres, ml_per_min, mmhg, mmhg_s_per_ml};

pub(super) fn real(name: &'static str, values: impl Iterator<Item = f64>) -> Column {
    Column { name, values: Values::Real(values.collect()) }
}

pub(super) fn whole(name: &'static str, values: impl Iterator<Item = usize>) -> Column {
    Column { name, values: Values::Integer(values.map(|v| v as i64).collect()) }
}

pub(super) fn text(name: &'static str, values: impl Iterator<Item = String>) -> Column {
    Column { name, values: Values::Text(values.collect()) }
}

pub(super) fn axis(position: Option<Point>, axis: usize) -> f64 {
    position.map_or(f64::NAN, |p| millimetres(p[axis]))
}

/// The columns of nodes.csv. `pressure` in Pa.
pub fn node_columns(network: &Network, boundary: &Boundary, pressure: &[Option<f64>], component: &[usize]) -> Vec<Column> {
    let nodes = || network.nodes();
    vec![
        whole("node", 0..network.node_count()),
        text("id", nodes().map(|n| n.id.clone())),
        real("x_mm", nodes().map(|n| axis(n.position, 0))),
        real("y_mm", nodes().map(|n| axis(n.position, 1))),
        real("z_mm", nodes().map(|n| axis(n.position, 2))),
        real("radius_mm", nodes().map(|n| n.radius.map_or(f64::NAN, millimetres))),
        text("label", nodes().map(|n| n.label.clone())),
        text("role", boundary.roles.iter().map(|r| r.name().to_owned())),
        real("pressure_mmHg", pressure.iter().map(|p| p.map_or(f64::NAN, mmhg))),
        whole("component", component.iter().copied()),
    ]
}

/// The terminal resistances and flows of the nodes, by which a graph file keeps its boundary conditions.
pub fn condition_columns(network: &Network, boundary: &Boundary) -> Vec<Column> {
    let figure = |of: fn(Condition) -> Option<f64>| {
        (0..network.node_count()).map(move |node| boundary.condition(node).and_then(of).unwrap_or(f64::NAN))
    };
    let mut columns = vec![
        real(
            "resistance_mmHg_s_per_mL",
            figure(|c| if let Condition::Resistance { resistance, .. } = c { Some(mmhg_s_per_ml(resistance)) } else { None }),
        ),
        real(
            "venous_pressure_mmHg",
            figure(
                |c| if let Condition::Resistance { venous, .. } = c { Some(mmhg(venous)).filter(|p| *p != 0.0) } else { None },
            ),
        ),
        real("flow_mL_per_min", figure(|c| if let Condition::Flow(flow) = c { Some(ml_per_min(flow)) } else { None })),
    ];
    columns.retain(|c| matches!(&c.values, Values::Real(v) if v.iter().any(|x| !x.is_nan())));
    columns
}

fn vessel_places(network: &Network) -> Vec<Column> {
    let end =
        |which: usize, of_axis: usize| network.vessels().map(move |(ends, _)| axis(network.node(ends[which]).position, of_axis));
    vec![
        whole("edge", 0..network.vessel_count()),
        whole("node_a", network.vessels().map(|(ends, _)| ends[0])),
        whole("node_b", network.vessels().map(|(ends, _)| ends[1])),
        real("ax_mm", end(0, 0)),
        real("ay_mm", end(0, 1)),
        real("az_mm", end(0, 2)),
        real("bx_mm", end(1, 0)),
        real("by_mm", end(1, 1)),
        real("bz_mm", end(1, 2)),
        text("label", network.vessels().map(|(_, v)| v.label.clone())),
        text("origin", network.vessels().map(|(_, v)| v.origin.name().to_owned())),
        real("length_mm", network.vessels().map(|(_, v)| millimetres(v.length))),
        real("radius_mm", network.vessels().map(|(_, v)| millimetres(v.radius))),
    ]
}

/// The columns of edges.csv.
pub fn vessel_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let flag = |name, flags: &[bool]| whole(name, flags.iter().map(|f| usize::from(*f)));
    let mut columns = vessel_places(network);
    columns.extend([
        real("prior", network.vessels().map(|(_, v)| if outcome.uniform_prior { 1.0 } else { v.prior })),
        real("likelihood", result.likelihood.iter().copied()),
        real("std_error", result.std_error.iter().copied()),
        real("frequency", result.frequency.iter().copied()),
        // Empty until an evidence model fills it.
        real("probability", network.vessels().map(|_| f64::NAN)),
        flag("above_median", &answer.above_median),
        flag("kept", &answer.kept),
    ]);
    columns
}

/// The attributes of nodes and vessels by which a candidate graph is handed on and read again.
pub fn graph_columns(network: &Network, boundary: &Boundary) -> (Vec<Column>, Vec<Column>) {
    let stated = |node: usize| match boundary.condition(node) {
        Some(Condition::Pressure(p)) => Some(p),
        _ => None,
    };
    let pressure: Vec<Option<f64>> = (0..network.node_count()).map(stated).collect();
    let mut nodes = node_columns(network, boundary, &pressure, &fragments(network, |_, _| true).of_node);
    nodes.extend(condition_columns(network, boundary));
    let mut vessels = vessel_places(network);
    vessels.push(real("prior", network.vessels().map(|(_, v)| v.prior)));
    if network.vessels().any(|(_, v)| v.resistance.is_some()) {
        let stated = network.vessels().map(|(_, v)| v.resistance.map_or(f64::NAN, mmhg_s_per_ml));
        vessels.push(real("resistance_mmHg_s_per_mL", stated));
    }
    if network.vessels().any(|(_, v)| v.certain) {
        vessels.push(text("certain", network.vessels().map(|(_, v)| v.certain.to_string())));
    }
    (nodes, vessels)
}

/// The rows of some columns.
pub fn select(columns: &[Column], rows: &[usize]) -> Vec<Column> {
    let pick = |values: &Values| match values {
        Values::Real(v) => Values::Real(rows.iter().map(|r| v[*r]).collect()),
        Values::Integer(v) => Values::Integer(rows.iter().map(|r| v[*r]).collect()),
        Values::Text(v) => Values::Text(rows.iter().map(|r| v[*r].clone()).collect()),
    };
    columns.iter().map(|c| Column { name: c.name, values: pick(&c.values) }).collect()
}
