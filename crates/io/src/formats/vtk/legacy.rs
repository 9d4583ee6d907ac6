//! Reads a legacy VTK PolyData file, ASCII or binary, section by section.

use crate::formats::options::ReadOptions;
use crate::formats::vtk::cursor::{VtkCursor, VtkType, unescape};
use crate::formats::vtk::polydata::{ArrayValues, LIMIT, NamedValues, PolyData, centerlines, check_cells, is_wanted};
use willis_core::error::Fault;
use willis_core::network::{Centerlines, Frame};

pub(crate) const TYPES: &str = "expected bit, char, short, int, long, float or double, or string";

/// Reads the polylines with the radius of each point, versions 2.0 to 5.1; returns also notes for the user.
///
/// Points keep their row as id; those on no line are left out. `options.radius_array` says which array holds the radius. Lines
/// that run together become one vessel; cell arrays such as `label` name their lines.
///
/// # Errors
///
/// Another data set than PolyData, arrays that end early or contradict each other, a point on a line without finite coordinates,
/// no radius array, or a surface instead of lines.
pub fn read_vtk(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut cursor = VtkCursor::new(bytes);
    let frame = head(&mut cursor)?;
    let mut reader = Reader { cursor, options, data: PolyData::default(), cells: [0; 4], group: None };
    while let Some(keyword) = reader.cursor.word() {
        reader.section(keyword)?;
    }
    let (data, notes) = reader.finish()?;
    let (mut lines, more) = centerlines(&[data], options)?;
    lines.frame = frame;
    Ok((lines, [notes, more].concat()))
}

/// The four lines before the data; returns the frame that the title states as 3D Slicer does.
fn head(cursor: &mut VtkCursor) -> Result<Frame, Fault> {
    let version = cursor.line().unwrap_or_default();
    if !version.starts_with("# vtk DataFile") {
        return Err(Fault::line(1, format!("\"{}\"", version.trim()), "expected # vtk DataFile Version 2.0 to 5.1"));
    }
    let title = cursor.line().unwrap_or_default();
    let encoding = cursor.need("ASCII or BINARY")?;
    let is_binary = encoding.eq_ignore_ascii_case("BINARY");
    if !is_binary && !encoding.eq_ignore_ascii_case("ASCII") {
        return Err(cursor.fault(format!("\"{encoding}\""), "expected ASCII or BINARY"));
    }
    let (keyword, kind) = (cursor.need("DATASET POLYDATA")?, cursor.need("DATASET POLYDATA")?);
    if !keyword.eq_ignore_ascii_case("DATASET") || !kind.eq_ignore_ascii_case("POLYDATA") {
        return Err(cursor.fault(format!("{keyword} {kind}"), "expected DATASET POLYDATA"));
    }
    cursor.binary = is_binary;
    Ok(Frame::of_header(&title))
}

/// What has been read of a file.
#[derive(Debug)]
pub(crate) struct Reader<'a> {
    pub(crate) cursor: VtkCursor<'a>,
    pub(crate) options: &'a ReadOptions,
    pub(crate) data: PolyData,
    /// How many vertex cells, lines, polygons and strips there are.
    cells: [usize; 4],
    /// Whether arrays belong to the points, or else to the cells, and how many values each has.
    pub(crate) group: Option<(bool, usize)>,
}

