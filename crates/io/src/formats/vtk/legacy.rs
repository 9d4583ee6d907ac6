//! Reads a legacy VTK PolyData file from left to right, section by section, in ASCII or big-endian binary.

use crate::formats::vtk::polydata::{ArrayValues, LIMIT, NamedValues, PolyData, centerlines, check_cells, is_wanted};
use crate::formats::{Centerlines, Fault, Frame, NumberType, ReadOptions, ensure, word};

const TYPES: &str = "expected bit, char, short, int, long, float or double, or string";
const SECTIONS: &str = "expected POINTS, VERTICES, LINES, POLYGONS, TRIANGLE_STRIPS, POINT_DATA, CELL_DATA or an array";

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
    let Reader { mut data, frame, cells: [verts, lines, polygons, strips], .. } = Reader::of(bytes, options)?;
    let mut notes = check_cells(lines, verts, polygons + strips, "expected LINES")?;
    // Cell data counts vertex cells before lines, wherever they stand in the file.
    for array in &mut data.line_data {
        match &mut array.values {
            ArrayValues::Numbers(values) => *values = values.iter().skip(verts).take(lines).copied().collect(),
            ArrayValues::Texts(values) => *values = values.iter().skip(verts).take(lines).cloned().collect(),
            ArrayValues::Unread => {}
        }
    }
    let (lines, more) = centerlines(vec![data], options)?;
    notes.extend(more);
    Ok((Centerlines { frame, ..lines }, notes))
}

/// The names of the arrays of points and cells; none of a file that cannot be read.
pub(crate) fn names_of_arrays(bytes: &[u8]) -> Option<Vec<String>> {
    let PolyData { point_data, line_data, .. } = Reader::of(bytes, &ReadOptions::default()).ok()?.data;
    Some(point_data.into_iter().chain(line_data).map(|array| array.name).collect())
}

/// The four lines before the data; returns the frame that the title states as 3D Slicer does.
fn head(cursor: &mut VtkCursor) -> Result<Frame, Fault> {
    let version = cursor.line().unwrap_or_default();
    let wrong = || Fault::line(1, format!("\"{}\"", version.trim()), "expected # vtk DataFile Version 2.0 to 5.1");
    ensure(version.starts_with("# vtk DataFile"), wrong)?;
    let title = cursor.line().unwrap_or_default();
    let encoding = cursor.need("ASCII or BINARY")?;
    let is_binary = encoding.eq_ignore_ascii_case("BINARY");
    let wrong = || cursor.fault(format!("\"{encoding}\""), "expected ASCII or BINARY");
    ensure(is_binary || encoding.eq_ignore_ascii_case("ASCII"), wrong)?;
    let (keyword, kind) = (cursor.need("DATASET POLYDATA")?, cursor.need("DATASET POLYDATA")?);
    let wrong = || cursor.fault(format!("{keyword} {kind}"), "expected DATASET POLYDATA");
    ensure(keyword.eq_ignore_ascii_case("DATASET") && kind.eq_ignore_ascii_case("POLYDATA"), wrong)?;
    cursor.binary = is_binary;
    Ok(Frame::of_header(&title))
}

/// What has been read of a file.
struct Reader<'a> {
    cursor: VtkCursor<'a>,
    options: &'a ReadOptions,
    data: PolyData,
    /// As the title states it, else an array of the whole file.
    frame: Frame,
    /// How many vertex cells, lines, polygons and strips there are.
    cells: [usize; 4],
    /// Whether arrays belong to the points, or else to the cells, and how many values each has.
    group: Option<(bool, usize)>,
}

impl<'a> Reader<'a> {
    /// Reads a whole file.
    fn of(bytes: &'a [u8], options: &'a ReadOptions) -> Result<Self, Fault> {
        let mut cursor = VtkCursor { bytes, at: 0, binary: false, section: String::new() };
        let frame = head(&mut cursor)?;
        let mut reader = Self { cursor, options, data: PolyData::default(), frame, cells: [0; 4], group: None };
        while let Some(keyword) = reader.cursor.word() {
            reader.section(keyword)?;
        }
        Ok(reader)
    }

