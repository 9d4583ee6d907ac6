//! iCafe: labels the branches of a traced SWC file with the arteries that Feature_Vessel.csv in the same folder names.

use std::path::{Path, PathBuf};

use crate::formats::input::{bytes_beside, content_beside, without_mark};
use crate::formats::{Centerlines, Content, Fault, LengthUnit, Point, ReadOptions, Result, Scale, TableReader, read_swc};
use willis_core::support::distinct;

/// iCafe's table of vessels.
pub(crate) const TABLE_OF_VESSELS: &str = "Feature_Vessel.csv";
/// iCafe's description of the image.
pub(crate) const IMAGE: &str = "Image_info.txt";

/// Bytes of Image_info.txt at the most.
const MOST_IMAGE: u64 = 1 << 20;
/// The arteries by `VesselType`; the first is none.
pub const ICAFE_ARTERIES: [&str; 23] = [
    "", "L-ICA", "R-ICA", "L-M1", "R-M1", "L-M2", "R-M2", "L-A1", "R-A1", "L-A2", "R-A2", "AComm", "L-M3", "R-M3", "L-VA",
    "R-VA", "BA", "L-P1", "R-P1", "L-P2", "R-P2", "L-PComm", "R-PComm",
];
/// Both files have six significant digits, so equal positions differ by less than this.
const DIGITS: f64 = 1e-5;
/// Points of a tracing in one place that are looked at: at a junction each branch has one.
const MOST_IN_ONE_PLACE: usize = 64;

/// A row of Feature_Vessel.csv.
#[derive(Debug, Clone, PartialEq)]
pub struct TracedVessel {
    /// The usual name of the artery, `VesselType` in digits where it has none; empty for type 0.
    pub label: String,
    /// Its first and last point, m.
    pub ends: [Point; 2],
    /// How many points it has.
    pub points: Option<usize>,
}

/// Whether a header line is that of Feature_Vessel.csv.
pub(crate) fn is_header(columns: &[&str]) -> bool {
    ["VesselType", "StartPointPositionX", "EndPointPositionX"].iter().all(|name| columns.contains(name))
}

/// The first number of the voxel spacing that Image_info.txt beside a tracing states, mm: iCafe's unit of length.
///
/// # Errors
///
/// The file is there and cannot be read.
pub(crate) fn image_spacing(tracing: &Path) -> Result<Option<f64>> {
    let Some(path) = find(tracing, IMAGE) else { return Ok(None) };
    let text = bytes_beside(&path, MOST_IMAGE)?;
    let text = String::from_utf8_lossy(&text);
    let numbers = text.lines().find_map(|line| line.trim().strip_prefix("Voxel spacing:"));
    let first = numbers.and_then(|numbers| numbers.split_whitespace().next());
    Ok(first.and_then(|number| number.parse().ok()).filter(|x: &f64| x.is_finite() && *x > 0.0))
}

/// Reads Feature_Vessel.csv.
///
/// # Errors
///
/// A missing column, a position that is no number, a type that is no whole number.
pub fn read_traced_vessels(bytes: &[u8], scale: &Scale) -> Result<Vec<TracedVessel>, Fault> {
    let mut rows = TableReader::ragged(bytes)?;
    let line = rows.header_line;
    let missing = |name: &str| Fault::line(line, format!("no column {name}"), format!("expected iCafe's {TABLE_OF_VESSELS}"));
    let column = |name: &str| rows.find(&[name]).ok_or_else(|| missing(name));
    let kind = column("VesselType")?;
    let axis = |end: &str, axis: char| column(&format!("{end}PointPosition{axis}"));
    let end = |end: &str| -> Result<[usize; 3], Fault> { Ok([axis(end, 'X')?, axis(end, 'Y')?, axis(end, 'Z')?]) };
    let ends = [end("Start")?, end("End")?];
    let count = rows.find(&["NumPts"]);
    let mut vessels = Vec::new();
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() {
            continue;
        }
        let ends = [row.position(ends[0])?, row.position(ends[1])?];
        let kind = row.real(kind)?;
        let wrong = || Fault::line(row.line, format!("VesselType {kind}"), "expected a whole number from 0 on");
        crate::formats::ensure(kind >= 0.0 && kind.fract() == 0.0, wrong)?;
        vessels.push(TracedVessel {
            label: ICAFE_ARTERIES.get(kind as usize).map_or_else(|| kind.to_string(), |name| (*name).to_owned()),
            ends: ends.map(|end| scale.position(end)),
            points: count.and_then(|column| row.text(column).parse().ok()),
        });
    }
    Ok(vessels)
}

