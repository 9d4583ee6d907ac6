//! The tables of an inference; and how far runs with different occlusion probabilities agree.

use super::outcome::Outcome;
use willis_core::decision::Decision;
use willis_core::flow::Boundary;
use willis_core::network::units::millimetres;
use willis_core::network::{Condition, Merged, Network, Role};
use willis_core::support::geometry::Point;
use willis_io::formats::{Column, POSITION_COLUMNS, Values, coordinate_columns};
use willis_models::contacts::split::{PairingDecision, Pairings, SuggestedCut};

/// The columns of agreement.csv: per pair of occlusion probabilities how many uncertain vessels are decided alike, and of
/// how many.
pub fn agreement(decisions: &[(f64, Decision)], uncertain: &[bool]) -> Vec<Column> {
    let pairs: Vec<(usize, usize)> = (0..decisions.len()).flat_map(|i| (i + 1..decisions.len()).map(move |j| (i, j))).collect();
    let same = |(i, j): &(usize, usize)| {
        let (a, b) = (&decisions[*i].1.kept, &decisions[*j].1.kept);
        a.iter().zip(b).zip(uncertain).filter(|((a, b), uncertain)| **uncertain && a == b).count()
    };
    let uncertain_count = uncertain.iter().filter(|u| **u).count();
    vec![
        Column::real("epsilon_a", pairs.iter().map(|(i, _)| decisions[*i].0)),
        Column::real("epsilon_b", pairs.iter().map(|(_, j)| decisions[*j].0)),
        Column::whole("decided_alike", pairs.iter().map(same)),
        Column::whole("uncertain", pairs.iter().map(|_| uncertain_count)),
    ]
}

/// The columns of the vessels of a topology from those of edges.csv. Of vessels that were merged, L and its error are means weighted by volume,
/// as ρ is of what it adds up over, and the frequency is the least; their other figures are equal.
pub fn merged_columns(network: &Network, merged: &Merged<'_>, vessels: Vec<Column>) -> Vec<Column> {
    let parts = &merged.parts;
    let words = parts.iter().map(|parts| parts.iter().map(usize::to_string).collect::<Vec<_>>().join("+"));
    let edges = Column::text("edges", words);
    let kept = Column::whole("kept", parts.iter().map(|_| 1));
    let first: Vec<usize> = parts.iter().filter_map(|parts| parts.iter().min().copied()).collect();
    if parts.len() == network.vessel_count() {
        // All are as they were.
        let each = vessels.into_iter().map(|column| if column.name == "kept" { kept.clone() } else { column });
        return each.chain([edges]).collect();
    }
    let is_merged = parts.iter().any(|parts| parts.len() > 1);
    let mut own = if is_merged { willis_io::formats::vessel_columns(&merged.network) } else { Vec::new() };
    let volume = |row: &usize| network.vessel(*row).volume();
    let mean = |of: &[f64], parts: &[usize]| {
        if let [row] = parts {
            return of[*row];
        }
        let whole: f64 = parts.iter().map(volume).sum();
        parts.iter().map(|row| of[*row] * (volume(row) / whole)).sum()
    };
    let least = |of: &[f64], parts: &[usize]| parts.iter().map(|row| of[*row]).fold(f64::INFINITY, f64::min);
    let column = |all: Column| match (&*all.name, &all.values) {
        ("likelihood" | "std_error", Values::Real(of)) => {
            Column { values: Values::Real(parts.iter().map(|parts| mean(of, parts)).collect()), name: all.name }
        }
        ("frequency", Values::Real(of)) => Column::real("frequency", parts.iter().map(|parts| least(of, parts))),
        ("kept", _) => kept.clone(),
        ("node_a" | "node_b", _) => {
            let side = usize::from(all.name == "node_b");
            Column::whole(all.name, merged.network.vessels().map(|(ends, _)| merged.nodes[ends[side]]))
        }
        (name, _) => match own.iter().position(|own| own.name == name && name != "edge") {
            Some(at) => own.swap_remove(at),
            None => Column { values: picked(&all.values, &first), name: all.name },
        },
    };
    vessels.into_iter().map(column).chain([edges]).collect()
}

/// The columns of nodes.csv. `pressure` in Pa.
pub fn node_columns(network: &Network, boundary: &Boundary, pressure: &[Option<f64>], component: &[usize]) -> Vec<Column> {
    let roles: Vec<Option<Role>> = boundary.roles.iter().copied().map(Some).collect();
    willis_io::formats::node_columns(network, &roles, pressure, component)
}

