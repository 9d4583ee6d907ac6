//! A list of the record, such as its boundary conditions, as a table.

use serde_json::Value;

use super::Table;
use crate::formats::{Column, Values};

/// One row an item; columns as named, of numbers where all that is there are numbers. `None` without an item.
pub fn list(title: &str, items: &Value, columns: &[&'static str]) -> Option<Table> {
    let items = items.as_array().filter(|items| !items.is_empty())?;
    let column = |&name: &&'static str| {
        let values = || items.iter().map(|item| &item[name]);
        let numbers = values().all(|v| v.is_null() || v.is_number());
        let values = if numbers {
            Values::Real(values().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect())
        } else {
            Values::Text(values().map(word).collect())
        };
        Column { name: name.into(), values }
    };
    Some(Table { title: title.to_owned(), columns: columns.iter().map(column).collect(), exact: &[], of_vessels: false })
}

fn word(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Bool(yes) => (if *yes { "yes" } else { "no" }).to_owned(),
        other => other.to_string(),
    }
}

/// The boundary conditions of a record.
pub fn conditions(items: &Value) -> Option<Table> {
    const COLUMNS: [&str; 8] =
        ["node", "id", "role", "found", "pressure_mmHg", "resistance_mmHg_s_per_mL", "venous_pressure_mmHg", "flow_mL_per_min"];
    list("Boundary conditions", items, &COLUMNS)
}
