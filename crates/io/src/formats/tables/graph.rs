//! A graph as CSV: a table of edges and a table of nodes, and the columns that GraphML shares with them; and CSV of points, `fragment,x,y,z,radius`, one
//! point a row.

use std::collections::HashMap;
use std::io::{self, Write};

use super::reader::{TableReader, columns};
use super::write::figures;
use crate::formats::attributes::{
    self, COMPLIANCE, POSITION_COLUMNS, PROXIMAL, Records, SPEED, THICKNESS, YOUNG, nodes, vessels,
};
use crate::formats::polylines::{is_straight, polylines};
use crate::formats::{Column, ReadOptions, Values, checksum, coordinate_columns, counted, ensure, escape_formula, write_csv};
use willis_core::error::Fault;
use willis_core::network::units::{in_megapascals, ml_per_min, ml_per_mmhg, mmhg, mmhg_s_per_ml};
use willis_core::network::{
    Centerlines, Condition, ConditionFrom, Evidence, Frame, Network, Node, PathPoint, Role, Scale, Wall, fragments, is_radius,
    millimetres,
};
use willis_core::support::geometry::{Point, distance};

/// The columns that may hold the names of nodes.
const NAMES: [&str; 2] = ["node", "id"];
const ENDS: [[&str; 2]; 2] = [["node_a", "node_b"], ["source", "target"]];

/// The row and the side of the edge that states the position of a node, if one does.
type EdgeEnd = Option<(usize, usize)>;

/// The nodes of a table, and the row of each by the name that the edges use.
#[derive(Debug, Clone)]
pub struct NodeTable {
    pub(crate) nodes: Vec<Node>,
    pub(crate) row_of: HashMap<String, usize>,
    /// Whether a length in it is in the unit of the file.
    pub(crate) has_lengths_without_unit: bool,
}

/// Whether these columns are those of a table of edges.
pub(crate) fn is_header(columns: &[&str]) -> bool {
    ENDS.iter().any(|ends| ends.iter().all(|end| columns.contains(end)))
}

/// Reads a table of nodes: `node` (the name in the table of edges), `id`, and the attributes of GraphML nodes.
///
/// # Errors
///
/// A table without `node` and `id`, a name or id that comes twice, an attribute that is wrong.
pub fn read_csv_nodes(bytes: &[u8], scale: &Scale) -> Result<NodeTable, Fault> {
    let (header_line, header, records) = table(bytes)?;
    let Some(key) = NAMES.into_iter().find(|key| header.iter().any(|h| h == key)) else {
        return Err(Fault::line(header_line, columns(&header), "expected a column node or id"));
    };
    let mut row_of = HashMap::with_capacity(records.len());
    let mut ids = Vec::with_capacity(records.len());
    for (row, record) in records.iter().enumerate() {
        let Some(name) = record.word(key) else {
            return Err(Fault::line(record.line, format!("no {key}"), "expected the name of a node"));
        };
        ids.push(record.text("id").unwrap_or(name));
        let twice = || Fault::line(record.line, format!("{key} {name} comes twice"), "expected every node once");
        ensure(row_of.insert(name.to_owned(), row).is_none(), twice)?;
    }
    let has_lengths_without_unit = attributes::has_lengths_without_unit(&records);
    Ok(NodeTable { nodes: nodes(&ids, &records, scale)?, row_of, has_lengths_without_unit })
}

