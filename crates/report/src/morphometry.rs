//! The tables of what is measured: vessels.csv, bifurcations.csv, ends.csv, intervals.csv, and the row of a subject in subjects.csv.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap, HashSet};

use super::circle_figures::{CircleFigures, NamedFigures, SIDES, asymmetry};
use willis_core::morphometry::{Morphometry, NetworkFigures, VesselTotals};
use willis_core::network::units::millimetres;
use willis_core::network::{Network, Role};
use willis_core::support::statistics::weighted_quantile;
use willis_io::formats::{Column, POSITION_COLUMNS, coordinate_columns, coordinates};
use willis_models::circle_of_willis::TERRITORIES;

const MM2: f64 = 1e6;
const MM3: f64 = 1e9;

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

    fn places(&self, nodes: &[usize]) -> [Column; 3] {
        coordinate_columns(POSITION_COLUMNS, || nodes.iter().map(|node| coordinates(self.network.node(*node).position)))
    }

    /// The columns of vessels.csv.
    pub fn vessels(&self) -> Vec<Column> {
        let vessels = &self.measured.vessels;
        let real = |name, of: &dyn Fn(usize) -> f64| Column::real(name, (0..vessels.len()).map(of));
        let shape = |row: usize| &vessels[row].shape;
        let order = |of: Option<usize>| of.map_or(f64::NAN, |n| n as f64);
        let per_mm = 1e-3;
        vec![
            self.subject(vessels.len()),
            Column::whole("vessel", 0..vessels.len()),
            Column::text("label", vessels.iter().map(|v| v.line.label.clone())),
            Column::text(
                "territory",
                vessels.iter().map(|v| v.territory.map_or_else(String::new, |at| TERRITORIES[at].to_string())),
            ),
            Column::text("id_a", vessels.iter().map(|v| self.id(v.line.ends[0]))),
            Column::text("id_b", vessels.iter().map(|v| self.id(v.line.ends[1]))),
            Column::whole("degree_a", vessels.iter().map(|v| v.degree[0])),
            Column::whole("degree_b", vessels.iter().map(|v| v.degree[1])),
            real("length_mm", &|row| millimetres(vessels[row].line.length)),
            real("chord_mm", &|row| millimetres(shape(row).chord)),
            real("radius_mm", &|row| millimetres(shape(row).radius)),
            real("radius_min_mm", &|row| millimetres(shape(row).least_radius)),
            real("taper", &|row| shape(row).taper),
            real("volume_mm3", &|row| MM3 * shape(row).volume),
            real("surface_mm2", &|row| MM2 * shape(row).surface),
            real("distance_metric", &|row| shape(row).distance_metric),
            real("inflection_count_metric", &|row| shape(row).inflection_count_metric),
            real("sum_of_angles_rad_per_mm", &|row| per_mm * shape(row).sum_of_angles_metric),
            real("curvature_per_mm", &|row| per_mm * shape(row).curvature),
            real("torsion_per_mm", &|row| per_mm * shape(row).torsion),
            real("generation", &|row| order(vessels[row].generation)),
            real("strahler", &|row| order(vessels[row].strahler)),
            real("strahler_by_diameter", &|row| order(vessels[row].diameter_strahler)),
            real("from_inlet_mm", &|row| finite(millimetres(vessels[row].from_inlet))),
            real("probability", &|row| vessels[row].probability),
        ]
    }

    /// The columns of bifurcations.csv.
    pub fn bifurcations(&self) -> Vec<Column> {
        let found = &self.measured.bifurcations;
        let nodes: Vec<usize> = found.iter().map(|b| b.node).collect();
        let real = |name, of: &dyn Fn(usize) -> f64| Column::real(name, (0..found.len()).map(of));
        let degrees = |name, of: &dyn Fn(usize) -> f64| real(name, &|row| of(row).to_degrees());
        let mut columns = vec![self.subject(found.len()), Column::text("id", nodes.iter().map(|node| self.id(*node)))];
        columns.extend(self.places(&nodes));
        columns.extend([
            Column::whole("degree", found.iter().map(|b| b.degree)),
            Column::whole("parent", found.iter().map(|b| b.parent)),
            Column::whole("child_1", found.iter().map(|b| b.children[0])),
            Column::whole("child_2", found.iter().map(|b| b.children[1])),
            real("radius_parent_mm", &|row| millimetres(found[row].radii[0])),
            real("radius_child_1_mm", &|row| millimetres(found[row].radii[1])),
            real("radius_child_2_mm", &|row| millimetres(found[row].radii[2])),
            degrees("angle_deg", &|row| found[row].angle),
            degrees("bend_child_1_deg", &|row| found[row].bends[0]),
            degrees("bend_child_2_deg", &|row| found[row].bends[1]),
            degrees("elevation_deg", &|row| found[row].elevation),
            real("asymmetry", &|row| found[row].asymmetry),
            real("area_ratio", &|row| found[row].area_ratio),
            real("murray_exponent", &|row| found[row].murray.unwrap_or(f64::NAN)),
        ]);
        columns
    }

    /// The columns of ends.csv; `role` says what a node is to the flow.
    pub fn ends(&self, role: impl Fn(usize) -> Role) -> Vec<Column> {
        let ends = &self.measured.ends;
        let nodes: Vec<usize> = ends.iter().map(|end| end.node).collect();
        let mut columns = vec![self.subject(ends.len()), Column::text("id", nodes.iter().map(|node| self.id(*node)))];
        columns.extend(self.places(&nodes));
        columns.extend([
            Column::text("label", nodes.iter().map(|node| self.network.node(*node).label.clone())),
            Column::text("role", nodes.iter().map(|node| role(*node).name().to_owned())),
            Column::whole("vessel", ends.iter().map(|end| end.vessel)),
            Column::real("radius_mm", ends.iter().map(|end| millimetres(end.radius))),
            Column::real("from_inlet_mm", ends.iter().map(|end| finite(millimetres(end.from_inlet)))),
        ]);
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
    let mut row: NamedFigures = OF_NETWORK.iter().map(|(name, figure)| ((*name).into(), figure(of))).collect();
    if let Some([length, volume, region]) = of.in_region {
        let densities =
            [("brain_mm3", MM3 * region), ("length_density_in_brain_per_mm2", length / MM2), ("volume_density_in_brain", volume)];
        row.extend(densities.map(|(name, x)| (name.into(), x)));
    }
    for (label, totals) in &of.arteries {
        row.extend(figures_of(label, totals));
    }
    let mut pairs: NamedFigures = asymmetries(&of.arteries, "", |totals| totals.radius);
    let territories: BTreeMap<String, VesselTotals> =
        of.territories.iter().map(|(at, totals)| (TERRITORIES[*at].to_string(), *totals)).collect();
    for (artery, totals) in &territories {
        row.extend(figures_of(&format!("territory_{artery}"), totals));
    }
    pairs.extend(asymmetries(&territories, "territory_", |totals| totals.length));
    row.extend(pairs);
    row.extend(circle.iter().flat_map(|circle| circle.columns()));
    row
}

