//! Reads a file of any format: the one place that knows every reader.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::sniff::{Format, format_of};
use super::{
    RadiusArray, add_loops, csv_graph, icafe, name_stretches, read_csv_edges, read_csv_nodes, read_graphml, read_markups,
    read_points, read_swc, read_traced_vessels, read_tre, read_vtp,
};
use crate::centerline::Centerlines;
use crate::error::{Error, Fault, Result};
use crate::network::Network;
use crate::units::{LengthUnit, Scale};

/// What a file holds.
#[derive(Debug, Clone)]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Vessels that an image showed, as they stand.
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
    /// The VTP point array, or the measurement of markups, that holds the radius, where it is not one of the usual names.
    pub radius_array: Option<String>,
    /// Whether centerlines may come without any radius.
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
    let mut format = format_of(path, bytes).map_err(|fault| fault.in_file(path))?;
    let here = |fault: Fault| fault.in_file(path);
    let radius = match options.radius_array.as_deref() {
        Some(name) => RadiusArray::Named(name),
        None if options.radius_optional => RadiusArray::Optional,
        None => RadiusArray::Usual,
    };
    let (mut content, mut notes) = match format {
        Format::Swc => {
            let (mut lines, mut notes) = read_swc(bytes, &options.scale).map_err(here)?;
            if let Some(table) = icafe::table_beside(path)
                && let Some(note) = name_vessels(&mut lines, &bytes_of(&table)?, &table, &options.scale)?
            {
                format = Format::ICafe;
                notes.push(note);
            }
            notes.extend(spacing_note(path, &options.scale));
            (Content::Centerlines(lines), notes)
        }
        Format::ICafe => {
            let tracing = icafe::tracing_beside(path).map_err(here)?;
            let traced = bytes_of(&tracing)?;
            let (mut lines, mut notes) =
                read_swc(without_mark(&traced), &options.scale).map_err(|fault| fault.in_file(&tracing))?;
            notes.push(format!("the points are those of {}", tracing.display()));
            let wrong =
                || Fault::file("none of its vessels begins and ends at points of the tracing", "expected those of one image");
            notes.push(name_vessels(&mut lines, bytes, path, &options.scale)?.ok_or_else(wrong).map_err(here)?);
            notes.extend(spacing_note(&tracing, &options.scale));
            (Content::Centerlines(lines), notes)
        }
        Format::Tre => {
            let (lines, notes) = read_tre(bytes, &options.scale, options.radius_optional).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::Markups => {
            let (lines, notes) = read_markups(bytes, &options.scale, radius).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::Points => {
            let (lines, notes) = read_points(bytes, &options.scale, options.radius_optional).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::Vtp => {
            let (lines, notes) = read_vtp(bytes, &options.scale, radius).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::GraphMl => {
            let (network, notes) = read_graphml(bytes, &options.scale).map_err(here)?;
            (Content::Graph(network), notes)
        }
        Format::Csv => {
            let beside = csv_graph::nodes_beside(path);
            let nodes = (beside.as_deref())
                .map(|nodes| {
                    let bytes = bytes_of(nodes)?;
                    read_csv_nodes(without_mark(&bytes), &options.scale).map_err(|fault| fault.in_file(nodes))
                })
                .transpose()?;
            let (network, mut notes) = read_csv_edges(bytes, nodes, &options.scale).map_err(here)?;
            notes.extend(beside.map(|nodes| format!("nodes are those of {}", nodes.display())));
            (Content::Graph(network), notes)
        }
        other => return Err(here(Fault::file(format!("{} cannot be read", other.name()), "expected another format"))),
    };
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = &mut content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("--loops", loops.display(), accepted));
        };
        let bytes = bytes_of(loops)?;
        let added = add_loops(without_mark(&bytes), lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{added} links are those of {}", loops.display()));
    }
    Ok(Document { format, content, notes, sha256: hexadecimal(&all) })
}

/// Names the stretches of an iCafe tracing after its table of vessels; `None` when the table is that of another tracing.
fn name_vessels(lines: &mut Centerlines, bytes: &[u8], table: &Path, scale: &Scale) -> Result<Option<String>> {
    let vessels = read_traced_vessels(without_mark(bytes), scale).map_err(|fault| fault.in_file(table))?;
    let named = name_stretches(lines, &vessels);
    let note = || format!("labels are those of {}: {named} of its {} vessels are in the tracing", table.display(), vessels.len());
    Ok((named > 0).then(note))
}

/// The voxel spacing that iCafe states beside a tracing, where lengths are not taken as voxels.
fn spacing_note(tracing: &Path, scale: &Scale) -> Option<String> {
    let spacing = icafe::spacing_beside(tracing).filter(|_| scale.unit != LengthUnit::Voxel)?;
    Some(format!("Image_info.txt beside it states a voxel spacing of {spacing} mm; give --units voxel --spacing {spacing}"))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })
}

/// The bytes after a byte order mark.
fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

fn hexadecimal(bytes: &[u8]) -> String {
    let digits = |byte: &u8| [byte >> 4, byte & 15].map(|digit| char::from(b"0123456789abcdef"[usize::from(digit)]));
    Sha256::digest(bytes).iter().flat_map(digits).collect()
}
