//! The two tables of VesselVio: vertices, and edges that refer to them by row; column names in any case.

use std::io::{self, Write};

use crate::formats::content::Content;
use crate::formats::options::ReadOptions;
use crate::formats::polylines::{add_straight, centerlines, is_straight, positions, skeleton};
use crate::formats::tables::reader::{Row, TableReader, counted};
use crate::formats::tables::write::{Column, coordinate_columns, write_csv};
use willis_core::error::Fault;
use willis_core::network::{Network, Node, PathPoint, Scale, is_radius, millimetres};
use willis_core::support::geometry::{Point, area_of, distance};

/// The columns of positions that are written.
const PLACE: [&str; 3] = ["X", "Y", "Z"];

/// The vertices of a table, by row.
#[derive(Debug, Clone)]
pub struct VertexTable {
    positions: Vec<Point>,
    radii: Option<Vec<f64>>,
}

/// Reads the table of vertices: `X,Y,Z`, with `radius` where the vertices are centerline points.
///
/// # Errors
///
/// A column that is missing, a position that is not finite, a number that is none.
pub fn read_vesselvio_vertices(bytes: &[u8], scale: &Scale) -> Result<VertexTable, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let what = "VesselVio's table of vertices";
    let place = rows.columns([&["X", "pos_x"], &["Y", "pos_y"], &["Z", "pos_z"]], what)?;
    let radius = rows.find(&["radius"]);
    let (mut positions, mut radii) = (Vec::new(), Vec::new());
    while let Some(row) = rows.row()? {
        positions.push(scale.position(row.position(place)?));
        radii.push(scale.length(radius.map_or(Ok(f64::NAN), |radius| row.real(radius))?));
    }
    if u32::try_from(positions.len()).is_err() {
        return Err(Fault::file(format!("{} vertices", positions.len()), "expected fewer than 2^32"));
    }
    Ok(VertexTable { positions, radii: radius.map(|_| radii) })
}

/// Reads the table of edges: `Source ID,Target ID` (or `source,target`), rows of the vertices counted from 0.
///
/// With `radius_avg` (or `radius`) every edge is a branch: one observed vessel, with the length in `length` or the
/// distance between its vertices. Otherwise the edges link centerline points. A missing radius is NaN where
/// radii are optional.
///
/// # Errors
///
/// A column that is missing, a row that the vertices lack, an edge without length or radius, no edge.
pub fn read_vesselvio_edges(bytes: &[u8], vertices: VertexTable, options: &ReadOptions) -> Result<(Content, Vec<String>), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let what = "VesselVio's table of edges";
    let ends = rows.columns([&["Source ID", "source"], &["Target ID", "target"]], what)?;
    let radius = rows.find(&["radius_avg", "radius"]);
    if radius.is_none() && vertices.radii.is_none() && !options.is_radius_optional() {
        let accepted = "expected radius_avg here or radius with the vertices, or give `default_radius`";
        return Err(Fault::line(rows.header_line, "no radius", accepted));
    }
    let (length, label) = (rows.find(&["length"]), rows.find(&["label"]));
    let name = |row: &Row| label.map_or("", |label| row.text(label)).to_owned();
    let none = || Fault::file("no edges", "expected a row for every edge");
    let Some(radius) = radius else {
        let (mut links, mut labels) = (Vec::new(), Vec::new());
        while let Some(row) = rows.row()? {
            links.push(linked(&row, ends, vertices.positions.len())?);
            labels.push(name(&row));
        }
        if links.is_empty() {
            return Err(none());
        }
        let radii = vertices.radii.unwrap_or_else(|| vec![f64::NAN; vertices.positions.len()]);
        let lines = centerlines(&vertices.positions, &radii, &links, |row| labels[row].clone());
        return Ok((Content::Centerlines(lines), vec!["edges link the vertices by row, as VesselVio's do".to_owned()]));
    };
    let mut network = Network::new();
    for (row, position) in vertices.positions.iter().enumerate() {
        network.add_node(Node { id: row.to_string(), position: Some(*position), ..Node::default() });
    }
    let mut straight = 0;
    while let Some(row) = rows.row()? {
        let ends = linked(&row, ends, vertices.positions.len())?;
        let fault = |found: String, accepted: &str| Fault::line(row.line, format!("edge {}: {found}", row.number), accepted);
        let size = options.scale.length(row.real(radius)?);
        if !is_radius(size) && !options.is_radius_optional() {
            let found = format!("{} \"{}\"", row.header[radius], row.text(radius));
            return Err(fault(found, "expected a positive number, or give `default_radius`"));
        }
        let length = length.map_or(Ok(f64::NAN), |length| row.real(length))?;
        straight += usize::from(length.is_nan());
        let size = Some(size).filter(|r| is_radius(*r)).unwrap_or(f64::NAN);
        add_straight(&mut network, ends.map(|end| end as usize), options.scale.length(length), size, &name(&row))
            .ok_or_else(|| fault("no positive length".to_owned(), "expected a positive length or different places"))?;
    }
    if network.vessel_count() == 0 {
        return Err(none());
    }
    let mut notes = vec!["edges refer to vertices by row, as VesselVio's do".to_owned()];
    notes.extend(counted(straight, "edge", "without length: took the distance between the vertices"));
    Ok((Content::Vessels(network), notes))
}

