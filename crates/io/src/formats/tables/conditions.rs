//! Boundary conditions from a file, CSV or TOML; and one period of a pressure or a flow: a table with `time_s` and `pressure_mmHg` or `flow_mL_per_min`, or
//! an inlet file of openBF.

use serde::Deserialize;

use super::reader::{TableReader, columns, uncommented};
use crate::formats::{ensure, input::without_mark};
use willis_core::error::{Fault, Place, in_few_digits};
use willis_core::network::units::{cubic_metres_per_second, pascals};
use willis_core::network::waveform::{Quantity, Waveform};
use willis_core::network::{Condition, Role, quantity::Dimension};
use willis_core::{support::suggestions::did_you_mean, support::toml_text::parse};

/// The column of the pressure behind a terminal resistance.
pub(crate) const VENOUS: &str = "venous_pressure_mmHg";
const ACCEPTED: &str = "expected inlet, ground, pressure, resistance or flow";
const NO_SINGLE_NODE: &str = "no single node";
const ONE_NODE: &str = "expected one of node, label, or a position in mm";
const KINDS: [&str; 5] = ["inlet", "ground", "pressure", "resistance", "flow"];

/// A condition as stated, before its node is looked up.
#[derive(Debug, Clone, PartialEq)]
pub struct Statement {
    /// Its place in the file.
    pub place: Place,
    /// Node id, label, or `x,y,z` in mm.
    pub spec: String,
    /// Inlet or outlet.
    pub role: Role,
    /// What holds there.
    pub condition: Condition,
}

impl Statement {
    /// The error that this condition cannot hold, at its place in the file.
    pub fn fault(&self, why: impl Into<String>) -> Fault {
        fault(&self.place, format!("\"{}\"", self.spec), why)
    }
}

