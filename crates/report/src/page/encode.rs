//! The data of a page as JSON: columns of numbers as little-endian arrays in base64, columns of text as a list of words.

use std::collections::HashMap;
use std::io;

use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde::ser::{SerializeMap as _, Serializer};
use serde_json::{Value, json};

use super::content::{Page, PageTable};
use super::scene::PageScene;
use crate::figures::colour::{Rgb, colour};
use willis_core::network::units::millimetres;
use willis_core::support::geometry::bounds;
use willis_io::formats::{Column, Texts, Values};
use willis_io::masks::cubes::{SIDE, STEP};

/// Steps of the colour map; the page interpolates between them.
const COLOURS: u32 = 32;

/// All data of a page, each array made as it is written: no text of all of them is held. Keys are in alphabetical order.
pub struct PageData<'a>(&'a Page);

impl<'a> PageData<'a> {
    /// The data of a page.
    ///
    /// # Errors
    ///
    /// A table whose columns differ in length.
    pub fn of(page: &'a Page) -> io::Result<Self> {
        page.tables.iter().try_for_each(|table| TableData::of(table).map(drop))?;
        Ok(Self(page))
    }
}

impl Serialize for PageData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let page = self.0;
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("colourings", &json!(page.colourings))?;
        map.serialize_entry("colours", &colours())?;
        map.serialize_entry("facts", &page.facts)?;
        map.serialize_entry("figures", &json!(page.figures))?;
        map.serialize_entry("image_places", &json!({ "side": SIDE, "step_mm": millimetres(STEP), "of": page.image_places }))?;
        map.serialize_entry("lead", &page.lead)?;
        map.serialize_entry("no_scene", &page.scene.as_ref().err())?;
        map.serialize_entry("phenotype", &page.phenotype)?;
        map.serialize_entry("record", &page.record)?;
        map.serialize_entry("scene", &page.scene.as_ref().ok().map(SceneData))?;
        map.serialize_entry("segmentation", &json!(page.segmentation))?;
        map.serialize_entry("tables", &page.tables.iter().map(TableData).collect::<Vec<_>>())?;
        map.serialize_entry("threshold", &json!(page.threshold))?;
        map.serialize_entry("title", &page.title)?;
        map.serialize_entry("warnings", &page.warnings)?;
        map.end()
    }
}

/// The colour map in equal steps, from low to high.
pub fn colours() -> Vec<Rgb> {
    (0..=COLOURS).map(|i| colour(f64::from(i) / f64::from(COLOURS))).collect()
}

/// The points as four u16 each (x, y, z, radius), with the corner and the two step sizes that convert them to mm.
struct SceneData<'a>(&'a PageScene);

impl Serialize for SceneData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let scene = self.0;
        let points = || scene.vessels.iter().flatten().chain(scene.markers.iter().map(|m| &m.place));
        let [low, high] = bounds(points().map(|[x, y, z, _]| [*x, *y, *z]));
        let widest = points().map(|[.., radius]| *radius).fold(0.0, f64::max);
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let step = |range: f64| if range > 0.0 { range / f64::from(u16::MAX) } else { 1.0 };
        let steps = [step(extent), step(widest)];
        let whole = |[x, y, z, radius]: &[f64; 4]| {
            let whole = [(x - low[0]) / steps[0], (y - low[1]) / steps[0], (z - low[2]) / steps[0], radius / steps[1]];
            whole.into_iter().flat_map(|w| (w.round() as u16).to_le_bytes())
        };
        let counts: Vec<i64> = scene.vessels.iter().map(|points| points.len() as i64).collect();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("corner", &low.map(|x| if x.is_finite() { x } else { 0.0 }))?;
        map.serialize_entry("counts", &ArrayData::whole(None, &counts))?;
        map.serialize_entry("markers", &scene.markers.iter().map(|m| (m.kind, &m.name)).collect::<Vec<_>>())?;
        map.serialize_entry("points", &Base64(points().flat_map(whole).collect()))?;
        map.serialize_entry("steps", &steps)?;
        map.end()
    }
}

/// A table and its columns, for a page that is small.
///
/// # Errors
///
/// Columns that differ in length.
pub fn table(table: &PageTable) -> io::Result<Value> {
    Ok(json!(TableData::of(table)?))
}