    fn section(&mut self, keyword: &str) -> Result<(), Fault> {
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
            "POINT_DATA" | "CELL_DATA" => {
                let count = self.cursor.count("a number of values", LIMIT)?;
                let of_points = keyword == "POINT_DATA";
                let (expected, what) =
                    if of_points { (self.data.points.len(), "points") } else { (self.cells.iter().sum(), "cells") };
                let accepted = || format!("expected {expected}, one for each of the {what}");
                ensure(count == expected, || self.cursor.fault(format!("{count} values"), accepted()))?;
                self.group = Some((of_points, count));
                Ok(())
            }
            _ => self.attribute(&keyword),
        }
    }

    /// Cells: since version 5.1 offsets, then points; before that each cell with its count and its points.
    fn connectivity(&mut self, which: usize) -> Result<(), Fault> {
        let first = self.cursor.count("a number of cells", LIMIT)?;
        let second = self.cursor.count("a number of entries", LIMIT)?;
        let (ends, cells) = if self.cursor.is_next("OFFSETS") {
            let mut ends = self.part("OFFSETS", first)?;
            // The first offset is 0: a cell ends where the next one starts.
            ends.drain(..ends.len().min(1));
            (ends, self.part("CONNECTIVITY", second)?)
        } else {
            let entries = self.cursor.wholes(INT, second)?;
            self.cells_with_counts(first, &entries)?
        };
        self.cells[which] = ends.len();
        if which == 1 {
            (self.data.ends, self.data.cells) = (ends, cells);
        }
        Ok(())
    }

    fn part(&mut self, word: &str, count: usize) -> Result<Vec<i64>, Fault> {
        self.cursor.expect(word)?;
        let kind = self.kind()?;
        self.cursor.wholes(kind, count)
    }

    fn cells_with_counts(&self, count: usize, entries: &[i64]) -> Result<(Vec<i64>, Vec<i64>), Fault> {
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
        Ok((ends, cells))
    }

    fn kind(&mut self) -> Result<VtkType, Fault> {
        let name = self.cursor.need("a type")?;
        type_named(name).ok_or_else(|| self.cursor.fault(format!("type \"{name}\""), TYPES))
    }

    /// An array of the points or cells, or of the whole file.
    fn attribute(&mut self, keyword: &str) -> Result<(), Fault> {
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
                for _ in 0..self.cursor.count("a number of arrays", LIMIT)? {
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
                let mut values = self.cursor.numbers(BYTE, rows.saturating_mul(width))?;
                if !self.cursor.binary {
                    // In text each byte is a share of 255.
                    for value in &mut values {
                        *value = (255.0 * *value).round();
                    }
                }
                self.keep(&name, width, ArrayValues::Numbers(values));
                Ok(())
            }
            "LOOKUP_TABLE" => {
                let size = self.cursor.count("a size", LIMIT)?;
                // As text they are real numbers: the type counts in binary alone.
                self.cursor.numbers(BYTE, 4 * size).map(drop)
            }
            "SCALARS" => {
                let kind = self.cursor.need("a type")?;
                let width = self.cursor.line().unwrap_or_default();
                let width = match width.trim() {
                    "" => 1,
                    text => text.parse().map_err(|_| self.cursor.fault(format!("\"{text}\""), "expected 1 to 4 components"))?,
                };
                self.cursor.expect("LOOKUP_TABLE")?;
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
            let kind = type_named(kind).ok_or_else(|| self.cursor.fault(format!("type \"{kind}\""), TYPES))?;
            ArrayValues::Numbers(self.cursor.numbers(kind, count)?)
        };
        self.keep(name, width, values);
        Ok(())
    }

    /// Adds an array to those of the points or cells, with its values if they are wanted.
    fn keep(&mut self, name: &str, width: usize, values: ArrayValues) {
        let name = name.trim().to_owned();
        if let (None, super::SPACE, Frame::Unknown, ArrayValues::Texts(words)) = (self.group, &*name, self.frame, &values) {
            self.frame = words.first().map_or(Frame::Unknown, |word| Frame::of_word(word));
        }
        let values = if width == 1 && is_wanted(&name, self.options) { values } else { ArrayValues::Unread };
        if let Some((of_points, _)) = self.group {
            let arrays = if of_points { &mut self.data.point_data } else { &mut self.data.line_data };
            arrays.push(NamedValues { name, values });
        }
    }
}

/// A type of number, and its bits in binary.
type VtkType = (NumberType, usize);

/// The whole numbers of the cells in files before version 5.1.
const INT: VtkType = (NumberType::Signed, 32);
/// Bytes.
const BYTE: VtkType = (NumberType::Unsigned, 8);

/// The type of this name, in any case.
fn type_named(name: &str) -> Option<VtkType> {
    use NumberType::{Real, Signed, Unsigned};
    Some(match name.to_ascii_lowercase().as_str() {
        "bit" => (Unsigned, 1),
        "char" | "signed_char" | "vtktypeint8" => (Signed, 8),
        "unsigned_char" | "vtktypeuint8" => BYTE,
        "short" | "vtktypeint16" => (Signed, 16),
        "unsigned_short" | "vtktypeuint16" => (Unsigned, 16),
        // VTK writes its ids as int, however wide they are.
        "int" | "vtkidtype" | "vtktypeint32" => INT,
        "unsigned_int" | "vtktypeuint32" => (Unsigned, 32),
        "long" | "long_long" | "vtktypeint64" => (Signed, 64),
        "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => (Unsigned, 64),
        "float" => (Real, 32),
        "double" => (Real, 64),
        _ => return None,
    })
}

/// A place in the file.
#[derive(Clone)]
struct VtkCursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether numbers and texts are binary.
    binary: bool,
    /// What is being read, for messages.
    section: String,
}

