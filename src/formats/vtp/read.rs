//! Reads the lines and radii of a VTP file.

use std::collections::HashMap;

use roxmltree::Node as Element;

use super::super::xml;
use super::array::{Arrays, attribute};
use super::block::{Encoding, Source};
use crate::centerline::Centerlines;
use crate::error::Fault;
use crate::suggestion::did_you_mean;
use crate::units::Scale;

/// The usual names of the radius, the first one first.
const RADIUS: [&str; 3] = ["MaximumInscribedSphereRadius", "Radius", "radius"];
/// More points, cells or indices than any centerline has: a file that announces them is broken.
const LIMIT: usize = 1 << 26;

/// Which point array holds the radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum RadiusArray<'a> {
    /// The first one with a usual name.
    #[default]
    Usual,
    /// The one with this name.
    Named(&'a str),
    /// The first one with a usual name; without one every radius is missing.
    Optional,
}

/// Reads the polylines of all pieces with the radius of each point; returns also what a person should know.
///
/// Points keep their row as id; those on no line are left out. The strand of a point is the first line that uses it.
/// `radius_array` says which point array holds the radius.
///
/// # Errors
///
/// XML that is not well-formed, an encoding that cannot be read, arrays that contradict each other, a point on a line
/// without finite coordinates, no radius array, or a surface instead of lines.
pub fn read_vtp(bytes: &[u8], scale: &Scale, radius_array: RadiusArray<'_>) -> Result<(Centerlines, Vec<String>), Fault> {
    let (head, appended) = split(bytes)?;
    let text = xml::utf8(&head)?;
    let document = xml::parse(text)?;
    let root = document.root_element();
    let little = match attribute(root, "byte_order") {
        "LittleEndian" | "" => true,
        "BigEndian" => false,
        other => return Err(Fault::file(format!("byte_order \"{other}\""), "expected LittleEndian or BigEndian")),
    };
    let word = match attribute(root, "header_type") {
        "UInt32" | "" => 4,
        "UInt64" => 8,
        other => return Err(Fault::file(format!("header_type \"{other}\""), "expected UInt32 or UInt64")),
    };
    let zlib = match attribute(root, "compressor") {
        "" => false,
        "vtkZLibDataCompressor" => true,
        other => return Err(Fault::file(format!("compressor {other}"), "expected vtkZLibDataCompressor or none")),
    };
    let arrays = Arrays { encoding: Encoding { little, word, zlib }, appended };
    let polydata = children(root, "PolyData").next();
    let pieces: Vec<Element> = polydata.into_iter().flat_map(|p| children(p, "Piece")).collect();
    let count = |name: &str| pieces.iter().map(|p| number(*p, name)).sum::<Result<usize, Fault>>();
    let (lines, verts) = (count("NumberOfLines")?, count("NumberOfVerts")?);
    let faces = count("NumberOfPolys")?.saturating_add(count("NumberOfStrips")?);
    if lines == 0 && faces > 0 {
        return Err(Fault::file(format!("a surface of {faces} polygons, not centerlines"), "expected polylines in <Lines>"));
    }
    if lines == 0 {
        return Err(Fault::file("no lines", "expected polylines in <Lines>"));
    }
    let mut notes = Vec::new();
    for (n, what) in [(verts, "vertex cells"), (faces, "polygons")] {
        if n > 0 {
            notes.push(format!("{n} {what} are ignored"));
        }
    }
    let mut out = Centerlines::default();
    let (mut first_point, mut first_line) = (0, 0);
    for piece in pieces {
        read_piece(&mut out, piece, &arrays, scale, radius_array, [first_point, first_line])?;
        first_point += number(piece, "NumberOfPoints")?;
        first_line += number(piece, "NumberOfLines")?;
    }
    Ok((out, notes))
}

