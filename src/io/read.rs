//! Reads a file of any format: the one place that knows every reader.

use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::companions::nodes_beside;
use super::format::{Format, HEAD, format_of};
use super::graphml::read::read_graphml;
use super::itk::read::read_tre;
use super::limit::{Counted, MAX_INPUT, Room, bytes_up_to, bytes_within};
use super::numpy::skeleton::unpack_skeleton_npz;
use super::swc::loops::add_loops;
use super::tables::csv_graph::{read_csv_edges, read_csv_nodes};
use super::tables::number::counted;
use super::tables::points::read_points;
use super::tables::table_pair;
use super::unit_check::{check_extent, unit_check};
use super::vendors::icafe::{read_table_of_vessels, read_tracing};
use super::vendors::slicer_markups::read_markups;
use super::vendors::vtrails::unpack_vtrails;
use super::vtk::legacy::read::read_vtk;
use super::vtk::polydata::radius::RadiusArray;
use super::vtk::xml::read::unpack_vtp;
use super::xml;
use crate::error::{Error, Fault, Result};
use crate::network::centerlines::Centerlines;
use crate::network::units::{Scale, millimetres};
use crate::network::{Network, RadiusRule, WELD_TOLERANCE, contract};

/// What a file holds.
#[derive(Debug, Clone)]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Vessels that an image showed, as they stand; a radius that the file lacks, where it may, is NaN.
    Vessels(Network),
    /// A ready graph, whose edges are vessels as they stand; a missing radius, where it may be, is NaN.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// The unit of its coordinates, lengths and radii.
    pub scale: Scale,
    /// The array of a VTK file, or the measurement of markups, that holds the radius, where it has none of the usual names.
    pub radius_array: Option<String>,
    /// Which radius stands for a vessel.
    #[serde(rename = "radius")]
    pub radius_rule: RadiusRule,
    /// The radius of vessels that have none, m, positive; without it such a vessel is an error.
    #[serde(rename = "default_radius_m")]
    pub default_radius: Option<f64>,
    /// A CSV file of pairs of point ids to link, which SWC cannot.
    pub loops: Option<PathBuf>,
    /// Whether the vessels of a graph are taken as observed, so that candidates are built around them.
    pub observed: bool,
    /// Bytes at the most, of each file and of all that is compressed in it.
    pub max_input: u64,
}

impl Default for ReadOptions {
    fn default() -> Self {
        Self {
            scale: Scale::default(),
            radius_array: None,
            radius_rule: RadiusRule::default(),
            default_radius: None,
            loops: None,
            observed: false,
            max_input: MAX_INPUT,
        }
    }
}

impl ReadOptions {
    /// Checks every field.
    ///
    /// # Errors
    ///
    /// Names the field, its value and the range.
    pub fn validate(&self) -> Result<()> {
        self.scale.validate()?;
        match self.default_radius {
            Some(m) if !(m.is_finite() && m > 0.0) => {
                Err(Error::parameter("default_radius", millimetres(m), "expected a positive length"))
            }
            _ => Ok(()),
        }
    }
}

/// Reads centerlines or a graph.
///
/// # Errors
///
/// A file that cannot be read, is in none of the formats, or has a fault in its content; a loops file with a graph.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Document> {
    let (format, mut content, mut notes, sha256) = read_any(path, options)?;
    check_extent(&content).map_err(|fault| fault.in_file(path))?;
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = &mut content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("loops", loops.display(), accepted));
        };
        let bytes = bytes_within(loops, options.max_input)?;
        let added = add_loops(&bytes, lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{} added from {}", counted(added, "link"), loops.display()));
    }
    notes.extend(unit_check(&content, &options.scale));
    Ok(Document { format, content, notes, sha256 })
}

/// Reads a file without those beside it, and its SHA-256; GraphML, of which the text is much longer than the graph, as a
/// stream.
fn read_any(path: &Path, options: &ReadOptions) -> Result<(Format, Content, Vec<String>, String)> {
    let mut file = Counted::open(path, options.max_input)?;
    let unread = |source| Error::Read { path: path.to_owned(), source };
    let mut all = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut all).map_err(unread)?;
    if xml::root(without_mark(&all)).is_some_and(|(name, _)| name == "graphml") {
        let stream = BufReader::with_capacity(HEAD as usize, Cursor::new(all).chain(&mut file));
        let (graph, notes) =
            read_graphml(stream, &options.scale, options.default_radius.is_some()).map_err(|fault| fault.in_file(path))?;
        return Ok((Format::GraphMl, Content::Graph(graph), notes, file.checksum()));
    }
    file.read_to_end(&mut all).map_err(unread)?;
    let sha256 = file.checksum();
    let bytes = without_mark(&all);
    let format = format_of(path, bytes).map_err(|fault| fault.in_file(path))?;
    let (format, content, notes) = read_as(format, path, bytes, options)?;
    Ok((format, content, notes, sha256))
}

