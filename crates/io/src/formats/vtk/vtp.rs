//! Reads the lines and radii of a VTK XML PolyData file (VTP); its data arrays of every type, ASCII, base64 or raw, compressed by zlib or not.

use std::{borrow::Cow, io::Read};

use base64::engine::{DecodePaddingMode, Engine, GeneralPurpose, GeneralPurposeConfig};

use crate::formats::vtk::polydata::{ArrayValues, LIMIT, NamedValues, PolyData, centerlines, check_cells, is_wanted};
use crate::formats::xml::Element;
use crate::formats::{Centerlines, Fault, Frame, NumberType, ReadOptions, UnpackLimit, ensure, find, word};

/// Reads the polylines of all pieces with the radius of each point; returns also notes for the user.
///
/// Points keep their row as id; those on no line are left out. The strand of a point is its tree: lines that share points are of one.
/// `options.radius_array` says which array holds the radius. Lines that run together become one vessel; cell arrays such as
/// `label` name their lines. The field `SPACE` states the frame.
///
/// # Errors
///
/// XML that is not well-formed, an encoding that cannot be read, arrays that contradict each other, a point on a line
/// without finite coordinates, no radius array, or a surface instead of lines.
pub fn read_vtp(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let room = &UnpackLimit::of(bytes.len(), options.max_input);
    let (head, appended) = split(bytes)?;
    let root = Element::root(&head)?;
    let little = match root.attribute("byte_order") {
        "LittleEndian" | "" => true,
        "BigEndian" => false,
        other => return Err(Fault::file(format!("byte_order \"{other}\""), "expected LittleEndian or BigEndian")),
    };
    let word = match root.attribute("header_type") {
        "UInt32" | "" => 4,
        "UInt64" => 8,
        other => return Err(Fault::file(format!("header_type \"{other}\""), "expected UInt32 or UInt64")),
    };
    let arrays = Arrays { little, word, compressor: root.attribute("compressor"), appended, room, options };
    let polydata = root.named("PolyData").next();
    let pieces: Vec<&Element> = polydata.into_iter().flat_map(|p| p.named("Piece")).collect();
    let count = |name: &str| pieces.iter().map(|p| number(p, name)).sum::<Result<usize, Fault>>();
    let (lines, verts) = (count("NumberOfLines")?, count("NumberOfVerts")?);
    let faces = count("NumberOfPolys")?.saturating_add(count("NumberOfStrips")?);
    let mut notes = check_cells(lines, verts, faces, "expected polylines in <Lines>")?;
    let mut read = Vec::new();
    let mut before = [0, 0];
    for piece in pieces {
        let lines = number(piece, "NumberOfLines")?;
        if lines > 0 {
            read.push(read_piece(piece, &arrays, before)?);
        }
        before = [before[0] + number(piece, "NumberOfPoints")?, before[1] + lines];
    }
    let (mut lines, more) = centerlines(read, options)?;
    lines.frame = polydata.map_or(Ok(Frame::Unknown), |polydata| frame(polydata, &arrays))?;
    notes.extend(more);
    Ok((lines, notes))
}

/// The frame that the field data state as 3D Slicer does, in an array of texts called `SPACE`.
fn frame(polydata: &Element, arrays: &Arrays) -> Result<Frame, Fault> {
    let mut fields = polydata.named("FieldData").flat_map(|fields| fields.children.iter().filter(|child| is_array(child)));
    match fields.find(|field| field.attribute("Name").trim() == super::SPACE && field.attribute("type") == "String") {
        Some(field) => Ok(arrays.texts(field, 1)?.first().map_or(Frame::Unknown, |word| Frame::of_word(word))),
        None => Ok(Frame::Unknown),
    }
}

