//! 3D Slicer markups: curves of control points, the radius a measurement at each.

use std::io::{self, Write};

use serde_json::Value;

use crate::formats::{
    Centerlines, Fault, Frame, LengthUnit, Network, Point, ReadOptions, Scale, figures, is_radius, listed, stated_unit,
};
use willis_core::support::distinct;

/// The usual names of the radius, the first one first; letters of either case.
const RADIUS: [&str; 2] = ["Radius", "MaximumInscribedSphereRadius"];
const CURVES: &str = "expected markups of type Curve, ClosedCurve or Line";

#[derive(serde::Deserialize)]
struct MarkupsFile {
    markups: Option<Vec<Markup>>,
}

/// One markup: a curve, a line, a list of points.
#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::formats) struct Markup {
    /// Its type.
    #[serde(rename = "type", default)]
    pub(in crate::formats) kind: String,
    name: Option<String>,
    coordinate_system: Option<Value>,
    coordinate_units: Option<Value>,
    /// Its points.
    #[serde(default)]
    pub(in crate::formats) control_points: Vec<ControlPoint>,
    #[serde(default)]
    measurements: Vec<MarkupsMeasurement>,
}

/// A point of a markup.
#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
pub(in crate::formats) struct ControlPoint {
    label: Option<String>,
    position: Option<Vec<Option<f64>>>,
    position_status: Option<String>,
    selected: Option<bool>,
}

impl Markup {
    /// Its name, empty where it has none.
    pub(in crate::formats) fn name(&self) -> &str {
        self.name.as_deref().unwrap_or_default().trim()
    }

    /// The frame of its positions, LPS where it states none.
    pub(in crate::formats) fn frame(&self, item: impl Fn() -> String) -> Result<Frame, Fault> {
        let Some(system) = &self.coordinate_system else { return Ok(Frame::Lps) };
        let text = system.as_str().map_or_else(|| system.to_string(), str::to_owned);
        let other = || Fault::item(item(), format!("coordinateSystem {}", text.escape_debug()), "expected LPS or RAS");
        frame_called(&text).ok_or_else(other)
    }
}

/// The frame that Slicer calls so; its older files say 0 for RAS and 1 for LPS.
pub(in crate::formats) fn frame_called(word: &str) -> Option<Frame> {
    match word {
        "LPS" | "1" => Some(Frame::Lps),
        "RAS" | "0" => Some(Frame::Ras),
        _ => None,
    }
}

impl ControlPoint {
    /// Its label, empty where it has none.
    pub(in crate::formats) fn label(&self) -> &str {
        self.label.as_deref().unwrap_or_default().trim()
    }

    /// Whether a person has set it; a file may keep the place of a point that is not set.
    pub(in crate::formats) fn is_defined(&self) -> bool {
        self.position_status.as_deref().is_none_or(|status| status == "defined")
    }

    /// Whether it counts: willis writes what is to be looked at first as not selected.
    pub(in crate::formats) fn is_selected(&self) -> bool {
        self.selected != Some(false)
    }

    /// Its three numbers.
    pub(in crate::formats) fn position(&self) -> Option<Point> {
        if let [Some(x), Some(y), Some(z)] = self.position.as_deref()? { Some([*x, *y, *z]) } else { None }
    }
}

