//! Finds the columns of an input that are not read, such as the results of an earlier run.

use std::path::Path;

use crate::formats::vtk::polydata::is_wanted;
use crate::formats::xml::{Events, XmlStep};
use crate::formats::{END_POSITION_COLUMNS, Format, ReadOptions, attributes, input::stream_of, regular_bytes_of, tables::graph};
use crate::formats::{graphml::FRAME, vtk::SPACE, vtk::legacy::names_of_arrays};

/// Whether a column only repeats the rows, parts and positions of a network, or is one of VTK's own arrays.
fn is_structure(name: &str) -> bool {
    let rows = matches!(name, "edge" | "edges" | "node" | "id" | "node_a" | "node_b" | "component" | "length_mm" | "radius_mm");
    rows || END_POSITION_COLUMNS.as_flattened().contains(&name) || matches!(name, "Points" | "connectivity" | "offsets")
}

/// The columns, attributes or arrays of a GraphML, CSV, VTP or VTK file that its reader ignores with these options, in their order; none
/// for a file of another format, or one that cannot be read again.
pub fn unread_columns(path: &Path, format: Format, options: &ReadOptions) -> Vec<String> {
    let bytes = || regular_bytes_of(path).ok();
    let header = || super::reader::TableReader::open(&bytes()?).ok().map(|rows| rows.header);
    let is_read = |name: &str| match format {
        Format::GraphMl => attributes::is_wanted(name) || name == FRAME,
        Format::Csv => graph::is_wanted(name),
        _ => is_wanted(name, options) || name == SPACE,
    };
    let names = match format {
        Format::GraphMl => named(path, ("key", "attr.name"), "graph"),
        Format::Vtp => named(path, ("DataArray", "Name"), "AppendedData"),
        Format::Vtk => bytes().and_then(|bytes| names_of_arrays(&bytes)),
        Format::Csv => header(),
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
