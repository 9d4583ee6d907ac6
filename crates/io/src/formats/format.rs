//! Which format a file has, which reader and writer belong to each, which other files in its folder belong to it (the second of two tables, the files
//! of an iCafe tracing, voxels), and how a network is made of an input of any.

use std::io::{self, BufReader, Cursor, Read};
use std::path::{Path, PathBuf};

use super::images::{metaimage, nifti, nrrd, numpy, stored_image::StoredImage, tiff};
use super::input::{
    HEAD, LimitedFile, bytes_within, is_gzip, refuse_utf16, unpacked_file, unpacked_head, unpacked_name, without_mark,
};
use super::tables::pairs::{self, edges_refer_to_rows, find_edges_table, head, read_csv_tables, read_table_pair};
use super::tables::reader::{counted, delimiter, plural};
use super::vendors::icafe::{self, read_table_of_vessels, read_tracing};
use super::{
    Content, Format, FormatTrait, ReadOptions, SolverSetting, add_loops, checksum, content::check_extent, content::unit_check,
    ensure, find, graph_columns, read_amira, read_graphml, read_markups, read_points, read_skeleton_npz, read_tre,
    read_vesselvio_edges, read_vesselvio_vertices, read_voreen_edges, read_voreen_nodes, read_vtk, read_vtp, read_vtrails,
    solvers::is_openbf, solvers::is_svzerod, tables::graph, vendors::amira::is_amira, write_amira, write_csv_graph,
    write_graphml, write_markups, write_openbf, write_points, write_skeleton_npz, write_svzerod, write_swc, write_tre,
    write_vesselvio, write_voreen, write_vtk, write_vtp, xml,
};
use crate::masks::{Cavities, Filled, Foreground, Image, Mask, RadiusFrom, trace, why_no_centerlines, why_no_vessels};
use willis_core::error::{Error, Fault, Result};
use willis_core::network::{Centerlines, Frame, Network, millimetres};

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

/// What remains after a network was written: links for a second file, and notes.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Written {
    /// Pairs of point ids for the file [`Target::loops`](super::convert::Target::loops), where there are any.
    pub loops: Vec<[u64; 2]>,
    /// Notes for the user.
    pub notes: Vec<String>,
    /// The ids of the nodes whose courses openBF takes from inlet files, in the order of their numbers.
    pub inlets: Vec<String>,
}

impl Format {
    /// Reads a file of this format, whose checksum is given, and the other files that belong to it. An SWC file with a table of vessels
    /// is one of iCafe.
    pub(crate) fn read(self, path: &Path, bytes: &[u8], sha256: String, options: &ReadOptions) -> Result<Document> {
        let lines = |(lines, notes): (Centerlines, Vec<String>)| (Content::Centerlines(lines), notes);
        let graph = |(graph, notes): (Network, Vec<String>)| (Content::Graph(graph), notes);
        let vessels = |(vessels, notes): (Network, Vec<String>)| (Content::Vessels(vessels), notes);
        let here = |fault: Fault| fault.in_file(path);
        let (mut format, mut lumen) = (self, None);
        let (content, notes) = match self {
            Self::Swc => {
                let (has_table, lines, notes) = read_tracing(path, bytes, options)?;
                format = if has_table { Self::ICafe } else { Self::Swc };
                (lines, notes)
            }
            Self::ICafe => read_table_of_vessels(path, bytes, options)?,
            Self::Csv => graph(read_csv_tables(path, bytes, options)?),
            Self::Voreen => vessels(read_table_pair(path, bytes, options, read_voreen_nodes, read_voreen_edges)?),
            Self::VesselVio => read_table_pair(path, bytes, options, read_vesselvio_vertices, read_vesselvio_edges)?,
            Self::GraphMl => graph(read_graphml(bytes, options).map_err(here)?),
            Self::Npz => read_skeleton_npz(bytes, options).map_err(here)?,
            Self::Vtp => lines(read_vtp(bytes, options).map_err(here)?),
            Self::Vtk => lines(read_vtk(bytes, options).map_err(here)?),
            Self::Tre => lines(read_tre(bytes, options).map_err(here)?),
            Self::Amira => lines(read_amira(bytes, options).map_err(here)?),
            Self::Markups => lines(read_markups(bytes, options).map_err(here)?),
            Self::Points => lines(read_points(bytes, options).map_err(here)?),
            Self::VTrails => lines(read_vtrails(bytes, options).map_err(here)?),
            Self::Nifti | Self::MetaImage | Self::Nrrd | Self::Tiff | Self::Npy => {
                let mask = self.read_mask(path, bytes, options)?;
                if self.is(FormatTrait::GivenSpacing) {
                    check_spacing(&mask, options.scale.spacing).map_err(here)?;
                }
                let (traced, voxels, notes) = centerlines_of(mask, options).map_err(here)?;
                lumen = Some(voxels);
                lines((traced, notes))
            }
            Self::SvZeroD | Self::OpenBf => {
                return Err(here(Fault::file(format!("{}, which is only written", self.name()), Self::expected())));
            }
        };
        Ok(Document { format, content, notes, sha256, lumen })
    }

