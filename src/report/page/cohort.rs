//! cohort.html: the subjects of a cohort in a table, the most uncertain first, and the distribution of any column.

use std::io::{self, Write};

use serde_json::json;

use super::{Table, Template, encode};
use crate::io::Column;
use crate::output::names::{PAGE, PHENOTYPE};
use crate::report::cohort::{About, Row, WALL_TIME};

const COHORT: Template = Template {
    goal: "subjects",
    main: include_str!("assets/cohort.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/table.js"),
        include_str!("assets/distribution.js"),
        include_str!("assets/cohort.js"),
    ],
};
/// The columns that the page leaves out: what differs between two runs of one command, and what nobody reads.
const LEFT_OUT: [&str; 2] = [WALL_TIME, "sha256"];

/// Writes the page of a cohort: `columns` are those of its `rows`, in the order in which they are shown.
///
/// # Errors
///
/// An error of the writer.
pub fn write_cohort_page(out: &mut impl Write, rows: &[Row], columns: Vec<Column>, about: &About<'_>) -> io::Result<()> {
    let columns = columns.into_iter().filter(|column| !LEFT_OUT.contains(&&*column.name)).collect();
    let table = Table { title: "Subjects".to_owned(), columns, exact: &[], of_vessels: false };
    let failed = rows.iter().filter(|row| row.figures.is_err()).count();
    let mut data = json!({
        "command": about.line,
        "willis": env!("CARGO_PKG_VERSION"),
        "parameters": about.parameters,
        "failed": failed,
        "opens": if about.command == "infer" { PAGE } else { PHENOTYPE },
        "table": encode::table(&table)?,
    });
    if rows.iter().any(|row| row.page.is_some()) {
        data["pages"] = rows.iter().map(|row| row.page.as_deref()).collect();
    }
    COHORT.fill(out, &format!("willis {}: {} subjects", about.command, rows.len()), &data)
}