fn read_piece(piece: &Element, arrays: &Arrays, before: [usize; 2]) -> Result<PolyData, Fault> {
    let [points, lines, verts] = ["NumberOfPoints", "NumberOfLines", "NumberOfVerts"].map(|name| number(piece, name));
    let (points, lines, verts) = (points?, lines?, verts?);
    let coordinates = piece.named("Points").next().and_then(|p| p.named("DataArray").next());
    let coordinates = coordinates.ok_or_else(|| Fault::file("no <Points>", "expected an array of 3 components"))?;
    let coordinates = arrays.reals(coordinates, 3 * points)?;
    let point_data = named(piece, "PointData", arrays, [0, points])?;
    let cells = |name| array(piece, "Lines", name).ok_or_else(|| Fault::file(format!("no {name} of <Lines>"), "expected it"));
    let ends = arrays.indices(cells("offsets")?, lines)?;
    let total = ends.last().and_then(|end| usize::try_from(*end).ok()).filter(|end| *end <= LIMIT);
    let total = total.ok_or_else(|| {
        let last = ends.last().copied().unwrap_or_default();
        Fault::item("offsets of <Lines>", format!("the last is {last}"), format!("expected a count up to {LIMIT}"))
    })?;
    let cells = arrays.indices(cells("connectivity")?, total)?;
    // Cell data counts vertex cells before lines.
    let line_data = named(piece, "CellData", arrays, [verts, lines])?;
    let points = coordinates.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    Ok(PolyData { before, points, ends, cells, point_data, line_data })
}

/// The arrays of a group by name, read where they are wanted: `count` values after the first `skipped`.
fn named(piece: &Element, group: &str, arrays: &Arrays, [skipped, count]: [usize; 2]) -> Result<Vec<NamedValues>, Fault> {
    let mut out = Vec::new();
    for array in piece.named(group).flat_map(|group| group.children.iter().filter(|c| is_array(c))) {
        let name = array.attribute("Name").trim();
        let scalar = matches!(array.attribute("NumberOfComponents").trim(), "" | "1");
        let values = if !scalar || !is_wanted(name, arrays.options) {
            ArrayValues::Unread
        } else if array.attribute("type") == "String" {
            ArrayValues::Texts(arrays.texts(array, skipped + count)?.split_off(skipped))
        } else {
            ArrayValues::Numbers(arrays.reals(array, skipped + count)?.split_off(skipped))
        };
        out.push(NamedValues { name: name.to_owned(), values });
    }
    Ok(out)
}

fn array<'a>(piece: &'a Element, group: &str, name: &str) -> Option<&'a Element> {
    piece.named(group).next()?.named("DataArray").find(|a| a.attribute("Name").trim() == name)
}

/// Arrays of texts may be `<Array>` instead.
fn is_array(element: &Element) -> bool {
    matches!(element.name.as_str(), "DataArray" | "Array")
}

/// A count that a piece states; 0 where it is absent.
fn number(piece: &Element, name: &str) -> Result<usize, Fault> {
    match piece.attribute(name).trim() {
        "" => Ok(0),
        text => (text.parse().ok().filter(|n| *n <= LIMIT))
            .ok_or_else(|| Fault::item("Piece", format!("{name} \"{text}\""), format!("expected a count up to {LIMIT}"))),
    }
}

/// Splits a file into its XML and its appended data, which need not be XML.
fn split(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, Option<Source<'_>>), Fault> {
    let Some(start) = find(bytes, b"<AppendedData") else { return Ok((bytes.into(), None)) };
    let rest = &bytes[start..];
    let broken = |found: &str| Fault::item("AppendedData", found, "expected a complete file");
    let open = find(rest, b">").ok_or_else(|| broken("the tag does not end"))?;
    let close = b"</AppendedData>";
    let end = rest.windows(close.len()).rposition(|w| w == close).ok_or_else(|| broken("the file ends within it"))?;
    let (tag, data) = (&rest[..open], rest.get(open + 1..end).unwrap_or_default());
    let data = data.trim_ascii_start().strip_prefix(b"_").ok_or_else(|| broken("no underscore at its start"))?;
    let is_base64 = find(tag, b"raw").is_none();
    let source = Source { bytes: if is_base64 { data.trim_ascii_end() } else { data }, is_base64 };
    Ok(([&bytes[..start], b"</VTKFile>"].concat().into(), Some(source)))
}

