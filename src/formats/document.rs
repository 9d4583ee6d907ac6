//! Reads a file of any format: the one place that knows every reader.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::sniff::{Format, format_of};
use super::tracing::{read_table_of_vessels, read_tracing};
use super::unit_check::unit_check;
use super::{
    RadiusArray, add_loops, pair, read_csv_edges, read_csv_nodes, read_graphml, read_markups, read_points, read_skeleton_npz,
    read_tre, read_vtk, read_vtp, read_vtrails,
};
use crate::centerline::Centerlines;
use crate::error::{Error, Fault, Result};
use crate::network::Network;
use crate::units::Scale;

/// What a file holds.
#[derive(Debug, Clone)]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Vessels that an image showed, as they stand; a radius that the file lacks, where it may, is NaN.
    Vessels(Network),
    /// A ready graph, whose edges are vessels as they stand.
    Graph(Network),
}

/// A file that has been read.
#[derive(Debug, Clone)]
pub struct Document {
    /// Its format.
    pub format: Format,
    /// Its content.
    pub content: Content,
    /// What a person should know about how it was read, one line each.
    pub notes: Vec<String>,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// How a file is to be read.
#[derive(Debug, Clone, Default)]
pub struct ReadOptions {
    /// The unit of its coordinates, lengths and radii.
    pub scale: Scale,
    /// The array of a VTK file, or the measurement of markups, that holds the radius, where it has none of the usual names.
    pub radius_array: Option<String>,
    /// Whether centerlines and observed vessels may come without any radius.
    pub radius_optional: bool,
    /// A CSV file of pairs of point ids to link, which SWC cannot.
    pub loops: Option<PathBuf>,
}

/// Reads centerlines or a graph.
///
/// # Errors
///
/// A file that cannot be read, is in none of the formats, or has a fault in its content; a loops file with a graph.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Document> {
    let all = bytes_of(path)?;
    let bytes = without_mark(&all);
    let format = format_of(path, bytes).map_err(|fault| fault.in_file(path))?;
    let (format, mut content, mut notes) = read_as(format, path, bytes, options)?;
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = &mut content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("--loops", loops.display(), accepted));
        };
        let bytes = bytes_of(loops)?;
        let added = add_loops(without_mark(&bytes), lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{added} links are those of {}", loops.display()));
    }
    notes.extend(unit_check(&content, &options.scale));
    Ok(Document { format, content, notes, sha256: checksum(&all) })
}

/// The format of a file with what lies beside it, what it holds, and what a person should know about it.
fn read_as(format: Format, path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Format, Content, Vec<String>)> {
    let (scale, optional) = (&options.scale, options.radius_optional);
    let radius = match options.radius_array.as_deref() {
        Some(name) => RadiusArray::Named(name),
        None if optional => RadiusArray::Optional,
        None => RadiusArray::Usual,
    };
    let here = |fault: Fault| fault.in_file(path);
    let lines = |read: Result<(Centerlines, Vec<String>), Fault>| {
        read.map_err(here).map(|(lines, notes)| (Content::Centerlines(lines), notes))
    };
    let read = match format {
        Format::Swc => return read_tracing(path, bytes, options),
        Format::ICafe => read_table_of_vessels(path, bytes, options),
        Format::Csv => read_tables(path, bytes, scale),
        Format::Voreen => pair::read_voreen(path, bytes, options),
        Format::VesselVio => pair::read_vesselvio(path, bytes, options),
        Format::GraphMl => read_graphml(bytes, scale).map_err(here).map(|(graph, notes)| (Content::Graph(graph), notes)),
        Format::Npz => read_skeleton_npz(bytes, scale, optional).map_err(here),
        Format::Vtp => lines(read_vtp(bytes, scale, radius)),
        Format::Vtk => lines(read_vtk(bytes, scale, radius)),
        Format::Tre => lines(read_tre(bytes, scale, optional)),
        Format::Markups => lines(read_markups(bytes, scale, radius)),
        Format::Points => lines(read_points(bytes, scale, optional)),
        Format::VTrails => lines(read_vtrails(bytes, scale, optional)),
    };
    read.map(|(content, notes)| (format, content, notes))
}

/// A table of edges, with the table of nodes beside it.
fn read_tables(path: &Path, bytes: &[u8], scale: &Scale) -> Result<(Content, Vec<String>)> {
    let beside = pair::nodes_beside(path);
    let read = |nodes: &PathBuf| {
        let bytes = bytes_of(nodes)?;
        read_csv_nodes(without_mark(&bytes), scale).map_err(|fault| fault.in_file(nodes))
    };
    let nodes = beside.as_ref().map(read).transpose()?;
    let (network, mut notes) = read_csv_edges(bytes, nodes, scale).map_err(|fault| fault.in_file(path))?;
    notes.extend(beside.map(|nodes| format!("nodes are those of {}", nodes.display())));
    Ok((Content::Graph(network), notes))
}

/// All bytes of a file.
///
/// # Errors
///
/// It cannot be read: names it.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })
}

/// The bytes after a byte order mark.
pub(super) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// The SHA-256 of some bytes in hexadecimal digits.
pub fn checksum(bytes: &[u8]) -> String {
    in_digits(&Sha256::digest(bytes))
}

/// The same of what `fill` writes, which need not be in memory at once.
///
/// # Errors
///
/// Those of `fill`.
pub fn checksum_of(fill: impl FnOnce(&mut Hashing) -> io::Result<()>) -> io::Result<String> {
    let mut hashing = Hashing(Sha256::new());
    fill(&mut hashing)?;
    Ok(in_digits(&hashing.0.finalize()))
}

/// Takes bytes for their SHA-256.
#[derive(Debug)]
pub struct Hashing(Sha256);

impl Write for Hashing {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

fn in_digits(bytes: &[u8]) -> String {
    let digits = |byte: &u8| [byte >> 4, byte & 15].map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)]));
    bytes.iter().flat_map(digits).collect()
}