/// Reads a table of edges: `node_a,node_b` (or `source,target`) and the attributes of GraphML edges; returns also what
/// notes for the user. Without a table of nodes, nodes come in the order of their first edge, positioned by
/// `ax_mm,ay_mm,az_mm` and `bx_mm,by_mm,bz_mm` where there are such columns.
///
/// # Errors
///
/// A table without the two columns or without rows, a node that is missing in the table of nodes, an attribute that is wrong.
pub fn read_csv_edges(bytes: &[u8], known: Option<NodeTable>, options: &ReadOptions) -> Result<(Network, Vec<String>), Fault> {
    let (header_line, header, records) = table(bytes)?;
    let Some(ends) = ENDS.into_iter().find(|ends| ends.iter().all(|end| header.iter().any(|h| h == end))) else {
        let has = |names: [&str; 2]| header.iter().any(|column| names.iter().any(|name| column.eq_ignore_ascii_case(name)));
        let accepted = if header.iter().any(|column| column == "node") {
            "these are nodes; give the table of edges, with columns node_a,node_b or source,target"
        } else if has(["x", "x_mm"]) && has(["y", "y_mm"]) && has(["z", "z_mm"]) {
            POINTS_HEADER
        } else {
            "expected a table of edges with columns node_a,node_b or source,target"
        };
        return Err(Fault::line(header_line, columns(&header), accepted));
    };
    let given = known.is_some();
    let has_unit = known.as_ref().is_some_and(|table| table.has_lengths_without_unit);
    let (found, mut row_of) = known.map_or_else(Default::default, |table| (table.nodes, table.row_of));
    // The nodes that no table names; and of every node the edge and the end that state its position.
    let mut made: Vec<&str> = Vec::new();
    let mut placed: Vec<EdgeEnd> = vec![None; found.len()];
    let mut rows = Vec::with_capacity(records.len());
    for (row, record) in records.iter().enumerate() {
        let mut both = [0; 2];
        for (side, (end, column)) in both.iter_mut().zip(ends).enumerate() {
            let Some(name) = record.word(column) else {
                return Err(Fault::line(record.line, format!("edge {row}: no {column}"), "expected the name of a node"));
            };
            *end = match row_of.get(name) {
                Some(node) => *node,
                None if given => {
                    let wrong = format!("edge {row}: {column} {name} is not in the table of nodes");
                    return Err(Fault::line(record.line, wrong, "expected a name of its column node"));
                }
                None => {
                    made.push(name);
                    placed.push(None);
                    row_of.insert(name.to_owned(), made.len() - 1);
                    made.len() - 1
                }
            };
            if placed[*end].is_none() && END_POSITION_COLUMNS[side].iter().any(|axis| record.text(axis).is_some()) {
                placed[*end] = Some((row, side));
            }
        }
        rows.push(both);
    }
    ensure(!rows.is_empty(), || Fault::file("no edges", "expected a row for every edge"))?;
    let places = places(&records, &placed);
    let nodes = if given {
        same_places(&found, &places, &records, &placed, &options.scale)?;
        found
    } else {
        nodes(&made, &places, &options.scale)?
    };
    let mut network = Network::of(Frame::Unknown, nodes, Vec::new());
    let mut notes = vessels(&mut network, &rows, &records, options)?;
    notes.extend(attributes::unit_note(&options.scale, has_unit || attributes::has_lengths_without_unit(&records)));
    let again = attributes::directions_as_one(&rows, &network).into_iter().filter(|is_new| !is_new).count();
    let note = "like another from its other end: taken for two vessels side by side; leave one out if both are one vessel";
    notes.extend(counted(again, "edge", note));
    Ok((network, notes))
}

/// Refuses a table of nodes that has nodes elsewhere than the table of edges: it is of another network.
fn same_places(nodes: &[Node], places: &Records, edges: &Records, placed: &[EdgeEnd], scale: &Scale) -> Result<(), Fault> {
    let names: Vec<&str> = nodes.iter().map(|node| &*node.id).collect();
    let stated = attributes::nodes(&names, places, scale)?;
    let most = attributes::reach(nodes.iter());
    for ((node, there), place) in nodes.iter().zip(&stated).zip(placed) {
        let (Some(here), Some(there), Some((row, side))) = (node.position, there.position, place) else { continue };
        if distance(here, there) > most {
            let end = END_POSITION_COLUMNS[*side][0].trim_end_matches("x_mm");
            let found = format!(
                "edge {row}: node {} lies at {} here and at {} in the table of nodes",
                node.id,
                attributes::place(there),
                attributes::place(here)
            );
            let accepted =
                format!("expected the table of nodes of this network, or a table without {end}x_mm, {end}y_mm, {end}z_mm");
            return Err(Fault::line(edges.get(*row).line, found, accepted));
        }
    }
    Ok(())
}