    /// Opens the voxels in a file of this format, which is to be `what`; a second file goes to `other`.
    fn open_voxels<'a>(
        self,
        what: &str,
        path: &Path,
        bytes: &'a [u8],
        other: &'a mut Vec<u8>,
        options: &ReadOptions,
    ) -> Result<StoredImage<'a>> {
        let (spacing, most) = (options.scale.spacing, options.max_input);
        let opened = match self {
            Self::MetaImage => return metaimage::open_metaimage(path, bytes, other, spacing, most),
            Self::Nrrd => return nrrd::open_nrrd(path, bytes, other, spacing, most),
            Self::Nifti => nifti::open_nifti(bytes, most),
            Self::Tiff => tiff::open_tiff(bytes, spacing, most),
            Self::Npy => numpy::open_numpy(bytes, spacing, most, other),
            _ => {
                let accepted = format!("expected {} voxels", Self::listed(FormatTrait::Mask, "or"));
                Err(Fault::file(format!("{}, not {what}", self.name()), accepted))
            }
        };
        let (voxels, stream) = opened.map_err(|fault| fault.in_file(path))?;
        Ok(StoredImage { file: path.to_owned(), voxels, layers: None, stream })
    }

    /// Reads the mask in the bytes of a file of this format; `path` tells where a second file is.
    ///
    /// # Errors
    ///
    /// A format of something else; a file that is cut, no mask of three dimensions, or one without a usable frame.
    pub fn read_mask(self, path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<Mask> {
        self.open_voxels("a mask", path, bytes, &mut Vec::new(), options)?.mask(options.level, options.max_input)
    }

    /// Writes a network, its nodes into `nodes` where the format has two tables. The links that close loops where the format cannot hold them, and
    /// the inlets, are noted in `written`.
    pub(crate) fn write(
        self,
        network: &Network,
        setting: &SolverSetting,
        mut vessels: impl io::Write + io::Seek,
        nodes: impl io::Write,
        written: &mut Written,
    ) -> io::Result<()> {
        let out = &mut vessels;
        match self {
            Self::Swc => written.loops = write_swc(out, network)?,
            Self::Vtp => write_vtp(out, network, &graph_columns(network).1)?,
            Self::Vtk => write_vtk(out, network, &graph_columns(network).1)?,
            Self::GraphMl => {
                let (of_nodes, of_vessels) = graph_columns(network);
                write_graphml(out, network, &of_nodes, &of_vessels)?;
            }
            Self::Csv => write_csv_graph(nodes, out, network)?,
            Self::Points => write_points(out, network)?,
            Self::Voreen => write_voreen(nodes, out, network)?,
            Self::VesselVio => write_vesselvio(nodes, out, network)?,
            Self::Markups => write_markups(out, network)?,
            Self::Tre => write_tre(out, network)?,
            Self::Amira => write_amira(out, network)?,
            Self::Npz => write_skeleton_npz(out, network)?,
            Self::SvZeroD => write_svzerod(out, network, setting)?,
            Self::OpenBf => written.inlets = write_openbf(out, network, setting)?,
            Self::ICafe | Self::VTrails | Self::Nifti | Self::MetaImage | Self::Nrrd | Self::Tiff | Self::Npy => {
                return Err(super::refused("it is only read"));
            }
        }
        Ok(())
    }
}

