//! Boundary conditions from a file: CSV or TOML.

use serde::Deserialize;

use super::reader::{TableReader, columns, uncommented};
use crate::formats::input::without_mark;
use willis_core::error::{Fault, Place};
use willis_core::network::{Condition, Role, quantity::Dimension, units::pascals};
use willis_core::{support::suggestions::did_you_mean, support::toml_text::parse};

/// The column of the pressure behind a terminal resistance.
pub(crate) const VENOUS: &str = "venous_pressure_mmHg";
const ACCEPTED: &str = "expected inlet, ground, pressure, resistance or flow";
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
    if kind.is_none() && usual.is_none() {
        return Err(wrong(format!("no column kind in {}", columns(&rows.header))));
    }
    let mut out = Vec::new();
    while let Some(row) = rows.row()? {
        let stated = |column: Option<usize>| column.filter(|column| !row.text(*column).is_empty());
        let text = |column: Option<usize>| stated(column).map(|column| row.text(column).to_owned());
        let number = |column: Option<usize>| stated(column).map(|column| row.finite(column)).transpose();
        let at = if let (Some(x), Some(y), Some(z)) = (stated(x), stated(y), stated(z)) { Some([x, y, z]) } else { None };
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
        _ => return Err(fault(&place, "no single node", "expected one of node, label, or a position in mm")),
    };
    let kind = entry.kind.ok_or_else(|| fault(&place, "no kind", ACCEPTED))?;
    let figure = |dimension: Dimension| {
        let value = entry.value.ok_or_else(|| fault(&place, format!("{kind} without a value"), dimension.accepted()))?;
        let unit = entry.unit.as_deref().unwrap_or_default();
        dimension.convert(value, unit).map_err(|accepted| fault(&place, format!("{kind} value {value}{unit}"), accepted))
    };
    let (role, condition) = match kind.as_str() {
        "inlet" if entry.value.is_none() => (Role::Inlet, Condition::INLET),
        "inlet" => (Role::Inlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "ground" => (Role::Outlet, Condition::GROUND),
        "pressure" => (Role::Outlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "resistance" => {
            let (resistance, venous) = (figure(Dimension::Resistance)?, pascals(entry.venous_pressure_mmhg.unwrap_or(0.0)));
            if !(resistance > 0.0 && venous.is_finite()) {
                let accepted = "expected a positive resistance, and a finite venous pressure";
                return Err(fault(&place, format!("resistance {resistance}"), accepted));
            }
            (Role::Outlet, Condition::Resistance { resistance, venous })
        }
        "flow" => {
            let flow = figure(Dimension::Flow)?;
            (Role::of_flow(flow), Condition::Flow(flow))
        }
        other => return Err(fault(&place, format!("kind \"{other}\""), did_you_mean(other, KINDS) + ACCEPTED)),
    };
    Ok(Statement { place, spec, role, condition })
}