/// The position of each node, from the columns of one end of an edge.
fn places(edges: &Records, placed: &[EdgeEnd]) -> Records {
    let mut nodes = Records::named(&POSITION_COLUMNS);
    for place in placed {
        let edge = place.map(|(row, side)| (edges.get(row), END_POSITION_COLUMNS[side]));
        nodes.begin(edge.as_ref().map_or(0, |(record, _)| record.line));
        for (axis, column) in edge.iter().flat_map(|(_, columns)| columns.iter().enumerate()) {
            if let Some(text) = edge.as_ref().and_then(|(record, _)| record.text(column)) {
                nodes.put(axis, text);
            }
        }
    }
    nodes
}

/// Writes a network as the two tables that [`read_csv_nodes`] and [`read_csv_edges`] take, with every attribute of GraphML:
/// the nodes with their ids and conditions, the vessels in their order, each with its points.
///
/// # Errors
///
/// The writers' own.
pub fn write_csv_graph(mut nodes: impl Write, edges: impl Write, network: &Network) -> io::Result<()> {
    let (node_columns, mut vessel_columns) = graph_columns(network);
    if !is_straight(network) {
        vessel_columns.push(Column::text("points", network.vessels().map(|(_, v)| points(&v.path))));
    }
    let mut table = Vec::new();
    write_csv(&mut table, &node_columns)?;
    let checksum = checksum_of_pair(&table);
    let in_first_row = (0..network.vessel_count()).map(|row| if row == 0 { checksum.clone() } else { String::new() });
    vessel_columns.push(Column::text(PAIR, in_first_row));
    nodes.write_all(&table)?;
    write_csv(edges, &vessel_columns)
}

/// The column of a table of edges with the checksum of its table of nodes, in the first row.
const PAIR: &str = "nodes_sha256";

/// The first 16 digits of the SHA-256 of a table of nodes.
pub(crate) fn checksum_of_pair(nodes: &[u8]) -> String {
    checksum(nodes).chars().take(16).collect()
}

/// The checksum that a table of edges states of its table of nodes.
pub(crate) fn stated_checksum(edges: &[u8]) -> Option<String> {
    let mut rows = TableReader::open(edges).ok()?;
    let column = rows.find(&[PAIR])?;
    let row = rows.row().ok()??;
    row.texts().find(|(at, _)| *at == column).map(|(_, text)| text.to_owned())
}

/// Whether a column is read.
pub(crate) fn is_wanted(name: &str) -> bool {
    let own = [&NAMES[..], ENDS.as_flattened(), END_POSITION_COLUMNS.as_flattened()];
    attributes::is_wanted(name) || name == PAIR || own.iter().any(|names| names.contains(&name))
}

/// The line of the header, the header and the rows of a file; of the rows only the columns that are read.
fn table(bytes: &[u8]) -> Result<(usize, Vec<String>, Records), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let header = rows.header.clone();
    let wanted: Vec<bool> = header.iter().map(|name| is_wanted(name)).collect();
    let mut records = Records::named(&header);
    while let Some(row) = rows.row()? {
        records.begin(row.line);
        for (column, text) in row.texts().filter(|(column, _)| wanted[*column]) {
            records.put(column, text);
        }
    }
    Ok((rows.header_line, header, records))
}

/// The columns with the positions of the two ends of a vessel.
pub const END_POSITION_COLUMNS: [[&str; 3]; 2] = [["ax_mm", "ay_mm", "az_mm"], ["bx_mm", "by_mm", "bz_mm"]];

/// The coordinates of a position, mm; NaN without one.
pub fn coordinates(position: Option<Point>) -> [f64; 3] {
    position.map_or([f64::NAN; 3], |p| p.map(millimetres))
}

/// What a node states, or is given: its role, its condition, and whether that was found.
pub type StatedNode = (Option<Role>, Option<Condition>, ConditionFrom);

/// The columns of nodes.csv. `pressure` in Pa.
pub fn node_columns(
    network: &Network,
    stated: &[StatedNode],
    pressure: impl Iterator<Item = Option<f64>>,
    component: &[usize],
) -> Vec<Column> {
    let nodes = || network.nodes();
    let [x, y, z] = coordinate_columns(POSITION_COLUMNS, || nodes().map(|n| coordinates(n.position)));
    vec![
        Column::whole("node", 0..network.node_count()),
        Column::text("id", nodes().map(|n| &n.id)),
        x,
        y,
        z,
        Column::real("radius_mm", nodes().map(|n| n.radius.map_or(f64::NAN, millimetres))),
        Column::text("label", nodes().map(|n| &n.label)),
        Column::text("role", stated.iter().map(|(role, ..)| role.map_or("", Role::name))),
        Column::real("pressure_mmHg", pressure.map(|p| p.map_or(f64::NAN, mmhg))),
        Column::whole("component", component.iter().copied()),
    ]
}

