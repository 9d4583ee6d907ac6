//! The two tables of VesselVio and of Voreen: vertices and edges that refer to them by row, column names in any case; nodes and edges, separated by
//! semicolons, as VesselGraph distributes them.

use std::io::{self, Write};

use crate::formats::ensure;
use crate::formats::polylines::{PointLinks, add_straight, centerlines, network_of_points, positions};
use crate::formats::tables::write::{Column, coordinate_columns, write_csv, write_table};
use crate::formats::tables::{graph::NodeTable, reader::Row};
use crate::formats::{
    Content, Fault, Frame, Network, Node, ReadOptions, Scale, TableReader, counted, is_radius, millimetres, plural,
};
use willis_core::support::geometry::{Point, area_of, distance, radius_of};

/// The columns of positions that are written.
const PLACE: [&str; 3] = ["X", "Y", "Z"];

/// The vertices of a table, by row.
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
    let wrong = || Fault::file(format!("{} vertices", positions.len()), "expected fewer than 2^32");
    ensure(u32::try_from(positions.len()).is_ok(), wrong)?;
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
    let accepted = "expected radius_avg here or radius with the vertices, or give `default_radius`";
    let wrong = || Fault::line(rows.header_line, "no radius", accepted);
    ensure(radius.is_some() || vertices.radii.is_some() || options.is_radius_optional(), wrong)?;
    let (length, label) = (rows.find(&["length"]), rows.find(&["label"]));
    let name = |row: &Row| label.map_or("", |label| row.text(label)).to_owned();
    let none = || Fault::file("no edges", "expected a row for every edge");
    let Some(radius) = radius else {
        let (mut links, mut labels) = (Vec::new(), Vec::new());
        while let Some(row) = rows.row()? {
            links.push(linked(&row, ends, vertices.positions.len())?);
            labels.push(name(&row));
        }
        ensure(!links.is_empty(), none)?;
        let radii = vertices.radii.unwrap_or_else(|| vec![f64::NAN; vertices.positions.len()]);
        let lines = centerlines(&vertices.positions, &radii, &links, &[], |row| labels[row].clone());
        return Ok((Content::Centerlines(lines), vec!["edges link the vertices by row, as VesselVio's do".to_owned()]));
    };
    let mut network = network_of_points(&vertices.positions);
    let mut straight = 0;
    while let Some(row) = rows.row()? {
        let ends = linked(&row, ends, vertices.positions.len())?;
        let fault = |found: String, accepted: &str| Fault::line(row.line, format!("edge {}: {found}", row.number), accepted);
        let size = Some(options.scale.length(row.real(radius)?)).filter(|size| is_radius(*size));
        let found = || format!("{} \"{}\"", row.header[radius], row.text(radius));
        let wrong = || fault(found(), "expected a positive number, or give `default_radius`");
        ensure(size.is_some() || options.is_radius_optional(), wrong)?;
        let length = length.map_or(Ok(f64::NAN), |length| row.real(length))?;
        straight += usize::from(length.is_nan());
        let (ends, size) = (ends.map(|end| end as usize), size.unwrap_or(f64::NAN));
        add_straight(&mut network, ends, options.scale.course(length), size, &name(&row))
            .ok_or_else(|| fault("no positive length".to_owned(), "expected a positive length or different places"))?;
    }
    ensure(network.vessel_count() > 0, none)?;
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
    let graph = PointLinks::of(network)?;
    let PointLinks { points: at, links, is_straight, radii, .. } = &graph;
    let mut table = coordinate_columns(PLACE, || at.iter().map(|p| p.map(millimetres))).to_vec();
    table.extend((!is_straight).then(|| Column::real("radius", radii.iter().copied().map(millimetres))));
    write_csv(vertices, &table)?;
    let side = |name, which: usize| Column::whole(name, links.iter().map(|link| link[which]));
    let mut table = vec![side("Source ID", 0), side("Target ID", 1)];
    if *is_straight {
        let vessels = || network.vessels().map(|(_, v)| (millimetres(v.length), millimetres(v.radius)));
        let gap = |[a, b]: [usize; 2]| millimetres(distance(at[a], at[b]));
        let tortuosity =
            |(ends, length): (&[usize; 2], f64)| Some(length / gap(*ends)).filter(|t| t.is_finite()).unwrap_or(f64::NAN);
        table.extend([
            Column::real("radius_avg", vessels().map(|(_, r)| r)),
            Column::real("length", vessels().map(|(l, _)| l)),
            Column::real("tortuosity", links.iter().zip(vessels().map(|(l, _)| l)).map(tortuosity)),
            Column::real("volume", vessels().map(|(l, r)| area_of(r) * l)),
            Column::real("surface_area", vessels().map(|(l, r)| std::f64::consts::TAU * r * l)),
        ]);
    }
    if network.vessels().any(|(_, v)| !v.label.is_empty()) {
        table.push(Column::text("label", graph.labels(network)));
    }
    write_csv(edges, &table)
}