/// Labels the links of a tracing read by [`crate::formats::swc::read_swc`] with the vessels that run along them, and removes all other
/// labels, since the types of iCafe's points are landmarks. Returns the number of vessels found; if that is 0, nothing changes.
///
/// A vessel is the path within one tree between points at its two ends; where several ends coincide, the path with its number of
/// points, and among those the first that no other vessel has.
pub fn name_stretches(lines: &mut Centerlines, vessels: &[TracedVessel]) -> usize {
    let mut up = vec![None; lines.points.len()];
    for (row, [parent, child]) in lines.links.iter().enumerate() {
        up[*child as usize] = Some((*parent as usize, row));
    }
    let mut by_x: Vec<usize> = (0..lines.points.len()).collect();
    by_x.sort_by(|a, b| lines.points[*a][0].total_cmp(&lines.points[*b][0]));
    let at = |p: Point| {
        let near = |a: f64, b: f64| (a - b).abs() <= DIGITS * a.abs().max(b.abs());
        let slack = 2.0 * DIGITS * p[0].abs();
        let from = by_x.partition_point(|row| lines.points[*row][0] < p[0] - slack);
        let close = by_x[from..].iter().take_while(|row| lines.points[**row][0] <= p[0] + slack);
        let mut rows = distinct(close.copied().filter(|row| (0..3).all(|axis| near(lines.points[*row][axis], p[axis]))));
        rows.truncate(MOST_IN_ONE_PLACE);
        rows
    };
    let mut labels = willis_core::network::Labels::default();
    let mut taken = vec![false; lines.links.len()];
    let mut named = 0;
    for vessel in vessels {
        let [starts, ends] = vessel.ends.map(at);
        let pairs = starts.iter().flat_map(|start| ends.iter().map(|end| (*start, *end)));
        let of_one_tree = pairs.filter(|(start, end)| lines.strand[*start] == lines.strand[*end]);
        let paths = of_one_tree.map(|(start, end)| path_between(&up, start, end)).filter(|path| !path.is_empty());
        let faults = |path: &Vec<usize>| [vessel.points.is_some_and(|n| n != path.len() + 1), taken[path[0]]];
        if let Some(path) = paths.clone().find(|path| faults(path) == [false; 2]).or_else(|| paths.min_by_key(faults)) {
            named += 1;
            for link in path {
                taken[link] = true;
                labels.set(link, &vessel.label);
            }
        }
    }
    if named > 0 {
        lines.labels = labels;
    }
    named
}

/// The links between two points of one tree; points of two trees share no link, and nobody asks for these.
fn path_between(up: &[Option<(usize, usize)>], a: usize, b: usize) -> Vec<usize> {
    let to_root = |point: usize| std::iter::successors(up[point], |(parent, _)| up[*parent]).map(|(_, link)| link);
    let (mut path, other): (Vec<usize>, Vec<usize>) = (to_root(a).collect(), to_root(b).collect());
    let shared = path.iter().rev().zip(other.iter().rev()).take_while(|(link, same)| link == same).count();
    path.truncate(path.len() - shared);
    path.extend(other[..other.len() - shared].iter().rev());
    path
}

