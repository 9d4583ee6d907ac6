//! The data of a page as JSON: columns of numbers as little-endian arrays in base64, columns of text as a list of words.

use std::collections::HashMap;

use base64::display::Base64Display;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde::ser::{SerializeMap as _, Serializer};

use super::content::PageTable;
use super::scene::PageScene;
use willis_core::support::geometry::bounds;
use willis_io::formats::{Column, Texts, Values};

impl Serialize for PageScene {
    /// The points as four u16 each (x, y, z, radius), with the corner and the two step sizes that convert them to mm.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let points = || self.vessels.iter().flatten().chain(self.markers.iter().map(|m| &m.place));
        let [low, high] = bounds(points().map(|[x, y, z, _]| [*x, *y, *z]));
        let widest = points().map(|[.., radius]| *radius).fold(0.0, f64::max);
        let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
        let step = |range: f64| if range > 0.0 { range / f64::from(u16::MAX) } else { 1.0 };
        let steps = [step(extent), step(widest)];
        let whole = |[x, y, z, radius]: &[f64; 4]| {
            let whole = [(x - low[0]) / steps[0], (y - low[1]) / steps[0], (z - low[2]) / steps[0], radius / steps[1]];
            whole.into_iter().flat_map(|w| (w.round() as u16).to_le_bytes())
        };
        let counts: Vec<i64> = self.vessels.iter().map(|points| points.len() as i64).collect();
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("corner", &low.map(|x| if x.is_finite() { x } else { 0.0 }))?;
        map.serialize_entry("counts", &ArrayData::whole(None, &counts))?;
        map.serialize_entry("markers", &self.markers.iter().map(|m| (m.kind, &m.name)).collect::<Vec<_>>())?;
        map.serialize_entry("points", &Base64(points().flat_map(whole).collect()))?;
        map.serialize_entry("steps", &steps)?;
        map.end()
    }
}

impl Serialize for PageTable {
    /// Each array is made as it is written: no text of all of them is held.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let columns = self.columns.iter().filter(|column| has_values(column));
        let columns = columns.map(|column| ColumnData { column, exact: self.exact.contains(&&*column.name) });
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("columns", &columns.collect::<Vec<_>>())?;
        map.serialize_entry("of_vessels", &self.of_vessels)?;
        map.serialize_entry("rows", &self.columns.first().map_or(0, |column| column.values.rows()))?;
        map.serialize_entry("title", &self.title)?;
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
        let array = |kind, bytes| ArrayData { data: Some(Base64(bytes)), kind, name: Some(name), ..ArrayData::default() };
        let made = match &self.column.values {
            Values::Real(v) if self.exact => array("f64", v.iter().flat_map(|x| x.to_le_bytes()).collect()),
            Values::Real(v) => array("f32", v.iter().flat_map(|x| (*x as f32).to_le_bytes()).collect()),
            Values::Integer(v) => ArrayData::whole(Some(name), v),
            Values::Text(v) => {
                let (words, rows) = words(v);
                let rows = Some(Box::new(ArrayData::whole(None, &rows)));
                ArrayData { kind: "text", name: Some(name), rows, words: Some(words), data: None }
            }
        };
        made.serialize(serializer)
    }
}

/// Bytes as text.
struct Base64(Vec<u8>);

impl Serialize for Base64 {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&Base64Display::new(&self.0, &STANDARD))
    }
}

/// Numbers of a kind as bytes, none where they are their rows; or words of rows: which there are, and the number of that of each row.
#[derive(Default, Serialize)]
struct ArrayData<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    data: Option<Base64>,
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rows: Option<Box<ArrayData<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    words: Option<Vec<&'a str>>,
}

impl<'a> ArrayData<'a> {
    /// Whole numbers in the narrowest type that holds them; a column that equals its row numbers needs no array.
    fn whole(name: Option<&'a str>, values: &[i64]) -> Self {
        if values.iter().enumerate().all(|(row, v)| *v == row as i64) {
            return Self { kind: "row", name, ..Self::default() };
        }
        let holds = |bytes: usize| values.iter().all(|v| (0..1_i64 << (8 * bytes)).contains(v));
        let (kind, bytes) = match [("u8", 1), ("u16", 2), ("u32", 4)].into_iter().find(|(_, bytes)| holds(*bytes)) {
            Some((kind, bytes)) => (kind, values.iter().flat_map(|v| v.to_le_bytes().into_iter().take(bytes)).collect()),
            None => ("f64", values.iter().flat_map(|v| (*v as f64).to_le_bytes()).collect()),
        };
        Self { data: Some(Base64(bytes)), kind, name, ..Self::default() }
    }
}

/// The distinct words in the order of their first rows, and the number of the word for each row.
fn words(values: &Texts) -> (Vec<&str>, Vec<i64>) {
    let (mut number, mut list, mut rows) = (HashMap::new(), Vec::new(), Vec::with_capacity(values.iter().len()));
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
