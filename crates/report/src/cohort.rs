//! The tables of many subjects, one row each, and their page: cohort.csv, cohort.html, and the same table as BIDS has it.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use serde_json::{Map, Value, json};

use crate::figures::{FRONT, units};
use crate::page::{PageKind, PageTable, column_of, write_page};
use willis_core::error::Result;
use willis_io::formats::tables::reader::plural;
use willis_io::formats::{Column, Covariates, Values, escape_formula, write_csv};
use willis_io::output::names::{COHORT_PAGE, COHORT_TABLE, PAGE, SUMMARY_PICTURE};
use willis_io::output::{StagedFiles, final_path, plain, write_file};
use willis_models::circle_of_willis::{Artery, FEEDERS, RING, TERRITORIES};

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

/// A column that every cohort has, and its text of a row.
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
    let mut columns = OF_EVERY_ROW.map(|(name, of)| Column::text(name, rows.iter().map(of))).to_vec();
    for (at, name) in covariate_names(rows).into_iter().enumerate() {
        let text = |row: &CohortRow| row.covariates.get(at).map_or_else(String::new, |(_, text)| text.clone());
        columns.push(Column::text(name, rows.iter().map(text)));
    }
    for (name, _) in rows.iter().flat_map(|row| row.figures.iter().flatten()) {
        if columns.iter().all(|column| column.name != *name) {
            columns.push(column_of(name.clone(), rows.iter().map(|row| row.cell(name).unwrap_or(&Value::Null))));
        }
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

/// The columns in their order: the name, in which a word in braces stands for arteries of a kind; by the name of a command the place of the figure in
/// its record, and of what it is divided by; and what BIDS says of a column.
static COLUMNS: LazyLock<Vec<Map<String, Value>>> = LazyLock::new(|| read(include_str!("cohort_columns.json")));

fn read<T: serde::de::DeserializeOwned>(text: &str) -> T {
    serde_json::from_str(text).expect("the columns are part of the program, with names of arteries in them")
}

/// The figures that the record of a command states, by column; null where one is missing.
pub(super) fn stated(command: &str, record: &Value) -> impl Iterator<Item = (Cow<'static, str>, Value)> {
    let number = |pointer: &Value| record.pointer(pointer.as_str()?)?.as_f64();
    COLUMNS.iter().filter_map(move |column| {
        let mut figure = number(column.get(command)?);
        if let Some(all) = column.get("over") {
            figure = figure.zip(number(all)).filter(|(_, all)| *all > 0.0).map(|(part, all)| part / all);
        }
        Some((column["column"].as_str()?.into(), json!(figure)))
    })
}

/// What a column is; `None` for one that is not known.
pub fn describe(column: &str) -> Option<Value> {
    static KNOWN: LazyLock<HashMap<String, Value>> = LazyLock::new(known);
    KNOWN.get(column).cloned()
}

/// Each column and what it is.
fn known() -> HashMap<String, Value> {
    let names = |arteries: &[Artery]| arteries.iter().map(ToString::to_string).collect::<Vec<String>>();
    let pairs = names(&RING).iter().filter_map(|name| name.strip_prefix("L-").map(str::to_owned)).collect();
    let kinds =
        [("{segment}", names(&RING)), ("{pair}", pairs), ("{feeder}", names(&FEEDERS)), ("{territory}", names(&TERRITORIES))];
    let about = |column: &Map<String, Value>| {
        let mut about = column.clone();
        about.retain(|key, _| key.starts_with(char::is_uppercase));
        Some((column["column"].as_str()?.to_owned(), json!(about).to_string()))
    };
    let mut all: HashMap<String, String> = COLUMNS.iter().filter_map(about).collect();
    for (kind, arteries) in &kinds {
        // A column of another kind stays as it is with each of them.
        let of = |(name, about): (String, String)| arteries.iter().map(move |a| (name.replace(kind, a), about.replace(kind, a)));
        all = all.into_iter().flat_map(of).collect();
    }
    all.into_iter().map(|(name, about)| (name, read(&about))).collect()
}

/// The one column that differs between two runs of one command, from run.json, in seconds.
pub const WALL_TIME: &str = "wall_s";

/// The column that says why a subject needs a person.
const NEEDS_PERSON: &str = "needs_person";

/// What came out of a subject, by column: text, or a number, which is null where it is missing.
pub type Figures = Vec<(Cow<'static, str>, Value)>;

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
    let mut all = phenotype_figures(record);
    if all.is_empty() {
        all.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    }
    all.extend(stated("infer", record));
    all
}

/// The figures of a naming: counts, and the probability that each segment of the circle is there. `doubtful` landmarks are those that a person
/// should look at.
pub fn label_figures(record: &Value) -> Figures {
    let doubtful = record.pointer("/counts/doubtful").and_then(Value::as_u64).unwrap_or_default();
    let why = if doubtful > 0 { format!("{} uncertain", plural(doubtful as usize, "landmark")) } else { String::new() };
    let mut figures: Figures =
        vec![(NEEDS_PERSON.into(), json!(why)), ("frame".into(), json!(record["frame"].as_str().unwrap_or_default()))];
    figures.extend(stated("label", record));
    figures.extend(RING.map(|artery| (format!("p_{artery}").into(), json!(record["segments"][artery.to_string()].as_f64()))));
    figures
}

/// The figures of a Circle of Willis; none where it was not classified. `margin` is the probability of the variant less that of the
/// next.
pub fn phenotype_figures(record: &Value) -> Figures {
    let Some(phenotype) = record.get("phenotype").filter(|p| p.is_object()) else { return Vec::new() };
    let segments = || RING.map(|artery| artery.to_string());
    let text = |value: &Value| json!(value.as_str().unwrap_or_default());
    let flag = |value: &Value| json!(value.as_bool().map(|there| f64::from(u8::from(there))));
    let mut figures = Figures::from(["variant", "completeness"].map(|name| (name.into(), text(&phenotype[name]))));
    figures.extend(segments().map(|segment| (segment.clone().into(), flag(&phenotype["segments"][segment]))));
    figures.push((NEEDS_PERSON.into(), json!(needs_person(record))));
    let thin: Vec<&str> = phenotype["hypoplastic"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    figures.push(("hypoplastic".into(), json!(thin.join(" "))));
    if let Some(probabilities) = phenotype.get("probabilities") {
        figures.extend(stated("circle", probabilities));
        let of_segment = |segment| (format!("p_{segment}").into(), json!(probabilities["segments"][segment].as_f64()));
        figures.extend(segments().map(of_segment));
    }
    figures
        .extend(crate::phenotype::CircleFigures::in_phenotype(phenotype).columns().into_iter().map(|(name, x)| (name, json!(x))));
    for feeder in FEEDERS.map(|artery| artery.to_string()) {
        let Some(collateral) = record["collateral"].get(&feeder) else { continue };
        figures.push((format!("takes_over_{feeder}").into(), text(&collateral["takes_over"])));
        for territory in TERRITORIES.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_without_{feeder}").into(), json!(collateral["residual"][territory].as_f64())));
        }
    }
    for territory in TERRITORIES.map(|artery| artery.to_string()) {
        let Some(supply) = record["supply"].get(&territory) else { continue };
        for feeder in FEEDERS.map(|artery| artery.to_string()) {
            figures.push((format!("{territory}_from_{feeder}").into(), json!(supply["shares"][&feeder]["mean"].as_f64())));
        }
        figures.push((format!("{territory}_arrival_ms").into(), json!(supply["arrival_ms"]["median"].as_f64())));
    }
    figures
}

const COHORT: PageKind = ["subjects", include_str!("page/assets/cohort.html"), "dom data table distribution zip walk cohort"];
/// The columns that the page leaves out: what differs between two runs of one command, and what nobody reads.
const LEFT_OUT: [&str; 2] = [WALL_TIME, "sha256"];

/// Writes the table and the page, in which the most uncertain come first, into the folder of a cohort of a subcommand, in place of earlier ones;
/// `line` repeats it, and `parameters` are the options that change a result.
///
/// # Errors
///
/// A file that cannot be written.
pub fn write_cohort(folder: &Path, rows: &[CohortRow], command: &str, line: &str, parameters: &Value) -> Result<()> {
    let [table, page] = [COHORT_TABLE, COHORT_PAGE].map(|name| StagedFiles::new(&folder.join(name), true));
    let (table, page) = (table?, page?);
    write_file(&table.path(), |out| write_csv(out, &cohort_columns(rows)))?;
    let mut rows: Vec<CohortRow> = rows.to_vec();
    rows.sort_by(|a, b| uncertainty(b).total_cmp(&uncertainty(a)));
    let columns = cohort_columns(&rows).into_iter().filter(|column| !LEFT_OUT.contains(&&*column.name)).collect();
    let mut data = json!({
        "command": line,
        "willis": env!("CARGO_PKG_VERSION"),
        "parameters": parameters,
        "failed": rows.iter().filter(|row| row.figures.is_err()).count(),
        "walks": command != "classify" && command != "label",
        "opens": PAGE,
        "thumbnail": FRONT.map(units),
        "table": PageTable::new("Subjects", columns, false),
    });
    if rows.iter().any(|row| row.page.is_some()) {
        data["pages"] = rows.iter().map(|row| row.page.as_deref()).collect();
    }
    data["pictures"] = rows.iter().map(|row| picture(row, folder)).collect();
    let title = format!("willis {command}: {}", plural(rows.len(), "subject"));
    write_file(&page.path(), |out| write_page(out, &title, COHORT, &data))?;
    table.commit()?;
    page.commit().map(drop)
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

/// The columns of a table of runs: `names` are the participant and the session of each row, and stand for its subject.
pub fn bids_columns(rows: &[CohortRow], names: &[(String, Option<String>)]) -> Vec<Column> {
    let mut columns = vec![Column::text("participant_id", names.iter().map(|(participant, _)| participant.clone()))];
    if names.iter().any(|(_, session)| session.is_some()) {
        columns.push(Column::text("session_id", names.iter().map(|(_, session)| session.clone().unwrap_or_default())));
    }
    columns.extend(cohort_columns(rows).into_iter().filter(|column| column.name != "subject"));
    columns
}

/// Writes columns as BIDS has them: tabs between cells, which hold none, no quotes, and n/a where a value is missing.
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
            if text.is_empty() { "n/a".into() } else { text.into() }
        };
        line(columns.iter().map(cell).collect())?;
    }
    Ok(())
}

/// The sidecar of a table: what the table is, and what each of its columns is.
pub fn sidecar(columns: &[Column]) -> Value {
    let about =
        "The connections between the vessels of each scan, and the variant of the Circle of Willis, as willis inferred them.";
    let tool = json!({ "Description": format!("willis {}", env!("CARGO_PKG_VERSION")) });
    let mut fields = json!({ "Description": about, "MeasurementToolMetadata": tool });
    for column in columns {
        let covariate = || json!({ "Description": "What participants.tsv says of the participant." });
        fields[&*column.name] = describe(&column.name).unwrap_or_else(covariate);
    }
    fields
}
