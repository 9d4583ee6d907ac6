//! Boundary conditions from a file: CSV or TOML.

use serde::Deserialize;

use crate::error::Fault;
use crate::network::{Condition, Role};
use crate::quantity::Dimension;
use crate::suggestion::did_you_mean;
use crate::units::pascals;

/// The column of the pressure behind a terminal resistance.
const VENOUS: &str = "venous_pressure_mmHg";

/// A condition as stated, before its node is looked up.
#[derive(Debug, Clone, PartialEq)]
pub struct Statement {
    /// Where in the file: `line 3`, `condition 2`.
    pub place: String,
    /// Node id, label, or `x,y,z` in mm.
    pub spec: String,
    /// Inlet or outlet.
    pub role: Role,
    /// What holds there.
    pub condition: Condition,
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
struct File {
    condition: Vec<Entry>,
}

/// Reads TOML: `[[condition]]` tables with `node`, `label` or `at = [x, y, z]` (mm), `kind`, `value`, `unit`,
/// `venous_pressure_mmHg`.
///
/// # Errors
///
/// The line or the number of the condition, and what is accepted.
pub fn read_toml(text: &str) -> Result<Vec<Statement>, Fault> {
    let file: File = toml::from_str(text).map_err(|e| {
        let line = e.span().map_or(1, |s| text[..s.start.min(text.len())].lines().count().max(1));
        Fault::line(
            line,
            e.message().replace('\n', " "),
            "expected [[condition]] tables with node, label or at, kind, value, unit, venous_pressure_mmHg",
        )
    })?;
    file.condition.into_iter().enumerate().map(|(i, e)| statement(e, &format!("condition {}", i + 1))).collect()
}

/// Reads CSV with the columns `node`, or `label`, or `x_mm,y_mm,z_mm`, then optionally `kind,value,unit`,
/// and `venous_pressure_mmHg` behind a resistance.
///
/// # Errors
///
/// The line, its value and what is accepted.
pub fn read_csv(text: &str) -> Result<Vec<Statement>, Fault> {
    const COLUMNS: [&str; 9] = ["node", "label", "x_mm", "y_mm", "z_mm", "kind", "value", "unit", VENOUS];
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let bad = |line: usize, found: String| Fault::line(line, found, format!("expected the columns {}", COLUMNS.join(",")));
    let header = reader.headers().map_err(|e| bad(1, e.to_string()))?.clone();
    if let Some(other) = header.iter().find(|name| !COLUMNS.contains(name)) {
        return Err(bad(1, format!("column \"{other}\"")));
    }
    let mut out = Vec::new();
    for record in reader.records() {
        let record = record
            .map_err(|e| bad(e.position().map_or(1, |p| p.line() as usize), "a row of another length than the header".into()))?;
        let line = record.position().map_or(0, |p| p.line() as usize);
        let field = |name: &str| header.iter().position(|h| h == name).and_then(|i| record.get(i)).filter(|v| !v.is_empty());
        let number = |name: &str| match field(name) {
            None => Ok(None),
            Some(v) => v.parse::<f64>().map(Some).map_err(|_| Fault::line(line, format!("{name} \"{v}\""), "expected a number")),
        };
        let at = [number("x_mm")?, number("y_mm")?, number("z_mm")?];
        let entry = Entry {
            node: field("node").map(|v| Text::Word(v.to_owned())),
            label: field("label").map(str::to_owned),
            at: if let [Some(x), Some(y), Some(z)] = at { Some([x, y, z]) } else { None },
            kind: field("kind").map(str::to_owned),
            value: number("value")?,
            unit: field("unit").map(str::to_owned),
            venous_pressure_mmhg: number(VENOUS)?,
        };
        out.push(statement(entry, &format!("line {line}"))?);
    }
    Ok(out)
}

fn statement(entry: Entry, place: &str) -> Result<Statement, Fault> {
    let spec = match (entry.node, entry.label, entry.at) {
        (Some(Text::Word(node)), None, None) => node,
        (Some(Text::Number(node)), None, None) => node.to_string(),
        (None, Some(label), None) => label,
        (None, None, Some([x, y, z])) => format!("{x},{y},{z}"),
        _ => return Err(Fault::item(place, "no single node", "expected one of node, label, or a position in mm")),
    };
    let kind = entry.kind.as_deref().unwrap_or("inlet");
    let figure = |dimension: Dimension| {
        let text = format!("{}{}", entry.value.unwrap_or_default(), entry.unit.as_deref().unwrap_or(""));
        let missing = || Fault::item(place, format!("{kind} without a value"), dimension.accepted());
        entry.value.ok_or_else(missing)?;
        dimension.parse(&text).map_err(|accepted| Fault::item(place, format!("{kind} value {text}"), accepted))
    };
    let (role, condition) = match kind {
        "inlet" if entry.value.is_none() => (Role::Inlet, Condition::INLET),
        "inlet" => (Role::Inlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "ground" => (Role::Outlet, Condition::GROUND),
        "pressure" => (Role::Outlet, Condition::Pressure(figure(Dimension::Pressure)?)),
        "resistance" => {
            let venous = pascals(entry.venous_pressure_mmhg.unwrap_or(0.0));
            (Role::Outlet, resistance(figure(Dimension::Resistance)?, venous, place)?)
        }
        "flow" => {
            let flow = figure(Dimension::Flow)?;
            (Role::of_flow(flow), Condition::Flow(flow))
        }
        other => {
            let meant = did_you_mean(other, ["inlet", "ground", "pressure", "resistance", "flow"]);
            return Err(Fault::item(
                place,
                format!("kind \"{other}\""),
                format!("{meant}expected inlet, ground, pressure, resistance or flow"),
            ));
        }
    };
    Ok(Statement { place: place.to_owned(), spec, role, condition })
}

fn resistance(resistance: f64, venous: f64, place: &str) -> Result<Condition, Fault> {
    if resistance > 0.0 && venous.is_finite() {
        return Ok(Condition::Resistance { resistance, venous });
    }
    Err(Fault::item(place, format!("resistance {resistance}"), "expected a positive resistance, and a finite venous pressure"))
}
