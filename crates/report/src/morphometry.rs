//! The tables of what is measured: vessels.csv, bifurcations.csv, ends.csv, intervals.csv, and the row of a subject in subjects.csv.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::circle_figures::{CircleFigures, NamedFigures, SIDES, asymmetry};
use willis_core::morphometry::columns::{IN_REGION, MeasuredColumn, OF_BIFURCATION, OF_END, OF_NETWORK, OF_TOTALS, OF_VESSEL};
use willis_core::morphometry::{Morphometry, NetworkFigures, VesselTotals};
use willis_core::network::{Network, Role};
use willis_core::support::statistics::weighted_quantile;
use willis_io::formats::{Column, POSITION_COLUMNS, coordinate_columns, coordinates};
use willis_models::circle_of_willis::TERRITORIES;

/// What was measured of a subject, and of which network.
#[derive(Debug, Clone, Copy)]
pub struct MeasuredSubject<'a> {
    /// Its name.
    pub name: &'a str,
    /// The vessels.
    pub network: &'a Network,
    /// What was measured of them.
    pub measured: &'a Morphometry,
}

impl MeasuredSubject<'_> {
    fn id(&self, node: usize) -> String {
        self.network.node(node).id.clone()
    }

    fn subject(&self, rows: usize) -> Column {
        Column::text("subject", std::iter::repeat_n(self.name.to_owned(), rows))
    }

    /// The subject, and the ids and the places of nodes.
    fn at_nodes(&self, nodes: &[usize]) -> Vec<Column> {
        let places = || nodes.iter().map(|node| coordinates(self.network.node(*node).position));
        let ids = Column::text("id", nodes.iter().map(|node| self.id(*node)));
        [self.subject(nodes.len()), ids].into_iter().chain(coordinate_columns(POSITION_COLUMNS, places)).collect()
    }

    /// The columns of vessels.csv.
    pub fn vessels(&self) -> Vec<Column> {
        let vessels = &self.measured.vessels;
        let territories = vessels.iter().map(|v| v.territory.map_or_else(String::new, |at| TERRITORIES[at].to_string()));
        let mut columns = vec![
            self.subject(vessels.len()),
            Column::whole("vessel", 0..vessels.len()),
            Column::text("label", vessels.iter().map(|v| v.line.label.clone())),
            Column::text("territory", territories),
            Column::text("id_a", vessels.iter().map(|v| self.id(v.line.ends[0]))),
            Column::text("id_b", vessels.iter().map(|v| self.id(v.line.ends[1]))),
            Column::whole("degree_a", vessels.iter().map(|v| v.degree[0])),
            Column::whole("degree_b", vessels.iter().map(|v| v.degree[1])),
        ];
        columns.extend(measured(&OF_VESSEL, vessels));
        columns
    }

    /// The columns of bifurcations.csv.
    pub fn bifurcations(&self) -> Vec<Column> {
        let found = &self.measured.bifurcations;
        let nodes: Vec<usize> = found.iter().map(|b| b.node).collect();
        let mut columns = self.at_nodes(&nodes);
        columns.extend([
            Column::whole("degree", found.iter().map(|b| b.degree)),
            Column::whole("parent", found.iter().map(|b| b.parent)),
            Column::whole("child_1", found.iter().map(|b| b.children[0])),
            Column::whole("child_2", found.iter().map(|b| b.children[1])),
        ]);
        columns.extend(measured(&OF_BIFURCATION, found));
        columns
    }

    /// The columns of ends.csv; `role` says what a node is to the flow.
    pub fn ends(&self, role: impl Fn(usize) -> Role) -> Vec<Column> {
        let ends = &self.measured.ends;
        let nodes: Vec<usize> = ends.iter().map(|end| end.node).collect();
        let mut columns = self.at_nodes(&nodes);
        columns.extend([
            Column::text("label", nodes.iter().map(|node| self.network.node(*node).label.clone())),
            Column::text("role", nodes.iter().map(|node| role(*node).name().to_owned())),
            Column::whole("vessel", ends.iter().map(|end| end.vessel)),
        ]);
        columns.extend(measured(&OF_END, ends));
        columns
    }

    /// The columns of intervals.csv: the figures of the whole, as kept and over topologies that are plausible, with their weights.
    pub fn intervals(&self, kept: &NamedFigures, plausible: &[(NamedFigures, f64)]) -> Vec<Column> {
        // What only other topologies have comes last.
        let mut names: Vec<&str> = if plausible.is_empty() { Vec::new() } else { kept.iter().map(|(name, _)| &**name).collect() };
        let mut known: HashSet<&str> = names.iter().copied().collect();
        let mut of: HashMap<&str, Vec<(f64, f64)>> = HashMap::new();
        for (figures, weight) in plausible {
            for (name, x) in figures {
                of.entry(name).or_default().push((*x, *weight));
                if known.insert(name) {
                    names.push(name);
                }
            }
        }
        let value = |name: &str| kept.iter().find(|(other, _)| other == name).map_or(f64::NAN, |(_, x)| finite(*x));
        let spreads: Vec<[f64; 3]> = names.iter().map(|name| spread(of.get(name).map_or(&[], Vec::as_slice))).collect();
        let end = |name, at: usize| Column::real(name, spreads.iter().map(move |spread| spread[at]));
        vec![
            self.subject(names.len()),
            Column::text("figure", names.iter().map(|name| (*name).to_owned())),
            Column::real("value", names.iter().map(|name| value(name))),
            end("mean", 0),
            end("low", 1),
            end("high", 2),
        ]
    }
}