/// A column of what some rows state; `None` where no row does.
fn stated_column(name: &'static str, values: impl Iterator<Item = Option<f64>>) -> Option<Column> {
    let values: Vec<f64> = values.map(|x| x.unwrap_or(f64::NAN)).collect();
    values.iter().any(|x| !x.is_nan()).then_some(Column { name: name.into(), values: Values::Real(values) })
}

/// The columns with the terminal resistances and flows of the nodes, as a graph file stores boundary conditions, and which of them were found;
/// columns without any value are left out.
pub fn condition_columns(stated: &[StatedNode]) -> Vec<Column> {
    let figure = |of: fn(Condition) -> Option<f64>| stated.iter().map(move |(_, condition, _)| condition.and_then(of));
    let resistance = |c| if let Condition::Resistance { resistance, .. } = c { Some(mmhg_s_per_ml(resistance)) } else { None };
    let venous = |c| if let Condition::Resistance { venous, .. } = c { Some(mmhg(venous)).filter(|p| *p != 0.0) } else { None };
    let flow = |c| if let Condition::Flow(flow) = c { Some(ml_per_min(flow)) } else { None };
    let columns = [
        stated_column("resistance_mmHg_s_per_mL", figure(resistance)),
        stated_column(super::conditions::VENOUS, figure(venous)),
        stated_column("flow_mL_per_min", figure(flow)),
    ];
    let from = || stated.iter().map(|(.., from)| *from);
    let is_found = from().any(|from| from != ConditionFrom::Statement);
    let found = is_found.then(|| Column::text("found", from().map(ConditionFrom::name)));
    columns.into_iter().chain([found]).flatten().collect()
}

/// The columns with the parts of the Windkessels of nodes; columns without any value are left out.
pub fn windkessel_columns(network: &Network) -> Vec<Column> {
    let proximal = network.nodes().map(|node| node.windkessel().proximal.map(mmhg_s_per_ml));
    let compliance = network.nodes().map(|node| node.windkessel().compliance.map(ml_per_mmhg));
    [stated_column(PROXIMAL, proximal), stated_column(COMPLIANCE, compliance)].into_iter().flatten().collect()
}

/// The columns with what vessels state of their flow, their resistances and walls; columns without any value are left out.
pub fn stated_columns(network: &Network) -> Vec<Column> {
    let resistances = network.vessels().map(|(_, v)| v.resistance.map(mmhg_s_per_ml));
    stated_column("resistance_mmHg_s_per_mL", resistances).into_iter().chain(wall_columns(network)).collect()
}

/// The columns with the walls of vessels; columns without any value are left out.
pub fn wall_columns(network: &Network) -> Vec<Column> {
    let figure = |of: fn(Wall) -> Option<f64>| network.vessels().map(move |(_, v)| v.wall.and_then(of));
    let speed = |wall| if let Wall::Speed(speed) = wall { Some(speed) } else { None };
    let young = |wall| if let Wall::Elastic { young, .. } = wall { Some(in_megapascals(young)) } else { None };
    let thickness = |wall| if let Wall::Elastic { thickness, .. } = wall { Some(millimetres(thickness)) } else { None };
    let columns =
        [stated_column(SPEED, figure(speed)), stated_column(YOUNG, figure(young)), stated_column(THICKNESS, figure(thickness))];
    columns.into_iter().flatten().collect()
}

/// The first columns of edges.csv: the ends of every vessel, its label, origin, length and radius.
pub fn vessel_columns(network: &Network) -> Vec<Column> {
    let end = |which: usize| {
        let places = || network.vessels().map(|(ends, _)| coordinates(network.node(ends[which]).position));
        coordinate_columns(END_POSITION_COLUMNS[which], places)
    };
    let mut columns = vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::whole("node_a", network.vessels().map(|(ends, _)| ends[0])),
        Column::whole("node_b", network.vessels().map(|(ends, _)| ends[1])),
    ];
    columns.extend([0, 1].into_iter().flat_map(end));
    columns.extend([
        Column::text("label", network.vessels().map(|(_, v)| &v.label)),
        Column::text("origin", network.vessels().map(|(_, v)| v.origin.name())),
        Column::real("length_mm", network.vessels().map(|(_, v)| millimetres(v.length))),
        Column::real("radius_mm", network.vessels().map(|(_, v)| millimetres(v.radius))),
    ]);
    columns
}

