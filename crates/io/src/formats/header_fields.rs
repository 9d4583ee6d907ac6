//! The lines of a header that is text, and its fields, each with the line that it stands on.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use willis_core::error::{Fault, Result};

/// How many characters of a wrong line an error shows.
const SHOWN: usize = 40;

/// A place in a file that mixes lines and binary data.
pub(super) struct HeaderLines<'a> {
    /// The bytes that are left.
    pub(super) rest: &'a [u8],
    line: usize,
}

impl<'a> HeaderLines<'a> {
    /// At the start of a file.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self { rest: bytes, line: 1 }
    }

    /// The next line without blanks around it, and its number; the place stays before it.
    pub(super) fn peek(&self) -> Option<(usize, &'a [u8])> {
        Self { rest: self.rest, line: self.line }.line()
    }

    /// The next line, and its number.
    pub(super) fn line(&mut self) -> Option<(usize, &'a [u8])> {
        if self.rest.is_empty() {
            return None;
        }
        let mut parts = self.rest.splitn(2, |b| *b == b'\n');
        let text = parts.next().unwrap_or_default();
        self.rest = parts.next().unwrap_or_default();
        self.line += 1;
        Some((self.line - 1, text.trim_ascii()))
    }

    /// The next line `key = value` that is not empty, with its number, as MetaIO writes them.
    pub(super) fn entry(&mut self) -> Result<Option<(usize, String, String)>, Fault> {
        while let Some((line, text)) = self.line() {
            let text = String::from_utf8_lossy(text);
            match text.split_once('=').map(|(key, value)| (key.trim(), value.trim())) {
                Some((key, value)) if !key.is_empty() => return Ok(Some((line, key.to_owned(), value.to_owned()))),
                _ if text.is_empty() => {}
                _ => return Err(Fault::line(line, format!("\"{}\"", shown(&text)), "expected a line Key = value")),
            }
        }
        Ok(None)
    }

    /// The next bytes, or how many there are when these are fewer.
    pub(super) fn bytes(&mut self, count: usize) -> Result<&'a [u8], usize> {
        let (taken, rest) = self.rest.split_at_checked(count).ok_or(self.rest.len())?;
        self.line += taken.split(|b| *b == b'\n').count() - 1;
        self.rest = rest;
        Ok(taken)
    }
}

/// The beginning of a text, fit for one line of an error.
pub(super) fn shown(text: &str) -> String {
    text.chars().take(SHOWN).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect()
}

/// The numbers of a field, where it is there.
type Numbers<N> = Result<Option<Vec<N>>, Fault>;

/// The fields by name.
#[derive(Default)]
pub(super) struct HeaderFields {
    /// Whether blanks and capitals in a name do not count.
    pub(super) is_loose: bool,
    fields: std::collections::HashMap<String, (usize, String)>,
}

impl HeaderFields {
    /// What counts of a name.
    fn plain(&self, name: &str) -> String {
        let counts = name.chars().filter(|c| !(self.is_loose && c.is_whitespace()));
        counts.map(|c| if self.is_loose { c.to_ascii_lowercase() } else { c }).collect()
    }

    /// Adds a field in place of an earlier one of its name.
    pub(super) fn insert(&mut self, name: &str, line: usize, value: &str) {
        self.fields.insert(self.plain(name), (line, value.to_owned()));
    }

    /// The line and the text of a field.
    pub(super) fn get(&self, name: &str) -> Option<(usize, &str)> {
        self.fields.get(&self.plain(name)).map(|(line, value)| (*line, value.as_str()))
    }

    /// The same of a field that must be there.
    pub(super) fn needed(&self, name: &str) -> Result<(usize, &str), Fault> {
        self.get(name).ok_or_else(|| self.wrong(name, "expected it in the header"))
    }

    /// The file in the folder of `path` that a field names, if it names one.
    pub(super) fn file(&self, path: &Path, name: &str) -> Option<PathBuf> {
        let (_, file) = self.get(name)?;
        let is_list = file.starts_with("LIST") || file.starts_with("SKIPLIST") || file.contains('%');
        super::input::beside(path, file).filter(|_| !is_list)
    }

    /// The same of a field that has to name one, and its bytes, at most so many; `accepted` describes the field for the error.
    pub(super) fn file_bytes(&self, path: &Path, name: &str, most: u64, accepted: &str) -> Result<(PathBuf, Vec<u8>)> {
        let file = self.file(path, name).ok_or_else(|| self.wrong(name, accepted).in_file(path))?;
        let bytes = super::input::bytes_beside(&file, most)?;
        Ok((file, bytes))
    }

    /// The fault that a field has another value than `accepted`.
    pub(super) fn wrong(&self, name: &str, accepted: impl Into<String>) -> Fault {
        match self.get(name) {
            Some((line, value)) => Fault::line(line, format!("{name} \"{value}\""), accepted),
            None => Fault::file(format!("no field {name}"), accepted),
        }
    }

    /// A yes or no; no where it is absent. MetaIO looks at the first letter only.
    pub(super) fn is_true(&self, name: &str) -> bool {
        self.get(name).is_some_and(|(_, value)| value.starts_with(['T', 't', '1']))
    }

    /// A whole number; `None` where the field is absent.
    pub(super) fn whole(&self, name: &str) -> Result<Option<i64>, Fault> {
        self.get(name).map(|(_, value)| value.parse().map_err(|_| self.wrong(name, "expected a whole number"))).transpose()
    }

    /// As many numbers as are asked for, of the first of some fields that is there.
    pub(super) fn first_numbers(&self, names: &[&str], count: usize, accepted: &str, admits: fn(&f64) -> bool) -> Numbers<f64> {
        let name = names.iter().find(|name| self.get(name).is_some());
        name.map_or(Ok(None), |name| self.numbers(name, count, accepted, admits))
    }

    /// As many numbers as are asked for that `admits` takes, which `accepted` describes for the error; `None` where the field is absent.
    pub(super) fn numbers<N: FromStr>(&self, name: &str, count: usize, accepted: &str, admits: fn(&N) -> bool) -> Numbers<N> {
        let Some((_, value)) = self.get(name) else { return Ok(None) };
        let numbers: Option<Vec<N>> = value.split_whitespace().map(|word| word.parse().ok().filter(admits)).collect();
        let wrong = || self.wrong(name, format!("expected {count} {accepted}"));
        numbers.filter(|numbers| numbers.len() == count).map(Some).ok_or_else(wrong)
    }
}