/// Reads the mask in a file, of any of the formats of masks, into the `frame` of the centerlines that it lies beside.
///
/// # Errors
///
/// A file that cannot be read, holds no mask, or has a fault in its content.
pub fn read_mask(path: &Path, options: &ReadOptions, frame: Frame) -> Result<Mask> {
    let bytes = bytes_within(path, options.max_input)?;
    let format = format_of(path, &bytes).map_err(|fault| fault.in_file(path))?;
    let mut other = Vec::new();
    let stored = format.open_voxels("a mask", path, &bytes, &mut other, options)?;
    let mut mask = stored.in_frame(frame).mask(options.level, options.max_input)?;
    if options.cavities == Cavities::Fill {
        mask.fill_cavities();
    }
    Ok(mask)
}

/// Reads the image in a file, of any of the formats of masks, into the `frame` of the centerlines that it lies beside; and its SHA-256.
///
/// # Errors
///
/// A file that cannot be read, holds no image, or has a fault in its content.
pub fn read_image(path: &Path, options: &ReadOptions, frame: Frame) -> Result<(Image, String)> {
    let bytes = bytes_within(path, options.max_input)?;
    let format = format_of(path, &bytes).map_err(|fault| fault.in_file(path))?;
    let mut other = Vec::new();
    let stored = format.open_voxels("an image", path, &bytes, &mut other, options)?;
    Ok((stored.in_frame(frame).image(options.max_input)?, checksum(&bytes)))
}

/// Refuses a spacing that is given for a mask whose file states another one.
fn check_spacing(mask: &Mask, given: Option<[f64; 3]>) -> Result<(), Fault> {
    let stated = mask.as_in_file(mask.spacing());
    let is_other = given.is_some_and(|given| (0..3).any(|axis| (given[axis] / stated[axis] - 1.0).abs() > 1e-6));
    let found = || format!("states voxels of {} mm", stated.map(|mm| mm.to_string()).join(" x "));
    ensure(!is_other, || Fault::file(found(), "expected no other `spacing`"))
}

/// The centerlines of a mask and the voxels inside its vessels, with what a person should know about them.
fn centerlines_of(mask: Mask, options: &ReadOptions) -> Result<(Centerlines, Foreground, Vec<String>), Fault> {
    let ([x, y, z], spacing) = (mask.as_in_file(mask.shape), mask.as_in_file(mask.spacing()));
    let size = spacing.map(|mm| ((mm * 1e4).round() / 1e4).to_string()).join(" x ");
    let frame = match (mask.frame, options.frame) {
        (Frame::Unknown, Some(Frame::Ras)) => "in the frame of its axes, RAS as `frame` states",
        (Frame::Unknown, Some(Frame::Lps)) => "in the frame of its axes, LPS as `frame` states",
        (Frame::Unknown, _) => "in the frame of its axes, as nobody states which way they point",
        (Frame::Ras | Frame::Lps, _) => "in the scanner's frame (RAS: right, anterior, superior)",
    };
    let walls = mask.walls.as_ref().filter(|_| options.radius_from == RadiusFrom::Area).map(|walls| walls.values);
    let stated = if mask.frame.is_known() { mask.frame } else { options.frame.unwrap_or_default() };
    let mut mask = Mask { frame: stated, ..mask }.in_scanner_order();
    let cleans = options.cavities == Cavities::Fill;
    let no_vessels = |why: String| Fault::file(why, "expected a mask of vessels; `cavities=keep` goes on with any");
    if let Some(why) = why_no_vessels(&mask).filter(|_| cleans) {
        return Err(no_vessels(why));
    }
    let filled = if cleans { mask.fill_cavities() } else { Filled::default() };
    let traced = trace(&mask, options.radius_from, options.cavities);
    let traced =
        traced.ok_or_else(|| Fault::file(format!("{x} x {y} x {z} voxels"), "expected at most 4 billion around vessels"))?;
    if let Some(why) = why_no_centerlines(&traced.lines).filter(|_| cleans) {
        return Err(no_vessels(why));
    }
    if traced.lines.links.is_empty() {
        let found = format!("no vessel in a mask of {x} x {y} x {z} voxels: {}", plural(traced.specks, "speck"));
        return Err(Fault::file(found, "expected a part that is longer than wide; `cavities=keep` takes all"));
    }
    let mut notes = vec![format!("a mask of {x} x {y} x {z} voxels of {size} mm: centerlines by thinning, {frame}")];
    notes.append(&mut mask.notes);
    notes.extend(walls.map(|walls| match walls {
        [0.0, 1.0] => "radii take values as the part of a voxel that is inside a vessel".to_owned(),
        [a, b] => format!("radii take voxels at a wall in part: {} is outside a vessel, {} inside", a as f32, b as f32),
    }));
    let cavities = |count: usize| if count == 1 { "1 cavity".to_owned() } else { format!("{count} cavities") };
    if filled.cavities > 0 {
        notes.push(format!("{} of {} filled", cavities(filled.cavities), plural(filled.voxels, "voxel")));
    }
    if filled.wide > 0 {
        let (wide, are) = (cavities(filled.wide), if filled.wide == 1 { "is" } else { "are" });
        notes.push(format!("{wide} {are} wider than half of the vessel around it, as where only walls are segmented; `cavities=keep` leaves all as they are"));
    }
    notes.extend(counted(traced.spurs, "spur", "removed that hardly left the lumen of another vessel"));
    if traced.specks > 0 {
        let length = millimetres(traced.speck_length);
        notes.push(format!("{} left out, shorter than wide: {length:.0} mm in all", plural(traced.specks, "speck")));
    }
    Ok((traced.lines, traced.lumen, notes))
}