/// The columns of nodes and of vessels with every attribute that the graph readers read, except the vessels' points.
pub fn graph_columns(network: &Network) -> (Vec<Column>, Vec<Column>) {
    graph_columns_with(network, &network.nodes().map(|n| (n.role, n.condition, n.condition_from)).collect::<Vec<_>>())
}

/// As [`graph_columns`], with other roles and conditions than those that the nodes state, and whether these were found.
pub fn graph_columns_with(network: &Network, stated: &[StatedNode]) -> (Vec<Column>, Vec<Column>) {
    let pressure = |(_, c, _): &StatedNode| if let Some(Condition::Pressure(p)) = c { Some(*p) } else { None };
    let mut nodes = node_columns(network, stated, stated.iter().map(pressure), &fragments(network, |_, _| true).of_node);
    nodes.extend(condition_columns(stated));
    let mut vessels = vessel_columns(network);
    vessels.push(Column::real("prior", network.vessels().map(|(_, v)| v.prior)));
    vessels.extend(stated_columns(network));
    nodes.extend(windkessel_columns(network));
    if network.vessels().any(|(_, v)| v.certain) {
        vessels.push(Column::text("certain", network.vessels().map(|(_, v)| v.certain.to_string())));
    }
    vessels.extend(stated_column("kept", network.vessels().map(|(_, v)| v.kept.map(|kept| f64::from(u8::from(kept))))));
    nodes.extend(stated_column("alone", network.nodes().map(|n| n.root_score)));
    if network.vessels().any(|(_, v)| v.evidence.is_some()) {
        let figure = |of: fn(Evidence) -> f64| network.vessels().map(move |(_, v)| v.evidence().map_or(f64::NAN, of));
        vessels.push(Column::real("probability", figure(|e| e.probability)));
        vessels.push(Column::real("hangs_a", figure(|e| e.attached[0])));
        vessels.push(Column::real("hangs_b", figure(|e| e.attached[1])));
        vessels.push(Column::real("continues_a", figure(|e| e.continuation_odds[0])));
        vessels.push(Column::real("continues_b", figure(|e| e.continuation_odds[1])));
    }
    (nodes, vessels)
}

/// A path as the attribute `points`, mm: `x y z r;x y z r`.
pub(crate) fn points(path: &[PathPoint]) -> String {
    path.iter().map(|point| figures(point, "").join(" ")).collect::<Vec<_>>().join(";")
}

const POINTS_HEADER: &str =
    "expected a header with columns fragment,x,y,z,radius (or x_mm and so on, in mm); label and id are optional";

/// Reads points in the order of their fragments; returns also notes for the user. Columns called `_mm` are in mm and come before
/// others, which are in the unit of `scale`.
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
    let [x, y, z] = [["x_mm", "x"], ["y_mm", "y"], ["z_mm", "z"]].map(|names| rows.find(&names));
    let radius = rows.find(&["radius_mm", "r_mm", "radius", "r"]);
    let (Some(fragment), Some(x), Some(y), Some(z)) = (fragment, x, y, z) else {
        return Err(Fault::line(header, columns(&rows.header), POINTS_HEADER));
    };
    let none = || Fault::line(header, "no column radius", "expected one, or give `default_radius`");
    ensure(radius.is_some() || options.is_radius_optional(), none)?;
    let mut lines = Centerlines::default();
    let mut last: HashMap<String, (u32, u32)> = HashMap::new();
    let mut line_of: HashMap<u64, usize> = HashMap::new();
    while let Some(row) = rows.row()? {
        if row.texts().next().is_none() {
            continue;
        }
        let name = row.text(fragment);
        ensure(!name.is_empty(), || Fault::line(row.line, "no fragment", "expected the name or number of the polyline"))?;
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
    ensure(!lines.points.is_empty(), || Fault::file("no points", "expected a row for every point"))?;
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
