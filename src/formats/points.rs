//! CSV of points: `fragment,x,y,z,radius`, one point a row.

use std::collections::HashMap;
use std::io::{self, BufRead, Read, Write};

use super::column::real;
use super::polyline::polylines;
use super::rows::{fault, lines_of};
use crate::centerline::{Centerlines, is_radius};
use crate::error::Fault;
use crate::network::Network;
use crate::units::{Scale, millimetres};

const HEADER: &str = "expected a header with columns fragment,x,y,z,radius (or x_mm and so on); label and id are optional";
const NAMES: [&[&str]; 7] =
    [&["fragment"], &["x", "x_mm"], &["y", "y_mm"], &["z", "z_mm"], &["radius", "radius_mm", "r", "r_mm"], &["label"], &["id"]];

/// Reads points in the order of their fragments; returns also what a person should know.
///
/// The columns are separated by commas, semicolons or tabs and may come in any order; further ones are ignored. The rows with the
/// same text in `fragment` form one polyline in their order, also where rows of others lie between them. An empty radius is a
/// missing one. A link has the label of the row that it leads to. Points have the number in `id`, else that of their row from 0.
///
/// # Errors
///
/// A missing column (that of the radius only unless `radius_optional`), a row without a fragment, a value that is no number, a
/// coordinate that is not finite, an id that comes twice, no row.
pub fn read_points(mut input: impl BufRead, scale: &Scale, radius_optional: bool) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut head = Vec::new();
    input.read_until(b'\n', &mut head).map_err(|e| Fault::line(1, format!("cannot be read: {e}"), "expected text"))?;
    let count = |mark: u8| head.split(|b| *b == mark).count();
    let delimiter = [b',', b';', b'\t'].into_iter().max_by_key(|mark| (count(*mark), *mark == b',')).unwrap_or(b',');
    let mut reader = lines_of(io::Cursor::new(head).chain(input), delimiter);
    let header = reader.headers().map_err(|e| fault(&e, 0))?.clone();
    let mut columns = [None; 7];
    for (at, name) in header.iter().enumerate() {
        let Some(which) = NAMES.iter().position(|names| names.iter().any(|n| n.eq_ignore_ascii_case(name))) else { continue };
        if columns[which].replace(at).is_some() {
            return Err(Fault::line(1, format!("column \"{name}\" comes twice"), "expected every column once"));
        }
    }
    if columns[..4].contains(&None) {
        let found = format!("columns {}", header.iter().collect::<Vec<_>>().join(","));
        return Err(Fault::line(1, found, HEADER));
    }
    if columns[4].is_none() && !radius_optional {
        return Err(Fault::line(1, "no column radius", "expected one, or give --default-radius"));
    }
    let mut lines = Centerlines::default();
    let mut last: HashMap<String, (u32, u32)> = HashMap::new();
    let mut line_of: HashMap<u64, usize> = HashMap::new();
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(|e| fault(&e, 0))? {
        let line = row.position().map_or(0, |p| p.line() as usize);
        let text = |which: usize| columns[which].and_then(|at: usize| row.get(at)).unwrap_or_default();
        if row.iter().all(str::is_empty) {
            continue;
        }
        if row.len() != header.len() {
            let accepted = format!("expected {}, as in the header", header.len());
            return Err(Fault::line(line, format!("{} columns", row.len()), accepted));
        }
        if text(0).is_empty() {
            return Err(Fault::line(line, "no fragment", "expected the name or number of the polyline"));
        }
        let number = |which: usize| {
            let wrong = || Fault::line(line, format!("{} \"{}\"", NAMES[which][0], text(which)), "expected a number");
            text(which).parse::<f64>().map_err(|_| wrong())
        };
        let position = [number(1)?, number(2)?, number(3)?];
        if let Some(axis) = position.iter().position(|x| !x.is_finite()) {
            return Err(Fault::line(line, format!("{} {}", NAMES[axis + 1][0], position[axis]), "expected a finite number"));
        }
        let radius = if text(4).is_empty() { f64::NAN } else { scale.length(number(4)?) };
        let radius = if is_radius(radius) { radius } else { f64::NAN };
        let id = if columns[6].is_some() {
            let wrong = || Fault::line(line, format!("id \"{}\"", text(6)), "expected a whole number from 0 on");
            let id = text(6).parse().map_err(|_| wrong())?;
            if let Some(first) = line_of.insert(id, line) {
                return Err(Fault::line(line, format!("id {id} is that of line {first} too"), "expected every id once"));
            }
            id
        } else {
            lines.points.len() as u64
        };
        let known = last.get(text(0)).copied();
        let strand = known.map_or(last.len() as u32, |(strand, _)| strand);
        let point = lines.add_point(scale.position(position), radius, id, strand);
        if let Some((_, before)) = known {
            lines.add_link([before, point], text(5));
        }
        match last.get_mut(text(0)) {
            Some(slot) => slot.1 = point,
            None => _ = last.insert(text(0).to_owned(), (strand, point)),
        }
    }
    if lines.points.is_empty() {
        return Err(Fault::file("no points", "expected a row for every point"));
    }
    Ok((lines, Vec::new()))
}

/// Writes every vessel as a fragment, numbered by its row: `fragment,x_mm,y_mm,z_mm,radius_mm,label`.
///
/// A vessel without a path is straight; a missing radius is an empty field.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_points(out: impl Write, network: &Network) -> io::Result<()> {
    let mut csv = csv::Writer::from_writer(out);
    csv.write_record(["fragment", "x_mm", "y_mm", "z_mm", "radius_mm", "label"])?;
    for (row, points) in polylines(network)?.into_iter().enumerate() {
        let (fragment, label) = (row.to_string(), &network.vessel(row).label);
        for point in points {
            let [x, y, z] = point.position.map(|x| real(millimetres(x)));
            let radius = if is_radius(point.radius) { real(millimetres(point.radius)) } else { String::new() };
            csv.write_record([&fragment, &x, &y, &z, &radius, label])?;
        }
    }
    csv.flush()
}