/// What the arrays of a file share.
struct Arrays<'a> {
    /// Whether the least significant byte comes first.
    little: bool,
    /// The bytes of a header word: 4 or 8.
    word: usize,
    /// What compresses the arrays that are not written in digits.
    compressor: &'a str,
    /// The appended data, after its underscore.
    appended: Option<Source<'a>>,
    /// What they may unpack to, all together.
    room: &'a UnpackLimit,
    /// Which of them are read.
    options: &'a ReadOptions,
}

const ZLIB: &str = "vtkZLibDataCompressor";
const TYPES: &str = "expected Int8 to Int64, UInt8 to UInt64, Float32 or Float64";

impl Arrays<'_> {
    /// The first `count` numbers of an array.
    fn reals(&self, array: &Element, count: usize) -> Result<Vec<f64>, Fault> {
        let (kind, size) = number_type(array)?;
        let found = if is_ascii(array) {
            let number = |word: &str| match (kind, size) {
                (NumberType::Real, 4) => word.parse().ok().map(|x: f32| f64::from(x)),
                (NumberType::Real, _) => word.parse().ok(),
                _ => word.parse().ok().map(|x: i64| x as f64),
            };
            let accepted = || format!("expected {count} numbers of type {}", array.attribute("type"));
            let read = |word: &str| number(word).ok_or_else(|| fault(array, format!("value \"{word}\""), accepted()));
            array.text.split_ascii_whitespace().take(count).map(read).collect::<Result<Vec<f64>, Fault>>()?
        } else {
            let bytes = self.bytes(array, count.saturating_mul(size), format!("expected {count} values of {size} bytes"))?;
            let values = bytes.chunks_exact(size);
            let is_large = |bytes| i64::try_from(word(bytes, !self.little)).is_err();
            let is_wide = kind == NumberType::Unsigned && values.clone().any(is_large);
            ensure(!is_wide, || fault(array, "a whole number above 2^63 - 1", "expected a smaller one"))?;
            values.map(|bytes| kind.value(bytes, !self.little)).collect()
        };
        ensure(found.len() == count, || fault(array, format!("{} values", found.len()), format!("expected {count}")))?;
        Ok(found)
    }

    /// The first `count` indices of an array.
    fn indices(&self, array: &Element, count: usize) -> Result<Vec<i64>, Fault> {
        let found = self.reals(array, count)?;
        let wrong = || fault(array, format!("type {}", array.attribute("type")), "expected a type of whole numbers");
        ensure(number_type(array)?.0 != NumberType::Real, wrong)?;
        Ok(found.into_iter().map(|x| x as i64).collect())
    }

    /// The first `count` texts of an array; each ends with a zero byte.
    fn texts(&self, array: &Element, count: usize) -> Result<Vec<String>, Fault> {
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
        ensure(texts.len() >= count, || fault(array, format!("{} texts", texts.len()), accepted()))?;
        texts.truncate(count);
        Ok(texts)
    }

    /// The first `limit` bytes of an array that is not written in digits.
    fn bytes(&self, array: &Element, limit: usize, accepted: String) -> Result<Vec<u8>, Fault> {
        let accepted_compressors =
            "expected vtkZLibDataCompressor or none: save it with SetCompressorTypeToZLib() in VTK, or ZLib in ParaView";
        let wrong = || Fault::file(format!("compressor {}", self.compressor), accepted_compressors);
        ensure(["", ZLIB].contains(&self.compressor), wrong)?;
        let own;
        let source = match array.attribute("format") {
            "binary" => {
                own = array.text.bytes().filter(|b| !b.is_ascii_whitespace()).collect::<Vec<u8>>();
                Some(Source { bytes: &own, is_base64: true })
            }
            "appended" => {
                let start = array.attribute("offset").trim().parse().unwrap_or(usize::MAX);
                self.appended.and_then(|appended| Some(Source { bytes: appended.bytes.get(start..)?, ..appended }))
            }
            other => return Err(fault(array, format!("format \"{other}\""), "expected ascii, binary or appended")),
        };
        let source = source.ok_or_else(|| {
            let offset = array.attribute("offset").trim();
            fault(array, format!("offset \"{offset}\""), "expected a place in the <AppendedData>")
        })?;
        let most = limit.min(self.room.left().saturating_add(1));
        let bytes = if self.compressor == ZLIB { self.inflate(source, most) } else { self.plain(source, most) };
        let bytes = bytes.map_err(|found| fault(array, found, accepted))?;
        self.room.take(bytes.len()).map_err(|(found, accepted)| fault(array, found, accepted))?;
        Ok(bytes)
    }

    /// The bytes of an array, the first `limit` of them: some programs write more values than there are points.
    fn plain(&self, mut source: Source, limit: usize) -> Result<Vec<u8>, String> {
        let mut ahead = source;
        let count = self.words(&ahead.take(self.word)?)[0];
        let count = usize::try_from(count).map_or(limit, |count| count.min(limit));
        if source.is_separate(self.word) {
            return ahead.take(count).map(Cow::into_owned);
        }
        // Header and data were encoded together.
        let mut both = source.take(self.word + count)?.into_owned();
        both.drain(..self.word);
        Ok(both)
    }

    fn inflate(&self, mut source: Source, limit: usize) -> Result<Vec<u8>, String> {
        let mut ahead = source;
        let blocks = self.words(&ahead.take(self.word)?)[0];
        if blocks == 0 {
            return Ok(Vec::new());
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
            let holds = (most.min(expected)..=expected).contains(&((out.len() - before) as u64));
            ensure(holds, || format!("zlib block {n} does not hold the {expected} bytes announced"))?;
            if out.len() == limit {
                break;
            }
        }
        Ok(out)
    }

    fn words(&self, bytes: &[u8]) -> Vec<u64> {
        bytes.chunks_exact(self.word).map(|bytes| word(bytes, !self.little)).collect()
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

fn fault(array: &Element, found: impl std::fmt::Display, accepted: impl Into<String>) -> Fault {
    Fault::item(format!("array \"{}\" of {}", array.attribute("Name").trim(), array.within), found.to_string(), accepted)
}

const BASE64: GeneralPurpose = GeneralPurpose::new(
    &base64::alphabet::STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent).with_decode_allow_trailing_bits(true),
);