impl Reader<'_> {
    pub(crate) fn section(&mut self, keyword: &str) -> Result<(), Fault> {
        let keyword = keyword.to_ascii_uppercase();
        if keyword == "METADATA" {
            // It ends with a blank line.
            self.cursor.line();
            while self.cursor.line().is_some_and(|line| !line.trim().is_empty()) {}
            return Ok(());
        }
        self.cursor.section.clone_from(&keyword);
        match keyword.as_str() {
            "POINTS" => {
                let count = self.cursor.count("the number of points", LIMIT)?;
                let kind = self.kind()?;
                let flat = self.cursor.numbers(kind, 3 * count)?;
                self.data.points = flat.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
                Ok(())
            }
            "VERTICES" => self.connectivity(0),
            "LINES" => self.connectivity(1),
            "POLYGONS" => self.connectivity(2),
            "TRIANGLE_STRIPS" => self.connectivity(3),
            "POINT_DATA" | "CELL_DATA" => self.data_of(keyword == "POINT_DATA"),
            _ => self.attribute(&keyword),
        }
    }

    fn data_of(&mut self, of_points: bool) -> Result<(), Fault> {
        let count = self.cursor.count("a number of values", LIMIT)?;
        let (expected, what) = if of_points { (self.data.points.len(), "points") } else { (self.cells.iter().sum(), "cells") };
        if count != expected {
            return Err(self.cursor.fault(format!("{count} values"), format!("expected {expected}, one for each of the {what}")));
        }
        self.group = Some((of_points, count));
        Ok(())
    }

    /// Cells: since version 5.1 offsets, then points; before that each cell with its count and its points.
    fn connectivity(&mut self, which: usize) -> Result<(), Fault> {
        let first = self.cursor.count("a number of cells", LIMIT)?;
        let second = self.cursor.count("a number of entries", LIMIT)?;
        if !self.cursor.is_next("OFFSETS") {
            let entries = self.cursor.wholes(VtkType::INT, second)?;
            return self.cells_with_counts(which, first, &entries);
        }
        let mut ends = self.part("OFFSETS", first)?;
        let cells = self.part("CONNECTIVITY", second)?;
        // The first offset is 0: a cell ends where the next one starts.
        ends.drain(..ends.len().min(1));
        self.keep(which, ends, cells);
        Ok(())
    }

    fn part(&mut self, word: &str, count: usize) -> Result<Vec<i64>, Fault> {
        let found = self.cursor.need(word)?;
        if !found.eq_ignore_ascii_case(word) {
            return Err(self.cursor.fault(format!("\"{}\"", found.escape_debug()), format!("expected {word}")));
        }
        let kind = self.kind()?;
        self.cursor.wholes(kind, count)
    }

    fn keep(&mut self, which: usize, ends: Vec<i64>, cells: Vec<i64>) {
        self.cells[which] = ends.len();
        if which == 1 {
            (self.data.ends, self.data.cells) = (ends, cells);
        }
    }

    fn cells_with_counts(&mut self, which: usize, count: usize, entries: &[i64]) -> Result<(), Fault> {
        let (mut ends, mut cells, mut at) = (Vec::new(), Vec::new(), 0);
        for n in 0..count {
            let cell = entries.get(at).and_then(|size| entries.get(at + 1..(at + 1).checked_add(usize::try_from(*size).ok()?)?));
            let cell = cell.ok_or_else(|| {
                let found = entries.get(at).map_or("is missing".to_owned(), |size| format!("has {size} points"));
                self.cursor.fault(format!("cell {n} {found}"), format!("expected {count} cells in {} entries", entries.len()))
            })?;
            cells.extend(cell);
            at += 1 + cell.len();
            ends.push(cells.len() as i64);
        }
        self.keep(which, ends, cells);
        Ok(())
    }

    fn kind(&mut self) -> Result<VtkType, Fault> {
        let name = self.cursor.need("a type")?;
        VtkType::named(name).ok_or_else(|| self.cursor.fault(format!("type \"{name}\""), TYPES))
    }

    fn finish(mut self) -> Result<(PolyData, Vec<String>), Fault> {
        let [verts, lines, polygons, strips] = self.cells;
        let notes = check_cells(lines, verts, polygons + strips, "expected LINES")?;
        // Cell data counts vertex cells before lines, wherever they stand in the file.
        for array in &mut self.data.line_data {
            match &mut array.values {
                ArrayValues::Numbers(values) => *values = values.iter().skip(verts).take(lines).copied().collect(),
                ArrayValues::Texts(values) => *values = values.iter().skip(verts).take(lines).cloned().collect(),
                ArrayValues::Unread => {}
            }
        }
        Ok((self.data, notes))
    }
}

const SECTIONS: &str = "expected POINTS, VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS, POINT_DATA, CELL_DATA or an array";