/// The rows of the vertices that an edge joins.
fn linked(row: &Row, ends: [usize; 2], vertices: usize) -> Result<[u32; 2], Fault> {
    let end = |column: usize| match row.real(column)? {
        x if x >= 0.0 && x < vertices as f64 && x.fract() == 0.0 => Ok(x as u32),
        _ => {
            let found = format!("edge {}: {} \"{}\"", row.number, row.header[column], row.text(column));
            let last = vertices.saturating_sub(1);
            Err(Fault::line(row.line, found, format!("expected a row of the vertices, 0 to {last}")))
        }
    };
    Ok([end(ends[0])?, end(ends[1])?])
}

/// Writes both tables, mm, under the names that VesselVio offers by default.
///
/// Where a vessel has points between its nodes these are "Centerlines" (a vertex a point, with its radius), which keep the
/// course; where none has, "Branches" (an edge a vessel), which keep length and radius. Labels, where there are any, stand
/// in a last column `label`, which VesselVio passes over.
///
/// # Errors
///
/// A node without a position; two vessels that points cannot distinguish (`InvalidInput`); the writers' own.
pub fn write_vesselvio(vertices: impl Write, edges: impl Write, network: &Network) -> io::Result<()> {
    let labelled = network.vessels().any(|(_, v)| !v.label.is_empty());
    let ends = |links: &[[usize; 2]]| {
        let side = |name, which: usize| Column::whole(name, links.iter().map(|link| link[which]));
        vec![side("Source ID", 0), side("Target ID", 1)]
    };
    if !is_straight(network) {
        let found = skeleton(network)?;
        let mut table = coordinate_columns(PLACE, || found.points.iter().map(|p| p.position.map(millimetres))).to_vec();
        table.push(Column::real("radius", found.points.iter().map(|p: &PathPoint| millimetres(p.radius))));
        write_csv(vertices, &table)?;
        let mut table = ends(&found.links);
        let label = |vessel: &usize| network.vessel(*vessel).label.clone();
        table.extend(labelled.then(|| Column::text("label", found.vessel.iter().map(label))));
        return write_csv(edges, &table);
    }
    let at = positions(network)?;
    write_csv(vertices, &coordinate_columns(PLACE, || at.iter().map(|p| p.map(millimetres))))?;
    let links: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
    let vessels = || network.vessels().map(|(_, v)| (millimetres(v.length), millimetres(v.radius)));
    let gap = |[a, b]: [usize; 2]| millimetres(distance(at[a], at[b]));
    let tortuosity = |(ends, length): (&[usize; 2], f64)| Some(length / gap(*ends)).filter(|t| t.is_finite()).unwrap_or(f64::NAN);
    let mut table = ends(&links);
    table.extend([
        Column::real("radius_avg", vessels().map(|(_, r)| r)),
        Column::real("length", vessels().map(|(l, _)| l)),
        Column::real("tortuosity", links.iter().zip(vessels().map(|(l, _)| l)).map(tortuosity)),
        Column::real("volume", vessels().map(|(l, r)| area_of(r) * l)),
        Column::real("surface_area", vessels().map(|(l, r)| std::f64::consts::TAU * r * l)),
    ]);
    table.extend(labelled.then(|| Column::text("label", network.vessels().map(|(_, v)| v.label.clone()))));
    write_csv(edges, &table)
}