/// Reads the table of nodes: `id;pos_x;pos_y;pos_z` and whatever else.
///
/// # Errors
///
/// A column that is missing, an id that is empty or comes twice, a position that is not finite.
pub fn read_voreen_nodes(bytes: &[u8], scale: &Scale) -> Result<NodeTable, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let [id, place @ ..] = rows.columns([&["id"], &["pos_x"], &["pos_y"], &["pos_z"]], "Voreen's table of nodes")?;
    let mut table = NodeTable { nodes: Vec::new(), row_of: std::collections::HashMap::new(), has_lengths_without_unit: true };
    while let Some(row) = rows.row()? {
        let id = row.text(id).to_owned();
        ensure(!id.is_empty(), || Fault::line(row.line, "no id", "expected the id of a node"))?;
        let wrong = || Fault::line(row.line, format!("id {id} comes twice"), "expected every node once");
        ensure(table.row_of.insert(id.clone(), row.number).is_none(), wrong)?;
        let position = Some(scale.position(row.position(place)?));
        table.nodes.push(Node { id, position, ..Node::default() });
    }
    Ok(table)
}

/// Reads the table of edges over the nodes of [`read_voreen_nodes`]: observed vessels as they stand.
///
/// The radius is sqrt(a/π) of `avgCrossSection`, else `avgRadiusAvg`. Voreen marks what it could not measure by -1: a
/// length is then the distance between the nodes, and a radius is missing: NaN where radii are optional.
///
/// # Errors
///
/// A column that is missing, a node that the table of nodes lacks, an edge without length or radius, no edge.
pub fn read_voreen_edges(bytes: &[u8], nodes: NodeTable, options: &ReadOptions) -> Result<(Network, Vec<String>), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let what = "Voreen's table of edges";
    let [ends @ .., length] = rows.columns([&["node1id"], &["node2id"], &["length"]], what)?;
    let (area, radius) = (rows.find(&["avgCrossSection"]), rows.find(&["avgRadiusAvg"]));
    if area.is_none() && radius.is_none() && !options.is_radius_optional() {
        rows.column(&["avgCrossSection", "avgRadiusAvg"], what)?;
    }
    let (id, label) = (rows.find(&["id"]), rows.find(&["label"]));
    let mut network = Network::of(Frame::Unknown, nodes.nodes, Vec::new());
    let (mut from_area, mut from_radius, mut straight) = (0, 0, 0);
    while let Some(row) = rows.row()? {
        let name = id.map_or_else(|| row.number.to_string(), |id| row.text(id).to_owned());
        let fault = |found: String, accepted: &str| Fault::line(row.line, format!("edge {name}: {found}"), accepted);
        let mut at = [0; 2];
        for (end, column) in at.iter_mut().zip(ends) {
            let node = row.text(column);
            let missing = || fault(format!("node {node} is not in the table of nodes"), "expected an id of that table");
            *end = *nodes.row_of.get(node).ok_or_else(missing)?;
        }
        let valid =
            |column: Option<usize>| column.map_or(Ok(f64::NAN), |c| row.real(c)).map(|x| Some(x).filter(|x| is_radius(*x)));
        let (area, radius) = (valid(area)?.map(radius_of), valid(radius)?);
        from_area += usize::from(area.is_some());
        from_radius += usize::from(area.is_none() && radius.is_some());
        let radius = area.or(radius).map_or(f64::NAN, |radius| options.scale.length(radius));
        let accepted = "expected a positive avgCrossSection or avgRadiusAvg, or give `default_radius`";
        ensure(!radius.is_nan() || options.is_radius_optional(), || fault("no valid radius".to_owned(), accepted))?;
        let length = valid(Some(length))?.unwrap_or(f64::NAN);
        straight += usize::from(length.is_nan());
        add_straight(&mut network, at, options.scale.course(length), radius, label.map_or("", |label| row.text(label)))
            .ok_or_else(|| fault("no valid length, and both nodes in one place".to_owned(), "expected a positive length"))?;
    }
    ensure(network.vessel_count() > 0, || Fault::file("no edges", "expected a row for every edge"))?;
    let radii = [(from_area, "sqrt(avgCrossSection/π)"), (from_radius, "avgRadiusAvg, since the cross-section is missing")];
    let radii = radii.into_iter().filter(|(edges, _)| *edges > 0);
    let mut notes: Vec<String> =
        radii.map(|(edges, means)| format!("the radius of {} is {means}", plural(edges, "edge"))).collect();
    notes.extend(counted(straight, "edge", "without a valid length: took the distance between the nodes"));
    Ok((network, notes))
}