/// Finds the format by the first bytes, then by the file ending, then by the first line with content.
pub(crate) fn format_of(path: &Path, bytes: &[u8]) -> Result<Format, Fault> {
    ensure(!bytes.trim_ascii().is_empty(), || Fault::file("the file is empty", Format::expected()))?;
    refused(path, bytes).map_or(Ok(()), Err)?;
    if let Some(format) = by_signature(bytes)? {
        return Ok(format);
    }
    match xml::root(bytes) {
        Some(("VTKFile", tag)) if ["\"PolyData\"", "'PolyData'"].iter().any(|kind| tag.contains(kind)) => return Ok(Format::Vtp),
        Some(("VTKFile", _)) => return Err(Fault::file("a VTKFile of another type than PolyData", Format::expected())),
        Some(("graphml", _)) => return Ok(Format::GraphMl),
        Some((name, _)) => return Err(Fault::file(format!("XML with the root element <{name}>"), Format::expected())),
        None => {}
    }
    let head = String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 16)]);
    let mut lines = head.split(['\r', '\n']).map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next().unwrap_or_default();
    let is_point = || first.split_whitespace().count() == 7 && first.split_whitespace().all(|w| w.parse::<f64>().is_ok());
    let found = match unpacked_name(path).extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("swc") => Some(Format::Swc),
        Some("csv" | "tsv") => table(path, first).or(Some(Format::Csv)),
        _ => table(path, first).or_else(|| is_point().then_some(Format::Swc)),
    };
    found.ok_or_else(|| Fault::file("the format is not known", Format::expected()))
}

/// Whether a file begins as an archive does.
fn is_zip(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"PK\x05\x06")
}

/// The format of a file that begins with a signature.
fn by_signature(bytes: &[u8]) -> Result<Option<Format>, Fault> {
    const HDF5: &[u8] = b"\x89HDF\r\n\x1a\n";
    refuse_utf16(bytes)?;
    if nifti::is_nifti(&unpacked_head(bytes, nifti::HEAD)) {
        return Ok(Some(Format::Nifti));
    }
    ensure(!is_gzip(bytes), || Fault::file("the file is packed by gzip twice", "expected a file that is packed once"))?;
    let holds_hdf5 = bytes.get(512..).is_some_and(|rest| rest.starts_with(HDF5));
    let wrong = || Fault::file("a MATLAB file before version 7.3", "expected version 7.3 (save with -v7.3)");
    ensure(holds_hdf5 || !bytes.starts_with(b"MATLAB 5.0 MAT-file"), wrong)?;
    let text = bytes.trim_ascii_start();
    let is_tre = || {
        let line = text.split(|b| *b == b'\n').next().unwrap_or_default();
        let key = line.split(|b| *b == b'=').next().unwrap_or_default().trim_ascii();
        ["ObjectType", "Comment", "NDims"].iter().any(|k| key == k.as_bytes() && line.contains(&b'='))
    };
    let known = [
        (bytes.starts_with(HDF5) || bytes.starts_with(b"MATLAB 7.3 MAT-file") || holds_hdf5, Format::VTrails),
        (bytes.starts_with(b"\x93NUMPY") || is_zip(bytes) && numpy::is_mask(bytes), Format::Npy),
        (is_zip(bytes), Format::Npz),
        (bytes.starts_with(b"# vtk DataFile"), Format::Vtk),
        (metaimage::is_metaimage(bytes), Format::MetaImage),
        (nrrd::is_nrrd(bytes), Format::Nrrd),
        (tiff::is_tiff(bytes), Format::Tiff),
        (is_amira(bytes), Format::Amira),
        (is_svzerod(text), Format::SvZeroD),
        (is_openbf(text), Format::OpenBf),
        (text.starts_with(b"{"), Format::Markups),
    ];
    Ok(first_that_is(known).or_else(|| is_tre().then_some(Format::Tre)))
}

