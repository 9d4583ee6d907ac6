//! cohort.csv and cohort.html: many subjects, one row each.

mod columns;
mod figures;
mod table;

use std::path::Path;

use super::page::cohort::write_cohort_page;
use willis_core::error::Result;
use willis_io::formats::write_csv;
use willis_io::output::names::{COHORT_PAGE, COHORT_TABLE};
use willis_io::output::{StagedFiles, write_file};

pub use columns::describe;
pub use figures::{Figures, WALL_TIME, infer_figures, label_figures, needs_person, phenotype_figures};
pub use table::{CohortRow, CohortRun, cohort_columns, row_records, uncertainty};

/// Writes the table and the page into the folder of a cohort, in place of earlier ones.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_cohort(folder: &Path, rows: &[CohortRow], about: &CohortRun<'_>) -> Result<()> {
    let [table, page] = [COHORT_TABLE, COHORT_PAGE].map(|name| StagedFiles::new(&folder.join(name), true));
    let (table, page) = (table?, page?);
    write_file(&table.path(), |out| write_csv(out, &cohort_columns(rows)))?;
    let mut first: Vec<CohortRow> = rows.to_vec();
    first.sort_by(|a, b| uncertainty(b).total_cmp(&uncertainty(a)));
    write_file(&page.path(), |out| write_cohort_page(out, &first, about, folder))?;
    table.commit()?;
    page.commit().map(drop)
}
