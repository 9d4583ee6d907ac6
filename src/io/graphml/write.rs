//! Writes a network as GraphML for NetworkX, igraph and Gephi.

use std::io::{self, Write};

use crate::io::tables::column::{Column, Values, check_rows};
use crate::io::tables::graph_columns::points;
use crate::io::xml::escape;
use crate::network::Network;

/// Writes the nodes with their ids, the vessels in their order, and the columns as attributes.
///
/// NaN and empty text are left out, and so is a column `id`, which is the node's own. A vessel with a path has it as
/// the attribute `points`: `x y z r;x y z r` in mm.
///
/// # Errors
///
/// A column without one value for each row (`InvalidInput`), or the writer's own.
pub fn write_graphml(
    mut out: impl Write,
    network: &Network,
    node_columns: &[Column],
    vessel_columns: &[Column],
) -> io::Result<()> {
    check_rows(node_columns, network.node_count())?;
    check_rows(vessel_columns, network.vessel_count())?;
    let with_points = network.vessels().any(|(_, v)| !v.path.is_empty()) && vessel_columns.iter().all(|c| c.name != "points");
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(out, r#"<graphml xmlns="http://graphml.graphdrawing.org/xmlns">"#)?;
    keys(&mut out, "node", node_columns)?;
    keys(&mut out, "edge", vessel_columns)?;
    if with_points {
        writeln!(out, r#"  <key id="points" for="edge" attr.name="points" attr.type="string"/>"#)?;
    }
    writeln!(out, r#"  <graph edgedefault="undirected">"#)?;
    let (mut of_node, mut of_vessel) = (Data::new("node", node_columns), Data::new("edge", vessel_columns));
    for (row, node) in network.nodes().enumerate() {
        writeln!(out, r#"    <node id="{}">"#, escape(&node.id))?;
        of_node.write(&mut out, row)?;
        writeln!(out, "    </node>")?;
    }
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let [a, b] = ends.map(|end| escape(&network.node(end).id));
        writeln!(out, r#"    <edge source="{a}" target="{b}">"#)?;
        of_vessel.write(&mut out, row)?;
        if with_points && !vessel.path.is_empty() {
            writeln!(out, r#"      <data key="points">{}</data>"#, points(&vessel.path))?;
        }
        writeln!(out, "    </edge>")?;
    }
    writeln!(out, "  </graph>\n</graphml>")?;
    out.flush()
}

fn keys(out: &mut impl Write, on: &str, columns: &[Column]) -> io::Result<()> {
    for (n, column) in columns.iter().enumerate().filter(|(_, c)| c.name != "id") {
        let kind = match column.values {
            Values::Real(_) => "double",
            Values::Integer(_) => "long",
            Values::Text(_) => "string",
        };
        writeln!(out, r#"  <key id="{on}{n}" for="{on}" attr.name="{}" attr.type="{kind}"/>"#, escape(&column.name))?;
    }
    Ok(())
}

/// The attributes of one kind of item, with what begins the element of each.
struct Data<'a> {
    columns: Vec<(String, &'a Values)>,
    text: String,
}

impl<'a> Data<'a> {
    fn new(on: &str, columns: &'a [Column]) -> Self {
        let written = columns.iter().enumerate().filter(|(_, c)| c.name != "id");
        let start = |(n, c): (usize, &'a Column)| (format!(r#"      <data key="{on}{n}">"#), &c.values);
        Self { columns: written.map(start).collect(), text: String::new() }
    }

    fn write(&mut self, out: &mut impl Write, row: usize) -> io::Result<()> {
        for (start, values) in &self.columns {
            values.put(row, &mut self.text);
            if !self.text.is_empty() {
                out.write_all(start.as_bytes())?;
                out.write_all(escape(&self.text).as_bytes())?;
                out.write_all(b"</data>\n")?;
            }
        }
        Ok(())
    }
}