/// The format of the first row that says so.
fn first_that_is<const N: usize>(known: [(bool, Format); N]) -> Option<Format> {
    known.into_iter().find(|(is_so, _)| *is_so).map(|(_, format)| format)
}

/// The table that a header line begins.
///
/// Edges by the columns `Source ID,Target ID` are VesselVio's, and so are edges by `source,target` whose table of nodes has
/// no names (`node`, `id`): these can only be rows. So is a table of positions without names in the folder of a table of edges.
fn table(path: &Path, header: &str) -> Option<Format> {
    let header = header.trim_start_matches('\u{feff}');
    let columns: Vec<&str> = header.split(delimiter(header)).map(|column| column.trim().trim_matches('"')).collect();
    let has = |names: &[&str]| names.iter().all(|name| columns.iter().any(|column| column.eq_ignore_ascii_case(name)));
    let named = has(&["node"]) || has(&["id"]);
    let known = [
        (has(&["node1id", "node2id"]) || has(&["id", "pos_x", "pos_y", "pos_z"]), Format::Voreen),
        (has(&["source id", "target id"]) || (has(&["source", "target"]) && edges_refer_to_rows(path)), Format::VesselVio),
        (graph::is_header(&columns), Format::Csv),
        (has(&["fragment"]), Format::Points),
        (icafe::is_header(&columns), Format::ICafe),
        (has(&["x", "y", "z"]) && !named && find_edges_table(path).is_some(), Format::VesselVio),
    ];
    first_that_is(known)
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
    content.settle_labels();
    check_extent(content).map_err(|fault| fault.in_file(path))?;
    if let Some(loops) = &options.loops {
        let Content::Centerlines(lines) = content else {
            let accepted = format!("goes with centerlines; {} holds a graph, which can have loops itself", path.display());
            return Err(Error::parameter("loops", loops.display(), accepted));
        };
        let bytes = unpacked_file(bytes_within(loops, options.max_input)?, loops, options.max_input)?;
        let added = add_loops(&bytes, lines).map_err(|fault| fault.in_file(loops))?;
        notes.push(format!("{} added from {}", plural(added, "link"), loops.display()));
    }
    let unit = if let Content::Centerlines(lines) = content { lines.unit } else { None };
    notes.extend(unit_check(content, &options.scale.in_unit(unit), format.is_mask()));
    Ok(document)
}

/// Reads what a file holds, whose checksum is given. Gzip around it is taken off, but for NIfTI, whose reader does so piece by piece.
fn read_content(path: &Path, mut bytes: Vec<u8>, sha256: String, options: &ReadOptions) -> Result<Document> {
    let here = |fault: Fault| fault.in_file(path);
    if !nifti::is_nifti(&unpacked_head(&bytes, nifti::HEAD)) {
        bytes = unpacked_file(bytes, path, options.max_input)?;
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
        return Ok(Document { format, content, notes, sha256: file.file.finish(), lumen: None });
    }
    file.read_to_end(&mut all).map_err(unread)?;
    let sha256 = file.file.finish();
    read_content(path, all, sha256, options)
}