/// Reads a tracing, labelled by the table of vessels in its folder if that belongs to it, which is said too.
pub(crate) fn read_tracing(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(bool, Content, Vec<String>)> {
    let (mut lines, mut notes) = read_swc(bytes, &options.scale).map_err(|fault| fault.in_file(path))?;
    let mut has_table = false;
    if let Some(table) = find(path, TABLE_OF_VESSELS)
        && let Some(note) = name_vessels(&mut lines, &content_beside(&table, options.max_input)?, &table, &options.scale)?
    {
        has_table = true;
        notes.push(note);
    }
    notes.extend(spacing_note(path, &options.scale)?);
    Ok((has_table, Content::Centerlines(lines), notes))
}

/// Reads the one tracing in the folder of a table of vessels.
pub(crate) fn read_table_of_vessels(path: &Path, bytes: &[u8], options: &ReadOptions) -> Result<(Content, Vec<String>)> {
    let here = |fault: Fault| fault.in_file(path);
    let tracing = find_tracing(path).map_err(here)?;
    let traced = content_beside(&tracing, options.max_input)?;
    let (mut lines, mut notes) = read_swc(without_mark(&traced), &options.scale).map_err(|fault| fault.in_file(&tracing))?;
    notes.push(format!("the points are those of {}", tracing.display()));
    let found = "none of its vessels begins and ends at points of the tracing";
    let wrong = || Fault::file(found, "expected a table and a tracing of the same image");
    notes.push(name_vessels(&mut lines, bytes, path, &options.scale)?.ok_or_else(wrong).map_err(here)?);
    notes.extend(spacing_note(&tracing, &options.scale)?);
    Ok((Content::Centerlines(lines), notes))
}

/// Labels a tracing by its table of vessels; `None` if the table belongs to another tracing.
fn name_vessels(lines: &mut Centerlines, bytes: &[u8], table: &Path, scale: &Scale) -> Result<Option<String>> {
    let vessels = read_traced_vessels(without_mark(bytes), scale).map_err(|fault| fault.in_file(table))?;
    let named = name_stretches(lines, &vessels);
    let note = || format!("labels are those of {}: {named} of its {} vessels are in the tracing", table.display(), vessels.len());
    Ok((named > 0).then(note))
}

/// A note on the voxel spacing that iCafe states for a tracing, if lengths are not read as voxels.
fn spacing_note(tracing: &Path, scale: &Scale) -> Result<Option<String>> {
    let spacing = image_spacing(tracing)?.filter(|_| scale.unit != LengthUnit::Voxel);
    Ok(spacing.map(|spacing| {
        format!("Image_info.txt beside it states a voxel spacing of {spacing} mm; give `units=voxel` `spacing={spacing}`")
    }))
}

/// A file of iCafe's in the folder of a tracing or its table of vessels: [`TABLE_OF_VESSELS`], or [`IMAGE`].
pub(crate) fn find(tracing: &Path, name: &str) -> Option<PathBuf> {
    Some(tracing.with_file_name(name)).filter(|path| crate::formats::is_there(path))
}

/// The one tracing in the folder of a table of vessels.
pub(crate) fn find_tracing(table: &Path) -> Result<PathBuf, Fault> {
    let folder = table.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let mut found = distinct(files.filter(|path| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("swc"))));
    match found.len() {
        0 => Err(Fault::file("an iCafe table of vessels without a tracing", "expected the SWC file of the tracing beside it")),
        1 => Ok(found.remove(0)),
        many => {
            let names: Vec<_> =
                found.iter().filter_map(|path| path.file_name()).map(|name| name.to_string_lossy()).take(3).collect();
            let (names, more) = (names.join(", "), if many > 3 { ", ..." } else { "" });
            let found = format!("{many} SWC files beside the table of vessels ({names}{more})");
            Err(Fault::file(found, "give the SWC file that it belongs to as INPUT"))
        }
    }
}
