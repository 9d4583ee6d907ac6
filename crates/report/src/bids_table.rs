//! The subjects of a cohort as BIDS has tables: TSV with n/a for what is missing, and a JSON sidecar that describes every column.

use std::borrow::Cow;
use std::io::{self, Write};

use serde_json::{Map, Value, json};

use super::cohort::{Row, cohort_columns};
use willis_io::formats::{Column, Values, escape_formula};
use willis_models::circle_of_willis::{FEEDERS, RING, TERRITORIES};

/// What a column is that the participants have of their own.
const COVARIATE: &str = "What participants.tsv says of the participant.";
/// What BIDS writes for a missing value.
const MISSING: &str = "n/a";

/// The columns of a table of runs: `names` are the participant and the session of each row, and stand for its subject.
pub fn bids_columns(rows: &[Row], names: &[(String, Option<String>)]) -> Vec<Column> {
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
    for row in 0..columns.first().map_or(0, |column| column.values.len()) {
        let cell = |column: &Column| {
            let text = match &column.values {
                Values::Text(texts) => escape_formula(&texts[row]).replace(char::is_control, " "),
                numbers => numbers.text(row),
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
        fields.insert(
            column.name.clone().into_owned(),
            describe(&column.name).unwrap_or_else(|| json!({ "Description": COVARIATE })),
        );
    }
    fields.into()
}

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    let text = |about: &str| json!({ "Description": about });
    let levels = |about: &str, levels: Value| json!({ "Description": about, "Levels": levels });
    let count = |about: &str| json!({ "Description": about, "Units": "1" });
    let whole = match column {
        "participant_id" => text("The participant."),
        "session_id" => text("The session."),
        "input" => text("The mask of the vessels; seen from the dataset of the masks where it lies there."),
        "sha256" => text("The SHA-256 of the mask."),
        "status" => {
            let known = json!({ "ok": "The run came to its end.", "failed": "The mask gave no answer." });
            levels("Whether there is an answer.", known)
        }
        "error" => text("Why there is no answer."),
        "nodes" => count("Nodes of the graph of vessels and candidate connections."),
        "observed" => count("Vessels that the mask shows."),
        "candidates" => count("Candidate connections between them."),
        "kept" => count("Candidate connections that are kept; the rest is cut."),
        "undecided" => count(
            "Uncertain vessels that a person should look at: by evidence a probability near the cut or a connection left open, by likelihood a figure within two standard errors of the threshold.",
        ),
        "components" => count("Connected components of the kept topology."),
        "cycles" => count("Independent cycles of the kept topology."),
        "sparsity" => count("Candidate connections that are kept, over all."),
        "rho_G_W_per_m3" => json!({ "Description": "Mean resilience of the network.", "Units": "W/m^3" }),
        "expected_wrong" => count("Expected number of wrong connections among those that are kept, by their probabilities."),
        "expected_missed" => count("Expected number of true connections among those that are cut, by their probabilities."),
        "wall_s" => json!({ "Description": "Time that the run took; it differs from run to run.", "Units": "s" }),
        "variant" => text("The variant of the Circle of Willis."),
        "completeness" => text("Which parts of the Circle of Willis are closed."),
        "p_variant" => count("The probability of the variant."),
        "needs_person" => text("Why a person should look; empty where nothing that is open could change the answer."),
        "hypoplastic" => text("The segments of the Circle of Willis that are there and thin."),
        "margin" => count("The probability of the variant minus that of the next."),
        _ => Value::Null,
    };
    if !whole.is_null() {
        return Some(whole);
    }
    let is_segment = |name: &str| RING.iter().any(|artery| artery.to_string() == name);
    let is_feeder = |name: &str| FEEDERS.iter().any(|artery| artery.to_string() == name);
    let is_there = || json!({ "0": "No.", "1": "Yes." });
    if is_segment(column) {
        return Some(levels(&format!("Whether the segment {column} of the Circle of Willis is there."), is_there()));
    }
    if let Some(segment) = column.strip_prefix("p_").filter(|name| is_segment(name)) {
        return Some(count(&format!("The probability that the segment {segment} of the Circle of Willis is there.")));
    }
    if let Some(artery) = column.strip_prefix("fetal_") {
        return Some(levels(&format!("Whether {artery}, a posterior cerebral artery, is of fetal type."), is_there()));
    }
    if let Some(feeder) = column.strip_prefix("takes_over_").filter(|name| is_feeder(name)) {
        return Some(text(&format!("The communicating artery that takes over when {feeder} is lost.")));
    }
    let is_territory = |name: &str| TERRITORIES.iter().any(|artery| artery.to_string() == name);
    if let Some((territory, feeder)) =
        column.split_once("_from_").filter(|(name, feeder)| is_territory(name) && is_feeder(feeder))
    {
        return Some(count(&format!("The share of the blood of {territory} that comes by {feeder}, on average.")));
    }
    if let Some(territory) = column.strip_suffix("_arrival_ms").filter(|name| is_territory(name)) {
        let about = format!("Mean time since the blood of {territory} entered, the median over the plausible topologies.");
        return Some(json!({ "Description": about, "Units": "ms" }));
    }
    let (territory, feeder) = column.split_once("_without_").filter(|(_, feeder)| is_feeder(feeder))?;
    is_territory(territory).then(|| count(&format!("The share of its flow that {territory} keeps when {feeder} is lost.")))
}