/// Encoded bytes, from the start of an array on.
#[derive(Clone, Copy)]
struct Source<'a> {
    bytes: &'a [u8],
    /// Whether they are in base64, or as they are.
    is_base64: bool,
}

impl<'a> Source<'a> {
    /// The next `count` bytes, which were encoded together.
    fn take(&mut self, count: usize) -> Result<Cow<'a, [u8]>, String> {
        let short = |has: usize| format!("{has} bytes where {count} should be");
        let (stored, has) = if self.is_base64 {
            (count.div_ceil(3).saturating_mul(4), self.bytes.len() / 4 * 3)
        } else {
            (count, self.bytes.len())
        };
        let (now, later) = self.bytes.split_at_checked(stored).ok_or_else(|| short(has))?;
        self.bytes = later;
        if !self.is_base64 {
            return Ok(Cow::Borrowed(now));
        }
        let mut bytes = BASE64.decode(now).map_err(|e| format!("not base64: {e}"))?;
        ensure(bytes.len() >= count, || short(bytes.len()))?;
        bytes.truncate(count);
        Ok(Cow::Owned(bytes))
    }

    /// Whether the first `count` bytes were encoded separately: base64 text is then padded within their characters.
    fn is_separate(&self, count: usize) -> bool {
        let padding = self.bytes.iter().take(count.div_ceil(3) * 4).filter(|b| **b == b'=').count();
        !self.is_base64 || padding == count.div_ceil(3) * 3 - count
    }
}
