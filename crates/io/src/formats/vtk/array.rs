//! One VTK XML data array as numbers: every type, ASCII, base64 or raw, compressed by zlib or not.

use std::borrow::Cow;
use std::io::Read;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};

use crate::formats::binary::{NumberType, word};
use crate::formats::input::UnpackLimit;
use crate::formats::vtk::polydata::LIMIT;
use crate::formats::xml::Element;
use willis_core::error::Fault;

/// What the arrays of a file share.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Arrays<'a> {
    /// Whether the least significant byte comes first.
    pub(crate) little: bool,
    /// The bytes of a header word: 4 or 8.
    pub(crate) word: usize,
    /// What compresses the arrays that are not written in digits.
    pub(crate) compressor: &'a str,
    /// The appended data, after its underscore.
    pub(crate) appended: Option<Source<'a>>,
    /// What they may unpack to, all together.
    pub(crate) room: &'a UnpackLimit,
}

const ZLIB: &str = "vtkZLibDataCompressor";
const TYPES: &str = "expected Int8 to Int64, UInt8 to UInt64, Float32 or Float64";

impl Arrays<'_> {
    /// The first `count` numbers of an array.
    pub(crate) fn reals(&self, array: &Element, count: usize) -> Result<Vec<f64>, Fault> {
        let (kind, size) = number_type(array)?;
        let found = if is_ascii(array) {
            ascii(array, (kind, size), count)?
        } else {
            let bytes = self.bytes(array, count.saturating_mul(size), format!("expected {count} values of {size} bytes"))?;
            let values = bytes.chunks_exact(size);
            if kind == NumberType::Unsigned && values.clone().any(|bytes| i64::try_from(word(bytes, !self.little)).is_err()) {
                return Err(fault(array, "a whole number above 2^63 - 1", "expected a smaller one"));
            }
            values.map(|bytes| kind.value(bytes, !self.little)).collect()
        };
        let other = || fault(array, format!("{} values", found.len()), format!("expected {count}"));
        if found.len() == count { Ok(found) } else { Err(other()) }
    }

    /// The first `count` indices of an array.
    pub(crate) fn indices(&self, array: &Element, count: usize) -> Result<Vec<i64>, Fault> {
        let found = self.reals(array, count)?;
        if number_type(array)?.0 == NumberType::Real {
            return Err(fault(array, format!("type {}", array.attribute("type")), "expected a type of whole numbers"));
        }
        Ok(found.into_iter().map(|x| x as i64).collect())
    }

    /// The first `count` texts of an array; each ends with a zero byte.
    pub(crate) fn texts(&self, array: &Element, count: usize) -> Result<Vec<String>, Fault> {
        let accepted = || format!("expected {count} texts");
        let bytes = if is_ascii(array) {
            let wrong = |word: &str| fault(array, format!("value \"{word}\""), "expected the codes of characters");
            let codes = &array.text;
            // Programs with signed characters write those above 127 below zero.
            let code = |w: &str| w.parse().ok().filter(|c: &i16| (-128..256).contains(c)).map(|c| c as u8);
            codes.split_ascii_whitespace().map(|w| code(w).ok_or_else(|| wrong(w))).collect::<Result<_, _>>()?
        } else {
            self.bytes(array, LIMIT, accepted())?
        };
        let mut texts: Vec<String> = bytes.split(|b| *b == 0).map(|text| String::from_utf8_lossy(text).into_owned()).collect();
        // What follows the last zero byte is nothing.
        texts.pop();
        if texts.len() < count {
            return Err(fault(array, format!("{} texts", texts.len()), accepted()));
        }
        texts.truncate(count);
        Ok(texts)
    }

    /// The first `limit` bytes of an array that is not written in digits.
    fn bytes(&self, array: &Element, limit: usize, accepted: String) -> Result<Vec<u8>, Fault> {
        if !["", ZLIB].contains(&self.compressor) {
            let accepted =
                "expected vtkZLibDataCompressor or none: save it with SetCompressorTypeToZLib() in VTK, or ZLib in ParaView";
            return Err(Fault::file(format!("compressor {}", self.compressor), accepted));
        }
        let own;
        let source = match array.attribute("format") {
            "binary" => {
                own = array.text.bytes().filter(|b| !b.is_ascii_whitespace()).collect::<Vec<u8>>();
                Some(Source::Base64(&own))
            }
            "appended" => {
                let start = array.attribute("offset").trim().parse().unwrap_or(usize::MAX);
                match self.appended {
                    Some(Source::Raw(bytes)) => bytes.get(start..).map(Source::Raw),
                    Some(Source::Base64(bytes)) => bytes.get(start..).map(Source::Base64),
                    None => None,
                }
            }
            other => return Err(fault(array, format!("format \"{other}\""), "expected ascii, binary or appended")),
        };
        let source = source.ok_or_else(|| {
            let offset = array.attribute("offset").trim();
            fault(array, format!("offset \"{offset}\""), "expected a place in the <AppendedData>")
        })?;
        let most = limit.min(self.room.left().saturating_add(1));
        let bytes = self.decode(source, most).map_err(|found| fault(array, found, accepted))?.into_owned();
        self.room.take(bytes.len()).map_err(|(found, accepted)| fault(array, found, accepted))?;
        Ok(bytes)
    }
}