/// The markups of a file.
///
/// # Errors
///
/// Text that is not JSON of this kind.
pub(in crate::formats) fn markups_of(bytes: &[u8]) -> Result<Vec<Markup>, Fault> {
    let file: MarkupsFile = serde_json::from_slice(bytes).map_err(|error| {
        let text = error.to_string();
        let cause = text.split(" at line ").next().unwrap_or_default().to_owned();
        Fault::line(error.line(), format!("column {}: {cause}", error.column()), "expected JSON of 3D Slicer markups")
    })?;
    file.markups.ok_or_else(|| Fault::file("JSON without \"markups\"", "expected 3D Slicer markups"))
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase")]
struct MarkupsMeasurement {
    #[serde(default)]
    name: String,
    units: Option<Value>,
    control_point_values: Option<Vec<Option<f64>>>,
}

/// Reads the Curve, ClosedCurve and Line markups of a file, their control points as they stand; returns also notes for the user.
///
/// Positions are in LPS, as in Slicer's VTK and ITK files; in those given in RAS, x and y change sign. The radius is the
/// measurement `Radius` at the control points, as SlicerVMTK's ExtractCenterline stores it, or the one that
/// `options.radius_array` names. Points whose position is not defined are left out. A curve's name is its label, its number in
/// the file its strand; points are numbered from 0.
///
/// # Errors
///
/// Text that is not JSON of this kind, another coordinate system or unit, a position that is not three numbers, a measurement
/// with more or fewer values than points, a curve without radii unless they are optional, a file without curves.
pub fn read_markups(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let markups = markups_of(bytes)?;
    let mut lines = Centerlines::default();
    let (mut undefined, mut flipped, mut others) = (0, 0, Vec::new());
    for (row, markup) in markups.iter().enumerate() {
        if !["Curve", "ClosedCurve", "Line"].contains(&markup.kind.as_str()) {
            others.push(markup.kind.as_str());
            continue;
        }
        let called = markup.name();
        let item = || format!("markup {row} \"{}\"", called.escape_debug());
        let frame = markup.frame(item)?;
        flipped += usize::from(frame == Frame::Ras);
        if markup.coordinate_system.is_some() {
            lines.frame = Frame::Lps;
        }
        let unit = unit(markup, &options.scale, item)?;
        let scale = options.scale.in_unit(unit);
        lines.unit = lines.unit.or(unit);
        let radii = radii(markup, options, item)?;
        let first = lines.points.len() as u32;
        for (at, point) in markup.control_points.iter().enumerate() {
            if !point.is_defined() {
                undefined += 1;
                continue;
            }
            let position = point.position().map(|p| frame.turn(Frame::Lps, p));
            let position = position.map(|p| scale.position(p)).filter(|p| p.iter().all(|x| x.is_finite()));
            let wrong = || Fault::item(item(), format!("control point {at} without a position"), "expected three finite numbers");
            let radius = radii.and_then(|(radii, unit)| Some(scale.in_unit(unit).length(radii[at]?))).unwrap_or(f64::NAN);
            let radius = if is_radius(radius) { radius } else { f64::NAN };
            let point = lines.add_point(position.ok_or_else(wrong)?, radius, u64::from(lines.points.len() as u32), row as u32);
            if point > first {
                lines.add_link([point - 1, point], called);
            }
        }
        let last = lines.points.len() as u32;
        if markup.kind == "ClosedCurve" && last > first + 2 {
            lines.add_link([last - 1, first], called);
        }
    }
    if others.len() == markups.len() {
        let landmarks = if others.contains(&"Fiducial") { ", which are landmarks and no centerlines" } else { "" };
        let others = distinct(others);
        let found =
            if others.is_empty() { "no markups".into() } else { format!("markups of type {}{landmarks}", others.join(", ")) };
        return Err(Fault::file(found.escape_debug().to_string(), CURVES));
    }
    crate::formats::ensure(!lines.points.is_empty(), || Fault::file("curves without points", "expected control points"))?;
    let notes = listed([
        (flipped, "markups in RAS, whose x and y changed sign because positions are kept in LPS"),
        (undefined, "control points without a defined position, left out"),
        (others.len(), "markups that are no curves, left out"),
    ]);
    Ok((lines, notes.collect()))
}

/// The unit that a markup states.
pub(in crate::formats) fn unit(markup: &Markup, given: &Scale, item: impl Fn() -> String) -> Result<Option<LengthUnit>, Fault> {
    coded_unit("coordinateUnits", markup.coordinate_units.as_ref(), given, item)
}

/// The unit of a code, or of an array that begins with it.
fn coded_unit(name: &str, code: Option<&Value>, given: &Scale, item: impl Fn() -> String) -> Result<Option<LengthUnit>, Fault> {
    let code = code.map(|units| units.get(0).unwrap_or(units).as_str().unwrap_or_default());
    stated_unit(code, given, || {
        let found = format!("{name} {}", code.unwrap_or_default().escape_debug());
        Fault::item(item(), found, "expected mm, um, cm or m")
    })
}

/// Values at control points, and the unit that is stated of them.
type PointValues<'a> = (&'a [Option<f64>], Option<LengthUnit>);

