//! Reads an input file of any format and makes a network of it.

use std::io::{BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::format::{Format, HEAD, format_of};
use super::unit_check::{check_extent, unit_check};
use super::xml;
use crate::formats::graphml::read_graphml;
use crate::formats::images::nifti::{self, is_nifti};
use crate::formats::input::{LimitedFile, MAX_INPUT, bytes_up_to, checksum, content_within, unpacked, unpacked_head};
use crate::formats::tables::lists::add_loops;
use crate::formats::tables::reader::plural;
use crate::masks::{Cavities, Foreground, RadiusFrom};
use willis_core::error::{Error, Fault, Result};
use willis_core::network::centerlines::Centerlines;
use willis_core::network::units::{Scale, millimetres};
use willis_core::network::{Frame, Network, RadiusRule, WELD_TOLERANCE, contract};
use willis_core::support::geometry::Point;

/// The content of a file.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a file has one")]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Observed vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Vessels(Network),
    /// A graph whose edges are vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Graph(Network),
}

/// A file that has been read.
#[derive(Debug, Clone)]
pub struct Document {
    /// Its format.
    pub format: Format,
    /// Its content.
    pub content: Content,
    /// Notes for the user about how it was read, one line each.
    pub notes: Vec<String>,
    /// The SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
    /// The voxels inside vessels, in the order of the scanner's axes; `None` for a file that is no mask.
    pub lumen: Option<Foreground>,
}

/// How to read a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReadOptions {
    /// The unit of its coordinates, lengths and radii.
    pub scale: Scale,
    /// The array of a VTK file, or the measurement of markups, that holds the radius, if it has none of the usual names. An array
    /// with "area" in its name holds areas.
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
    /// The least value of a vessel's voxel in an image of probabilities or intensities, whose values then tell how much of the voxels at a
    /// wall is inside; without it the image holds classes.
    pub level: Option<f64>,
    /// What the radius of a mask's centerlines is.
    pub radius_from: RadiusFrom,
    /// What is done with the cavities of a mask.
    pub cavities: Cavities,
    /// The corners of the image's box with the least and the largest coordinates, m, in the frame of the file. A free end at its faces is
    /// where a vessel leaves the image. A mask states its own.
    #[serde(rename = "box_m")]
    pub field_of_view: Option<[Point; 2]>,
    /// Which way the axes of a file point that does not state it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<Frame>,
    /// The most bytes of each file, and of all that is compressed in it.
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
            level: None,
            field_of_view: None,
            radius_from: RadiusFrom::default(),
            cavities: Cavities::default(),
            frame: None,
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
        if let Some(level) = self.level.filter(|level| !level.is_finite()) {
            return Err(Error::parameter("level", level, "expected a finite number"));
        }
        if let Some([low, high]) = self.field_of_view.filter(|[low, high]| !(0..3).all(|k| low[k] < high[k])) {
            let given: Vec<String> = low.iter().chain(&high).map(|m| millimetres(*m).to_string()).collect();
            let accepted = "expected the least x,y,z and the largest x,y,z, in mm";
            return Err(Error::parameter("box", given.join(","), accepted));
        }
        match self.default_radius {
            Some(m) if !(m.is_finite() && m > 0.0) => {
                Err(Error::parameter("default_radius", millimetres(m), "expected a positive length"))
            }
            _ => Ok(()),
        }
    }

    /// Whether vessels may lack any radius.
    pub fn is_radius_optional(&self) -> bool {
        self.default_radius.is_some()
    }
}

/// Reads centerlines or a graph.
///
/// # Errors
///
/// A file that cannot be read, has no known format or wrong content; a loops file with a graph.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Document> {
    completed(read_any(path, options)?, path, options)
}

