//! Landmarks in files: a CSV table, or a point list of 3D Slicer (`.mrk.json`, `.fcsv`).

use std::io::{self, Write};

use super::tables::reader::{Row, TableReader, listed, uncommented};
use super::vendors::slicer_markups::{SCHEMA, frame_called, markups_of, unit};
use super::{Column, POSITION_COLUMNS, coordinate_columns, ensure, input::without_mark, tables::write::real, write_csv};
use willis_core::error::{Fault, Place};
use willis_core::network::{Frame, Scale, millimetres};
use willis_core::support::geometry::Point;

/// A landmark in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedLandmark {
    /// Its line, or the number of its control point.
    pub place: Place,
    /// Its label as given.
    pub label: String,
    /// Where, m, in the frame of the file.
    pub position: Point,
}

/// The landmarks of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct LandmarkList {
    /// In the order of the file.
    pub landmarks: Vec<ListedLandmark>,
    /// The frame of the positions; unknown for a table of `x,y,z`, whose axes are those of the network's file.
    pub frame: Frame,
    /// The format of the file.
    pub format: LandmarkFormat,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// A landmark to write.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MarkedPoint {
    /// The artery that ends there (`L-ICA`), or the arteries that meet there (`L-ICA/L-M1/L-A1`).
    pub label: String,
    /// Where, m.
    pub position: Point,
    /// How probable the label is, from 0 to 1.
    pub probability: Option<f64>,
    /// A remark; may be empty.
    pub description: String,
}

/// The formats in which landmarks are written, in the order of their names in `output::names::LANDMARKS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LandmarkFormat {
    /// A table of `label,x_mm,y_mm,z_mm` in the axes of the network's file.
    Csv,
    /// A point list of 3D Slicer in its JSON for markups.
    Markups,
    /// The older point list of 3D Slicer.
    Fcsv,
}

/// Reads landmarks, in the format that the content shows.
///
/// A table has the columns `label,x_mm,y_mm,z_mm`, or `x,y,z` in the unit of `scale`; or `label,r,a,s` or `label,l,p,s`, as 3D Slicer
/// exports control points. Rows that begin with `#` are comments. Of markups the point lists (`Fiducial`) are read. Points whose position
/// is not defined are left out, and so are those that are improbable or, in 3D Slicer, not selected.
///
/// # Errors
///
/// A missing column or label, a position that is not three finite numbers, another coordinate system or unit, no landmark at all.
pub fn read_landmarks(bytes: &[u8], scale: &Scale) -> Result<LandmarkList, Fault> {
    let list = if without_mark(bytes).trim_ascii_start().starts_with(b"{") {
        read_markups(without_mark(bytes))?
    } else if let Some((frame, table)) = fcsv_table(bytes)? {
        read_fcsv(&table, frame)?
    } else {
        read_table(bytes, scale)?
    };
    let none = || Fault::file("no landmark", "expected a row or a control point for every landmark");
    ensure(!list.landmarks.is_empty(), none).map(|()| list)
}

/// The landmarks that were found so far, and how many were left out.
#[derive(Default)]
struct FoundLandmarks {
    landmarks: Vec<ListedLandmark>,
    undefined: usize,
    doubtful: usize,
}

impl FoundLandmarks {
    /// Whether a landmark counts; else it is counted as left out.
    fn takes(&mut self, is_defined: bool, is_sure: bool) -> bool {
        self.undefined += usize::from(!is_defined);
        self.doubtful += usize::from(is_defined && !is_sure);
        is_defined && is_sure
    }

    /// The list, with a note on what was left out.
    fn list(self, format: LandmarkFormat, frame: Frame) -> LandmarkList {
        let undefined = (self.undefined, "landmarks without a defined position, left out");
        let doubtful = (self.doubtful, "doubtful landmarks that nobody has confirmed, left out");
        LandmarkList { landmarks: self.landmarks, frame, format, notes: listed([undefined, doubtful]).collect() }
    }
}

fn read_table(bytes: &[u8], scale: &Scale) -> Result<LandmarkList, Fault> {
    const WHAT: &str = "label,x_mm,y_mm,z_mm";
    // A comment has as many columns as it has commas.
    let mut rows = TableReader::ragged(bytes)?;
    let label = rows.column(&["label"], WHAT)?;
    let slicer = [(["r", "a", "s"], Frame::Ras), (["l", "p", "s"], Frame::Lps)];
    let mut found = slicer.iter().filter_map(|(names, frame)| {
        let [x, y, z] = names.map(|name| rows.find(&[name]));
        Some(([x?, y?, z?], *frame, Scale::default()))
    });
    let (place, frame, scale) = if let Some(found) = found.next() {
        found
    } else {
        (rows.columns([&["x_mm", "x"], &["y_mm", "y"], &["z_mm", "z"]], WHAT)?, Frame::Unknown, *scale)
    };
    let of_slicer = |name: &str| rows.find(&[name]).filter(|_| frame.is_known());
    let (defined, selected) = (of_slicer("defined"), of_slicer("selected"));
    let probability = rows.find(&["probability"]);
    let mut all = FoundLandmarks::default();
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() || row.text(0).starts_with('#') {
            continue;
        }
        let is_improbable = probability.is_some_and(|column| row.text(column).parse().is_ok_and(|p: f64| p < SURE));
        if all.takes(!says_no(&row, defined), !says_no(&row, selected) && !is_improbable) {
            let (place, position) = (Place::Line(row.line), row.point(place, &scale)?);
            all.landmarks.push(ListedLandmark { place, label: row.text(label).to_owned(), position });
        }
    }
    Ok(all.list(LandmarkFormat::Csv, frame))
}