/// Why a file is not read that begins with these bytes, if its format is one of those.
fn refused(path: &Path, bytes: &[u8]) -> Option<Fault> {
    let head = &bytes[..bytes.len().min(HEAD as usize)];
    let has = |word: &[u8]| find(head, word).is_some();
    let ending = unpacked_name(path).extension().map(std::ffi::OsStr::to_ascii_lowercase);
    let is_called = |word: &str| ending.as_ref().is_some_and(|ending| *ending == *word);
    let (found, accepted) = if head.get(128..132) == Some(b"DICM") {
        // The class of segmentations stands in the first group.
        let kind = if has(b"1.2.840.10008.5.1.4.1.1.66.4") { "a segmentation in DICOM (DICOM SEG)" } else { "a file of DICOM" };
        (kind, "expected a mask in NIfTI or NRRD: export it with 3D Slicer, or with segimage2itkimage of dcmqi")
    } else if head.starts_with(b"CDF\x01")
        || head.starts_with(b"CDF\x02")
        || (head.starts_with(b"\x89HDF") && (is_called("mnc") || has(b"minc-2.0")))
    {
        ("a volume in MINC", "expected NIfTI: convert it with mnc2nii")
    } else if head.starts_with(&[0, 0, 0, 1]) && (is_called("mgz") || is_called("mgh")) {
        ("a volume of FreeSurfer (.mgz)", "expected NIfTI: convert it with mri_convert")
    } else if head.starts_with("⛾ gt".as_bytes()) {
        ("a graph of graph-tool (.gt)", "expected GraphML: save it with graph.save(\"name.graphml\")")
    } else {
        let root = xml::root(head).map(|(name, _)| name.to_owned())?;
        let is = |word: &str| root == word || (root == "format" && has(format!("<{word} ").as_bytes()));
        let centerlines = "expected centerlines: extract those of the model in SimVascular, and save them as .vtp";
        if is("contourgroup") || (root == "format" && is_called("ctgr")) {
            ("contours of SimVascular (.ctgr)", centerlines)
        } else if is("path") || (root == "format" && is_called("pth")) {
            ("a path of SimVascular (.pth), which has no radii", centerlines)
        } else {
            return None;
        }
    };
    Some(Fault::file(found, accepted))
}

/// The other files that [`read`] reads for `path`, as the folder is now, sorted by name.
pub fn companion_files(path: &Path) -> Vec<PathBuf> {
    let head = head(path);
    let bytes = without_mark(&head);
    let found = match format_of(path, bytes) {
        Ok(Format::Csv) => [pairs::find_nodes_table(path), None],
        Ok(Format::Voreen | Format::VesselVio) => [pairs::other_table(path, bytes).ok().and_then(|(_, other)| other), None],
        Ok(Format::Swc) => [icafe::find(path, icafe::TABLE_OF_VESSELS), icafe::find(path, icafe::IMAGE)],
        Ok(Format::ICafe) => [icafe::find_tracing(path).ok(), icafe::find(path, icafe::IMAGE)],
        Ok(Format::MetaImage) => [metaimage::file_of_voxels(path, bytes), None],
        Ok(Format::Nrrd) => [nrrd::file_of_voxels(path, bytes), None],
        _ => [None, None],
    };
    let mut found: Vec<PathBuf> = found.into_iter().flatten().collect();
    found.sort();
    found
}

/// Where the voxel spacing of an input is stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StatedSpacing {
    /// In the file itself, whose coordinates are in mm.
    Within,
    /// In a file beside it, in mm: its coordinates are in voxels.
    Beside(f64),
    /// Nowhere.
    Nowhere,
}

/// Where the voxel spacing of an input is stated: most masks state their own, and Image_info.txt that of an iCafe tracing beside it.
///
/// # Errors
///
/// A file beside it that is there and cannot be read.
pub fn stated_spacing(path: &Path) -> Result<StatedSpacing> {
    let head = head(path);
    Ok(match format_of(path, without_mark(&head)) {
        Ok(format) if format.is(FormatTrait::OwnSpacing) => StatedSpacing::Within,
        Ok(Format::Swc | Format::ICafe) => icafe::image_spacing(path)?.map_or(StatedSpacing::Nowhere, StatedSpacing::Beside),
        _ => StatedSpacing::Nowhere,
    })
}