/// The type of an array's numbers and the bytes of each.
fn number_type(array: &Element) -> Result<(NumberType, usize), Fault> {
    Ok(match array.attribute("type") {
        "Int8" => (NumberType::Signed, 1),
        "Int16" => (NumberType::Signed, 2),
        "Int32" => (NumberType::Signed, 4),
        "Int64" => (NumberType::Signed, 8),
        "UInt8" => (NumberType::Unsigned, 1),
        "UInt16" => (NumberType::Unsigned, 2),
        "UInt32" => (NumberType::Unsigned, 4),
        "UInt64" => (NumberType::Unsigned, 8),
        "Float32" => (NumberType::Real, 4),
        "Float64" => (NumberType::Real, 8),
        name => return Err(fault(array, format!("type \"{name}\""), TYPES)),
    })
}

fn is_ascii(array: &Element) -> bool {
    matches!(array.attribute("format"), "ascii" | "")
}

fn ascii(array: &Element, kind: (NumberType, usize), count: usize) -> Result<Vec<f64>, Fault> {
    let number = |word: &str| match kind {
        (NumberType::Real, 4) => word.parse().ok().map(|x: f32| f64::from(x)),
        (NumberType::Real, _) => word.parse().ok(),
        _ => word.parse().ok().map(|x: i64| x as f64),
    };
    let accepted = || format!("expected {count} numbers of type {}", array.attribute("type"));
    let read = |word: &str| number(word).ok_or_else(|| fault(array, format!("value \"{word}\""), accepted()));
    array.text.split_ascii_whitespace().take(count).map(read).collect()
}