impl Reader<'_> {
    /// An array of the points or cells, or of the whole file.
    pub(crate) fn attribute(&mut self, keyword: &str) -> Result<(), Fault> {
        let width = match keyword {
            "VECTORS" | "NORMALS" => 3,
            "TENSORS" => 9,
            "TENSORS6" => 6,
            "GLOBAL_IDS" | "PEDIGREE_IDS" | "EDGE_FLAGS" => 1,
            // What follows states it.
            "FIELD" | "SCALARS" | "COLOR_SCALARS" | "LOOKUP_TABLE" | "TEXTURE_COORDINATES" => 0,
            _ => {
                "keyword".clone_into(&mut self.cursor.section);
                return Err(self.cursor.fault(format!("\"{}\"", keyword.escape_debug()), SECTIONS));
            }
        };
        let name = unescape(self.cursor.need("a name")?);
        let rows = self.group.map_or(0, |(_, count)| count);
        self.cursor.section = format!("{keyword} \"{name}\"");
        match keyword {
            "FIELD" => {
                let arrays = self.cursor.count("a number of arrays", LIMIT)?;
                for _ in 0..arrays {
                    while self.cursor.is_next("METADATA") {
                        self.cursor.word();
                        self.section("METADATA")?;
                    }
                    self.field()?;
                }
                Ok(())
            }
            "COLOR_SCALARS" => {
                let width = self.cursor.count("a number of components", LIMIT)?;
                self.cursor.numbers(VtkType::BYTE, rows.saturating_mul(width)).map(drop)
            }
            "LOOKUP_TABLE" => {
                let size = self.cursor.count("a size", LIMIT)?;
                self.cursor.numbers(if self.cursor.binary { VtkType::BYTE } else { VtkType::REAL }, 4 * size).map(drop)
            }
            "SCALARS" => {
                let kind = self.cursor.need("a type")?;
                let width = self.cursor.line().unwrap_or_default();
                let width = match width.trim() {
                    "" => 1,
                    text => text.parse().map_err(|_| self.cursor.fault(format!("\"{text}\""), "expected 1 to 4 components"))?,
                };
                let table = self.cursor.need("LOOKUP_TABLE")?;
                if !table.eq_ignore_ascii_case("LOOKUP_TABLE") {
                    return Err(self.cursor.fault(format!("\"{}\"", table.escape_debug()), "expected LOOKUP_TABLE"));
                }
                self.cursor.need("a name")?;
                self.values(&name, kind, width, rows)
            }
            _ => {
                let width = if keyword == "TEXTURE_COORDINATES" { self.cursor.count("a dimension", 3)? } else { width };
                let kind = self.cursor.need("a type")?;
                self.values(&name, kind, width, rows)
            }
        }
    }

    /// One array of a field, which states its own size.
    fn field(&mut self) -> Result<(), Fault> {
        let name = unescape(self.cursor.need("the name of an array")?);
        if name == "NULL_ARRAY" {
            return Ok(());
        }
        self.cursor.section = format!("array \"{name}\"");
        let width = self.cursor.count("a number of components", LIMIT)?;
        let rows = self.cursor.count("a number of values", LIMIT)?;
        let kind = self.cursor.need("a type")?;
        if let Some((_, expected)) = self.group.filter(|(_, expected)| *expected != rows && is_wanted(name.trim(), self.options))
        {
            return Err(self.cursor.fault(format!("{rows} values"), format!("expected {expected}")));
        }
        self.values(&name, kind, width, rows)
    }

    fn values(&mut self, name: &str, kind: &str, width: usize, rows: usize) -> Result<(), Fault> {
        let count = rows.saturating_mul(width);
        let values = if ["string", "utf8_string"].iter().any(|text| kind.eq_ignore_ascii_case(text)) {
            ArrayValues::Texts(self.cursor.texts(count)?)
        } else {
            let kind = VtkType::named(kind).ok_or_else(|| self.cursor.fault(format!("type \"{kind}\""), TYPES))?;
            ArrayValues::Numbers(self.cursor.numbers(kind, count)?)
        };
        let name = name.trim().to_owned();
        let values = if width == 1 && is_wanted(&name, self.options) { values } else { ArrayValues::Unread };
        if let Some((of_points, _)) = self.group {
            let arrays = if of_points { &mut self.data.point_data } else { &mut self.data.line_data };
            arrays.push(NamedValues { name, values });
        }
        Ok(())
    }
}