fn read_piece(
    out: &mut Centerlines,
    piece: Element,
    arrays: &Arrays,
    scale: &Scale,
    radius_array: RadiusArray<'_>,
    [first_point, first_line]: [usize; 2],
) -> Result<(), Fault> {
    let (points, lines) = (number(piece, "NumberOfPoints")?, number(piece, "NumberOfLines")?);
    if lines == 0 {
        return Ok(());
    }
    let coordinates = children(piece, "Points").next().and_then(|p| children(p, "DataArray").next());
    let coordinates = coordinates.ok_or_else(|| Fault::file("no <Points>", "expected an array of 3 components"))?;
    let coordinates = arrays.reals(coordinates, 3 * points)?;
    let named = if let RadiusArray::Named(name) = radius_array { Some(name) } else { None };
    let radii = match radius(piece, named) {
        Err(_) if radius_array == RadiusArray::Optional => vec![f64::NAN; points],
        array => arrays.reals(array?, points)?,
    };
    let cells =
        |name| array(piece, "Lines", |n| n == name).ok_or_else(|| Fault::file(format!("no {name} of <Lines>"), "expected it"));
    let ends = arrays.indices(cells("offsets")?, lines)?;
    let total = ends.last().and_then(|end| usize::try_from(*end).ok()).filter(|end| *end <= LIMIT);
    let total = total.ok_or_else(|| {
        let last = ends.last().copied().unwrap_or_default();
        Fault::item("offsets of <Lines>", format!("the last is {last}"), format!("expected a count up to {LIMIT}"))
    })?;
    let connectivity = arrays.indices(cells("connectivity")?, total)?;
    let mut row_of: HashMap<usize, u32> = HashMap::new();
    let mut start = 0;
    for (line, end) in ends.iter().enumerate() {
        let name = || format!("line {}", first_line + line);
        let cell = usize::try_from(*end).ok().and_then(|end| connectivity.get(start..end));
        let cell = cell.ok_or_else(|| Fault::item(name(), format!("offset {end} after {start}"), "expected rising offsets"))?;
        start += cell.len();
        let mut before = None;
        for point in cell {
            let range = || {
                Fault::item(name(), format!("point {point}"), format!("expected a point from 0 to {}", points.saturating_sub(1)))
            };
            let point = usize::try_from(*point).ok().filter(|p| *p < points).ok_or_else(range)?;
            let row = if let Some(row) = row_of.get(&point) {
                *row
            } else {
                let (Some([x, y, z]), Some(radius)) = (coordinates.get(3 * point..3 * point + 3), radii.get(point)) else {
                    return Err(range());
                };
                if ![x, y, z].into_iter().all(|x| x.is_finite()) {
                    let found = format!("coordinates {x} {y} {z}");
                    return Err(Fault::item(format!("point {}", first_point + point), found, "expected finite numbers"));
                }
                let row = out.points.len() as u32;
                out.points.push(scale.position([*x, *y, *z]));
                out.radii.push(scale.length(*radius));
                out.ids.push((first_point + point) as u64);
                out.strand.push((first_line + line) as u32);
                row_of.insert(point, row);
                row
            };
            if let Some(before) = before.replace(row).filter(|before| *before != row) {
                out.links.push([before, row]);
            }
        }
    }
    Ok(())
}

/// The array of point data that holds the radius.
fn radius<'a, 'i>(piece: Element<'a, 'i>, name: Option<&str>) -> Result<Element<'a, 'i>, Fault> {
    let found = match name {
        Some(name) => array(piece, "PointData", |n| n == name.trim()),
        None => RADIUS.iter().find_map(|usual| array(piece, "PointData", |n| n == *usual)),
    };
    found.ok_or_else(|| {
        let arrays = children(piece, "PointData").flat_map(|p| children(p, "DataArray"));
        let arrays: Vec<String> = arrays.map(|a| format!("\"{}\"", attribute(a, "Name").trim())).collect();
        let has = if arrays.is_empty() { "there are none".to_owned() } else { format!("there are {}", arrays.join(", ")) };
        match name {
            Some(name) => {
                let meant = did_you_mean(name, arrays.iter().map(|a| a.trim_matches('"')));
                Fault::file(format!("no point array \"{}\"", name.trim()), format!("{meant}{has}"))
            }
            None => Fault::file(format!("no point array {}", RADIUS.join(", ")), format!("{has}; name one with --radius-array")),
        }
    })
}

fn array<'a, 'i>(piece: Element<'a, 'i>, group: &'static str, is: impl Fn(&str) -> bool) -> Option<Element<'a, 'i>> {
    let group = children(piece, group).next()?;
    children(group, "DataArray").find(|a| is(attribute(*a, "Name").trim()))
}

fn children<'a, 'i>(parent: Element<'a, 'i>, name: &'static str) -> impl Iterator<Item = Element<'a, 'i>> {
    parent.children().filter(move |c| c.is_element() && c.tag_name().name() == name)
}

/// A count that a piece announces; absent is 0.
fn number(piece: Element, name: &str) -> Result<usize, Fault> {
    match attribute(piece, name).trim() {
        "" => Ok(0),
        text => (text.parse().ok().filter(|n| *n <= LIMIT))
            .ok_or_else(|| Fault::item("Piece", format!("{name} \"{text}\""), format!("expected a count up to {LIMIT}"))),
    }
}

/// The XML without its appended data, which need not be XML, and these.
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