/// Whether all node ids are whole numbers, as in Voreen.
pub(crate) fn has_whole_ids(network: &Network) -> bool {
    network.nodes().all(|n| n.id.parse::<u64>().is_ok_and(|id| id.to_string() == n.id))
}

/// Writes both tables in Voreen's order of columns, in mm, mm² and mm³; unknown values are -1, as in Voreen.
///
/// Nodes keep their ids where all of these are whole numbers, as Voreen's are; otherwise the id is the row. Labels, where
/// there are any, stand in a last column `label`.
///
/// # Errors
///
/// A node without a position (`InvalidInput`), or the writers' own.
pub fn write_voreen(nodes: impl Write, edges: impl Write, network: &Network) -> io::Result<()> {
    let at = positions(network)?;
    let whole = has_whole_ids(network);
    let id = |row: usize| if whole { network.node(row).id.clone() } else { row.to_string() };
    let degree = network.degrees(|_| true);
    let [x, y, z] = coordinate_columns(["pos_x", "pos_y", "pos_z"], || at.iter().map(|p| p.map(millimetres)));
    let unknown = |name: &'static str, rows: usize| Column::real(name, std::iter::repeat_n(-1.0, rows));
    let table = [
        Column::text("id", (0..network.node_count()).map(id)),
        x,
        y,
        z,
        Column::whole("degree", degree.iter().copied()),
        unknown("isAtSampleBorder", network.node_count()),
    ];
    write_table(nodes, b';', &table)?;
    let vessels = || network.vessels().map(|(_, v)| v);
    let gap = |[a, b]: [usize; 2]| millimetres(distance(at[a], at[b]));
    let curveness = |length: f64, gap: f64| if gap > 0.0 { millimetres(length) / gap } else { -1.0 };
    let area = || vessels().map(|v| area_of(millimetres(v.radius)));
    let missing = |name| unknown(name, network.vessel_count());
    let mut table = vec![
        Column::whole("id", 0..network.vessel_count()),
        Column::text("node1id", network.vessels().map(|(ends, _)| id(ends[0]))),
        Column::text("node2id", network.vessels().map(|(ends, _)| id(ends[1]))),
        Column::real("length", vessels().map(|v| millimetres(v.length))),
        Column::real("distance", network.vessels().map(|(ends, _)| gap(ends))),
        Column::real("curveness", network.vessels().map(|(ends, v)| curveness(v.length, gap(ends)))),
        Column::real("volume", area().zip(vessels()).map(|(area, v)| area * millimetres(v.length))),
        Column::real("avgCrossSection", area()),
    ];
    table.extend(["minRadiusAvg", "minRadiusStd"].map(missing));
    table.push(Column::real("avgRadiusAvg", vessels().map(|v| millimetres(v.radius))));
    table.extend(["avgRadiusStd", "maxRadiusAvg", "maxRadiusStd", "roundnessAvg", "roundnessStd"].map(missing));
    table.push(Column::whole("node1_degree", network.vessels().map(|(ends, _)| degree[ends[0]])));
    table.push(Column::whole("node2_degree", network.vessels().map(|(ends, _)| degree[ends[1]])));
    table.extend(["num_voxels", "hasNodeAtSampleBorder"].map(missing));
    if vessels().any(|v| !v.label.is_empty()) {
        table.push(Column::text("label", vessels().map(|v| v.label.clone())));
    }
    write_table(edges, b';', &table)
}
