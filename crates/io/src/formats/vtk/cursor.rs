//! Reads a legacy VTK file from left to right: words, lines, numbers and texts, in ASCII or big-endian binary.

use std::str::FromStr;

use crate::formats::binary::{NumberType, word};
use willis_core::error::Fault;

/// A type of number.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VtkType {
    /// Bits in binary.
    bits: u32,
    number: NumberType,
}

impl VtkType {
    /// The whole numbers of the cells in files before version 5.1.
    pub(crate) const INT: Self = Self { bits: 32, number: NumberType::Signed };
    /// Bytes.
    pub(crate) const BYTE: Self = Self { bits: 8, number: NumberType::Unsigned };
    /// Real numbers, where only the digits matter.
    pub(crate) const REAL: Self = Self { bits: 32, number: NumberType::Real };

    /// The type of this name, in any case.
    pub(crate) fn named(name: &str) -> Option<Self> {
        use NumberType::{Real, Signed, Unsigned};
        let (bits, number) = match name.to_ascii_lowercase().as_str() {
            "bit" => (1, Unsigned),
            "char" | "signed_char" | "vtktypeint8" => (8, Signed),
            "unsigned_char" | "vtktypeuint8" => (8, Unsigned),
            "short" | "vtktypeint16" => (16, Signed),
            "unsigned_short" | "vtktypeuint16" => (16, Unsigned),
            // VTK writes its ids as int, however wide they are.
            "int" | "vtkidtype" | "vtktypeint32" => (32, Signed),
            "unsigned_int" | "vtktypeuint32" => (32, Unsigned),
            "long" | "long_long" | "vtktypeint64" => (64, Signed),
            "unsigned_long" | "unsigned_long_long" | "vtktypeuint64" => (64, Unsigned),
            "float" => (32, Real),
            "double" => (64, Real),
            _ => return None,
        };
        Some(Self { bits, number })
    }
}

/// A place in the file.
#[derive(Debug, Clone)]
pub(crate) struct VtkCursor<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Whether numbers and texts are binary.
    pub(crate) binary: bool,
    /// What is being read, for messages.
    pub(crate) section: String,
}

impl<'a> VtkCursor<'a> {
    /// At the start of a file.
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        Self { bytes, at: 0, binary: false, section: String::new() }
    }

    /// A fault here: with the line in a file of digits, with the section in a binary one.
    pub(crate) fn fault(&self, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
        let section = if self.section.is_empty() { "the head of the file" } else { &self.section };
        if self.binary {
            return Fault::item(section, found.to_string(), accepted);
        }
        let before = &self.bytes[..self.at.min(self.bytes.len())];
        let line = before.trim_ascii_end().split(|b| *b == b'\n').count();
        Fault::line(line, format!("{section}: {found}"), accepted)
    }

    /// The rest of the line, without its end.
    pub(crate) fn line(&mut self) -> Option<String> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = rest.iter().position(|b| *b == b'\n');
        self.at += end.map_or(rest.len(), |end| end + 1);
        let line = &rest[..end.unwrap_or(rest.len())];
        Some(String::from_utf8_lossy(line.strip_suffix(b"\r").unwrap_or(line)).into_owned())
    }

    /// The next word; `None` at the end of the file.
    pub(crate) fn word(&mut self) -> Option<&'a str> {
        let rest = self.bytes.get(self.at..)?;
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let word = rest[start..].split(u8::is_ascii_whitespace).next()?;
        self.at += start + word.len();
        Some(std::str::from_utf8(word).unwrap_or("\u{fffd}"))
    }

    /// Whether the next word is this one, in any case.
    pub(crate) fn is_next(&self, word: &str) -> bool {
        self.clone().word().is_some_and(|next| next.eq_ignore_ascii_case(word))
    }

    /// The next word, which must be there.
    pub(crate) fn need(&mut self, what: &str) -> Result<&'a str, Fault> {
        self.word().ok_or_else(|| self.fault("the file ends", format!("expected {what}")))
    }

    /// The next word as a count that a file can have.
    pub(crate) fn count(&mut self, what: &str, most: usize) -> Result<usize, Fault> {
        let word = self.need(what)?;
        word.parse()
            .ok()
            .filter(|n| *n <= most)
            .ok_or_else(|| self.fault(format!("\"{word}\""), format!("expected {what}, a count up to {most}")))
    }

    /// Whole numbers.
    pub(crate) fn wholes(&mut self, kind: VtkType, count: usize) -> Result<Vec<i64>, Fault> {
        if self.binary {
            return Ok(self.numbers(kind, count)?.into_iter().map(|x| x as i64).collect());
        }
        self.entries(count, "expected a whole number")
    }

    /// Numbers of any type.
    pub(crate) fn numbers(&mut self, kind: VtkType, count: usize) -> Result<Vec<f64>, Fault> {
        if !self.binary {
            return self.entries(count, "expected a number");
        }
        let bytes = self.bytes(count.saturating_mul(kind.bits as usize).div_ceil(8), true)?;
        if kind.bits == 1 {
            return Ok((0..count).map(|n| f64::from(bytes[n / 8] >> (7 - n % 8) & 1)).collect());
        }
        Ok(bytes.chunks_exact(kind.bits as usize / 8).map(|bytes| kind.number.value(bytes, true)).collect())
    }

    /// Texts: a line each with escapes, or in binary their lengths before them.
    pub(crate) fn texts(&mut self, count: usize) -> Result<Vec<String>, Fault> {
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
    fn entries<N: FromStr>(&mut self, count: usize, accepted: &str) -> Result<Vec<N>, Fault> {
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
pub(crate) fn unescape(text: &str) -> String {
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
