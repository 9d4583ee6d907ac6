//! The page of a classification: the circle as a drawing, its variant in words, and what becomes of the flow without each feeder.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::content::{PageTable, colours, warnings};
use super::template::Template;
use willis_io::formats::Column;

const PHENOTYPE_PAGE: Template = Template {
    goal: "circle",
    main: include_str!("assets/phenotype.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/colour.js"),
        include_str!("assets/table.js"),
        include_str!("assets/record.js"),
        include_str!("assets/circle.js"),
        include_str!("assets/phenotype.js"),
    ],
};

/// Writes the page of a classification of a `subject` from its record and the columns of collateral.csv; `run`: the page of its run.
///
/// # Errors
///
/// An error of the writer.
pub fn write_phenotype_page(
    out: &mut impl Write,
    subject: &str,
    record: &Value,
    run: Option<&str>,
    collaterals: Vec<Column>,
) -> io::Result<()> {
    let mut record = record.clone();
    let phenotype = record["phenotype"].take();
    record["collateral"].take();
    let table = PageTable::new("Flow without each feeder", collaterals, false);
    let warnings = warnings(&record, &[]);
    let data = json!({
        "phenotype": phenotype,
        "record": record,
        "run": run,
        "warnings": warnings,
        "colours": colours(),
        "collaterals": table,
    });
    PHENOTYPE_PAGE.fill(out, &format!("willis classify: {subject}"), &data)
}
