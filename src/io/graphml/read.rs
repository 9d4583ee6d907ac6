//! Reads a GraphML graph through its keys, defaults included, as one stream.

use std::collections::HashMap;
use std::io::BufRead;

use super::keys::Keys;
use crate::error::Fault;
use crate::io::attributes::edge::vessels;
use crate::io::attributes::node::nodes;
use crate::io::attributes::records::Records;
use crate::io::xml::events::{Events, Step, Tag};
use crate::network::Network;
use crate::network::units::Scale;

/// What has been read of a file.
#[derive(Default)]
struct Graph {
    keys: Keys,
    ids: Vec<String>,
    row_of: HashMap<String, usize>,
    nodes: Records,
    ends: Vec<[End; 2]>,
    edges: Records,
    directed: bool,
    /// The text of an element, kept for the next one.
    text: String,
}

/// The end of an edge: the row of a node, or the id of one that has not come yet.
enum End {
    Row(usize),
    Id(String),
}

/// Reads a graph with its nodes and edges in the order of the file, of which it keeps what it needs alone; returns also what a person should know.
///
/// # Errors
///
/// XML that is not well-formed or declares entities, more or fewer than one graph, a nested graph, hyperedge or port, a key
/// that is not declared, a node id that comes twice, an edge to a node that does not exist, an attribute that is wrong.
pub fn read_graphml(input: impl BufRead, scale: &Scale, radius_optional: bool) -> Result<(Network, Vec<String>), Fault> {
    let mut events = Events::new(input);
    let mut graph = Graph::default();
    let mut graphs = 0;
    while let Some(step) = events.next()? {
        if step != Step::Start || events.depth() == 1 {
            continue;
        }
        match events.tag().name() {
            "key" => graph.keys.declare(&mut events)?,
            "graph" => {
                graphs += 1;
                if graphs == 1 { graph.read(&mut events)? } else { events.skip(|_| Ok(()))? }
            }
            _ => events.skip(|_| Ok(()))?,
        }
    }
    drop(events);
    if graphs != 1 {
        return Err(Fault::file(format!("{graphs} graphs"), "expected one <graph> in <graphml>"));
    }
    graph.network(scale, radius_optional)
}

/// Refuses what is no simple graph.
fn simple(tag: &Tag) -> Result<(), Fault> {
    match tag.name() {
        name @ ("graph" | "hyperedge" | "port") => {
            Err(Fault::line(tag.line, format!("a <{name}> within the graph"), "expected only nodes and edges"))
        }
        _ => Ok(()),
    }
}

impl Graph {
    /// Reads a `<graph>`, which has begun, up to its end.
    fn read(&mut self, events: &mut Events<impl BufRead>) -> Result<(), Fault> {
        self.directed = events.tag().attribute("edgedefault")?.as_deref() == Some("directed");
        let depth = events.depth();
        while events.depth() >= depth {
            match events.next()? {
                Some(Step::Start) => {}
                Some(_) => continue,
                None => break,
            }
            let tag = events.tag();
            simple(tag)?;
            match tag.name() {
                "node" => {
                    let missing = || Fault::line(tag.line, format!("node {} has no id", self.ids.len()), "expected an id");
                    let id = tag.attribute("id")?.ok_or_else(missing)?.into_owned();
                    self.row_of.entry(id.clone()).or_insert(self.ids.len());
                    self.ids.push(id);
                    item(&mut self.nodes, &mut self.keys, events, &mut self.text)?;
                }
                "edge" => {
                    self.directed |= tag.attribute("directed")?.as_deref() == Some("true");
                    let row = self.ends.len();
                    let end = |side: &str| {
                        let missing = || Fault::line(tag.line, format!("edge {row} has no {side}"), "expected the id of a node");
                        let id = tag.attribute(side)?.ok_or_else(missing)?;
                        Ok(self.row_of.get(&*id).map_or_else(|| End::Id(id.into_owned()), |row| End::Row(*row)))
                    };
                    self.ends.push([end("source")?, end("target")?]);
                    item(&mut self.edges, &mut self.keys, events, &mut self.text)?;
                }
                _ => events.skip(simple)?,
            }
        }
        Ok(())
    }

    fn network(mut self, scale: &Scale, radius_optional: bool) -> Result<(Network, Vec<String>), Fault> {
        if self.ids.is_empty() {
            return Err(Fault::file("the graph has no nodes", "expected <node> elements"));
        }
        self.keys.name(&mut self.nodes, "node")?;
        self.keys.name(&mut self.edges, "edge")?;
        let mut network = Network::new();
        for node in nodes(&self.ids, &self.nodes, scale)? {
            network.add_node(node);
        }
        (self.nodes, self.ids) = Default::default();
        let ends = self.rows()?;
        let mut notes = vessels(&mut network, &ends, &self.edges, scale, radius_optional)?;
        if self.directed {
            notes.push("the graph is directed: its edges are taken as undirected".to_owned());
        }
        Ok((network, notes))
    }

    /// The rows of the nodes at the ends of each edge.
    fn rows(&mut self) -> Result<Vec<[usize; 2]>, Fault> {
        let mut rows = Vec::with_capacity(self.ends.len());
        let row_of = std::mem::take(&mut self.row_of);
        for (row, both) in std::mem::take(&mut self.ends).iter().enumerate() {
            let mut ends = [0; 2];
            for (place, (end, side)) in ends.iter_mut().zip(both.iter().zip(["source", "target"])) {
                *place = match end {
                    End::Row(node) => *node,
                    End::Id(id) => *row_of.get(id).ok_or_else(|| {
                        let found = format!("edge {row}: {side} \"{id}\" does not exist");
                        Fault::line(self.edges.get(row).line, found, "expected the id of a node")
                    })?,
                };
            }
            rows.push(ends);
        }
        Ok(rows)
    }
}

/// Reads the data of a node or edge, which has begun, up to its end; `text` is for the texts.
fn item(records: &mut Records, keys: &mut Keys, events: &mut Events<impl BufRead>, text: &mut String) -> Result<(), Fault> {
    records.begin(events.tag().line);
    let depth = events.depth();
    while events.depth() >= depth {
        match events.next()? {
            Some(Step::Start) if events.tag().name() == "data" => {
                let tag = events.tag();
                let key = keys.number(&tag.attribute("key")?.unwrap_or_default(), tag.line);
                if keys.is_wanted(key) {
                    events.text(simple, text)?;
                    records.put(key, text);
                } else {
                    events.skip(simple)?;
                }
            }
            Some(Step::Start) => {
                simple(events.tag())?;
                events.skip(simple)?;
            }
            Some(_) => {}
            None => break,
        }
    }
    Ok(())
}
