//! cohort.html: the subjects of a cohort in a table, the most uncertain first, and the distribution of any column.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::content::PageTable;
use super::template::Template;
use crate::cohort::{CohortRow, CohortRun, WALL_TIME, cohort_columns};
use crate::figures::{FRONT, units};
use willis_io::output::names::{PAGE, SUMMARY_PICTURE};
use willis_io::output::{final_path, plain};

const COHORT: Template = Template {
    goal: "subjects",
    main: include_str!("assets/cohort.html"),
    scripts: &[
        include_str!("assets/dom.js"),
        include_str!("assets/data.js"),
        include_str!("assets/table.js"),
        include_str!("assets/distribution.js"),
        include_str!("assets/zip.js"),
        include_str!("assets/walk.js"),
        include_str!("assets/cohort.js"),
    ],
};
/// The columns that the page leaves out: what differs between two runs of one command, and what nobody reads.
const LEFT_OUT: [&str; 2] = [WALL_TIME, "sha256"];

/// Writes the page of a cohort, of its `rows` in the order in which they are shown.
///
/// # Errors
///
/// An error of the writer.
pub fn write_cohort_page(out: &mut impl Write, rows: &[CohortRow], about: &CohortRun<'_>, folder: &Path) -> io::Result<()> {
    let columns = cohort_columns(rows).into_iter().filter(|column| !LEFT_OUT.contains(&&*column.name)).collect();
    let table = PageTable::new("Subjects", columns, false);
    let failed = rows.iter().filter(|row| row.figures.is_err()).count();
    let mut data = json!({
        "command": about.line,
        "willis": env!("CARGO_PKG_VERSION"),
        "parameters": about.parameters,
        "failed": failed,
        "walks": about.command != "classify" && about.command != "label",
        "opens": PAGE,
        "thumbnail": FRONT.map(units),
        "table": table,
    });
    if rows.iter().any(|row| row.page.is_some()) {
        data["pages"] = rows.iter().map(|row| row.page.as_deref()).collect();
    }
    data["pictures"] = rows.iter().map(|row| picture(row, folder)).collect();
    COHORT.fill(out, &format!("willis {}: {} subjects", about.command, rows.len()), &data)
}

/// The picture of a subject, seen from the folder of the cohort; null where there is none.
fn picture(row: &CohortRow, folder: &Path) -> Value {
    let page = row.page.clone().unwrap_or_else(|| format!("{}/{PAGE}", row.subject));
    let beside = Path::new(&page).with_file_name(format!("{SUMMARY_PICTURE}.svg"));
    // A folder that is being written stands elsewhere until it is whole; subjects in it are with it, others are told from where it will stand.
    let will_be = plain(&final_path(folder).join(&beside)).map(|steps| steps.iter().collect::<PathBuf>());
    let there = folder.join(&beside).is_file() || will_be.is_some_and(|path| path.is_file());
    if row.figures.is_ok() && there { json!(beside) } else { Value::Null }
}