/// A table and its columns.
struct TableData<'a>(&'a PageTable);

impl<'a> TableData<'a> {
    /// The data of a table.
    ///
    /// # Errors
    ///
    /// Columns that differ in length.
    pub fn of(table: &'a PageTable) -> io::Result<Self> {
        let made = Self(table);
        if table.columns.iter().any(|column| column.values.len() != made.rows()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, format!("{}: columns differ in length", table.title)));
        }
        Ok(made)
    }

    fn rows(&self) -> usize {
        self.0.columns.first().map_or(0, |column| column.values.len())
    }
}

impl Serialize for TableData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let table = self.0;
        let columns = table.columns.iter().filter(|column| has_values(column));
        let columns = columns.map(|column| ColumnData { column, exact: table.exact.contains(&&*column.name) });
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("columns", &columns.collect::<Vec<_>>())?;
        map.serialize_entry("of_vessels", &table.of_vessels)?;
        map.serialize_entry("rows", &self.rows())?;
        map.serialize_entry("title", &table.title)?;
        map.end()
    }
}

fn has_values(column: &Column) -> bool {
    match &column.values {
        Values::Real(values) => values.iter().any(|x| !x.is_nan()),
        Values::Integer(values) => !values.is_empty(),
        Values::Text(values) => values.iter().any(|text| !text.is_empty()),
    }
}

/// A column, in double precision where it is to be exact.
struct ColumnData<'a> {
    column: &'a Column,
    exact: bool,
}

impl Serialize for ColumnData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let name = &*self.column.name;
        let array = |kind, bytes| ArrayData { data: Some(Base64(bytes)), kind, name: Some(name) };
        match &self.column.values {
            Values::Real(v) if self.exact => array("f64", v.iter().flat_map(|x| x.to_le_bytes()).collect()).serialize(serializer),
            Values::Real(v) => array("f32", v.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()).serialize(serializer),
            Values::Integer(v) => ArrayData::whole(Some(name), v).serialize(serializer),
            Values::Text(v) => {
                let (words, rows) = words(v);
                TextData { kind: "text", name, rows: ArrayData::whole(None, &rows), words }.serialize(serializer)
            }
        }
    }
}

/// Bytes as text.
struct Base64(Vec<u8>);

impl Serialize for Base64 {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&Base64Display::new(&self.0, &STANDARD))
    }
}

/// Numbers of a kind as bytes, none where they are their rows.
#[derive(Serialize)]
struct ArrayData<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    data: Option<Base64>,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
}

/// Words of rows: which there are, and the number of that of each row.
#[derive(Serialize)]
struct TextData<'a> {
    kind: &'static str,
    name: &'a str,
    rows: ArrayData<'a>,
    words: Vec<&'a str>,
}

impl<'a> ArrayData<'a> {
    /// Whole numbers in the narrowest type that holds them; a column that equals its row numbers needs no array.
    fn whole(name: Option<&'a str>, values: &[i64]) -> Self {
        let within = |high: i64| values.iter().all(|v| (0..=high).contains(v));
        if values.iter().enumerate().all(|(row, v)| *v == row as i64) {
            return Self { data: None, kind: "row", name };
        }
        let (kind, bytes) = if within(u8::MAX.into()) {
            ("u8", values.iter().map(|v| *v as u8).collect())
        } else if within(u16::MAX.into()) {
            ("u16", values.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect())
        } else if within(u32::MAX.into()) {
            ("u32", values.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect())
        } else {
            ("f64", values.iter().flat_map(|v| (*v as f64).to_le_bytes()).collect())
        };
        Self { data: Some(Base64(bytes)), kind, name }
    }
}

/// The distinct words in the order of their first rows, and the number of the word for each row.
fn words(values: &Texts) -> (Vec<&str>, Vec<i64>) {
    let (mut number, mut list, mut rows) = (HashMap::new(), Vec::new(), Vec::with_capacity(values.len()));
    for text in values.iter() {
        let next = list.len() as i64;
        let row = *number.entry(text).or_insert_with(|| {
            list.push(text);
            next
        });
        rows.push(row);
    }
    (list, rows)
}
