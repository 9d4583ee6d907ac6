//! The data of a page as JSON: columns of numbers as little-endian arrays in base64, columns of text as a list of words.

use std::collections::HashMap;
use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::content::{Page, PageTable};
use super::scene::PageScene;
use crate::figures::colour::{Rgb, colour};
use willis_io::formats::{Column, Values};
use willis_io::masks::strips::{ACROSS, ALONG};

/// Steps of the colour map; the page interpolates between them.
const COLOURS: u32 = 32;

/// All data of a page.
pub fn page(page: &Page) -> io::Result<Value> {
    Ok(json!({
        "title": page.title,
        "record": page.record,
        "lead": page.lead,
        "warnings": page.warnings,
        "facts": page.facts,
        "scene": page.scene.as_ref().map_or(Value::Null, scene),
        "no_scene": page.scene.as_ref().err(),
        "colours": colours(),
        "phenotype": page.phenotype,
        "colourings": page.colourings,
        "threshold": page.threshold,
        "segmentation": page.segmentation,
        "image_cuts": { "along": ALONG, "across": ACROSS, "of": page.image_cuts },
        "figures": page.figures,
        "tables": page.tables.iter().map(table).collect::<io::Result<Vec<_>>>()?,
    }))
}

/// The colour map in equal steps, from low to high.
pub fn colours() -> Vec<Rgb> {
    (0..=COLOURS).map(|i| colour(f64::from(i) / f64::from(COLOURS))).collect()
}

/// The points as four u16 each (x, y, z, radius), with the corner and the two step sizes that convert them to mm.
fn scene(scene: &PageScene) -> Value {
    let points = || scene.vessels.iter().flatten().chain(scene.markers.iter().map(|m| &m.place));
    let (mut low, mut high, mut widest) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], 0.0_f64);
    for [x, y, z, radius] in points() {
        for (axis, at) in [x, y, z].into_iter().enumerate() {
            low[axis] = low[axis].min(*at);
            high[axis] = high[axis].max(*at);
        }
        widest = widest.max(*radius);
    }
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let step = |range: f64| if range > 0.0 { range / f64::from(u16::MAX) } else { 1.0 };
    let steps = [step(extent), step(widest)];
    let mut bytes = Vec::new();
    for [x, y, z, radius] in points() {
        let whole = [(x - low[0]) / steps[0], (y - low[1]) / steps[0], (z - low[2]) / steps[0], radius / steps[1]];
        bytes.extend(whole.into_iter().flat_map(|w| (w.round() as u16).to_le_bytes()));
    }
    let counts: Vec<i64> = scene.vessels.iter().map(|points| points.len() as i64).collect();
    json!({
        "corner": low.map(|x| if x.is_finite() { x } else { 0.0 }),
        "steps": steps,
        "points": STANDARD.encode(&bytes),
        "counts": integers(&counts),
        "markers": scene.markers.iter().map(|m| json!([m.kind, m.name])).collect::<Vec<_>>(),
    })
}

/// A table and its columns.
pub fn table(table: &PageTable) -> io::Result<Value> {
    let rows = table.columns.first().map_or(0, |column| column.values.len());
    if table.columns.iter().any(|column| column.values.len() != rows) {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{}: columns differ in length", table.title)));
    }
    let columns = table.columns.iter().filter(|column| has_values(column));
    let columns = columns.map(|c| with_name(&c.name, &c.values, table.exact.contains(&&*c.name)));
    Ok(json!({ "title": table.title, "rows": rows, "of_vessels": table.of_vessels, "columns": columns.collect::<Vec<_>>() }))
}

fn has_values(column: &Column) -> bool {
    match &column.values {
        Values::Real(values) => values.iter().any(|x| !x.is_nan()),
        Values::Integer(values) => !values.is_empty(),
        Values::Text(values) => values.iter().any(|text| !text.is_empty()),
    }
}

fn with_name(name: &str, values: &Values, exact: bool) -> Value {
    let mut column = match values {
        Values::Real(v) if exact => array("f64", v.iter().flat_map(|x| x.to_le_bytes())),
        Values::Real(v) => array("f32", v.iter().flat_map(|x| (*x as f32).to_le_bytes())),
        Values::Integer(v) => integers(v),
        Values::Text(v) => words(v),
    };
    column["name"] = json!(name);
    column
}

fn array(kind: &str, bytes: impl Iterator<Item = u8>) -> Value {
    json!({ "kind": kind, "data": STANDARD.encode(bytes.collect::<Vec<u8>>()) })
}

/// Whole numbers in the narrowest type that holds them; a column that equals its row numbers needs no array.
fn integers(values: &[i64]) -> Value {
    let within = |high: i64| values.iter().all(|v| (0..=high).contains(v));
    if values.iter().enumerate().all(|(row, v)| *v == row as i64) {
        json!({ "kind": "row" })
    } else if within(u8::MAX.into()) {
        array("u8", values.iter().map(|v| *v as u8))
    } else if within(u16::MAX.into()) {
        array("u16", values.iter().flat_map(|v| (*v as u16).to_le_bytes()))
    } else if within(u32::MAX.into()) {
        array("u32", values.iter().flat_map(|v| (*v as u32).to_le_bytes()))
    } else {
        array("f64", values.iter().flat_map(|v| (*v as f64).to_le_bytes()))
    }
}

/// The distinct words in the order of their first rows, and the number of the word for each row.
fn words(values: &[String]) -> Value {
    let (mut number, mut list, mut rows) = (HashMap::new(), Vec::new(), Vec::with_capacity(values.len()));
    for text in values {
        let next = list.len() as i64;
        let row = *number.entry(text).or_insert_with(|| {
            list.push(text);
            next
        });
        rows.push(row);
    }
    json!({ "kind": "text", "words": list, "rows": integers(&rows) })
}
