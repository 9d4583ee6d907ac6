//! Tables of text row by row, whichever delimiter, line end and mark at the beginning their program gave them.

use std::collections::HashSet;

use super::number::{counted, number};
use super::write::unplain;
use crate::error::Fault;

/// A table of which the header has been read.
pub(crate) struct Rows<'a> {
    reader: csv::Reader<&'a [u8]>,
    header: Vec<String>,
    record: csv::StringRecord,
    /// The file from its header on.
    text: &'a [u8],
    /// Lines before the header.
    skipped: usize,
    /// Rows read.
    count: usize,
}

/// One row.
pub(crate) struct Row<'a> {
    header: &'a [String],
    fields: &'a csv::StringRecord,
    /// Its line, counted from 1.
    pub(crate) line: usize,
    /// Its number, counted from 0.
    pub(crate) number: usize,
}

/// The delimiter that a header line uses most of comma, semicolon and tab.
pub(crate) fn delimiter(header: &str) -> char {
    let count = |delimiter: char| header.matches(delimiter).count();
    [',', ';', '\t'].into_iter().rev().max_by_key(|d| count(*d)).unwrap_or(',')
}

/// A header in a message, however many columns it has.
pub(crate) fn columns(header: &[String]) -> String {
    const MOST: usize = 8;
    let (shown, more) = (header[..header.len().min(MOST)].join(","), header.len().saturating_sub(MOST));
    if more == 0 { format!("columns {shown}") } else { format!("columns {shown} and {more} more") }
}

/// A table whose lines of comments (`#`) are empty, so that every line keeps its number.
pub(crate) fn uncommented(bytes: &[u8]) -> Vec<u8> {
    let is_comment = |line: &[u8]| line.trim_ascii_start().starts_with(b"#");
    bytes.split_inclusive(|b| *b == b'\n').flat_map(|line| if is_comment(line) { b"\n" } else { line }).copied().collect()
}

impl<'a> Rows<'a> {
    /// Reads the header: the first line that is neither empty nor a comment (`#`).
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::with(bytes, false)
    }

    /// The same of a table whose rows may have more or fewer columns than its header.
    pub(crate) fn ragged(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::with(bytes, true)
    }

    fn with(bytes: &'a [u8], ragged: bool) -> Result<Self, Fault> {
        if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
            return Err(Fault::file("the text is UTF-16", "expected UTF-8; save it so"));
        }
        let (mut rest, mut skipped) = (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), 0);
        let first = loop {
            let end = rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len());
            let line = rest[..end].trim_ascii();
            if !line.is_empty() && !line.starts_with(b"#") {
                break line;
            }
            if end == rest.len() {
                return Err(Fault::file("the table is empty", "expected a header and rows"));
            }
            (rest, skipped) = (&rest[end + 1..], skipped + 1);
        };
        let delimiter = delimiter(&String::from_utf8_lossy(first)) as u8;
        let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).flexible(ragged).trim(csv::Trim::All).from_reader(rest);
        let header: Vec<String> = reader.headers().map_err(|e| fault(&e, rest, skipped))?.iter().map(str::to_owned).collect();
        let mut seen = HashSet::new();
        if let Some(twice) = header.iter().find(|name| !name.is_empty() && !seen.insert(name.as_str())) {
            return Err(Fault::line(skipped + 1, format!("column \"{twice}\" comes twice"), "expected every column once"));
        }
        Ok(Self { reader, header, record: csv::StringRecord::new(), text: rest, skipped, count: 0 })
    }

    /// The names of the columns.
    pub(crate) fn header(&self) -> &[String] {
        &self.header
    }

    /// The first of the names that the header has, in whatever case.
    pub(crate) fn find(&self, names: &[&str]) -> Option<usize> {
        names.iter().find_map(|name| self.header.iter().position(|column| column.eq_ignore_ascii_case(name)))
    }

    /// The first of the names that the header has, in whatever case; `what` says what they are for.
    pub(crate) fn column(&self, names: &[&str], what: &str) -> Result<usize, Fault> {
        let accepted = || format!("expected {what}: a column {}", names.join(" or "));
        self.find(names).ok_or_else(|| Fault::line(self.skipped + 1, columns(&self.header), accepted()))
    }

    /// The line of the header.
    pub(crate) fn header_line(&self) -> usize {
        self.skipped + 1
    }

    /// The next row.
    pub(crate) fn next(&mut self) -> Result<Option<Row<'_>>, Fault> {
        if !self.reader.read_record(&mut self.record).map_err(|e| fault(&e, self.text, self.skipped))? {
            return Ok(None);
        }
        self.count += 1;
        let line = self.record.position().map_or(0, |p| line_of(p, self.text)) + self.skipped;
        Ok(Some(Row { header: &self.header, fields: &self.record, line, number: self.count - 1 }))
    }
}

impl Row<'_> {
    /// The name of a column.
    pub(crate) fn name(&self, column: usize) -> &str {
        &self.header[column]
    }

    /// The text of a column; empty where the row has none.
    pub(crate) fn text(&self, column: usize) -> &str {
        unplain(self.fields.get(column).unwrap_or_default())
    }

    /// Texts that are not empty, with their columns.
    pub(crate) fn texts(&self) -> impl Iterator<Item = (usize, &str)> {
        self.fields.iter().map(unplain).enumerate().filter(|(_, text)| !text.is_empty())
    }

    /// The number in a column; NaN for an empty one.
    pub(crate) fn real(&self, column: usize) -> Result<f64, Fault> {
        let text = self.text(column);
        if text.is_empty() {
            return Ok(f64::NAN);
        }
        number(text).map_err(|accepted| Fault::line(self.line, format!("{} \"{text}\"", self.header[column]), accepted))
    }

    /// The finite numbers in three columns.
    pub(crate) fn position(&self, columns: [usize; 3]) -> Result<[f64; 3], Fault> {
        let mut position = [0.0; 3];
        for (x, column) in position.iter_mut().zip(columns) {
            *x = self.finite(column)?;
        }
        Ok(position)
    }

    /// The finite number in a column.
    pub(crate) fn finite(&self, column: usize) -> Result<f64, Fault> {
        let found = || format!("{} \"{}\"", self.header[column], self.text(column));
        let number = Some(self.real(column)?).filter(|x| x.is_finite());
        number.ok_or_else(|| Fault::line(self.line, found(), "expected a finite number"))
    }
}

/// The line on which a record begins. The reader of CSV takes a record to begin before the line ends that it skips.
fn line_of(position: &csv::Position, text: &[u8]) -> usize {
    let rest = text.get(position.byte() as usize..).unwrap_or_default();
    let skipped = rest.iter().take_while(|b| matches!(b, b'\r' | b'\n'));
    position.line() as usize + skipped.filter(|b| **b == b'\n').count()
}

fn fault(error: &csv::Error, text: &[u8], skipped: usize) -> Fault {
    let line = error.position().map_or(1, |p| line_of(p, text)) + skipped;
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            Fault::line(line, counted(*len as usize, "column"), format!("expected {expected_len}, as in the header"))
        }
        csv::ErrorKind::Utf8 { err, .. } => {
            Fault::line(line, format!("column {} is not UTF-8", err.field() + 1), "expected UTF-8 text")
        }
        _ => Fault::line(line, format!("not CSV: {error}"), "expected comma-separated values"),
    }
}