/// The radius at every control point of a markup; `None` without radii where they are optional, and without points.
fn radii<'a>(markup: &'a Markup, options: &ReadOptions, item: impl Fn() -> String) -> Result<Option<PointValues<'a>>, Fault> {
    let called = |name: &str| {
        let mut found = markup.measurements.iter().filter(|m| m.name.eq_ignore_ascii_case(name));
        found.find_map(|m| m.control_point_values.as_deref().map(|values| (m, values)))
    };
    let named = options.radius_array.as_deref();
    let found = named.map_or_else(|| RADIUS.iter().find_map(|name| called(name)), called);
    match (found, named) {
        (Some((measured, values)), _) if values.len() == markup.control_points.len() => {
            let code = measured.units.as_ref().filter(|units| *units != "");
            let unit = coded_unit(&format!("units of {}", measured.name), code, &options.scale, item)?;
            Ok(Some((values, unit)))
        }
        // A curve that was resampled keeps the values of its old points.
        (_, None) if options.is_radius_optional() => Ok(None),
        _ if markup.control_points.is_empty() => Ok(None),
        (Some((measured, values)), _) => {
            let (name, points) = (measured.name.escape_debug(), markup.control_points.len());
            let found = format!("{} values of {name} for {points} points", values.len());
            Err(Fault::item(item(), found, "expected one for each control point, or give `default_radius`"))
        }
        (None, Some(name)) => {
            let found = format!("no measurement {name} at its control points");
            Err(Fault::item(item(), found, "expected the one that `radius_array` names"))
        }
        (None, None) => {
            let accepted = "expected a measurement Radius with a value for each control point, or give `default_radius`";
            Err(Fault::item(item(), "no radius", accepted))
        }
    }
}

/// The published schema of the files.
pub(in crate::formats) const SCHEMA: &str = "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/markups-schema-v1.0.3.json#";

/// Writes every vessel as a Curve of one markups file, its label as the name, the radius as the measurement `Radius` at the
/// control points; LPS, millimetres. A network in RAS is turned to LPS. A vessel without a path is straight, a missing radius 0.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_markups(mut out: impl Write, network: &Network) -> io::Result<()> {
    writeln!(out, "{{\n\"@schema\": \"{SCHEMA}\",\n\"markups\": [")?;
    let network = &*network.in_frame(Frame::Lps);
    for (row, points) in crate::formats::polylines::polylines(network)?.into_iter().enumerate() {
        let before = if row > 0 { ",\n" } else { "" };
        let name = serde_json::to_string(&network.vessel(row).label)?;
        write!(out, "{before}{{\"type\": \"Curve\", \"name\": {name}, \"coordinateSystem\": \"LPS\", ")?;
        writeln!(out, "\"coordinateUnits\": \"mm\",\n\"controlPoints\": [")?;
        let figures: Vec<[String; 4]> = points.iter().map(|point| figures(point, "0")).collect();
        for (at, [x, y, z, _]) in figures.iter().enumerate() {
            let comma = if at + 1 < points.len() { "," } else { "" };
            writeln!(out, "{{\"id\": \"{}\", \"position\": [{x}, {y}, {z}]}}{comma}", at + 1)?;
        }
        let radii: Vec<&str> = figures.iter().map(|[.., radius]| radius.as_str()).collect();
        writeln!(out, "],\n\"measurements\": [{{\"name\": \"Radius\", \"enabled\": true, \"units\": \"mm\",")?;
        write!(out, "\"controlPointValues\": [{}]}}]}}", radii.join(", "))?;
    }
    writeln!(out, "\n]\n}}")?;
    out.flush()
}
