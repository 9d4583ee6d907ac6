//! CSV of points: `fragment,x,y,z,radius`, one point a row.

use std::collections::HashMap;
use std::io::{self, Write};

use super::reader::{TableReader, columns as describe};
use crate::formats::{ReadOptions, escape_formula, polylines::polylines, tables::write::figures};
use willis_core::error::Fault;
use willis_core::network::{Centerlines, Network, is_radius};

pub(crate) const HEADER: &str =
    "expected a header with columns fragment,x,y,z,radius (or x_mm and so on, in mm); label and id are optional";

/// Reads points in the order of their fragments; returns also notes for the user. Columns called `_mm` are in mm, others in the
/// unit of `scale`.
///
/// The columns are separated by commas, semicolons or tabs and may come in any order; further ones are ignored. The rows with the
/// same text in `fragment` form one polyline in their order, even with rows of other fragments in between. An empty radius is a
/// missing one. A link has the label of the row that it leads to. Points have the number in `id`, else that of their row from 0.
///
/// # Errors
///
/// A missing column (that of the radius only unless radii are optional), a row without a fragment, a value that is no number, a
/// coordinate that is not finite, an id that comes twice, no row.
pub fn read_points(bytes: &[u8], options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let header = rows.header_line;
    let [fragment, label, id] = ["fragment", "label", "id"].map(|name| rows.find(&[name]));
    let [x, y, z] = [["x", "x_mm"], ["y", "y_mm"], ["z", "z_mm"]].map(|names| rows.find(&names));
    let radius = rows.find(&["radius", "radius_mm", "r", "r_mm"]);
    let (Some(fragment), Some(x), Some(y), Some(z)) = (fragment, x, y, z) else {
        return Err(Fault::line(header, describe(&rows.header), HEADER));
    };
    if radius.is_none() && !options.is_radius_optional() {
        return Err(Fault::line(header, "no column radius", "expected one, or give `default_radius`"));
    }
    let mut lines = Centerlines::default();
    let mut last: HashMap<String, (u32, u32)> = HashMap::new();
    let mut line_of: HashMap<u64, usize> = HashMap::new();
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() {
            continue;
        }
        let name = row.text(fragment);
        if name.is_empty() {
            return Err(Fault::line(row.line, "no fragment", "expected the name or number of the polyline"));
        }
        let position = row.point([x, y, z], &options.scale)?;
        let radius = radius.map_or(Ok(f64::NAN), |column| row.length(column, &options.scale))?;
        let radius = Some(radius).filter(|r| is_radius(*r)).unwrap_or(f64::NAN);
        let id = if let Some(column) = id {
            let text = row.text(column);
            let wrong = || Fault::line(row.line, format!("id \"{text}\""), "expected a whole number from 0 on");
            let id = text.parse().map_err(|_| wrong())?;
            if let Some(first) = line_of.insert(id, row.line) {
                return Err(Fault::line(row.line, format!("id {id} is that of line {first} too"), "expected every id once"));
            }
            id
        } else {
            lines.points.len() as u64
        };
        let known = last.get(name).copied();
        let strand = known.map_or(last.len() as u32, |(strand, _)| strand);
        let point = lines.add_point(position, radius, id, strand);
        if let Some((_, before)) = known {
            lines.add_link([before, point], label.map_or("", |column| row.text(column)));
        }
        match last.get_mut(name) {
            Some(slot) => slot.1 = point,
            None => _ = last.insert(name.to_owned(), (strand, point)),
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
        let (fragment, label) = (row.to_string(), escape_formula(&network.vessel(row).label));
        for point in points {
            let [x, y, z, radius] = figures(&point, "");
            csv.write_record([&*fragment, &x, &y, &z, &radius, &label])?;
        }
    }
    csv.flush()
}