fn fault(array: &Element, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
    Fault::item(format!("array \"{}\" of {}", array.attribute("Name").trim(), array.within), found.to_string(), accepted)
}

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// Encoded bytes, from the start of an array on.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source<'a> {
    /// As they are.
    Raw(&'a [u8]),
    /// In base64.
    Base64(&'a [u8]),
}

impl<'a> Source<'a> {
    /// The next `count` bytes, which were encoded together.
    fn take(&mut self, count: usize) -> Result<Cow<'a, [u8]>, String> {
        let short = |has: usize| format!("{has} bytes where {count} should be");
        match self {
            Self::Raw(rest) => {
                let (now, later) = rest.split_at_checked(count).ok_or_else(|| short(rest.len()))?;
                *rest = later;
                Ok(Cow::Borrowed(now))
            }
            Self::Base64(rest) => {
                let characters = count.div_ceil(3).saturating_mul(4);
                let (now, later) = rest.split_at_checked(characters).ok_or_else(|| short(rest.len() / 4 * 3))?;
                let mut bytes = BASE64.decode(now).map_err(|e| format!("not base64: {e}"))?;
                if bytes.len() < count {
                    return Err(short(bytes.len()));
                }
                bytes.truncate(count);
                *rest = later;
                Ok(Cow::Owned(bytes))
            }
        }
    }

    /// Whether the base64 text is padded within the characters of the first `count` bytes, so that these were encoded separately.
    fn is_padded(&self, count: usize) -> bool {
        match self {
            Self::Raw(_) => true,
            Self::Base64(rest) => {
                let padding = rest.iter().take(count.div_ceil(3) * 4).filter(|b| **b == b'=').count();
                padding == count.div_ceil(3) * 3 - count
            }
        }
    }
}

impl Arrays<'_> {
    /// The bytes of an array, the first `limit` of them: some programs write more values than there are points.
    fn decode<'s>(&self, mut source: Source<'s>, limit: usize) -> Result<Cow<'s, [u8]>, String> {
        if self.compressor == ZLIB { self.inflate(source, limit) } else { self.plain(&mut source, limit) }
    }

    fn plain<'a>(&self, source: &mut Source<'a>, limit: usize) -> Result<Cow<'a, [u8]>, String> {
        let separate = source.is_padded(self.word);
        let mut ahead = *source;
        let count = self.words(&ahead.take(self.word)?)[0];
        let count = usize::try_from(count).map_or(limit, |count| count.min(limit));
        if separate {
            return ahead.take(count);
        }
        // Header and data were encoded together.
        let mut both = source.take(self.word + count)?.into_owned();
        both.drain(..self.word);
        Ok(Cow::Owned(both))
    }

    fn inflate<'s>(&self, mut source: Source<'s>, limit: usize) -> Result<Cow<'s, [u8]>, String> {
        let mut ahead = source;
        let blocks = self.words(&ahead.take(self.word)?)[0];
        if blocks == 0 {
            return Ok(Cow::Borrowed(&[]));
        }
        let header = usize::try_from(blocks).ok().and_then(|n| n.checked_add(3)?.checked_mul(self.word));
        let header = source.take(header.ok_or_else(|| format!("{blocks} blocks announced"))?)?;
        let words = self.words(&header);
        let [_, size, last, packed @ ..] = &words[..] else { return Err("a header without sizes".into()) };
        let (size, last) = (*size, *last);
        let total = packed.iter().try_fold(0_usize, |sum, n| sum.checked_add(usize::try_from(*n).ok()?));
        let data = source.take(total.ok_or("compressed blocks too large")?)?;
        let mut rest = &data[..];
        let mut out = Vec::new();
        for (n, count) in packed.iter().enumerate() {
            let (block, later) = rest.split_at_checked(*count as usize).ok_or("blocks run over the data")?;
            rest = later;
            let expected = if n + 1 == packed.len() && last > 0 { last } else { size };
            let (before, room) = (out.len(), limit - out.len());
            // One byte more than announced shows a block that is too long without unpacking all of it.
            let most = expected.saturating_add(1).min(room as u64);
            (flate2::read::ZlibDecoder::new(block).take(most).read_to_end(&mut out))
                .map_err(|e| format!("zlib block {n}: {e}"))?;
            if ((out.len() - before) as u64) < most.min(expected) || (out.len() - before) as u64 > expected {
                return Err(format!("zlib block {n} does not hold the {expected} bytes announced"));
            }
            if out.len() == limit {
                break;
            }
        }
        Ok(Cow::Owned(out))
    }

    fn words(&self, bytes: &[u8]) -> Vec<u64> {
        bytes.chunks_exact(self.word).map(|bytes| word(bytes, !self.little)).collect()
    }
}
