//! One VTK data array as numbers, whatever its type and encoding.

use roxmltree::Node as Element;

use super::block::{Encoding, Source};
use crate::error::Fault;

/// What the arrays of a file share.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arrays<'a> {
    pub(super) encoding: Encoding,
    /// The appended data, after its underscore.
    pub(super) appended: Option<Source<'a>>,
}

/// The numbers of an array.
enum Numbers {
    Real(Vec<f64>),
    Whole(Vec<i64>),
}

const TYPES: &str = "expected Int8 to Int64, UInt8 to UInt64, Float32 or Float64";

impl Arrays<'_> {
    /// The first `count` numbers of an array.
    pub(super) fn reals(&self, array: Element, count: usize) -> Result<Vec<f64>, Fault> {
        Ok(match self.numbers(array, count)? {
            Numbers::Real(values) => values,
            Numbers::Whole(values) => values.into_iter().map(|x| x as f64).collect(),
        })
    }

    /// The first `count` indices of an array.
    pub(super) fn indices(&self, array: Element, count: usize) -> Result<Vec<i64>, Fault> {
        match self.numbers(array, count)? {
            Numbers::Whole(values) => Ok(values),
            Numbers::Real(_) => {
                Err(fault(array, format!("type {}", attribute(array, "type")), "expected a type of whole numbers"))
            }
        }
    }

    fn numbers(&self, array: Element, count: usize) -> Result<Numbers, Fault> {
        let kind = attribute(array, "type");
        let size = match kind {
            "Int8" | "UInt8" => 1,
            "Int16" | "UInt16" => 2,
            "Int32" | "UInt32" | "Float32" => 4,
            "Int64" | "UInt64" | "Float64" => 8,
            _ => return Err(fault(array, format!("type \"{kind}\""), TYPES)),
        };
        let text = || array.children().filter_map(|c| if c.is_text() { c.text() } else { None }).collect::<String>();
        let found = match attribute(array, "format") {
            "ascii" | "" => ascii(array, &text(), kind, count)?,
            "binary" => {
                let text: Vec<u8> = text().bytes().filter(|b| !b.is_ascii_whitespace()).collect();
                self.binary(array, Source::Base64(&text), kind, size, count)?
            }
            "appended" => {
                let offset = attribute(array, "offset").trim();
                let beyond = || fault(array, format!("offset \"{offset}\""), "expected a place in the <AppendedData>");
                let start: usize = offset.parse().map_err(|_| beyond())?;
                let source = match self.appended {
                    Some(Source::Raw(bytes)) => bytes.get(start..).map(Source::Raw),
                    Some(Source::Base64(bytes)) => bytes.get(start..).map(Source::Base64),
                    None => None,
                };
                self.binary(array, source.ok_or_else(beyond)?, kind, size, count)?
            }
            other => return Err(fault(array, format!("format \"{other}\""), "expected ascii, binary or appended")),
        };
        let length = match &found {
            Numbers::Real(values) => values.len(),
            Numbers::Whole(values) => values.len(),
        };
        if length == count { Ok(found) } else { Err(fault(array, format!("{length} values"), format!("expected {count}"))) }
    }

    fn binary(&self, array: Element, source: Source, kind: &str, size: usize, count: usize) -> Result<Numbers, Fault> {
        let bytes = (self.encoding.bytes(source, count.saturating_mul(size)))
            .map_err(|found| fault(array, found, format!("expected {count} values of {size} bytes")))?;
        let mut numbers = bytes.chunks_exact(size).map(|chunk| {
            let mut word = [0_u8; 8];
            for (place, byte) in chunk.iter().enumerate() {
                word[if self.encoding.little { place } else { size - 1 - place }] = *byte;
            }
            u64::from_le_bytes(word)
        });
        // Shifting up and down again carries the sign of a shorter number.
        let unused = 64 - 8 * size as u32;
        Ok(match kind {
            "Float32" => Numbers::Real(numbers.map(|w| f64::from(f32::from_bits(w as u32))).collect()),
            "Float64" => Numbers::Real(numbers.map(f64::from_bits).collect()),
            _ if kind.starts_with('I') => Numbers::Whole(numbers.map(|w| ((w << unused) as i64) >> unused).collect()),
            _ => match numbers.try_fold(Vec::new(), |mut all, w| {
                all.push(i64::try_from(w).ok()?);
                Some(all)
            }) {
                Some(values) => Numbers::Whole(values),
                None => return Err(fault(array, "a whole number above 2^63 - 1", "expected a smaller one")),
            },
        })
    }
}

fn ascii(array: Element, text: &str, kind: &str, count: usize) -> Result<Numbers, Fault> {
    let wrong = |word: &str| fault(array, format!("value \"{word}\""), format!("expected {count} numbers of type {kind}"));
    let words = text.split_ascii_whitespace().take(count);
    if kind == "Float32" {
        let single = |w: &str| w.parse().map(|x: f32| f64::from(x)).map_err(|_| wrong(w));
        return words.map(single).collect::<Result<_, _>>().map(Numbers::Real);
    }
    if kind.starts_with('F') {
        return words.map(|w| w.parse().map_err(|_| wrong(w))).collect::<Result<_, _>>().map(Numbers::Real);
    }
    words.map(|w| w.parse().map_err(|_| wrong(w))).collect::<Result<_, _>>().map(Numbers::Whole)
}

/// An attribute of an element; empty when it has none.
pub(super) fn attribute<'a>(element: Element<'a, '_>, name: &str) -> &'a str {
    element.attribute(name).unwrap_or_default()
}

fn fault(array: Element, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
    let within = array.parent().map_or("", |parent| parent.tag_name().name());
    Fault::item(format!("array \"{}\" of {within}", attribute(array, "Name").trim()), found.to_string(), accepted)
}
