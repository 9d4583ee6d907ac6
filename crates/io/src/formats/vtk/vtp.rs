//! Reads the lines and radii of a VTK XML PolyData file (VTP).

use crate::formats::input::UnpackLimit;
use crate::formats::options::ReadOptions;
use crate::formats::vtk::SPACE;
use crate::formats::vtk::array::{Arrays, Source};
use crate::formats::vtk::polydata::{ArrayValues, LIMIT, NamedValues, PolyData, centerlines, check_cells, is_wanted};
use crate::formats::xml::{self, Element};
use willis_core::error::Fault;
use willis_core::network::{Centerlines, Frame};

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
    let arrays = Arrays { little, word, compressor: root.attribute("compressor"), appended, room };
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
            read.push(read_piece(piece, &arrays, options, before)?);
        }
        before = [before[0] + number(piece, "NumberOfPoints")?, before[1] + lines];
    }
    let (mut lines, more) = centerlines(&read, options)?;
    lines.frame = polydata.map_or(Ok(Frame::Unknown), |polydata| frame(polydata, &arrays))?;
    notes.extend(more);
    Ok((lines, notes))
}

/// The frame that the field data state as 3D Slicer does, in an array of texts called `SPACE`.
fn frame(polydata: &Element, arrays: &Arrays) -> Result<Frame, Fault> {
    let mut fields = polydata.named("FieldData").flat_map(|fields| fields.children.iter().filter(|child| is_array(child)));
    match fields.find(|field| field.attribute("Name").trim() == SPACE && field.attribute("type") == "String") {
        Some(field) => Ok(arrays.texts(field, 1)?.first().map_or(Frame::Unknown, |word| Frame::of_word(word))),
        None => Ok(Frame::Unknown),
    }
}

fn read_piece(piece: &Element, arrays: &Arrays, options: &ReadOptions, before: [usize; 2]) -> Result<PolyData, Fault> {
    let [points, lines, verts] = ["NumberOfPoints", "NumberOfLines", "NumberOfVerts"].map(|name| number(piece, name));
    let (points, lines, verts) = (points?, lines?, verts?);
    let coordinates = piece.named("Points").next().and_then(|p| p.named("DataArray").next());
    let coordinates = coordinates.ok_or_else(|| Fault::file("no <Points>", "expected an array of 3 components"))?;
    let coordinates = arrays.reals(coordinates, 3 * points)?;
    let point_data = named(piece, "PointData", arrays, options, [0, points])?;
    let cells = |name| array(piece, "Lines", name).ok_or_else(|| Fault::file(format!("no {name} of <Lines>"), "expected it"));
    let ends = arrays.indices(cells("offsets")?, lines)?;
    let total = ends.last().and_then(|end| usize::try_from(*end).ok()).filter(|end| *end <= LIMIT);
    let total = total.ok_or_else(|| {
        let last = ends.last().copied().unwrap_or_default();
        Fault::item("offsets of <Lines>", format!("the last is {last}"), format!("expected a count up to {LIMIT}"))
    })?;
    let cells = arrays.indices(cells("connectivity")?, total)?;
    // Cell data counts vertex cells before lines.
    let line_data = named(piece, "CellData", arrays, options, [verts, lines])?;
    let points = coordinates.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
    Ok(PolyData { before, points, ends, cells, point_data, line_data })
}

/// The arrays of a group by name, read where they are wanted: `count` values after the first `skipped`.
fn named(
    piece: &Element,
    group: &'static str,
    arrays: &Arrays,
    options: &ReadOptions,
    [skipped, count]: [usize; 2],
) -> Result<Vec<NamedValues>, Fault> {
    let mut out = Vec::new();
    for array in piece.named(group).flat_map(|group| group.children.iter().filter(|c| is_array(c))) {
        let name = array.attribute("Name").trim();
        let scalar = matches!(array.attribute("NumberOfComponents").trim(), "" | "1");
        let values = if !scalar || !is_wanted(name, options) {
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
fn split(bytes: &[u8]) -> Result<(std::borrow::Cow<'_, [u8]>, Option<Source<'_>>), Fault> {
    let Some(start) = xml::find(bytes, b"<AppendedData") else { return Ok((bytes.into(), None)) };
    let rest = &bytes[start..];
    let broken = |found: &str| Fault::item("AppendedData", found, "expected a complete file");
    let open = xml::find(rest, b">").ok_or_else(|| broken("the tag does not end"))?;
    let close = b"</AppendedData>";
    let end = rest.windows(close.len()).rposition(|w| w == close).ok_or_else(|| broken("the file ends within it"))?;
    let (tag, data) = (&rest[..open], rest.get(open + 1..end).unwrap_or_default());
    let data = data.trim_ascii_start().strip_prefix(b"_").ok_or_else(|| broken("no underscore at its start"))?;
    let source = if xml::find(tag, b"raw").is_some() { Source::Raw(data) } else { Source::Base64(data.trim_ascii_end()) };
    Ok(([&bytes[..start], b"</VTKFile>"].concat().into(), Some(source)))
}