fn fault(place: &Place, found: impl Into<String>, accepted: impl Into<String>) -> Fault {
    Fault { place: place.clone(), ..Fault::file(found, accepted) }
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    node: Option<Text>,
    label: Option<String>,
    at: Option<[f64; 3]>,
    kind: Option<String>,
    value: Option<f64>,
    unit: Option<String>,
    /// Of a resistance.
    #[serde(rename = "venous_pressure_mmHg")]
    venous_pressure_mmhg: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum Text {
    Word(String),
    Number(i64),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ConditionsFile {
    condition: Vec<Entry>,
}

/// Reads TOML: `[[condition]]` tables with `node`, `label` or `at = [x, y, z]` (mm), `kind`, `value`, `unit`,
/// `venous_pressure_mmHg`.
///
/// # Errors
///
/// The line or the number of the condition, and what is accepted.
pub fn read_toml(bytes: &[u8]) -> Result<Vec<Statement>, Fault> {
    const ACCEPTED: &str = "expected [[condition]] tables with node, label or at, kind, value, unit, venous_pressure_mmHg";
    let text = std::str::from_utf8(without_mark(bytes)).map_err(|_| Fault::file("the text is not UTF-8", "expected UTF-8"))?;
    let file: ConditionsFile = parse(text, ACCEPTED)?;
    let place = |n: usize| Place::Item(format!("condition {}", n + 1));
    file.condition.into_iter().enumerate().map(|(n, entry)| statement(entry, place(n))).collect()
}

/// Reads a table with the columns `node`, or `label`, or `x_mm,y_mm,z_mm`, then `kind`, and where they are needed `value`, `unit`
/// and, behind a resistance, `venous_pressure_mmHg`. Lines of comments begin with `#`.
///
/// # Errors
///
/// The line, its value and what is accepted.
pub fn read_csv(bytes: &[u8]) -> Result<Vec<Statement>, Fault> {
    read_table(bytes, None)
}

/// Reads a table of inlets, with the columns of [`read_csv`]; `kind` may be left out.
///
/// # Errors
///
/// As [`read_csv`].
pub fn read_inlets(bytes: &[u8]) -> Result<Vec<Statement>, Fault> {
    let all = read_table(bytes, Some("inlet"))?;
    Ok(all.into_iter().filter(|statement| statement.role == Role::Inlet).collect())
}

/// Reads a table in which a row without a kind has the `usual` one.
fn read_table(bytes: &[u8], usual: Option<&str>) -> Result<Vec<Statement>, Fault> {
    const COLUMNS: [&str; 9] = ["node", "label", "x_mm", "y_mm", "z_mm", "kind", "value", "unit", VENOUS];
    let text = uncommented(bytes);
    let mut rows = TableReader::open(&text)?;
    let wrong = |found: String| Fault::line(rows.header_line, found, format!("expected the columns {}", COLUMNS.join(",")));
    if let Some(other) = rows.header.iter().find(|name| !COLUMNS.iter().any(|known| known.eq_ignore_ascii_case(name))) {
        return Err(wrong(format!("column \"{other}\"")));
    }
    let [node, label, x, y, z, kind, value, unit, venous] = COLUMNS.map(|name| rows.find(&[name]));
    ensure(kind.is_some() || usual.is_some(), || wrong(format!("no column kind in {}", columns(&rows.header))))?;
    let mut out = Vec::new();
    while let Some(row) = rows.row()? {
        let stated = |column: Option<usize>| column.filter(|column| !row.text(*column).is_empty());
        let text = |column: Option<usize>| stated(column).map(|column| row.text(column).to_owned());
        let number = |column: Option<usize>| stated(column).map(|column| row.finite(column)).transpose();
        let at = match [x, y, z].map(stated) {
            [Some(x), Some(y), Some(z)] => Some([x, y, z]),
            [None, None, None] => None,
            _ => return Err(Fault::line(row.line, NO_SINGLE_NODE, ONE_NODE)),
        };
        let entry = Entry {
            node: text(node).map(Text::Word),
            label: text(label),
            at: at.map(|at| row.position(at)).transpose()?,
            kind: text(kind).or(usual.map(str::to_owned)),
            value: number(value)?,
            unit: text(unit),
            venous_pressure_mmhg: number(venous)?,
        };
        out.push(statement(entry, Place::Line(row.line))?);
    }
    Ok(out)
}

fn statement(entry: Entry, place: Place) -> Result<Statement, Fault> {
    let spec = match (entry.node, entry.label, entry.at) {
        (Some(Text::Word(node)), None, None) => node,
        (Some(Text::Number(node)), None, None) => node.to_string(),
        (None, Some(label), None) => label,
        (None, None, Some([x, y, z])) => format!("{x},{y},{z}"),
        _ => return Err(fault(&place, NO_SINGLE_NODE, ONE_NODE)),
    };
    let kind = entry.kind.ok_or_else(|| fault(&place, "no kind", ACCEPTED))?;
    let figure = |dimension: Dimension| {
        let value = entry.value.ok_or_else(|| fault(&place, format!("{kind} without a value"), dimension.accepted()))?;
        let unit = entry.unit.as_deref().unwrap_or_default();
        let found = || format!("{kind} value {}{unit}", in_few_digits(value.to_string()));
        dimension.convert(value, unit).map_err(|accepted| fault(&place, found(), accepted))
    };
    let (role, condition) = match kind.as_str() {
        "inlet" if entry.value.is_none() => (Role::Inlet, Condition::INLET),
        "inlet" => (Role::Inlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "ground" => (Role::Outlet, Condition::GROUND),
        "pressure" => (Role::Outlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "resistance" => {
            let (resistance, venous) = (figure(Dimension::Resistance)?, pascals(entry.venous_pressure_mmhg.unwrap_or(0.0)));
            let accepted = "expected a positive resistance, and a finite venous pressure";
            let is_right = resistance > 0.0 && venous.is_finite();
            ensure(is_right, || fault(&place, format!("resistance {resistance}"), accepted))?;
            (Role::Outlet, Condition::Resistance { resistance, venous })
        }
        "flow" => {
            let flow = figure(Dimension::Flow)?;
            (Role::of_flow(flow), Condition::Flow(flow))
        }
        other => return Err(fault(&place, format!("kind \"{other}\""), did_you_mean(other, KINDS) + ACCEPTED)),
    };
    // What is stated holds, or is refused.
    let is_stated = |figure: Option<f64>| figure.is_some_and(|x| x != 0.0);
    let wrong = || fault(&place, "ground with a value", "expected none, or the kind pressure");
    ensure(kind != "ground" || !is_stated(entry.value), wrong)?;
    let wrong = || fault(&place, format!("{kind} with a {VENOUS}"), "expected it with a resistance alone");
    ensure(kind == "resistance" || !is_stated(entry.venous_pressure_mmhg), wrong)?;
    Ok(Statement { place, spec, role, condition })
}

const PRESSURE: &str = "pressure_mmHg";
const FLOW: &str = "flow_mL_per_min";

/// The line, the time and the value of a row, in SI units.
type TimedValue = (usize, f64, f64);

/// Reads a waveform, and what a person should know about it; other columns are left alone. Times that fall by no more than a mean step
/// between rows are put in order.
///
/// # Errors
///
/// No column of times; both a pressure and a flow, or neither; fewer than two rows; a time that falls by more; a number that is not finite.
pub fn read_waveform(bytes: &[u8]) -> Result<(Waveform, Option<String>), Fault> {
    inlet_of_openbf(bytes).map_or_else(|| read_period(bytes), |(quantity, rows)| in_order(quantity, rows))
}

/// The rows of an inlet file of openBF, which has no header: a time and a flow in m³/s, or a pressure in Pa. No heart gives 1 m³/s, and
/// no pressure stays below 1 Pa.
fn inlet_of_openbf(bytes: &[u8]) -> Option<(Quantity, Vec<TimedValue>)> {
    let mut rows = Vec::new();
    for (row, line) in std::str::from_utf8(bytes).ok()?.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        let numbers: Option<Vec<f64>> =
            line.split_whitespace().map(|word| word.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let [t, x] = numbers?[..] else { return None };
        rows.push((row + 1, t, x));
    }
    let is_flow = rows.iter().all(|(_, _, x)| x.abs() < 1.0);
    (!rows.is_empty()).then_some((if is_flow { Quantity::Flow } else { Quantity::Pressure }, rows))
}

fn read_period(bytes: &[u8]) -> Result<(Waveform, Option<String>), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let time = rows.column(&["time_s"], "the time of each row")?;
    let (quantity, column) = match (rows.find(&[PRESSURE]), rows.find(&[FLOW])) {
        (Some(_), Some(_)) => {
            let found = format!("both {PRESSURE} and {FLOW}");
            return Err(Fault::line(rows.header_line, found, "expected one of them: an inlet has a pressure or a flow"));
        }
        (Some(column), None) => (Quantity::Pressure, column),
        (None, Some(column)) => (Quantity::Flow, column),
        (None, None) => {
            let accepted = format!("expected a column {PRESSURE} or {FLOW}");
            return Err(Fault::line(rows.header_line, columns(&rows.header), accepted));
        }
    };
    let mut read = Vec::new();
    while let Some(row) = rows.row()? {
        let (t, x) = (row.finite(time)?, row.finite(column)?);
        let value = if quantity == Quantity::Pressure { pascals(x) } else { cubic_metres_per_second(x) };
        read.push((row.line, t, value));
    }
    in_order(quantity, read)
}

/// The waveform of rows whose times may fall a little.
fn in_order(quantity: Quantity, mut read: Vec<TimedValue>) -> Result<(Waveform, Option<String>), Fault> {
    let step = if let [(_, first, _), .., (_, last, _)] = read[..] { (last - first) / (read.len() - 1) as f64 } else { 0.0 };
    let falls: Vec<&[TimedValue]> = read.windows(2).filter(|pair| pair[1].1 < pair[0].1).collect();
    if let Some([(_, before, _), (line, t, _)]) = falls.iter().copied().find(|pair| pair[0].1 - pair[1].1 > step) {
        let [t, before] = [t, before].map(|t| in_few_digits(t.to_string()));
        return Err(Fault::line(*line, format!("time_s {t} after {before}"), "expected times that never fall"));
    }
    let note = falls.first().map(|pair| {
        let by = falls.iter().map(|pair| pair[0].1 - pair[1].1).fold(0.0, f64::max);
        format!("line {}: times that fall, by {by:.2e} s at most, are put in order", pair[1].0)
    });
    read.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (times, values): (Vec<f64>, Vec<f64>) = read.into_iter().map(|(_, t, value)| (t, value)).unzip();
    if times.len() < 2 || times[0] == times[times.len() - 1] {
        let found = match times.len() {
            0 => "no row".to_owned(),
            1 => "one row".to_owned(),
            rows => format!("{rows} rows at one time"),
        };
        return Err(Fault::file(found, "expected two or more rows over one period"));
    }
    Ok((Waveform { quantity, times, values }, note))
}