/// The terminal resistances and flows of the nodes, and which of their conditions were found, by which a graph file keeps its boundary
/// conditions.
pub fn condition_columns(network: &Network, boundary: &Boundary) -> Vec<Column> {
    let conditions: Vec<Option<Condition>> = (0..network.node_count()).map(|node| boundary.condition(node)).collect();
    let found: Vec<bool> = (0..network.node_count()).map(|node| boundary.is_found(node)).collect();
    willis_io::formats::condition_columns(&conditions).into_iter().chain(willis_io::formats::found_column(&found)).collect()
}

/// The columns of edges.csv.
pub fn vessel_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let (network, result, answer) = (outcome.network, outcome.result, outcome.answer);
    let flag = |name, flags: &[bool]| Column::whole(name, flags.iter().map(|f| usize::from(*f)));
    let mut columns = willis_io::formats::vessel_columns(network);
    columns.extend([
        Column::real("prior", network.vessels().map(|(_, v)| if outcome.sampling.uniform_prior { 1.0 } else { v.prior })),
        Column::real("likelihood", result.likelihood.iter().copied()),
        Column::real("std_error", result.std_error.iter().copied()),
        Column::real("frequency", result.frequency.iter().copied()),
        Column::real("probability", network.vessels().map(|(_, v)| v.evidence().map_or(f64::NAN, |e| e.probability))),
        Column::real("needed", answer.needed.iter().copied()),
        Column::real("instead", answer.instead.iter().map(|row| row.map_or(f64::NAN, |row| row as f64))),
        flag("above_median", &answer.above_median),
        flag("kept", &answer.kept),
    ]);
    columns
}

/// The columns of suggested-cuts.csv.
pub fn suggested_cut_columns(cuts: &[SuggestedCut]) -> Vec<Column> {
    let mut columns = positions(|| cuts.iter().map(|cut| cut.position));
    columns.extend([
        Column::real("radius_mm", cuts.iter().map(|cut| millimetres(cut.radius))),
        Column::text("node", cuts.iter().map(|cut| cut.node.clone())),
        Column::real("probability", cuts.iter().map(|cut| cut.probability)),
    ]);
    columns
}

/// Three columns of positions.
pub(super) fn positions<I: Iterator<Item = Point>>(of: impl Fn() -> I) -> Vec<Column> {
    coordinate_columns(POSITION_COLUMNS, || of().map(|at| at.map(millimetres))).to_vec()
}

/// The columns of pairings.csv.
pub fn pairing_columns(outcome: &Outcome<'_>) -> Vec<Column> {
    let kept = &outcome.answer.kept;
    let mut rows: Vec<(&Pairings, Vec<usize>, f64, bool)> = Vec::new();
    for pairings in outcome.pairings {
        let taken = pairings.taken(kept);
        rows.extend(pairings.ways.iter().map(|(way, p)| (pairings, way.clone(), *p, *way == taken)));
        if pairings.ways.iter().all(|(way, _)| *way != taken) {
            rows.push((pairings, taken, f64::NAN, true));
        }
    }
    let decided: Vec<PairingDecision> =
        rows.iter().map(|(pairings, way, ..)| pairings.decision(way, outcome.network).unwrap_or_default()).collect();
    // A space before a minus, which is no formula then.
    let as_text = |places: String| if places.starts_with('-') { format!(" {places}") } else { places };
    let listed = |of: &[usize]| of.iter().map(usize::to_string).collect::<Vec<String>>().join(" ");
    let mut columns = positions(|| rows.iter().map(|row| row.0.position));
    columns.extend([
        Column::text("vessels", rows.iter().map(|(pairings, way, ..)| pairings.told(way))),
        Column::real("probability", rows.iter().map(|row| row.2)),
        Column::whole("taken", rows.iter().map(|row| usize::from(row.3))),
        Column::text("contacts", rows.iter().map(|row| listed(&row.0.contacts.iter().map(|(_, row)| *row).collect::<Vec<_>>()))),
        Column::text("accept", decided.iter().map(|of| listed(&of.accept))),
        Column::text("reject", decided.iter().map(|of| listed(&of.reject))),
        Column::text("part", decided.iter().map(|of| of.part.as_ref().map_or_else(String::new, |edit| as_text(edit.places())))),
    ]);
    columns
}

/// The rows of some columns.
pub fn select(columns: &[Column], rows: &[usize]) -> Vec<Column> {
    columns.iter().map(|c| Column { name: c.name.clone(), values: picked(&c.values, rows) }).collect()
}

fn picked(values: &Values, rows: &[usize]) -> Values {
    match values {
        Values::Real(v) => Values::Real(rows.iter().map(|r| v[*r]).collect()),
        Values::Integer(v) => Values::Integer(rows.iter().map(|r| v[*r]).collect()),
        Values::Text(v) => Values::Text(rows.iter().map(|r| &v[*r]).collect()),
    }
}
