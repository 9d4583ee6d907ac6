//! The data of a page as JSON: columns of numbers as little-endian arrays in base64, columns of text as a list of words.

use std::collections::HashMap;
use std::io;

use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use serde::ser::{Serialize, SerializeMap as _, Serializer};
use serde_json::{Value, json};

use super::content::{Page, PageTable};
use super::scene::PageScene;
use crate::figures::colour::{Rgb, colour};
use willis_core::network::units::millimetres;
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
        let name = Some(&*self.column.name);
        let array = |kind, bytes| ArrayData { kind, bytes: Base64(bytes), name };
        match &self.column.values {
            Values::Real(v) if self.exact => array("f64", v.iter().flat_map(|x| x.to_le_bytes()).collect()).serialize(serializer),
            Values::Real(v) => array("f32", v.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()).serialize(serializer),
            Values::Integer(v) => ArrayData::whole(name, v).serialize(serializer),
            Values::Text(v) => {
                let (words, rows) = words(v);
                let mut map = serializer.serialize_map(None)?;
                map.serialize_entry("kind", "text")?;
                map.serialize_entry("name", &name)?;
                map.serialize_entry("rows", &ArrayData::whole(None, &rows))?;
                map.serialize_entry("words", &words)?;
                map.end()
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
struct ArrayData<'a> {
    kind: &'static str,
    bytes: Base64,
    name: Option<&'a str>,
}

impl<'a> ArrayData<'a> {
    /// Whole numbers in the narrowest type that holds them; a column that equals its row numbers needs no array.
    fn whole(name: Option<&'a str>, values: &[i64]) -> Self {
        let within = |high: i64| values.iter().all(|v| (0..=high).contains(v));
        let (kind, bytes) = if values.iter().enumerate().all(|(row, v)| *v == row as i64) {
            ("row", Vec::new())
        } else if within(u8::MAX.into()) {
            ("u8", values.iter().map(|v| *v as u8).collect())
        } else if within(u16::MAX.into()) {
            ("u16", values.iter().flat_map(|v| (*v as u16).to_le_bytes()).collect())
        } else if within(u32::MAX.into()) {
            ("u32", values.iter().flat_map(|v| (*v as u32).to_le_bytes()).collect())
        } else {
            ("f64", values.iter().flat_map(|v| (*v as f64).to_le_bytes()).collect())
        };
        Self { kind, bytes: Base64(bytes), name }
    }
}

impl Serialize for ArrayData<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        if self.kind != "row" {
            map.serialize_entry("data", &self.bytes)?;
        }
        map.serialize_entry("kind", self.kind)?;
        if let Some(name) = self.name {
            map.serialize_entry("name", name)?;
        }
        map.end()
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
