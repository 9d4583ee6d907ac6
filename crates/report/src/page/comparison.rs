//! The page of a comparison: a panel for each measure with the points of both groups, and comparison.csv as a table.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::content::PageTable;
use super::template::Template;
use crate::cohort::CohortRow;
use willis_io::formats::{Column, Values};

const COMPARISON: Template = Template {
    goal: "measures",
    main: include_str!("assets/comparison.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/table.js"),
        include_str!("assets/record.js"),
        include_str!("assets/comparison.js"),
    ],
};

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
    COMPARISON.fill(out, &format!("willis measure: groups by {column}"), &data)
}