/// The format of a file with what lies beside it, what it holds, and what a person should know about it.
fn read_as(format: Format, path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Format, Content, Vec<String>)> {
    let (scale, optional) = (&options.scale, options.default_radius.is_some());
    let radius = match options.radius_array.as_deref() {
        Some(name) => RadiusArray::Named(name),
        None if optional => RadiusArray::Optional,
        None => RadiusArray::Usual,
    };
    let room = Room::of(bytes.len(), options.max_input);
    let here = |fault: Fault| fault.in_file(path);
    let lines = |read: Result<(Centerlines, Vec<String>), Fault>| {
        read.map_err(here).map(|(lines, notes)| (Content::Centerlines(lines), notes))
    };
    let read = match format {
        Format::Swc => return read_tracing(path, bytes, options),
        Format::ICafe => read_table_of_vessels(path, bytes, options),
        Format::Csv => read_tables(path, bytes, options),
        Format::Voreen => table_pair::read_voreen(path, bytes, options),
        Format::VesselVio => table_pair::read_vesselvio(path, bytes, options),
        Format::GraphMl => {
            read_graphml(bytes, scale, optional).map_err(here).map(|(graph, notes)| (Content::Graph(graph), notes))
        }
        Format::Npz => unpack_skeleton_npz(bytes, scale, optional, &room).map_err(here),
        Format::Vtp => lines(unpack_vtp(bytes, scale, radius, &room)),
        Format::Vtk => lines(read_vtk(bytes, scale, radius)),
        Format::Tre => lines(read_tre(bytes, scale, optional)),
        Format::Markups => lines(read_markups(bytes, scale, radius)),
        Format::Points => lines(read_points(bytes, scale, optional)),
        Format::VTrails => lines(unpack_vtrails(bytes, scale, optional, &room)),
    };
    read.map(|(content, notes)| (format, content, notes))
}

/// A table of edges, with the table of nodes beside it.
fn read_tables(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let (beside, scale) = (nodes_beside(path), &options.scale);
    let read = |nodes: &PathBuf| {
        let bytes = bytes_within(nodes, options.max_input)?;
        read_csv_nodes(without_mark(&bytes), scale).map_err(|fault| fault.in_file(nodes))
    };
    let nodes = beside.as_ref().map(read).transpose()?;
    let (network, mut notes) =
        read_csv_edges(bytes, nodes, scale, options.default_radius.is_some()).map_err(|fault| fault.in_file(path))?;
    notes.extend(beside.map(|nodes| format!("nodes are those of {}", nodes.display())));
    Ok((Content::Graph(network), notes))
}

/// All bytes of a file.
///
/// # Errors
///
/// It cannot be read, or has more than [`MAX_INPUT`]: names it.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    bytes_up_to(path, MAX_INPUT, "")
}

/// The bytes after a byte order mark.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// A network made of a file's content.
#[derive(Debug, Clone)]
pub struct Made {
    /// The network.
    pub network: Network,
    /// The centerlines that it was made of, welded.
    pub lines: Option<Centerlines>,
    /// What a person should know about how it was made, one line each.
    pub notes: Vec<String>,
}

impl Content {
    /// Makes a network of centerlines, or of vessels as they stand; `default_radius` (m) is that of vessels without any.
    ///
    /// # Errors
    ///
    /// No vessel, one without length, or one without a radius where no default is given.
    pub fn into_network(self, rule: RadiusRule, default_radius: Option<f64>) -> Result<Made, Fault> {
        let mut notes = Vec::new();
        let mut note = |count: usize, noun: &str, what: &str| {
            if count > 0 {
                notes.push(format!("{} {what}", counted(count, noun)));
            }
        };
        let defaulted = format!(
            "without any radius: took --default-radius, {} mm",
            default_radius.map_or(String::new(), |r| millimetres(r).to_string())
        );
        let (network, lines) = match self {
            Self::Centerlines(mut lines) => {
                note(lines.weld(WELD_TOLERANCE), "point", "coinciding with another: made one with it");
                let made = contract(&lines, rule, default_radius)?;
                note(made.repaired_radii, "point", "without a positive finite radius: interpolated along the vessel");
                note(made.mixed_labels, "vessel", "with more than one label along them: took that of the longest part");
                note(made.default_radii, "vessel", &defaulted);
                (made.network, Some(lines))
            }
            Self::Vessels(mut network) | Self::Graph(mut network) => {
                let without: Vec<usize> = (0..network.vessel_count()).filter(|v| network.vessel(*v).radius.is_nan()).collect();
                match (default_radius, without.first()) {
                    (None, None) => {}
                    (None, Some(row)) => {
                        let accepted = "expected a positive radius, or --default-radius LENGTH";
                        return Err(Fault::item(format!("vessel {row}"), "no valid radius", accepted));
                    }
                    (Some(radius), _) => {
                        for row in &without {
                            network.vessel_mut(*row).radius = radius;
                        }
                        note(without.len(), "vessel", &defaulted);
                    }
                }
                (network, None)
            }
        };
        if network.vessel_count() == 0 {
            return Err(Fault::file("no vessel", "expected centerlines with at least two linked points, or edges"));
        }
        Ok(Made { network, lines, notes })
    }
}
