//! Reads a GraphML graph through its keys, defaults included, as one stream.

use std::borrow::Cow;
use std::collections::HashMap;

use super::super::attributes::{Records, nodes, vessels};
use super::super::xml::{self, Event, Events, Tag};
use super::keys::Keys;
use crate::error::Fault;
use crate::network::Network;
use crate::units::Scale;

/// What has been read of a file.
#[derive(Default)]
struct Graph<'a> {
    keys: Keys<'a>,
    ids: Vec<Cow<'a, str>>,
    nodes: Records,
    ends: Vec<[Cow<'a, str>; 2]>,
    edges: Records,
    directed: bool,
}

/// Reads a graph with its nodes and edges in the order of the file; returns also what a person should know.
///
/// # Errors
///
/// XML that is not well-formed or declares entities, more or fewer than one graph, a nested graph, hyperedge or port, a key
/// that is not declared, a node id that comes twice, an edge to a node that does not exist, an attribute that is wrong.
pub fn read_graphml(bytes: &[u8], scale: &Scale) -> Result<(Network, Vec<String>), Fault> {
    let mut events = Events::new(xml::utf8(bytes)?);
    let mut graph = Graph::default();
    let mut graphs = 0;
    while let Some(event) = events.next()? {
        match event {
            Event::Start(_) if events.depth() == 1 => {}
            Event::Start(tag) if tag.name == "key" => graph.keys.declare(&tag, &mut events)?,
            Event::Start(tag) if tag.name == "graph" => {
                graphs += 1;
                if graphs == 1 { graph.read(&tag, &mut events)? } else { events.skip(|_| Ok(()))? }
            }
            Event::Start(_) => events.skip(|_| Ok(()))?,
            _ => {}
        }
    }
    if graphs != 1 {
        return Err(Fault::file(format!("{graphs} graphs"), "expected one <graph> in <graphml>"));
    }
    graph.network(scale)
}

/// Refuses what is no simple graph.
fn simple(tag: &Tag) -> Result<(), Fault> {
    match tag.name {
        "graph" | "hyperedge" | "port" => {
            Err(Fault::line(tag.line, format!("a <{}> within the graph", tag.name), "expected only nodes and edges"))
        }
        _ => Ok(()),
    }
}

impl<'a> Graph<'a> {
    /// Reads a `<graph>`, which has begun, up to its end.
    fn read(&mut self, tag: &Tag<'a>, events: &mut Events<'a>) -> Result<(), Fault> {
        self.directed = tag.attribute("edgedefault")?.as_deref() == Some("directed");
        let depth = events.depth();
        while events.depth() >= depth {
            let tag = match events.next()? {
                Some(Event::Start(tag)) => tag,
                Some(_) => continue,
                None => break,
            };
            simple(&tag)?;
            match tag.name {
                "node" => {
                    let missing = || Fault::line(tag.line, format!("node {} has no id", self.ids.len()), "expected an id");
                    self.ids.push(tag.attribute("id")?.ok_or_else(missing)?);
                    item(&mut self.nodes, &mut self.keys, &tag, events)?;
                }
                "edge" => {
                    self.directed |= tag.attribute("directed")?.as_deref() == Some("true");
                    let row = self.ends.len();
                    let end = |side: &str| {
                        let missing = || Fault::line(tag.line, format!("edge {row} has no {side}"), "expected the id of a node");
                        tag.attribute(side)?.ok_or_else(missing)
                    };
                    self.ends.push([end("source")?, end("target")?]);
                    item(&mut self.edges, &mut self.keys, &tag, events)?;
                }
                _ => events.skip(simple)?,
            }
        }
        Ok(())
    }

    fn network(mut self, scale: &Scale) -> Result<(Network, Vec<String>), Fault> {
        if self.ids.is_empty() {
            return Err(Fault::file("the graph has no nodes", "expected <node> elements"));
        }
        self.keys.name(&mut self.nodes, "node")?;
        self.keys.name(&mut self.edges, "edge")?;
        let mut network = Network::new();
        for node in nodes(&self.ids, &self.nodes, scale)? {
            network.add_node(node);
        }
        self.nodes = Records::default();
        let ends = self.rows()?;
        let mut notes = vessels(&mut network, &ends, &self.edges, scale)?;
        if self.directed {
            notes.push("the graph is directed: its edges are taken as undirected".to_owned());
        }
        Ok((network, notes))
    }

    /// The rows of the nodes at the ends of each edge.
    fn rows(&mut self) -> Result<Vec<[usize; 2]>, Fault> {
        let row_of: HashMap<&str, usize> = self.ids.iter().enumerate().map(|(row, id)| (id.as_ref(), row)).collect();
        let mut rows = Vec::with_capacity(self.ends.len());
        for (row, ids) in std::mem::take(&mut self.ends).into_iter().enumerate() {
            let mut ends = [0; 2];
            for (end, (id, side)) in ends.iter_mut().zip(ids.iter().zip(["source", "target"])) {
                *end = *row_of.get(id.as_ref()).ok_or_else(|| {
                    let found = format!("edge {row}: {side} \"{id}\" does not exist");
                    Fault::line(self.edges.get(row).line, found, "expected the id of a node")
                })?;
            }
            rows.push(ends);
        }
        Ok(rows)
    }
}

/// Reads the data of a node or edge, which has begun, up to its end.
fn item<'a>(records: &mut Records, keys: &mut Keys<'a>, tag: &Tag<'a>, events: &mut Events<'a>) -> Result<(), Fault> {
    records.begin(tag.line);
    let depth = events.depth();
    while events.depth() >= depth {
        match events.next()? {
            Some(Event::Start(data)) if data.name == "data" => {
                let key = keys.number(data.attribute("key")?.unwrap_or_default(), data.line);
                records.put(key, &events.text(simple)?);
            }
            Some(Event::Start(other)) => {
                simple(&other)?;
                events.skip(simple)?;
            }
            Some(_) => {}
            None => break,
        }
    }
    Ok(())
}
