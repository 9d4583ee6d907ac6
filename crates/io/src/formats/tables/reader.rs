//! Reads tables of text row by row, whichever delimiter, line end and number format their program chose.

use super::write::unescape_formula;
use crate::formats::{ensure, input::refuse_utf16, input::without_mark};
use willis_core::{error::Fault, network::Scale, support::geometry::Point};

/// Whether a text states that there is no value: it is empty, NaN, or what R, pandas and BIDS write.
///
/// One rule for the attributes of all formats of text, and for cells: where this is so, nothing is stated.
pub(crate) fn is_missing(text: &str) -> bool {
    let word = text.strip_prefix(['-', '+']).unwrap_or(text);
    text.is_empty() || word.eq_ignore_ascii_case("nan") || ["NA", "N/A", "n/a", "<NA>"].contains(&text)
}

/// A reader of a table whose header has been read.
pub struct TableReader<'a> {
    reader: csv::Reader<&'a [u8]>,
    /// The names of the columns.
    pub(crate) header: Vec<String>,
    record: csv::StringRecord,
    /// The file from its header on.
    text: &'a [u8],
    /// The line of the header.
    pub header_line: usize,
    /// Rows read so far.
    count: usize,
}

/// One row.
pub struct Row<'a> {
    /// The names of the columns.
    pub(crate) header: &'a [String],
    fields: &'a csv::StringRecord,
    /// Its line, counted from 1.
    pub line: usize,
    /// Its number, counted from 0.
    pub(crate) number: usize,
}

/// The delimiter of a table: whichever of comma, semicolon and tab its header uses most.
pub(crate) fn delimiter(header: &str) -> char {
    let count = |delimiter: char| header.matches(delimiter).count();
    [',', ';', '\t'].into_iter().rev().max_by_key(|d| count(*d)).unwrap_or(',')
}

/// The header as text for a message, shortened where it is long.
pub(crate) fn columns(header: &[String]) -> String {
    const MOST: usize = 8;
    let (shown, more) = (header[..header.len().min(MOST)].join(","), header.len().saturating_sub(MOST));
    if more == 0 { format!("columns {shown}") } else { format!("columns {shown} and {more} more") }
}

/// The table with comment lines (`#`) emptied, so that every line keeps its number.
pub(crate) fn uncommented(bytes: &[u8]) -> Vec<u8> {
    let is_comment = |line: &[u8]| line.trim_ascii_start().starts_with(b"#");
    let emptied = |line| if is_comment(line) { &line[line.trim_ascii_end().len()..] } else { line };
    bytes.split_inclusive(|b| matches!(b, b'\r' | b'\n')).flat_map(emptied).copied().collect()
}

impl<'a> TableReader<'a> {
    /// Reads the header: the first line that is neither empty nor a comment (`#`).
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::with(bytes, false)
    }

    /// As `open`, for a table whose rows may have more or fewer columns than its header.
    ///
    /// # Errors
    ///
    /// No header, or one with a column twice.
    pub fn ragged(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::with(bytes, true)
    }

    fn with(bytes: &'a [u8], ragged: bool) -> Result<Self, Fault> {
        refuse_utf16(bytes)?;
        let (mut rest, mut line) = (without_mark(bytes), 1);
        let first = loop {
            // Old programs end a line with a carriage return alone.
            let end = rest.iter().position(|b| matches!(b, b'\r' | b'\n')).unwrap_or(rest.len());
            let text = rest[..end].trim_ascii();
            if !text.is_empty() && !text.starts_with(b"#") {
                break text;
            }
            ensure(end < rest.len(), || Fault::file("the table is empty", "expected a header and rows"))?;
            let ending = if rest[end..].starts_with(b"\r\n") { 2 } else { 1 };
            (rest, line) = (&rest[end + ending..], line + 1);
        };
        let delimiter = delimiter(&String::from_utf8_lossy(first)) as u8;
        let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).flexible(ragged).trim(csv::Trim::All).from_reader(rest);
        let names = reader.headers().map_err(|e| fault(&e, rest, line))?;
        let header: Vec<String> = names.iter().map(|name| unescape_formula(name).to_owned()).collect();
        let mut seen = std::collections::HashSet::new();
        if let Some(twice) = header.iter().find(|name| !name.is_empty() && !seen.insert(name.as_str())) {
            return Err(Fault::line(line, format!("column \"{twice}\" comes twice"), "expected every column once"));
        }
        Ok(Self { reader, header, record: csv::StringRecord::new(), text: rest, header_line: line, count: 0 })
    }

    /// The column with the first of these names that the header has, in any case.
    pub fn find(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.header.iter().position(|column| column.eq_ignore_ascii_case(name)))
    }

    /// As [`Self::find`], for a column that must be there; `what` describes its content for the error.
    pub(crate) fn column(&self, names: &[&str], what: &str) -> Result<usize, Fault> {
        let accepted = || format!("expected {what}: a column {}", names.join(" or "));
        self.find(names).ok_or_else(|| Fault::line(self.header_line, columns(&self.header), accepted()))
    }

    /// The same for several columns.
    pub(crate) fn columns<const N: usize>(&self, names: [&[&str]; N], what: &str) -> Result<[usize; N], Fault> {
        let mut found = [0; N];
        for (column, names) in found.iter_mut().zip(names) {
            *column = self.column(names, what)?;
        }
        Ok(found)
    }

    /// The next row.
    ///
    /// # Errors
    ///
    /// A row with another number of columns than the header, or that is not UTF-8.
    pub fn row(&mut self) -> Result<Option<Row<'_>>, Fault> {
        if !self.reader.read_record(&mut self.record).map_err(|e| fault(&e, self.text, self.header_line))? {
            return Ok(None);
        }
        self.count += 1;
        let line = self.record.position().map_or(0, |p| line_of(p, self.text)) + self.header_line - 1;
        Ok(Some(Row { header: &self.header, fields: &self.record, line, number: self.count - 1 }))
    }
}

