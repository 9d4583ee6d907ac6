//! The two tables of Voreen's vessel graph, which VesselGraph distributes: nodes and edges, separated by semicolons.

use std::collections::HashMap;
use std::io::{self, Write};

use crate::formats::options::ReadOptions;
use crate::formats::polylines::{add_straight, positions};
use crate::formats::tables::graph::NodeTable;
use crate::formats::tables::reader::{TableReader, counted, plural};
use crate::formats::tables::write::{Column, coordinate_columns, write_table};
use willis_core::error::Fault;
use willis_core::network::{Network, Node, Scale, is_radius, millimetres};
use willis_core::support::geometry::{area_of, distance, radius_of};

/// Reads the table of nodes: `id;pos_x;pos_y;pos_z` and whatever else.
///
/// # Errors
///
/// A column that is missing, an id that is empty or comes twice, a position that is not finite.
pub fn read_voreen_nodes(bytes: &[u8], scale: &Scale) -> Result<NodeTable, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let [id, place @ ..] = rows.columns([&["id"], &["pos_x"], &["pos_y"], &["pos_z"]], "Voreen's table of nodes")?;
    let mut table = NodeTable { nodes: Vec::new(), row_of: HashMap::new(), has_lengths_without_unit: true };
    while let Some(row) = rows.row()? {
        let id = row.text(id).to_owned();
        if id.is_empty() {
            return Err(Fault::line(row.line, "no id", "expected the id of a node"));
        }
        if table.row_of.insert(id.clone(), row.number).is_some() {
            return Err(Fault::line(row.line, format!("id {id} comes twice"), "expected every node once"));
        }
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
    let mut network = Network::new();
    for node in nodes.nodes {
        network.add_node(node);
    }
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
        if radius.is_nan() && !options.is_radius_optional() {
            let accepted = "expected a positive avgCrossSection or avgRadiusAvg, or give `default_radius`";
            return Err(fault("no valid radius".to_owned(), accepted));
        }
        let length = valid(Some(length))?.map_or(f64::NAN, |length| options.scale.length(length));
        straight += usize::from(length.is_nan());
        add_straight(&mut network, at, length, radius, label.map_or("", |label| row.text(label)))
            .ok_or_else(|| fault("no valid length, and both nodes in one place".to_owned(), "expected a positive length"))?;
    }
    if network.vessel_count() == 0 {
        return Err(Fault::file("no edges", "expected a row for every edge"));
    }
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