/// Whether a row has 0 in a column of yes and no, if there is the column.
fn says_no(row: &Row<'_>, column: Option<usize>) -> bool {
    column.is_some_and(|column| row.text(column) == "0")
}

/// The control points of the point lists in markups, in the frame of the first list.
fn read_markups(bytes: &[u8]) -> Result<LandmarkList, Fault> {
    const POINTS: &str = "expected a point list (markups of type Fiducial)";
    let markups = markups_of(bytes)?;
    let lists = || markups.iter().enumerate().filter(|(_, markup)| markup.kind == "Fiducial");
    if lists().next().is_none() {
        let mut kinds: Vec<&str> = markups.iter().map(|markup| markup.kind.as_str()).collect();
        kinds.dedup();
        let found = if kinds.is_empty() { "no markups".into() } else { format!("markups of type {}", kinds.join(", ")) };
        return Err(Fault::file(found.escape_debug().to_string(), POINTS));
    }
    let several = lists().count() > 1;
    let (mut all, mut first) = (FoundLandmarks::default(), None);
    for (row, markup) in lists() {
        let item = || format!("markup {row} \"{}\"", markup.name().escape_debug());
        let frame = markup.frame(item)?;
        let of_file = *first.get_or_insert(frame);
        let scale = Scale::default().in_unit(unit(markup, &Scale::default(), item)?);
        for (at, point) in markup.control_points.iter().enumerate() {
            if !all.takes(point.is_defined(), point.is_selected()) {
                continue;
            }
            let of = if several { format!(" of {}", item()) } else { String::new() };
            let place = format!("control point {at}{of}");
            let position = point.position().map(|p| scale.position(p)).filter(|p| p.iter().all(|x| x.is_finite()));
            let wrong = || Fault::item(&place, "no position", "expected three finite numbers");
            let position = frame.turn(of_file, position.ok_or_else(wrong)?);
            all.landmarks.push(ListedLandmark { label: point.label().to_owned(), position, place: Place::Item(place) });
        }
    }
    Ok(all.list(LandmarkFormat::Markups, first.unwrap_or(Frame::Lps)))
}

/// Landmarks below this probability are for a person to look at: they do not count until the probability is raised or taken away, or, in
/// 3D Slicer, the point is selected.
pub const SURE: f64 = 0.5;

/// Slicer's names of the columns, for a file that does not state them.
const FCSV_COLUMNS: &str = "id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID";

/// The frame and the table of an `.fcsv` file. The names of its columns stand in a comment, which becomes the header. `None` for a
/// file that is no `.fcsv`: one has a comment that names it, its columns or its coordinate system.
fn fcsv_table(bytes: &[u8]) -> Result<Option<(Frame, Vec<u8>)>, Fault> {
    // Slicer wrote RAS before it stated the coordinate system.
    let (mut frame, mut is_fcsv) = (Frame::Ras, false);
    let (mut header, mut names) = (0, FCSV_COLUMNS.to_owned());
    for (row, line) in without_mark(bytes).split(|b| *b == b'\n').enumerate() {
        let line = String::from_utf8_lossy(line);
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let Some(comment) = line.strip_prefix('#').map(str::trim) else { break };
        is_fcsv |= comment.starts_with("Markups fiducial file") || comment.starts_with("Fiducial List file");
        let Some((name, value)) = comment.split_once('=') else { continue };
        let (name, value) = (name.trim(), value.trim());
        if name.eq_ignore_ascii_case("columns") {
            (header, names) = (row, value.to_owned());
            is_fcsv = true;
        } else if name.eq_ignore_ascii_case("CoordinateSystem") {
            is_fcsv = true;
            let found = || format!("CoordinateSystem {}", value.escape_debug());
            frame = frame_called(value).ok_or_else(|| Fault::line(row + 1, found(), "expected LPS, RAS, 0 or 1"))?;
        }
    }
    if !is_fcsv {
        return Ok(None);
    }
    let mut table = Vec::with_capacity(bytes.len() + names.len());
    for (row, line) in uncommented(bytes).split_inclusive(|b| *b == b'\n').enumerate() {
        if row == header {
            table.extend_from_slice(names.as_bytes());
            table.push(b'\n');
        } else {
            table.extend_from_slice(line);
        }
    }
    Ok(Some((frame, table)))
}

