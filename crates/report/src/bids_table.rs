//! The subjects of a cohort as BIDS has tables: TSV with n/a for what is missing, and a JSON sidecar that describes every column.

use std::borrow::Cow;
use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::cohort::{CohortRow, cohort_columns, describe};
use willis_io::formats::{Column, Values, escape_formula};

/// What a column is that the participants have of their own.
const COVARIATE: &str = "What participants.tsv says of the participant.";
/// What BIDS writes for a missing value.
const MISSING: &str = "n/a";

/// The columns of a table of runs: `names` are the participant and the session of each row, and stand for its subject.
pub fn bids_columns(rows: &[CohortRow], names: &[(String, Option<String>)]) -> Vec<Column> {
    let mut columns = vec![Column::text("participant_id", names.iter().map(|(participant, _)| participant.clone()))];
    if names.iter().any(|(_, session)| session.is_some()) {
        columns.push(Column::text("session_id", names.iter().map(|(_, session)| session.clone().unwrap_or_default())));
    }
    columns.extend(cohort_columns(rows).into_iter().filter(|column| column.name != "subject"));
    columns
}

/// Writes columns as BIDS has them: tabs between cells, which hold none, and no quotes.
///
/// # Errors
///
/// The writer's own.
pub fn write_tsv(out: &mut impl Write, columns: &[Column]) -> io::Result<()> {
    let mut line = |cells: Vec<Cow<'_, str>>| writeln!(out, "{}", cells.join("\t"));
    line(columns.iter().map(|column| column.name.clone()).collect())?;
    for row in 0..columns.first().map_or(0, |column| column.values.rows()) {
        let cell = |column: &Column| {
            let text = match &column.values {
                Values::Text(texts) => escape_formula(&texts[row]).replace(char::is_control, " "),
                numbers => numbers.text(row).into_owned(),
            };
            if text.is_empty() { MISSING.into() } else { text.into() }
        };
        line(columns.iter().map(cell).collect())?;
    }
    Ok(())
}

/// The sidecar of a table: what the table is, and what each of its columns is.
pub fn sidecar(columns: &[Column]) -> Value {
    let mut fields = Map::new();
    let about =
        "The connections between the vessels of each scan, and the variant of the Circle of Willis, as willis inferred them.";
    fields.insert("Description".into(), json!(about));
    fields.insert("MeasurementToolMetadata".into(), json!({ "Description": format!("willis {}", env!("CARGO_PKG_VERSION")) }));
    for column in columns {
        let about = describe(&column.name).unwrap_or_else(|| json!({ "Description": COVARIATE }));
        fields.insert(column.name.clone().into_owned(), about);
    }
    fields.into()
}
