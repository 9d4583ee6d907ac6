//! The table of a cohort: its rows, its columns, and how uncertain each row is.

use std::collections::HashSet;

use serde_json::{Value, json};

use super::columns::describe;
use super::figures::Figures;
use willis_io::formats::{Column, Covariates};

/// A subject.
#[derive(Debug, Clone)]
pub struct CohortRow {
    /// The name of its folder.
    pub subject: String,
    /// Its input.
    pub input: String,
    /// The SHA-256 of its input, empty where that cannot be read.
    pub sha256: String,
    /// What else is said of it: the same columns in all rows, or nothing.
    pub covariates: Covariates,
    /// The page that it opens, or its record where it has none, seen from the folder of the cohort; `None` for the one in the folder of its name.
    pub page: Option<String>,
    /// What came out, by column, or why nothing did.
    pub figures: Result<Figures, String>,
}

/// What a cohort is made with.
#[derive(Debug, Clone)]
pub struct CohortRun<'a> {
    /// The subcommand.
    pub command: &'static str,
    /// The command line that repeats it.
    pub line: String,
    /// Every option that changes a result.
    pub parameters: &'a Value,
}

impl CohortRow {
    fn cell(&self, column: &str) -> Option<&Value> {
        self.figures.as_ref().ok()?.iter().find(|(name, _)| *name == column).map(|(_, cell)| cell)
    }

    /// A figure; not a number where it is missing.
    pub(crate) fn number(&self, column: &str) -> f64 {
        self.cell(column).and_then(Value::as_f64).unwrap_or(f64::NAN)
    }

    fn record(&self, covariates: &[String]) -> Value {
        let known = OF_EVERY_ROW.iter().map(|(name, text)| ((*name).to_owned(), json!(text(self))));
        let said = covariates.iter().zip(&self.covariates).map(|(name, (_, text))| (name.clone(), json!(text)));
        let figures = self.figures.iter().flatten().map(|(name, cell)| (name.clone().into_owned(), cell.clone()));
        known.chain(said).chain(figures).collect()
    }
}

/// A column and the text of a row in it.
type KnownColumn = (&'static str, fn(&CohortRow) -> &str);

/// The columns that every cohort has.
const OF_EVERY_ROW: [KnownColumn; 5] = [
    ("subject", |row| &row.subject),
    ("input", |row| &row.input),
    ("sha256", |row| &row.sha256),
    ("status", |row| if row.figures.is_ok() { "ok" } else { "failed" }),
    ("error", |row| row.figures.as_ref().err().map_or("", String::as_str)),
];

/// The rows as objects, by the names of the columns of their table.
pub fn row_records(rows: &[CohortRow]) -> Vec<Value> {
    let names = covariate_names(rows);
    rows.iter().map(|row| row.record(&names)).collect()
}

/// The columns of covariates. Names that the table has for its own columns stay with those, and so do names of other covariates.
fn covariate_names(rows: &[CohortRow]) -> Vec<String> {
    let figures: HashSet<&str> = rows.iter().flat_map(|row| row.figures.iter().flatten()).map(|(name, _)| &**name).collect();
    let is_own = |name: &str| name == "subject" || describe(name).is_some() || figures.contains(name);
    let stated = rows.iter().map(|row| &row.covariates).max_by_key(|stated| stated.len());
    let stated: Vec<&String> = stated.into_iter().flatten().map(|(name, _)| name).collect();
    let is_free = |column: &String, name| !is_own(column) && (column == name || !stated.contains(&column));
    // No column of its own begins so: as many times as there are covariates are enough.
    let times = || 0..=stated.len() + 1;
    stated.iter().filter_map(|name| times().map(|n| "given_".repeat(n) + name).find(|column| is_free(column, *name))).collect()
}

/// The columns of cohort.csv: those of every cohort, then covariates, then the figures in the order in which rows have them first.
pub fn cohort_columns(rows: &[CohortRow]) -> Vec<Column> {
    let text = |(name, of): KnownColumn| Column::text(name, rows.iter().map(of));
    let mut columns = OF_EVERY_ROW.map(text).to_vec();
    for (at, name) in covariate_names(rows).into_iter().enumerate() {
        let text = |row: &CohortRow| row.covariates.get(at).map_or_else(String::new, |(_, text)| text.clone());
        columns.push(Column::text(name, rows.iter().map(text)));
    }
    for (name, _) in rows.iter().flat_map(|row| row.figures.iter().flatten()) {
        if columns.iter().any(|column| column.name == *name) {
            continue;
        }
        columns.push(if rows.iter().any(|row| row.cell(name).is_some_and(Value::is_string)) {
            let word = |row: &CohortRow| row.cell(name).and_then(Value::as_str).unwrap_or_default().to_owned();
            Column::text(name.clone(), rows.iter().map(word))
        } else {
            Column::real(name.clone(), rows.iter().map(|row| row.number(name)))
        });
    }
    columns
}

/// How uncertain a subject is: by the probability that its variant is another; without a variant by the errors expected of it, or its
/// undecided connections where there is no evidence, or its doubtful landmarks. One that failed is the most uncertain.
pub fn uncertainty(row: &CohortRow) -> f64 {
    if row.figures.is_err() {
        return f64::INFINITY;
    }
    let variant = row.number("p_variant");
    if !variant.is_nan() {
        return 1.0 - variant;
    }
    let expected = row.number("expected_wrong") + row.number("expected_missed");
    let figures = [expected, row.number("undecided"), row.number("doubtful")];
    figures.into_iter().find(|figure| !figure.is_nan()).unwrap_or_default()
}