/// The figures of an artery or a territory.
fn figures_of(name: &str, totals: &VesselTotals) -> [(Cow<'static, str>, f64); 4] {
    [
        (format!("{name}_length_mm").into(), millimetres(totals.length)),
        (format!("{name}_volume_mm3").into(), MM3 * totals.volume),
        (format!("{name}_diameter_mm").into(), 2.0 * millimetres(totals.radius)),
        (format!("{name}_from_inlet_mean_mm").into(), millimetres(totals.mean_from_inlet)),
    ]
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

/// The columns of subjects.csv that are of a whole network.
type OfNetwork = (&'static str, fn(&NetworkFigures) -> f64);

const OF_NETWORK: [OfNetwork; 17] = [
    ("vessels", |of| of.vessels as f64),
    ("bifurcations", |of| of.bifurcations as f64),
    ("ends", |of| of.ends as f64),
    ("parts", |of| of.parts as f64),
    ("loops", |of| of.loops as f64),
    ("length_mm", |of| millimetres(of.whole.length)),
    ("longest_part", |of| of.longest_part),
    ("volume_mm3", |of| MM3 * of.whole.volume),
    ("surface_mm2", |of| MM2 * of.whole.surface),
    ("radius_mm", |of| millimetres(of.whole.radius)),
    ("box_mm3", |of| MM3 * of.boxed),
    ("length_density_per_mm2", |of| of.whole.length / of.boxed / MM2),
    ("volume_density", |of| of.whole.volume / of.boxed),
    ("box_dimension", |of| of.box_dimension),
    ("from_inlet_mean_mm", |of| millimetres(of.whole.mean_from_inlet)),
    ("from_inlet_max_mm", |of| millimetres(of.whole.most_from_inlet)),
    ("murray_exponent_median", |of| of.murray),
];

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
