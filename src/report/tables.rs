//! The columns of nodes.csv and edges.csv, which GraphML and VTP carry as attributes under the same names.

use super::outcome::Outcome;
use crate::formats::{self, Column, Values};
use crate::hemodynamics::Boundary;
use crate::network::{Condition, Network, Role};

/// The columns of nodes.csv. `pressure` in Pa.
pub fn node_columns(network: &Network, boundary: &Boundary, pressure: &[Option<f64>], component: &[usize]) -> Vec<Column> {
    let roles: Vec<Option<Role>> = boundary.roles.iter().copied().map(Some).collect();
    formats::node_columns(network, &roles, pressure, component)
}

/// The terminal resistances and flows of the nodes, by which a graph file keeps its boundary conditions.
pub fn condition_columns(network: &Network, boundary: &Boundary) -> Vec<Column> {
    let conditions: Vec<Option<Condition>> = (0..network.node_count()).map(|node| boundary.condition(node)).collect();
    formats::condition_columns(&conditions)
}

/// The columns of edges.csv.
pub fn vessel_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let flag = |name, flags: &[bool]| Column::whole(name, flags.iter().map(|f| usize::from(*f)));
    let mut columns = formats::vessel_columns(network);
    columns.extend([
        Column::real("prior", network.vessels().map(|(_, v)| if outcome.uniform_prior { 1.0 } else { v.prior })),
        Column::real("likelihood", result.likelihood.iter().copied()),
        Column::real("std_error", result.std_error.iter().copied()),
        Column::real("frequency", result.frequency.iter().copied()),
        Column::real("probability", network.vessels().map(|(_, v)| v.evidence.map_or(f64::NAN, |e| e.probability))),
        flag("above_median", &answer.above_median),
        flag("kept", &answer.kept),
    ]);
    columns
}

/// The rows of some columns.
pub fn select(columns: &[Column], rows: &[usize]) -> Vec<Column> {
    let pick = |values: &Values| match values {
        Values::Real(v) => Values::Real(rows.iter().map(|r| v[*r]).collect()),
        Values::Integer(v) => Values::Integer(rows.iter().map(|r| v[*r]).collect()),
        Values::Text(v) => Values::Text(rows.iter().map(|r| v[*r].clone()).collect()),
    };
    columns.iter().map(|c| Column { name: c.name.clone(), values: pick(&c.values) }).collect()
}
