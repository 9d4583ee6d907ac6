//! Finds the columns of an input that are not read, such as the results of an earlier run.

use std::path::Path;

use crate::formats::vtk::polydata::is_wanted;
use crate::formats::xml::{Events, XmlStep};
use crate::formats::{END_POSITION_COLUMNS, Format, ReadOptions, attributes, input::stream_of, regular_bytes_of, tables::graph};

/// Whether a column only repeats the rows and positions of a network, or is one of VTK's own arrays.
fn is_structure(name: &str) -> bool {
    let rows = matches!(name, "edge" | "edges" | "node" | "id" | "node_a" | "node_b" | "length_mm" | "radius_mm");
    rows || END_POSITION_COLUMNS.as_flattened().contains(&name) || matches!(name, "Points" | "connectivity" | "offsets")
}

/// The columns, attributes or arrays of a GraphML, CSV or VTP file that its reader ignores, in their order; none for a
/// file of another format, or one that cannot be read again.
pub fn unread_columns(path: &Path, format: Format) -> Vec<String> {
    let header = || super::reader::TableReader::open(&regular_bytes_of(path).ok()?).ok().map(|rows| rows.header);
    let (names, is_read): (_, fn(&str) -> bool) = match format {
        Format::GraphMl => (named(path, ("key", "attr.name"), "graph"), attributes::is_wanted),
        Format::Vtp => (named(path, ("DataArray", "Name"), "AppendedData"), |name| is_wanted(name, &ReadOptions::default())),
        Format::Csv => (header(), graph::is_wanted),
        _ => return Vec::new(),
    };
    let (mut names, mut seen) = (names.unwrap_or_default(), std::collections::HashSet::new());
    names.retain(|name| !is_structure(name) && !is_read(name) && seen.insert(name.clone()));
    names
}

/// An attribute of every XML element of one name, up to the first element called `end`.
fn named(path: &Path, (element, attribute): (&str, &str), end: &str) -> Option<Vec<String>> {
    let mut events = Events::new(stream_of(path).ok()?);
    let mut names = Vec::new();
    while let Some(step) = events.next().ok()? {
        if step == XmlStep::Start && events.tag.name() == end {
            break;
        }
        if step == XmlStep::Start && events.tag.name() == element {
            names.extend(events.tag.attribute(attribute).ok()?.map(|name| name.trim().to_owned()));
        }
    }
    Some(names)
}
