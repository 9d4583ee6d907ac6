//! The tables of what is measured: vessels.csv, bifurcations.csv, ends.csv, intervals.csv, the row of a subject in subjects.csv, what two readers say, and the page of a comparison.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::io::{self, Write};

use serde_json::{Value, json};

use crate::cohort::CohortRow;
use crate::page::{PageKind, PageTable, write_page};
use crate::phenotype::{CircleFigures, NamedFigures, SIDES, asymmetry};
use willis_core::morphometry::columns::{IN_REGION, MeasuredColumn, OF_BIFURCATION, OF_END, OF_NETWORK, OF_TOTALS, OF_VESSEL};
use willis_core::morphometry::{Morphometry, NetworkFigures, VesselTotals};
use willis_core::network::{Network, Role};
use willis_core::support::kappa::{CohenKappa, cohen_kappa};
use willis_io::formats::{ANSWERS, Column, ConnectionDecision, POSITION_COLUMNS, Values, coordinate_columns, coordinates};
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
    let [low, high] = willis_core::support::weighted_quantiles(known(), [0.025, 0.975]).map(|x| x.unwrap_or(f64::NAN));
    [mean, low, high]
}

fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { f64::NAN }
}

/// The number of what a reader says of a connection among the answers.
fn answer(read: &ConnectionDecision) -> usize {
    ANSWERS.iter().position(|(accepted, _)| *accepted == read.accepted).unwrap_or_default()
}

/// A connection that one of two readers decided on at least.
#[derive(Debug, Clone, PartialEq)]
pub struct TwiceRead {
    /// The subject.
    pub subject: String,
    /// The kind of question: `candidate` or `contact`.
    pub kind: &'static str,
    /// Its row in edges.csv.
    pub edge: usize,
    /// The ids of its two nodes.
    pub ids: [String; 2],
    /// Where it is, mm.
    pub middle: [f64; 3],
    /// What the run says; not a number without evidence.
    pub probability: f64,
    /// What the readers say; none of one who did not decide.
    pub read: [Option<ConnectionDecision>; 2],
}

impl TwiceRead {
    /// The answers of both, where both decided.
    fn answers(&self) -> Option<[usize; 2]> {
        let [a, b] = &self.read;
        Some([answer(a.as_ref()?), answer(b.as_ref()?)])
    }
}

/// Kappa over all connections.
pub fn kappa_of(read: &[TwiceRead]) -> CohenKappa {
    cohen_kappa(&read.iter().filter_map(TwiceRead::answers).collect::<Vec<_>>(), ANSWERS.len())
}

/// The columns of readers.csv: a row for each kind of question, and one for all.
pub fn reader_columns(read: &[TwiceRead]) -> Vec<Column> {
    let kinds: BTreeSet<&str> = read.iter().map(|row| row.kind).collect();
    let of = |kind: &str| read.iter().filter(|row| row.kind == kind).cloned().collect::<Vec<_>>();
    let each = kinds.into_iter().map(|kind| (kind, of(kind)));
    let rows: Vec<(&str, Vec<TwiceRead>)> = each.chain([("all", read.to_vec())]).collect();
    let found: Vec<CohenKappa> = rows.iter().map(|(_, read)| kappa_of(read)).collect();
    let counted = |name: String, counts: &dyn Fn(&TwiceRead) -> bool| {
        Column::whole(name, rows.iter().map(|(_, read)| read.iter().filter(|row| counts(row)).count()))
    };
    let real = |name, of: fn(&CohenKappa) -> f64| Column::real(name, found.iter().map(of));
    let mut columns = vec![
        Column::text("kind", rows.iter().map(|(kind, _)| (*kind).to_owned())),
        Column::whole("decided", found.iter().map(|found| found.count)),
        Column::whole("alike", found.iter().map(|found| found.alike)),
        real("kappa", |found| found.kappa),
        real("kappa_low", |found| found.interval[0]),
        real("kappa_high", |found| found.interval[1]),
    ];
    for (a, (_, first)) in ANSWERS.iter().enumerate() {
        for (b, (_, second)) in ANSWERS.iter().enumerate() {
            columns.push(counted(format!("{first}_{second}"), &|row| row.answers() == Some([a, b])));
        }
    }
    columns.push(counted("only_a".to_owned(), &|row| row.read[1].is_none()));
    columns.push(counted("only_b".to_owned(), &|row| row.read[0].is_none()));
    columns
}

/// A column that both readers have: its name, and its text of one of them.
type ReaderColumn = (&'static str, fn(&ConnectionDecision) -> String);

/// The columns of differences.csv: the connections that both decided otherwise, or only one.
pub fn difference_columns(read: &[TwiceRead]) -> Vec<Column> {
    let rows: Vec<&TwiceRead> = read.iter().filter(|row| row.answers().is_none_or(|[a, b]| a != b)).collect();
    let text = |name: String, of: &dyn Fn(&TwiceRead) -> String| Column::text(name, rows.iter().map(|row| of(row)));
    let mut columns = vec![
        text("subject".to_owned(), &|row| row.subject.clone()),
        text("kind".to_owned(), &|row| row.kind.to_owned()),
        Column::whole("edge", rows.iter().map(|row| row.edge)),
        text("id_a".to_owned(), &|row| row.ids[0].clone()),
        text("id_b".to_owned(), &|row| row.ids[1].clone()),
    ];
    columns.extend(coordinate_columns(POSITION_COLUMNS, || rows.iter().map(|row| row.middle)));
    columns.push(Column::real("probability", rows.iter().map(|row| row.probability)));
    let of_reader: [ReaderColumn; 3] = [
        ("decision", |read| ANSWERS[answer(read)].1.to_owned()),
        ("who", |read| read.who.clone()),
        ("comment", |read| read.comment.clone()),
    ];
    for (name, of) in of_reader {
        for (reader, letter) in ["a", "b"].into_iter().enumerate() {
            columns.push(text(format!("{name}_{letter}"), &|row| row.read[reader].as_ref().map_or_else(String::new, of)));
        }
    }
    columns
}

const COMPARISON: PageKind = ["measures", include_str!("page/assets/comparison.html"), "dom data table record comparison"];

/// Writes the page of a comparison from its record and the columns of comparison.csv. `first` says which of the subjects are of the first group; none for
/// one that is in neither.
///
/// # Errors
///
/// An error of the writer.
pub fn write_comparison_page(
    out: &mut impl Write,
    record: &Value,
    comparison: Vec<Column>,
    rows: &[CohortRow],
    first: &[Option<bool>],
) -> io::Result<()> {
    let mut record = record.clone();
    record["subjects"].take();
    let compared: Vec<(&CohortRow, bool)> =
        rows.iter().zip(first).filter(|(row, _)| row.figures.is_ok()).filter_map(|(row, first)| Some((row, (*first)?))).collect();
    let mut subjects = vec![Column::text("subject", compared.iter().map(|(row, _)| row.subject.clone()))];
    if let Some(Values::Text(measures)) = comparison.first().map(|column| &column.values) {
        subjects
            .extend(measures.iter().map(|name| Column::real(name.to_owned(), compared.iter().map(|(row, _)| row.number(name)))));
    }
    let column = record["parameters"]["compare"].as_str().unwrap_or_default().to_owned();
    let data = json!({
        "record": record,
        "compare": column,
        "first": compared.iter().map(|(_, first)| *first).collect::<Vec<bool>>(),
        "subjects": PageTable::new("Subjects", subjects, false),
        "comparison": PageTable::new("Comparison", comparison, false),
    });
    write_page(out, &format!("willis measure: groups by {column}"), COMPARISON, &data)
}