/// Reads the bytes of a file that would be called `name`. Tables of two files are read from files only.
///
/// # Errors
///
/// As [`read`].
pub fn read_bytes(name: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Document> {
    completed(read_content(name, bytes.to_vec(), checksum(bytes), options)?, name, options)
}

/// What was read, checked, with the links of the file beside it.
fn completed(mut document: Document, path: &Path, options: &ReadOptions) -> Result<Document> {
    let Document { format, content, notes, .. } = &mut document;
    check_extent(content).map_err(|fault| fault.in_file(path))?;
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("loops", loops.display(), accepted));
        };
        let bytes = content_within(loops, options.max_input)?;
        let added = add_loops(&bytes, lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{} added from {}", plural(added, "link"), loops.display()));
    }
    notes.extend(unit_check(content, &options.scale, format.is_mask()));
    Ok(document)
}

/// Reads what a file holds, whose checksum is given. Gzip around it is taken off, but for NIfTI, whose reader does so piece by piece.
fn read_content(path: &Path, mut bytes: Vec<u8>, sha256: String, options: &ReadOptions) -> Result<Document> {
    let here = |fault: Fault| fault.in_file(path);
    if !is_nifti(&unpacked_head(&bytes, nifti::HEAD)) {
        bytes = unpacked(bytes, options.max_input).map_err(here)?;
    }
    let bytes = without_mark(&bytes);
    format_of(path, bytes).map_err(here)?.read(path, bytes, sha256, options)
}

/// Reads a file and computes its SHA-256. GraphML is read as a stream where it is not packed.
fn read_any(path: &Path, options: &ReadOptions) -> Result<Document> {
    let mut file = LimitedFile::open(path, options.max_input)?;
    let unread = |source| Error::Read { path: path.to_owned(), source };
    let mut all = Vec::new();
    file.by_ref().take(HEAD).read_to_end(&mut all).map_err(unread)?;
    if xml::root(without_mark(&all)).is_some_and(|(name, _)| name == "graphml") {
        let stream = BufReader::with_capacity(HEAD as usize, Cursor::new(all).chain(&mut file));
        let (graph, notes) = read_graphml(stream, options).map_err(|fault| fault.in_file(path))?;
        let (format, content) = (Format::GraphMl, Content::Graph(graph));
        return Ok(Document { format, content, notes, sha256: file.checksum(), lumen: None });
    }
    file.read_to_end(&mut all).map_err(unread)?;
    let sha256 = file.checksum();
    read_content(path, all, sha256, options)
}

/// All bytes of a file, without the gzip around them.
///
/// # Errors
///
/// The file cannot be read, is damaged, or has more than `MAX_INPUT` bytes; the error names it.
pub fn bytes_of(path: &Path) -> Result<Vec<u8>> {
    unpacked(bytes_up_to(path, MAX_INPUT, "")?, MAX_INPUT).map_err(|fault| fault.in_file(path))
}

/// The bytes after a byte order mark.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// A network made of a file's content.
#[derive(Debug, Clone)]
pub struct BuiltNetwork {
    /// The network.
    pub network: Network,
    /// The centerlines that it was made of, with coincident points merged.
    pub lines: Option<Centerlines>,
    /// Notes for the user about how it was made, one line each.
    pub notes: Vec<String>,
}

impl Content {
    /// Makes a network of centerlines, or of ready vessels; `default_radius` (m) is for vessels without any radius.
    ///
    /// # Errors
    ///
    /// No vessel, one without length, or one without a radius where no default is given.
    pub fn into_network(self, rule: RadiusRule, default_radius: Option<f64>) -> Result<BuiltNetwork, Fault> {
        let mut notes = Vec::new();
        let mut note = |count: usize, noun: &str, what: &str| {
            if count > 0 {
                notes.push(format!("{} {what}", plural(count, noun)));
            }
        };
        let defaulted = format!(
            "without any radius: took `default_radius`, {} mm",
            default_radius.map_or(String::new(), |r| millimetres(r).to_string())
        );
        let (network, lines) = match self {
            Self::Centerlines(mut lines) => {
                note(lines.weld(WELD_TOLERANCE), "point", "coinciding with another: merged with it");
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
                        let accepted = "expected a positive radius, or `default_radius`";
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
        Ok(BuiltNetwork { network, lines, notes })
    }
}
