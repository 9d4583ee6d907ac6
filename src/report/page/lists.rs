//! A picture in a page. The only file of the page that knows in which format the pictures come.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use super::Table;
use crate::error::Result;
use crate::io::{Column, Values};

/// The largest drawing in lines that goes into a page; beyond it pixels are smaller. In bytes.
const DRAWING: usize = 200_000;

/// A picture and what it shows.
#[derive(Debug, Clone)]
pub struct Figure {
    /// Its heading.
    pub title: &'static str,
    /// What it shows, for those who read it and those who cannot see it.
    pub says: &'static str,
    source: String,
}

impl Figure {
    /// The picture in lines, or in pixels where these make the page lighter.
    ///
    /// # Errors
    ///
    /// What drawing says.
    pub fn new(title: &'static str, says: &'static str, picture: &crate::report::figures::figure::Figure) -> Result<Self> {
        let drawing = picture.svg()?;
        let (kind, bytes) = if drawing.len() <= DRAWING {
            ("svg+xml", drawing.into_bytes())
        } else {
            ("png", picture.png(crate::report::figures::figure::DEFAULT_DPI)?)
        };
        Ok(Self { title, says, source: format!("data:image/{kind};base64,{}", STANDARD.encode(bytes)) })
    }

    /// Where a page finds it: within itself.
    pub fn source(&self) -> &str {
        &self.source
    }
}

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
