//! The page of a resistance modulation: vessels by their mean flow, drop, resilience and hypertension in each class.

use super::content::{ColourScale, Colouring, Page, PagePicture, PageTable, conditions, facts, warnings};
use super::scene::scene;
use crate::modulation::ModulationRun;
use crate::run_record::RunRecord;
use willis_io::formats::{Column, Values};

/// The quantities of a vessel in the order of edges.csv: name, unit, start of the names of its columns, column of its variation.
const QUANTITIES: [(&str, &str, &str, &str); 4] = [
    ("flow", "mL/min", "flow_mL_per_min", "flow_variation"),
    ("pressure drop", "mmHg", "drop_mmHg", "drop_variation"),
    ("resilience \u{3c1}", "W/m\u{b3}", "resilience_W_per_m3", "resilience_variation"),
    ("hypertension", "mmHg/mm\u{b2}", "hypertension_mmHg_per_mm2", "hypertension_variation"),
];
/// The names of the colourings by variation.
const VARIATION: [&str; 4] =
    ["variation of flow", "variation of pressure drop", "variation of resilience", "variation of hypertension"];

/// The page of a modulation.
pub fn page(
    outcome: &ModulationRun<'_>,
    of_run: &RunRecord,
    [of_classes, nodes, vessels, hypertension]: [Vec<Column>; 4],
    figures: Vec<PagePicture>,
) -> Page {
    let record = of_run.for_page();
    let warnings = warnings(&record, &of_run.conditions);
    let lead = super::lead::modulation(&record);
    let classes: Vec<String> = outcome.result.classes.iter().map(|(class, _)| class.to_string()).collect();
    let facts = facts(
        &record,
        &[
            ("nodes", "/counts/nodes", ""),
            ("vessels", "/counts/vessels", ""),
            ("instances per class", "/parameters/samples", ""),
            ("reading", "/parameters/reading", ""),
            ("seed", "/seed", ""),
            ("\u{3c1}_G unperturbed", "/unperturbed/rho_G_W_per_m3", "W/m\u{b3}"),
            ("inflow unperturbed", "/unperturbed/total_inflow_mL_per_min", "mL/min"),
            ("threshold of hypertension", "/parameters/threshold_mmHg_per_mm2", "mmHg/mm\u{b2}"),
        ],
    );
    let of = |(at, class)| PageTable::new(format!("Vessels, u in {class}"), of_class(outcome, &vessels, at), true);
    let mut all: Vec<PageTable> = classes.iter().enumerate().map(of).collect();
    all.push(PageTable::new("Classes", of_classes, false));
    all.push(PageTable::new("Nodes", nodes, false));
    all.push(PageTable::new("Hypertension", hypertension, false));
    all.extend(conditions(&of_run.conditions));
    let scene = scene(&outcome.network, &outcome.boundary);
    let colourings = colourings(&classes);
    Page { lead, warnings, facts, colourings, tables: all, ..Page::new("modulate", record, scene, &[], figures) }
}

/// One row per vessel, from the rows of edges.csv of one class; these are in the order of class, vessel, quantity (flow, drop, resilience,
/// hypertension).
fn of_class(outcome: &ModulationRun<'_>, tidy: &[Column], class: usize) -> Vec<Column> {
    let vessels = outcome.network.vessel_count();
    let row = |vessel: usize, quantity: usize| (class * vessels + vessel) * QUANTITIES.len() + quantity;
    let figures = |name: &str| match tidy.iter().find(|c| c.name == name).map(|c| &c.values) {
        Some(Values::Real(values)) => &values[..],
        _ => &[],
    };
    let first = |column: &&Column| ["edge", "node_a", "node_b", "label"].contains(&&*column.name);
    let rows: Vec<usize> = (0..vessels).map(|vessel| row(vessel, 0)).collect();
    let of_rows: Vec<Column> = tidy.iter().filter(first).cloned().collect();
    let mut columns = crate::inference::tables::select(&of_rows, &rows);
    for (quantity, (_, _, name, variation_name)) in QUANTITIES.into_iter().enumerate() {
        let of = |name: &str| (0..vessels).map(|v| figures(name)[row(v, quantity)]).collect::<Vec<f64>>();
        let (mean, std) = (of("mean"), of("std"));
        let variation = mean.iter().zip(&std).map(|(mean, std)| if *mean == 0.0 { f64::NAN } else { std / mean.abs() });
        let variation: Vec<f64> = variation.collect();
        columns.extend([
            Column::real(format!("{name}_mean"), mean.into_iter()),
            Column::real(format!("{name}_std"), std.into_iter()),
            Column::real(variation_name, variation.into_iter()),
            Column::real(format!("{name}_unperturbed"), of("unperturbed").into_iter()),
        ]);
    }
    columns
}

fn colourings(classes: &[String]) -> Vec<Colouring> {
    let by_class = |column: String| {
        let variant = move |(at, class): (usize, &String)| (format!("u in {class}"), at, column.clone());
        classes.iter().enumerate().map(variant)
    };
    let each = QUANTITIES.into_iter().zip(VARIATION).map(|((name, unit, column, variation), of)| {
        let at_rest = std::iter::once(("unperturbed".to_owned(), 0, format!("{column}_unperturbed")));
        let mean = Colouring::new(name, unit, ColourScale::Log, by_class(format!("{column}_mean")).chain(at_rest).collect());
        [mean, Colouring::new(of, "std / |mean|", ColourScale::Log, by_class(variation.to_owned()).collect())]
    });
    each.flatten().collect()
}