impl<'a> VtkCursor<'a> {
    /// A fault here: with the line in a file of digits, with the section in a binary one.
    fn fault(&self, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
        let section = if self.section.is_empty() { "the head of the file" } else { &self.section };
        if self.binary {
            return Fault::item(section, found.to_string(), accepted);
        }
        let before = &self.bytes[..self.at.min(self.bytes.len())];
        let line = before.trim_ascii_end().split(|b| *b == b'\n').count();
        Fault::line(line, format!("{section}: {found}"), accepted)
    }

    /// The rest of the line, without its end.
    fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        let line = &rest[..end.unwrap_or(rest.len())];
        Some(String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)).into_owned())
    }

    /// The next word; `None` at the end of the file.
    fn word(&mut self) -> Option<&'a str> {
        let rest = self.bytes.get(self.at..)?;
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let word = rest[start..].split(u8::is_ascii_whitespace).next()?;
        self.at += start + word.len();
        Some(std::str::from_utf8(word).unwrap_or("\u{fffd}"))
    }

    /// Whether the next word is this one, in any case.
    fn is_next(&self, word: &str) -> bool {
        self.clone().word().is_some_and(|next| next.eq_ignore_ascii_case(word))
    }

    /// The next word, which must be there.
    fn need(&mut self, what: &str) -> Result<&'a str, Fault> {
        self.word().ok_or_else(|| self.fault("the file ends", format!("expected {what}")))
    }

    /// The next word, which must be this one, in any case.
    fn expect(&mut self, word: &str) -> Result<(), Fault> {
        let found = self.need(word)?;
        let other = || self.fault(format!("\"{}\"", found.escape_debug()), format!("expected {word}"));
        ensure(found.eq_ignore_ascii_case(word), other)
    }

    /// The next word as a count that a file can have.
    fn count(&mut self, what: &str, most: usize) -> Result<usize, Fault> {
        let word = self.need(what)?;
        let count = word.parse().ok().filter(|n| *n <= most);
        count.ok_or_else(|| self.fault(format!("\"{word}\""), format!("expected {what}, a count up to {most}")))
    }

    /// Whole numbers.
    fn wholes(&mut self, kind: VtkType, count: usize) -> Result<Vec<i64>, Fault> {
        if self.binary {
            return Ok(self.numbers(kind, count)?.into_iter().map(|x| x as i64).collect());
        }
        self.entries(count, "expected a whole number")
    }

    /// Numbers of any type.
    fn numbers(&mut self, (kind, bits): VtkType, count: usize) -> Result<Vec<f64>, Fault> {
        if !self.binary {
            return self.entries(count, "expected a number");
        }
        let bytes = self.bytes(count.saturating_mul(bits).div_ceil(8), true)?;
        if bits == 1 {
            return Ok((0..count).map(|n| f64::from(bytes[n / 8] >> (7 - n % 8) & 1)).collect());
        }
        Ok(bytes.chunks_exact(bits / 8).map(|bytes| kind.value(bytes, true)).collect())
    }

    /// Texts: a line each with escapes, or in binary their lengths before them.
    fn texts(&mut self, count: usize) -> Result<Vec<String>, Fault> {
        self.line();
        let mut out = Vec::new();
        for n in 0..count {
            if !self.binary {
                let line = self.line().ok_or_else(|| self.fault(format!("{n} texts"), format!("expected {count}")))?;
                out.push(unescape(&line));
                continue;
            }
            // The two upper bits of the first byte state how many bytes the length has: 8, 4, 2 or 1.
            let first = self.bytes.get(self.at).copied().unwrap_or_default();
            let size = [8, 4, 2, 1][usize::from(first >> 6)];
            let head = self.bytes(size, false)?;
            let length = word(head, true) & (u64::MAX >> (66 - 8 * size));
            let text = self.bytes(usize::try_from(length).unwrap_or(usize::MAX), false)?;
            out.push(String::from_utf8_lossy(text).into_owned());
        }
        Ok(out)
    }

    /// Numbers in digits.
    fn entries<N: std::str::FromStr>(&mut self, count: usize, accepted: &str) -> Result<Vec<N>, Fault> {
        let entry = |n: usize| {
            let word = self.word().ok_or_else(|| self.fault(format!("{n} values"), format!("expected {count}")))?;
            word.parse().map_err(|_| self.fault(format!("\"{word}\""), accepted))
        };
        (0..count).map(entry).collect()
    }

    /// The next bytes; those of an array begin on the next line.
    fn bytes(&mut self, count: usize, next_line: bool) -> Result<&'a [u8], Fault> {
        if next_line {
            self.line();
        }
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let bytes =
            rest.get(..count).ok_or_else(|| self.fault(format!("{} bytes are left", rest.len()), format!("expected {count}")))?;
        self.at += count;
        Ok(bytes)
    }
}

/// Replaces `%20` and the like by their characters; other text stays.
fn unescape(text: &str) -> String {
    let bytes = text.as_bytes();
    let (mut out, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let digits = text.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        if let Some(byte) = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            out.push(byte);
            at += 3;
        } else {
            out.push(bytes[at]);
            at += 1;
        }
    }
    String::from_utf8_lossy(&out).into_owned()
}
