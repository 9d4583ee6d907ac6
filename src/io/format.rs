//! Which format a file has: by its content first, by its ending then.

use std::path::Path;

use super::companions::{edges_beside, refers_to_rows};
use super::tables::graph;
use super::tables::rows::delimiter;
use super::vendors::icafe;
use super::xml;
use crate::error::Fault;

/// Bytes that show what a file is.
pub(crate) const HEAD: u64 = 1 << 16;

/// The formats that are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// SWC: one centerline point a line.
    Swc,
    /// VTK XML PolyData.
    Vtp,
    /// VTK legacy PolyData.
    Vtk,
    /// GraphML.
    GraphMl,
    /// A table of edges, with a table of nodes beside it or not.
    Csv,
    /// A table of points, `fragment,x,y,z,radius`.
    Points,
    /// iCafe: a tracing in SWC with its table of vessels.
    ICafe,
    /// Voreen's tables of nodes and edges.
    Voreen,
    /// VesselVio's tables of vertices and edges.
    VesselVio,
    /// 3D Slicer markups.
    Markups,
    /// ITK tubes.
    Tre,
    /// A skeleton graph as NumPy arrays.
    Npz,
    /// VTrails' geodesic trees, a MATLAB 7.3 file.
    VTrails,
}

impl Format {
    /// The usual name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Swc => "SWC",
            Self::Vtp => "VTP",
            Self::Vtk => "VTK legacy",
            Self::GraphMl => "GraphML",
            Self::Csv => "CSV",
            Self::Points => "CSV of points",
            Self::ICafe => "iCafe",
            Self::Voreen => "Voreen CSV",
            Self::VesselVio => "VesselVio CSV",
            Self::Markups => "Slicer markups",
            Self::Tre => "TRE",
            Self::Npz => "NPZ",
            Self::VTrails => "VTrails MAT",
        }
    }
}

const ACCEPTED: &str = "expected SWC, VTP, VTK PolyData, GraphML, CSV, TRE, 3D Slicer markups, NPZ or VTrails MAT";

/// Decides by the first bytes, then by the ending, then by the first line that says something.
pub(crate) fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, Fault> {
    if bytes.trim_ascii().is_empty() {
        return Err(Fault::file("the file is empty", ACCEPTED));
    }
    if let Some(format) = by_signature(bytes)? {
        return Ok(format);
    }
    match xml::root(bytes) {
        Some(("VTKFile", tag)) if ["\"PolyData\"", "'PolyData'"].iter().any(|kind| tag.contains(kind)) => {
            return Ok(Format::Vtp);
        }
        Some(("VTKFile", _)) => return Err(Fault::file("a VTKFile of another type than PolyData", ACCEPTED)),
        Some(("graphml", _)) => return Ok(Format::GraphMl),
        Some((name, _)) => return Err(Fault::file(format!("XML with the root element <{name}>"), ACCEPTED)),
        None => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    let mut lines = head.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next().unwrap_or_default();
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("swc") => return Ok(Format::Swc),
        Some("csv" | "tsv") => return Ok(table(path, first).unwrap_or(Format::Csv)),
        _ => {}
    }
    if let Some(format) = table(path, first) {
        return Ok(format);
    }
    if first.split_whitespace().count() == 7 && first.split_whitespace().all(|w| w.parse::<f64>().is_ok()) {
        return Ok(Format::Swc);
    }
    Err(Fault::file("the format is not known", ACCEPTED))
}

/// The formats that begin in a way of their own.
fn by_signature(bytes: &[u8]) -> Result<Option<Format>, Fault> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    let starts = |signature: &[u8]| bytes.starts_with(signature);
    if starts(b"\xff\xfe") || starts(b"\xfe\xff") {
        return Err(Fault::file("the text is UTF-16", "expected UTF-8; save it so"));
    }
    if starts(b"\x1f\x8b") {
        return Err(Fault::file("the file is compressed by gzip", "expected it unpacked (gunzip)"));
    }
    if starts(HDF5) || starts(b"MATLAB 7.3 MAT-file") || bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5)) {
        return Ok(Some(Format::VTrails));
    }
    if starts(b"MATLAB 5.0 MAT-file") {
        return Err(Fault::file("a MATLAB file before version 7.3", "expected it saved with -v7.3"));
    }
    if starts(b"\x93NUMPY") {
        return Err(Fault::file("a single NumPy array", "expected a skeleton graph as .npz: coords, edges, radii"));
    }
    if starts(b"PK\x03\x04") || starts(b"PK\x05\x06") {
        return Ok(Some(Format::Npz));
    }
    if starts(b"# vtk DataFile") {
        return Ok(Some(Format::Vtk));
    }
    let text = bytes.trim_ascii_start();
    if text.starts_with(b"{") {
        return Ok(Some(Format::Markups));
    }
    let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
    let key = line.split(|b| *b == b'=').next().unwrap_or_default().trim_ascii();
    Ok(["ObjectType", "Comment", "NDims"].iter().any(|k| key == k.as_bytes() && line.contains(&b'=')).then_some(Format::Tre))
}

/// The table that a header line begins.
///
/// Edges by the columns `Source ID,Target ID` are VesselVio's, and so are edges by `source,target` whose table of nodes has
/// no names (`node`, `id`): these can only be rows. So is a table of positions without names beside a table of edges.
fn table(path: &Path, header: &str) -> Option<Format> {
    let header = header.trim_start_matches('\u{feff}');
    let columns: Vec<&str> = header.split(delimiter(header)).map(|column| column.trim().trim_matches('"')).collect();
    let has = |names: &[&str]| names.iter().all(|name| columns.iter().any(|column| column.eq_ignore_ascii_case(name)));
    let named = has(&["node"]) || has(&["id"]);
    if has(&["node1id", "node2id"]) || (has(&["id", "pos_x", "pos_y", "pos_z"])) {
        Some(Format::Voreen)
    } else if has(&["source id", "target id"]) || (has(&["source", "target"]) && refers_to_rows(path)) {
        Some(Format::VesselVio)
    } else if graph::is_header(header) {
        Some(Format::Csv)
    } else if has(&["fragment"]) {
        Some(Format::Points)
    } else if icafe::is_header(&columns) {
        Some(Format::ICafe)
    } else if has(&["x", "y", "z"]) && !named && edges_beside(path).is_some() {
        Some(Format::VesselVio)
    } else {
        None
    }
}
