//! Reads a GraphML graph through its keys, defaults included.

use std::collections::{BTreeMap, HashMap};

use roxmltree::Node as Element;

use super::super::attributes::{Record, nodes, vessels};
use super::super::xml;
use crate::error::Fault;
use crate::network::Network;
use crate::units::Scale;

/// A declared attribute: its name (none for what only an editor needs), its default for nodes and for edges.
struct Key<'a> {
    name: Option<&'a str>,
    default: Option<String>,
    on: &'a str,
}

/// Counts the lines up to an element, going forward from one to the next.
struct Lines<'a> {
    text: &'a str,
    at: usize,
    line: usize,
}

impl Lines<'_> {
    fn of(&mut self, element: Element) -> usize {
        let to = element.range().start;
        self.line += self.text.get(self.at..to).map_or(0, |passed| passed.matches('\n').count());
        self.at = to;
        self.line
    }
}

/// Reads a graph with its nodes and edges in the order of the file; returns also what a person should know.
///
/// # Errors
///
/// XML that is not well-formed, more or fewer than one graph, a nested graph, hyperedge or port, a key that is not
/// declared, a node id that comes twice, an edge to a node that does not exist, an attribute that is wrong.
pub fn read_graphml(bytes: &[u8], scale: &Scale) -> Result<(Network, Vec<String>), Fault> {
    let text = xml::utf8(bytes)?;
    let document = xml::parse(text)?;
    let keys = keys(document.root_element())?;
    let line_of = |element: Element| document.text_pos_at(element.range().start).row as usize;
    let graphs: Vec<Element> = children(document.root_element(), "graph").collect();
    let [graph] = graphs[..] else {
        return Err(Fault::file(format!("{} graphs", graphs.len()), "expected one <graph> in <graphml>"));
    };
    let refused = |e: &Element| matches!(e.tag_name().name(), "graph" | "hyperedge" | "port");
    if let Some(element) = graph.descendants().skip(1).find(refused) {
        let found = format!("a <{}> within the graph", element.tag_name().name());
        return Err(Fault::line(line_of(element), found, "expected only nodes and edges"));
    }
    let mut lines = Lines { text, at: 0, line: 1 };
    let (mut records, mut row_of) = (Vec::new(), HashMap::new());
    let mut ends = Vec::new();
    let mut directed = graph.attribute("edgedefault") == Some("directed");
    for element in graph.children().filter(Element::is_element) {
        match element.tag_name().name() {
            "node" => {
                let line = lines.of(element);
                let Some(id) = element.attribute("id") else {
                    return Err(Fault::line(line, format!("node {} has no id", records.len()), "expected an id"));
                };
                row_of.entry(id).or_insert(records.len());
                records.push((id.to_owned(), record(element, line, &keys)?));
            }
            "edge" => {
                directed |= element.attribute("directed") == Some("true");
                let line = lines.of(element);
                ends.push((element, line));
            }
            _ => {}
        }
    }
    if records.is_empty() {
        return Err(Fault::file("the graph has no nodes", "expected <node> elements"));
    }
    let mut edges = Vec::with_capacity(ends.len());
    for (row, (element, line)) in ends.into_iter().enumerate() {
        let end = |side: &str| {
            let id = element.attribute(side);
            let id = id.ok_or_else(|| Fault::line(line, format!("edge {row} has no {side}"), "expected the id of a node"))?;
            row_of.get(id).copied().ok_or_else(|| {
                Fault::line(line, format!("edge {row}: {side} \"{id}\" does not exist"), "expected the id of a node")
            })
        };
        edges.push(([end("source")?, end("target")?], record(element, line, &keys)?));
    }
    let mut network = Network::new();
    for node in nodes(&records, scale)? {
        network.add_node(node);
    }
    let mut notes = vessels(&mut network, &edges, scale)?;
    if directed {
        notes.push("the graph is directed: its edges are taken as undirected".to_owned());
    }
    Ok((network, notes))
}

fn children<'a, 'input>(parent: Element<'a, 'input>, name: &'static str) -> impl Iterator<Item = Element<'a, 'input>> {
    parent.children().filter(move |c| c.is_element() && c.tag_name().name() == name)
}

fn text_of(element: Element) -> String {
    element.children().filter_map(|c| if c.is_text() { c.text() } else { None }).collect()
}

fn keys<'a>(root: Element<'a, '_>) -> Result<BTreeMap<&'a str, Key<'a>>, Fault> {
    let mut keys = BTreeMap::new();
    for element in children(root, "key") {
        let line = || element.document().text_pos_at(element.range().start).row as usize;
        let id = element.attribute("id").ok_or_else(|| Fault::line(line(), "a <key> has no id", "expected an id"))?;
        let key = Key {
            name: element.attribute("attr.name"),
            default: children(element, "default").next().map(text_of),
            on: element.attribute("for").unwrap_or("all"),
        };
        if keys.insert(id, key).is_some() {
            return Err(Fault::line(line(), format!("key \"{id}\" is declared twice"), "expected every key once"));
        }
    }
    Ok(keys)
}

/// The data of a node or edge by attribute name, over the defaults of their keys.
fn record(element: Element, line: usize, keys: &BTreeMap<&str, Key>) -> Result<Record, Fault> {
    let mut record = Record { line, ..Record::default() };
    for key in keys.values().filter(|key| key.on == "all" || key.on == element.tag_name().name()) {
        if let (Some(name), Some(default)) = (key.name, &key.default) {
            record.values.insert(name.to_owned(), default.clone());
        }
    }
    for data in children(element, "data") {
        let place = || element.document().text_pos_at(data.range().start).row as usize;
        let id = data.attribute("key").unwrap_or_default();
        let key = keys
            .get(id)
            .ok_or_else(|| Fault::line(place(), format!("key \"{id}\" is not declared"), "expected the id of a <key> element"))?;
        if let Some(name) = key.name {
            record.values.insert(name.to_owned(), text_of(data));
        }
    }
    Ok(record)
}
