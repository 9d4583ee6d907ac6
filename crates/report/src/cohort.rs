//! cohort.csv and cohort.html: many subjects, one row each.

use std::borrow::Cow;
use std::path::Path;

use serde_json::{Map, Value, json};

use super::bids_table::describe;
use super::page::cohort::write_cohort_page;
use willis_core::error::Result;
use willis_io::formats::tables::reader::plural;
use willis_io::formats::{Column, Covariates, write_csv};
use willis_io::output::atomic::{StagedFile, write_file};
use willis_io::output::names::{COHORT_PAGE, COHORT_TABLE};
use willis_models::circle_of_willis::{FEEDERS, RING, TERRITORIES};

/// The one column that differs between two runs of one command, from run.json, in seconds.
pub const WALL_TIME: &str = "wall_s";

/// The column that says why a subject needs a person.
const NEEDS_PERSON: &str = "needs_person";

/// A subject.
#[derive(Debug, Clone)]
pub struct Row {
    /// The name of its folder.
    pub subject: String,
    /// Its input.
    pub input: String,
    /// The SHA-256 of its input, empty where that cannot be read.
    pub sha256: String,
    /// What else is said of it: the same columns in all rows, or nothing.
    pub covariates: Covariates,
    /// The page that it opens, seen from the folder of the cohort; `None` for the one in the folder of its name.
    pub page: Option<String>,
    /// What came out, by column, or why nothing did.
    pub figures: Result<Figures, String>,
}

/// What a cohort is made with.
#[derive(Debug, Clone)]
pub struct About<'a> {
    /// The subcommand.
    pub command: &'static str,
    /// The command line that repeats it.
    pub line: String,
    /// Every option that changes a result.
    pub parameters: &'a Value,
}

impl Row {
    fn status(&self) -> &'static str {
        if self.figures.is_ok() { "ok" } else { "failed" }
    }

    fn error(&self) -> &str {
        self.figures.as_ref().err().map_or("", String::as_str)
    }

    fn cell(&self, column: &str) -> Option<&Value> {
        self.figures.as_ref().ok()?.iter().find(|(name, _)| *name == column).map(|(_, cell)| cell)
    }

    fn number(&self, column: &str) -> f64 {
        self.cell(column).and_then(Value::as_f64).unwrap_or(f64::NAN)
    }

    /// The row as an object.
    pub fn record(&self) -> Value {
        let mut fields = Map::new();
        fields.insert("subject".into(), json!(self.subject));
        fields.insert("input".into(), json!(self.input));
        fields.insert("sha256".into(), json!(self.sha256));
        fields.insert("status".into(), json!(self.status()));
        fields.insert("error".into(), json!(self.error()));
        fields.extend(self.covariates.iter().map(|(name, text)| (covariate(name), json!(text))));
        fields.extend(self.figures.iter().flatten().map(|(name, cell)| (name.clone().into_owned(), cell.clone())));
        fields.into()
    }
}

/// The column of a covariate. Names that the table has for its own columns stay with those.
fn covariate(name: &str) -> String {
    if describe(name).is_some() || name == "subject" { format!("given_{name}") } else { name.to_owned() }
}

/// The columns of cohort.csv: those of every cohort, then covariates, then the figures in the order in which rows have them first.
pub fn cohort_columns(rows: &[Row]) -> Vec<Column> {
    let text = |name, of: fn(&Row) -> &str| Column::text(name, rows.iter().map(|row| of(row).to_owned()));
    let mut columns = vec![
        text("subject", |row| &row.subject),
        text("input", |row| &row.input),
        text("sha256", |row| &row.sha256),
        text("status", Row::status),
        text("error", Row::error),
    ];
    let stated = rows.iter().map(|row| &row.covariates).max_by_key(|stated| stated.len());
    for (at, (name, _)) in stated.into_iter().flatten().enumerate() {
        let text = |row: &Row| row.covariates.get(at).map_or_else(String::new, |(_, text)| text.clone());
        columns.push(Column::text(covariate(name), rows.iter().map(text)));
    }
    for (name, _) in rows.iter().flat_map(|row| row.figures.iter().flatten()) {
        if columns.iter().any(|column| column.name == *name) {
            continue;
        }
        columns.push(if rows.iter().any(|row| row.cell(name).is_some_and(Value::is_string)) {
            let word = |row: &Row| row.cell(name).and_then(Value::as_str).unwrap_or_default().to_owned();
            Column::text(name.clone(), rows.iter().map(word))
        } else {
            Column::real(name.clone(), rows.iter().map(|row| row.number(name)))
        });
    }
    columns
}

/// How uncertain a subject is: by the probability that its variant is another; without a variant by the errors expected of it, or its
/// undecided connections where there is no evidence. One that failed is the most uncertain.
pub fn uncertainty(row: &Row) -> f64 {
    if row.figures.is_err() {
        return f64::INFINITY;
    }
    let variant = row.number("p_variant");
    if !variant.is_nan() {
        return 1.0 - variant;
    }
    let expected = row.number("expected_wrong") + row.number("expected_missed");
    let figure = if expected.is_nan() { row.number("undecided") } else { expected };
    if figure.is_nan() { 0.0 } else { figure }
}

/// Writes the table and the page into the folder of a cohort, in place of earlier ones.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_cohort(folder: &Path, rows: &[Row], about: &About<'_>) -> Result<()> {
    let [table, page] = [COHORT_TABLE, COHORT_PAGE].map(|name| StagedFile::new(&folder.join(name), true));
    let (table, page) = (table?, page?);
    write_file(&table.path(), |out| write_csv(out, &cohort_columns(rows)))?;
    let mut first: Vec<Row> = rows.to_vec();
    first.sort_by(|a, b| uncertainty(b).total_cmp(&uncertainty(a)));
    write_file(&page.path(), |out| write_cohort_page(out, &first, cohort_columns(&first), about, folder))?;
    table.commit()?;
    page.commit()
}

