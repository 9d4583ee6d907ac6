//! The columns by which a network is handed on and read again, as GraphML attributes and as tables of nodes and edges.

use super::column::{Column, Values, real};
use super::conditions::VENOUS;
use crate::network::units::{millimetres, ml_per_min, mmhg, mmhg_s_per_ml};
use crate::network::{Condition, Evidence, Network, PathPoint, Role, fragments};
use crate::support::geometry::Point;

/// The columns of the position of a node.
pub(crate) const PLACE: [&str; 3] = ["x_mm", "y_mm", "z_mm"];
/// The columns of the positions of the two ends of a vessel.
pub const END_PLACES: [[&str; 3]; 2] = [["ax_mm", "ay_mm", "az_mm"], ["bx_mm", "by_mm", "bz_mm"]];

/// One coordinate of a position, mm; NaN without one.
pub fn axis(position: Option<Point>, axis: usize) -> f64 {
    position.map_or(f64::NAN, |p| millimetres(p[axis]))
}

/// The columns of nodes.csv. `role` by node, `pressure` in Pa.
pub fn node_columns(network: &Network, role: &[Option<Role>], pressure: &[Option<f64>], component: &[usize]) -> Vec<Column> {
    let nodes = || network.nodes();
    let place = |of_axis: usize| Column::real(PLACE[of_axis], nodes().map(|n| axis(n.position, of_axis)));
    vec![
        Column::whole("node", 0..network.node_count()),
        Column::text("id", nodes().map(|n| n.id.clone())),
        place(0),
        place(1),
        place(2),
        Column::real("radius_mm", nodes().map(|n| n.radius.map_or(f64::NAN, millimetres))),
        Column::text("label", nodes().map(|n| n.label.clone())),
        Column::text("role", role.iter().map(|r| r.map_or("", Role::name).to_owned())),
        Column::real("pressure_mmHg", pressure.iter().map(|p| p.map_or(f64::NAN, mmhg))),
        Column::whole("component", component.iter().copied()),
    ]
}

/// The terminal resistances and flows of the nodes, by which a graph file keeps its boundary conditions; columns without
/// any value are left out.
pub fn condition_columns(conditions: &[Option<Condition>]) -> Vec<Column> {
    let figure = |of: fn(Condition) -> Option<f64>| conditions.iter().map(move |c| c.and_then(of).unwrap_or(f64::NAN));
    let resistance = |c| if let Condition::Resistance { resistance, .. } = c { Some(mmhg_s_per_ml(resistance)) } else { None };
    let venous = |c| if let Condition::Resistance { venous, .. } = c { Some(mmhg(venous)).filter(|p| *p != 0.0) } else { None };
    let flow = |c| if let Condition::Flow(flow) = c { Some(ml_per_min(flow)) } else { None };
    let mut columns = vec![
        Column::real("resistance_mmHg_s_per_mL", figure(resistance)),
        Column::real(VENOUS, figure(venous)),
        Column::real("flow_mL_per_min", figure(flow)),
    ];
    columns.retain(|c| matches!(&c.values, Values::Real(v) if v.iter().any(|x| !x.is_nan())));
    columns
}

/// The first columns of edges.csv: where every vessel runs, its name, origin, length and radius.
pub fn vessel_columns(network: &Network) -> Vec<Column> {
    let end = |which: usize, of_axis: usize| {
        let place = network.vessels().map(|(ends, _)| axis(network.node(ends[which]).position, of_axis));
        Column::real(END_PLACES[which][of_axis], place)
    };
    vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::whole("node_a", network.vessels().map(|(ends, _)| ends[0])),
        Column::whole("node_b", network.vessels().map(|(ends, _)| ends[1])),
        end(0, 0),
        end(0, 1),
        end(0, 2),
        end(1, 0),
        end(1, 1),
        end(1, 2),
        Column::text("label", network.vessels().map(|(_, v)| v.label.clone())),
        Column::text("origin", network.vessels().map(|(_, v)| v.origin.name().to_owned())),
        Column::real("length_mm", network.vessels().map(|(_, v)| millimetres(v.length))),
        Column::real("radius_mm", network.vessels().map(|(_, v)| millimetres(v.radius))),
    ]
}

/// All attributes of nodes and vessels that a reader of graphs takes, but for the vessels' points.
pub fn graph_columns(network: &Network) -> (Vec<Column>, Vec<Column>) {
    let pressure = |condition: &Option<Condition>| match condition {
        Some(Condition::Pressure(p)) => Some(*p),
        _ => None,
    };
    let roles: Vec<Option<Role>> = network.nodes().map(|n| n.role).collect();
    let conditions: Vec<Option<Condition>> = network.nodes().map(|n| n.condition).collect();
    let pressures: Vec<Option<f64>> = conditions.iter().map(pressure).collect();
    let mut nodes = node_columns(network, &roles, &pressures, &fragments(network, |_, _| true).of_node);
    nodes.extend(condition_columns(&conditions));
    let mut vessels = vessel_columns(network);
    vessels.push(Column::real("prior", network.vessels().map(|(_, v)| v.prior)));
    if network.vessels().any(|(_, v)| v.resistance.is_some()) {
        let stated = network.vessels().map(|(_, v)| v.resistance.map_or(f64::NAN, mmhg_s_per_ml));
        vessels.push(Column::real("resistance_mmHg_s_per_mL", stated));
    }
    if network.vessels().any(|(_, v)| v.certain) {
        vessels.push(Column::text("certain", network.vessels().map(|(_, v)| v.certain.to_string())));
    }
    if network.nodes().any(|n| n.root_score.is_some()) {
        nodes.push(Column::real("alone", network.nodes().map(|n| n.root_score.unwrap_or(f64::NAN))));
    }
    if network.vessels().any(|(_, v)| v.evidence.is_some()) {
        let figure = |of: fn(Evidence) -> f64| network.vessels().map(move |(_, v)| v.evidence.map_or(f64::NAN, of));
        vessels.push(Column::real("probability", figure(|e| e.probability)));
        vessels.push(Column::real("hangs_a", figure(|e| e.attached[0])));
        vessels.push(Column::real("hangs_b", figure(|e| e.attached[1])));
        vessels.push(Column::real("continues_a", figure(|e| e.continuation_odds[0])));
        vessels.push(Column::real("continues_b", figure(|e| e.continuation_odds[1])));
    }
    (nodes, vessels)
}

/// The centerlines of the vessels, where there is one at all.
pub(crate) fn points_column(network: &Network) -> Option<Column> {
    let any = network.vessels().any(|(_, v)| !v.path.is_empty());
    any.then(|| Column::text("points", network.vessels().map(|(_, v)| points(&v.path))))
}

/// A path as the attribute `points`, mm: `x y z r;x y z r`.
pub(crate) fn points(path: &[PathPoint]) -> String {
    let point = |p: &PathPoint| {
        let [x, y, z] = p.position.map(|x| real(millimetres(x)));
        format!("{x} {y} {z} {}", real(millimetres(p.radius)))
    };
    path.iter().map(point).collect::<Vec<_>>().join(";")
}