/// All figures of a network: of the whole, by label, by territory, and of its circle where one is known.
pub fn named_figures(of: &NetworkFigures, circle: Option<&CircleFigures>) -> NamedFigures {
    let mut row = named("", &OF_NETWORK, of);
    row.extend(of.in_region.iter().flat_map(|region| named("", &IN_REGION, region)));
    row.extend(of.arteries.iter().flat_map(|(label, totals)| named(&format!("{label}_"), &OF_TOTALS, totals)));
    let mut pairs: NamedFigures = asymmetries(&of.arteries, "", |totals| totals.radius);
    let territories: BTreeMap<String, VesselTotals> =
        of.territories.iter().map(|(at, totals)| (TERRITORIES[*at].to_string(), *totals)).collect();
    row.extend(territories.iter().flat_map(|(artery, totals)| named(&format!("territory_{artery}_"), &OF_TOTALS, totals)));
    pairs.extend(asymmetries(&territories, "territory_", |totals| totals.length));
    row.extend(pairs);
    row.extend(circle.iter().flat_map(|circle| circle.columns()));
    row
}

/// The asymmetry of what is there on both sides.
fn asymmetries(of: &BTreeMap<String, VesselTotals>, prefix: &str, figure: fn(&VesselTotals) -> f64) -> NamedFigures {
    let pair = |(name, left): (&String, &VesselTotals)| {
        let name = name.strip_prefix(SIDES[0])?;
        let right = of.get(&format!("{}{name}", SIDES[1]))?;
        Some((format!("{prefix}{name}_asymmetry").into(), asymmetry(figure(left), figure(right))))
    };
    of.iter().filter_map(pair).collect()
}

/// The figures of a row by the names of their columns, with what stands before those.
fn named<T>(before: &str, columns: &[MeasuredColumn<T>], of: &T) -> NamedFigures {
    columns.iter().map(|(name, figure)| (format!("{before}{name}").into(), figure(of))).collect()
}

/// Measured columns of a table.
fn measured<'a, T>(columns: &'a [MeasuredColumn<T>], rows: &'a [T]) -> impl Iterator<Item = Column> + 'a {
    columns.iter().map(move |(name, figure)| Column::real(*name, rows.iter().map(|row| finite(figure(row)))))
}

/// The weighted mean, and the weighted quantiles of .025 and .975.
fn spread(values: &[(f64, f64)]) -> [f64; 3] {
    let known = || values.iter().copied().filter(|(x, _)| x.is_finite());
    let total: f64 = known().map(|(_, weight)| weight).sum();
    let mean = known().map(|(x, weight)| x * weight).sum::<f64>() / total;
    let quantile = |share| weighted_quantile(known(), share).unwrap_or(f64::NAN);
    [mean, quantile(0.025), quantile(0.975)]
}

fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { f64::NAN }
}