/// What came out of a subject, by column: text, or a number, which is null where it is missing.
pub type Figures = Vec<(Cow<'static, str>, Value)>;

fn number(value: &Value) -> Value {
    json!(value.as_f64())
}

fn flag(value: &Value) -> Value {
    json!(value.as_bool().map(|there| f64::from(u8::from(there))))
}

fn text(value: &Value) -> Value {
    json!(value.as_str().unwrap_or_default())
}

/// A variant below this probability needs a person.
const SURE_VARIANT: f64 = 0.9;
/// A connection is open between this share of the plausible topologies and the rest.
const OPEN: std::ops::Range<f64> = 0.1..0.9;

/// Why a subject needs a person; empty where it does not. Where arteries are known, that is what could change the variant: it is not sure, or
/// one open connection would make another one likelier than not. Where they are not, it is any undecided connection, or an error that the
/// evidence expects.
pub fn needs_person(record: &Value) -> String {
    let mut why = Vec::new();
    let number = |pointer: &str| record.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
    if record["phenotype"].is_object() {
        let p = number("/phenotype/probabilities/variant");
        if p < SURE_VARIANT {
            why.push(format!("variant uncertain, P = {p:.3}"));
        }
        let deciding = record.pointer("/phenotype/probabilities/deciding").and_then(Value::as_array);
        let changes = |d: &&Value| {
            let of = |key: &str| d[key].as_f64().unwrap_or(f64::NAN);
            OPEN.contains(&of("share")) && of("variant_with").min(of("variant_without")) < 0.5
        };
        let changing = deciding.into_iter().flatten().filter(changes).count();
        if changing > 0 {
            why.push(format!("{} would change the variant", plural(changing, "open connection")));
        }
        return why.join("; ");
    }
    let undecided = number("/convergence/undecided");
    if undecided > 0.0 {
        why.push(format!("{undecided} undecided"));
    }
    let (wrong, missed) = (number("/expected_errors/wrong"), number("/expected_errors/missed"));
    if wrong + missed >= 1.0 {
        why.push(format!("about {wrong:.1} wrong and {missed:.1} missed expected"));
    }
    why.join("; ")
}

/// The figures of an inference. `kept`, `components` and `cycles` are those of the kept topology; `sparsity` is the share of kept
/// candidates among all; wrong and missed connections are those that the evidence expects.
pub fn infer_figures(record: &Value) -> Figures {
    let number = |pointer: &str| record.pointer(pointer).and_then(Value::as_f64).unwrap_or(f64::NAN);
    let (kept, candidates) = (number("/counts/topology/kept_candidates"), number("/counts/candidates"));
    let figures = [
        ("nodes", number("/counts/nodes")),
        ("observed", number("/counts/observed")),
        ("candidates", candidates),
        ("kept", kept),
        ("undecided", number("/convergence/undecided")),
        ("components", number("/counts/topology/components")),
        ("cycles", number("/counts/topology/cycles")),
        ("sparsity", if candidates > 0.0 { kept / candidates } else { f64::NAN }),
        ("rho_G_W_per_m3", number("/rho_G_W_per_m3")),
        ("expected_wrong", number("/expected_errors/wrong")),
        ("expected_missed", number("/expected_errors/missed")),
        (WALL_TIME, number("/time/wall_s")),
    ];
    let mut all = phenotype_figures(record);
    if all.is_empty() {
        all.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    }
    all.extend(figures.map(|(name, x)| (name.into(), json!(x))));
    all
}

/// The figures of a Circle of Willis; none where it was not classified. `margin` is the probability of the variant less that of the
/// next.
pub fn phenotype_figures(record: &Value) -> Figures {
    let Some(phenotype) = record.get("phenotype").filter(|p| p.is_object()) else { return Vec::new() };
    let segments = || RING.map(|artery| artery.to_string());
    let mut figures: Figures =
        ["variant", "completeness"].map(|name| (name.into(), text(&phenotype[name]))).into_iter().collect();
    figures.extend(segments().map(|segment| (segment.clone().into(), flag(&phenotype["segments"][segment]))));
    figures.extend(["L-PCA", "R-PCA"].map(|side| (format!("fetal_{side}").into(), flag(&phenotype["fetal"][side]))));
    figures.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    let thin: Vec<&str> = phenotype["hypoplastic"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    figures.push(("hypoplastic".into(), json!(thin.join(" "))));
    if let Some(probabilities) = phenotype.get("probabilities") {
        let of_variant = [("p_variant", "variant"), ("margin", "margin")];
        figures.extend(of_variant.map(|(name, key)| (name.into(), number(&probabilities[key]))));
        let of_segment = |segment| (format!("p_{segment}").into(), number(&probabilities["segments"][segment]));
        figures.extend(segments().map(of_segment));
    }
    for feeder in FEEDERS.map(|artery| artery.to_string()) {
        let Some(collateral) = record["collateral"].get(&feeder) else { continue };
        figures.push((format!("takes_over_{feeder}").into(), text(&collateral["takes_over"])));
        for territory in TERRITORIES.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_without_{feeder}").into(), number(&collateral["residual"][territory])));
        }
    }
    for territory in TERRITORIES.map(|artery| artery.to_string()) {
        let Some(supply) = record["supply"].get(&territory) else { continue };
        for feeder in FEEDERS.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_from_{feeder}").into(), number(&supply["shares"][&feeder]["mean"])));
        }
        figures.push((format!("{territory}_arrival_ms").into(), number(&supply["arrival_ms"]["median"])));
    }
    figures
}