fn read_fcsv(table: &[u8], frame: Frame) -> Result<LandmarkList, Fault> {
    let mut all = FoundLandmarks::default();
    let mut rows = TableReader::ragged(table)?;
    let columns = rows.columns([&["x"], &["y"], &["z"], &["label"]], "an .fcsv file of 3D Slicer")?;
    let [place @ .., label] = columns;
    // The columns that newer versions write without naming them begin with the status: 2 is defined.
    let status = rows.find(&["associatedNodeID"]).map(|last| last + 1);
    let selected = rows.find(&["sel"]);
    let is_defined = |row: &Row<'_>| status.is_none_or(|column| matches!(row.text(column), "" | "2"));
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() {
            continue;
        }
        if all.takes(is_defined(&row), !says_no(&row, selected)) {
            let (place, position) = (Place::Line(row.line), row.point(place, &Scale::default())?);
            all.landmarks.push(ListedLandmark { place, label: row.text(label).to_owned(), position });
        }
    }
    Ok(all.list(LandmarkFormat::Fcsv, frame))
}

/// Writes landmarks whose positions are in `frame`.
///
/// The table has them as they are, with columns `probability` and `description` where any landmark has one. The formats of 3D Slicer have
/// them in LPS, with the probability in the description; positions in an unknown frame are written as they are, and called LPS.
///
/// # Errors
///
/// Those of `out`.
pub fn write_landmarks(mut out: impl Write, format: LandmarkFormat, frame: Frame, landmarks: &[MarkedPoint]) -> io::Result<()> {
    let lps = |point: &MarkedPoint| frame.turn(Frame::Lps, point.position).map(|x| real(millimetres(x)));
    match format {
        LandmarkFormat::Csv => write_table(out, landmarks),
        LandmarkFormat::Markups => {
            writeln!(out, "{{\n\"@schema\": \"{SCHEMA}\",\n\"markups\": [{{\"type\": \"Fiducial\", \"name\": \"landmarks\",")?;
            writeln!(out, "\"coordinateSystem\": \"LPS\", \"coordinateUnits\": \"mm\", \"controlPoints\": [")?;
            for (at, point) in landmarks.iter().enumerate() {
                let [x, y, z] = lps(point);
                let (label, about) = (serde_json::to_string(&point.label)?, serde_json::to_string(&point.about())?);
                let comma = if at + 1 < landmarks.len() { "," } else { "" };
                writeln!(
                    out,
                    "{{\"id\": \"{}\", \"label\": {label}, \"description\": {about}, \"position\": [{x}, {y}, {z}], \
                     \"selected\": {}, \"positionStatus\": \"defined\"}}{comma}",
                    at + 1,
                    point.is_sure()
                )?;
            }
            writeln!(out, "]}}]\n}}")?;
            out.flush()
        }
        LandmarkFormat::Fcsv => {
            writeln!(out, "# Markups fiducial file version = 4.11\n# CoordinateSystem = LPS\n# columns = {FCSV_COLUMNS}")?;
            let mut rows = csv::Writer::from_writer(out);
            for (at, point) in landmarks.iter().enumerate() {
                let ([x, y, z], id) = (lps(point), (at + 1).to_string());
                let selected = if point.is_sure() { "1" } else { "0" };
                let row = [&id, &x, &y, &z, "0", "0", "0", "1", "1", selected, "0", &point.label, &point.about(), ""];
                rows.write_record(row)?;
            }
            rows.flush()
        }
    }
}

fn write_table(out: impl Write, landmarks: &[MarkedPoint]) -> io::Result<()> {
    let mut columns = vec![Column::text("label", landmarks.iter().map(|point| point.label.clone()))];
    columns.extend(coordinate_columns(POSITION_COLUMNS, || landmarks.iter().map(|point| point.position.map(millimetres))));
    if landmarks.iter().any(|point| point.probability.is_some()) {
        columns.push(Column::real("probability", landmarks.iter().map(|point| point.probability.unwrap_or(f64::NAN))));
    }
    if landmarks.iter().any(|point| !point.description.is_empty()) {
        columns.push(Column::text("description", landmarks.iter().map(|point| point.description.clone())));
    }
    write_csv(out, &columns)
}

impl MarkedPoint {
    /// A landmark without a probability or a remark.
    pub fn new(label: impl Into<String>, position: Point) -> Self {
        Self { label: label.into(), position, ..Self::default() }
    }

    /// Whether it counts without being looked at.
    fn is_sure(&self) -> bool {
        self.probability.is_none_or(|p| p >= SURE)
    }

    /// The remark for a format that has no place for a probability.
    fn about(&self) -> String {
        let probability = self.probability.map(|p| format!("probability {}", real(p)));
        let remark = Some(self.description.clone()).filter(|text| !text.is_empty());
        [probability, remark].into_iter().flatten().collect::<Vec<_>>().join("; ")
    }
}