impl Row<'_> {
    /// The text of a column; empty where the row has none, or a missing value.
    pub fn text(&self, column: usize) -> &str {
        Some(self.written(column)).filter(|text| !is_missing(text)).unwrap_or_default()
    }

    /// The words of a person in a column, where NA may be initials; empty where the row has none.
    pub(crate) fn written(&self, column: usize) -> &str {
        unescape_formula(self.fields.get(column).unwrap_or_default())
    }

    /// Texts that are not empty, with their columns.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (usize, &str)> {
        self.fields.iter().map(unescape_formula).enumerate().filter(|(_, text)| !text.is_empty())
    }

    /// The number in a column; NaN for a missing one.
    ///
    /// # Errors
    ///
    /// What is no finite number.
    pub fn real(&self, column: usize) -> Result<f64, Fault> {
        let text = self.text(column);
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        let wrong = |accepted| Fault::line(self.line, format!("{} \"{text}\"", self.header[column]), accepted);
        let found = number(text).map_err(wrong)?;
        if found.is_finite() { Ok(found) } else { Err(wrong("expected a finite number")) }
    }

    /// The finite numbers in three columns.
    pub(crate) fn position(&self, columns: [usize; 3]) -> Result<[f64; 3], Fault> {
        let [x, y, z] = columns;
        Ok([self.finite(x)?, self.finite(y)?, self.finite(z)?])
    }

    /// The finite number in a column.
    pub(crate) fn finite(&self, column: usize) -> Result<f64, Fault> {
        let found = || format!("{} \"{}\"", self.header[column], self.fields.get(column).unwrap_or_default());
        let number = Some(self.real(column)?).filter(|x| x.is_finite());
        number.ok_or_else(|| Fault::line(self.line, found(), "expected a finite number"))
    }

    /// The length in a column, m; NaN for an empty one.
    pub(crate) fn length(&self, column: usize, scale: &Scale) -> Result<f64, Fault> {
        Ok(self.scale(column, scale).length(self.real(column)?))
    }

    /// The finite position in three columns, m.
    pub(crate) fn point(&self, columns: [usize; 3], scale: &Scale) -> Result<Point, Fault> {
        let position = self.position(columns)?;
        Ok([0, 1, 2].map(|axis| self.scale(columns[axis], scale).position(position)[axis]))
    }

    fn scale(&self, column: usize, scale: &Scale) -> Scale {
        if self.header[column].to_ascii_lowercase().ends_with("_mm") { Scale::default() } else { *scale }
    }
}

/// The line on which a record begins. The CSV reader counts the line ends that it skips before a record as part of it.
fn line_of(position: &csv::Position, text: &[u8]) -> usize {
    let rest = text.get(position.byte() as usize..).unwrap_or_default();
    let skipped = rest.iter().take_while(|b| matches!(b, b'\r' | b'\n'));
    position.line() as usize + skipped.filter(|b| **b == b'\n').count()
}

fn fault(error: &csv::Error, text: &[u8], header_line: usize) -> Fault {
    let line = error.position().map_or(1, |p| line_of(p, text)) + header_line - 1;
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            Fault::line(line, plural(*len as usize, "column"), format!("expected {expected_len}, as in the header"))
        }
        csv::ErrorKind::Utf8 { err, .. } => {
            Fault::line(line, format!("column {} is not UTF-8", err.field() + 1), "expected UTF-8 text")
        }
        _ => Fault::line(line, format!("not CSV: {error}"), "expected comma-separated values"),
    }
}

/// Reads a number, decimal or in the hexadecimal form that C prints and graph-tool writes.
///
/// # Errors
///
/// The accepted form.
pub fn number(text: &str) -> Result<f64, &'static str> {
    if let Some(x) = text.parse().ok().or_else(|| hexadecimal(text)) {
        return Ok(x);
    }
    match text.replacen(',', ".", 1).parse::<f64>() {
        Ok(_) if text.contains(',') => Err("expected a decimal point, not a comma"),
        _ => Err("expected a number"),
    }
}

/// A count with its noun: "1 edge", "2 edges".
pub fn plural(n: usize, noun: &str) -> String {
    format!("{n} {noun}{}", if n == 1 { "" } else { "s" })
}

/// A note on things of which there is one at least: "2 edges without length".
pub(crate) fn counted(n: usize, noun: &str, what: &str) -> Option<String> {
    (n > 0).then(|| format!("{} {what}", plural(n, noun)))
}

/// A note on each of several things of which there is one at least: "points left out: 2".
pub(crate) fn listed<const N: usize>(counts: [(usize, &str); N]) -> impl Iterator<Item = String> {
    counts.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{what}: {n}"))
}

/// `[-]0xH.HHHp[+-]D`: the significand in hexadecimal digits, times a power of two.
fn hexadecimal(text: &str) -> Option<f64> {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    let (significand, exponent) = digits.split_once(['p', 'P'])?;
    let (whole, fraction) = significand.split_once('.').unwrap_or((significand, ""));
    let all = format!("{whole}{fraction}");
    let plain = all.bytes().all(|b| b.is_ascii_hexdigit()) && all.len() <= 15;
    let value = if plain { u64::from_str_radix(&all, 16).ok()? } else { return None };
    let power = exponent.parse::<i32>().ok().filter(|e| e.abs() < 5000)? - 4 * fraction.len() as i32;
    // In two steps, so that no intermediate power is out of range.
    Some(sign * value as f64 * 2_f64.powi(power / 2) * 2_f64.powi(power - power / 2))
}
