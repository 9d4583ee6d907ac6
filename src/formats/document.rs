//! Reads a file of any format: the one place that knows every reader.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::sniff::{Format, format_of};
use super::{
    RadiusArray, add_loops, pair, read_csv_edges, read_csv_nodes, read_graphml, read_skeleton_npz, read_swc, read_vtp,
    read_vtrails,
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
    /// The VTP point array that holds the radius, where it is not one of the usual names.
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
    let here = |fault: Fault| fault.in_file(path);
    let (mut content, mut notes) = match format {
        Format::Swc => {
            let (lines, notes) = read_swc(bytes, &options.scale).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::Vtp => {
            let radius = match options.radius_array.as_deref() {
                Some(name) => RadiusArray::Named(name),
                None if options.radius_optional => RadiusArray::Optional,
                None => RadiusArray::Usual,
            };
            let (lines, notes) = read_vtp(bytes, &options.scale, radius).map_err(here)?;
            (Content::Centerlines(lines), notes)
        }
        Format::GraphMl => {
            let (network, notes) = read_graphml(bytes, &options.scale).map_err(here)?;
            (Content::Graph(network), notes)
        }
        Format::Csv => {
            let beside = pair::nodes_beside(path);
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
        Format::Voreen => pair::read_voreen(path, bytes, options)?,
        Format::VesselVio => pair::read_vesselvio(path, bytes, options)?,
        Format::Npz => read_skeleton_npz(bytes, &options.scale, options.radius_optional).map_err(here)?,
        Format::VTrails => {
            let (lines, notes) = read_vtrails(bytes, &options.scale, options.radius_optional).map_err(here)?;
            (Content::Centerlines(lines), notes)
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

pub(super) fn bytes_of(path: &Path) -> Result<Vec<u8>> {
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
