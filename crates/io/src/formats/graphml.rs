//! GraphML: reads a graph through its keys as one stream, writes one for NetworkX, igraph and Gephi.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::io::{self, BufRead, Write};

use crate::formats::attributes::{Records, directions_as_one, has_lengths_without_unit, is_wanted, nodes, unit_note, vessels};
use crate::formats::xml::{Events, Tag, XmlStep};
use crate::formats::{Column, Fault, Frame, Network, ReadOptions, Values, check_rows, counted, ensure, escape};

/// The attribute of a graph that states the frame of its positions.
pub(super) const FRAME: &str = "frame";

/// What has been read of a file.
#[derive(Default)]
struct Graph {
    keys: Keys,
    ids: Vec<String>,
    /// The number of each id that was met, of a node or at the end of an edge; by number the row of its node, once that has come.
    numbers: HashMap<String, usize>,
    row_of: Vec<Option<usize>>,
    nodes: Records,
    /// The numbers of the ids at the ends of each edge.
    ends: Vec<[usize; 2]>,
    edges: Records,
    directed: bool,
    frame: Frame,
    /// The text of an element, kept for the next one.
    text: String,
}

/// Reads a graph as a stream, nodes and edges in the order of the file; returns also notes for the user.
///
/// # Errors
///
/// XML that is not well-formed or declares entities, more or fewer than one graph, a nested graph, hyperedge or port, a key
/// that is not declared, a node id that comes twice, an edge to a node that does not exist, an attribute that is wrong.
pub fn read_graphml(input: impl BufRead, options: &ReadOptions) -> Result<(Network, Vec<String>), Fault> {
    let mut events = Events::new(input);
    let mut graph = Graph::default();
    let mut graphs = 0;
    while let Some(step) = events.next()? {
        if step != XmlStep::Start || events.depth == 1 {
            continue;
        }
        graphs += usize::from(events.tag.name() == "graph");
        match events.tag.name() {
            "key" => graph.keys.declare(&mut events)?,
            "graph" if graphs == 1 => graph.read(&mut events)?,
            _ => events.skip(|_| Ok(()))?,
        }
    }
    drop(events);
    ensure(graphs == 1, || Fault::file(format!("{graphs} graphs"), "expected one <graph> in <graphml>"))?;
    graph.network(options)
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
        self.directed = events.tag.attribute("edgedefault")?.as_deref() == Some("directed");
        let depth = events.depth;
        while events.next_child(depth)? {
            let tag = &events.tag;
            simple(tag)?;
            match tag.name() {
                "node" => {
                    let missing = || Fault::line(tag.line, format!("node {} has no id", self.ids.len()), "expected an id");
                    let id = tag.attribute("id")?.ok_or_else(missing)?.into_owned();
                    let number = self.number(&id);
                    self.row_of[number].get_or_insert(self.ids.len());
                    self.ids.push(id);
                    item(&mut self.nodes, &mut self.keys, events, &mut self.text)?;
                }
                "edge" => {
                    self.directed |= tag.attribute("directed")?.as_deref() == Some("true");
                    let row = self.ends.len();
                    let mut end = |side: &str| {
                        let missing = || Fault::line(tag.line, format!("edge {row} has no {side}"), "expected the id of a node");
                        Ok(self.number(&tag.attribute(side)?.ok_or_else(missing)?))
                    };
                    let ends = [end("source")?, end("target")?];
                    self.ends.push(ends);
                    item(&mut self.edges, &mut self.keys, events, &mut self.text)?;
                }
                "data" if self.keys.is_frame(&tag.attribute("key")?.unwrap_or_default()) => {
                    events.text(simple, &mut self.text)?;
                    self.frame = Frame::of_word(&self.text);
                }
                _ => events.skip(simple)?,
            }
        }
        Ok(())
    }

    fn network(mut self, options: &ReadOptions) -> Result<(Network, Vec<String>), Fault> {
        ensure(!self.ids.is_empty(), || Fault::file("the graph has no nodes", "expected <node> elements"))?;
        self.keys.name(&mut self.nodes, "node")?;
        self.keys.name(&mut self.edges, "edge")?;
        if let Some(ids) = self.own_ids() {
            self.ids = ids;
        }
        let unit = unit_note(&options.scale, [&self.nodes, &self.edges].into_iter().any(has_lengths_without_unit));
        let mut network = Network::of(self.frame, nodes(&self.ids, &self.nodes, &options.scale)?, Vec::new());
        let ends = self.rows()?;
        (self.nodes, self.ids) = Default::default();
        (self.numbers, self.row_of) = Default::default();
        let mut notes = vessels(&mut network, &ends, &self.edges, options)?;
        notes.extend(unit);
        if self.directed {
            let stays = directions_as_one(&self.ends, &network);
            let of_two = stays.iter().filter(|stays| !**stays).count();
            network = network.subgraph(|row| stays[row]).0;
            let both = counted(of_two, "edge", "in both directions, as one vessel");
            notes.push(format!(
                "the graph is directed: its edges are taken as undirected{}",
                both.map_or(String::new(), |both| format!(", {both}"))
            ));
        }
        Ok((network, notes))
    }

    /// The attribute `id` of the nodes, where igraph has put it in the place of their ids, which it numbers n0, n1, …
    fn own_ids(&self) -> Option<Vec<String>> {
        let numbered = self.ids.iter().enumerate().all(|(row, id)| id.strip_prefix('n') == Some(&row.to_string()));
        let ids: Vec<String> = self.nodes.iter().map_while(|node| node.word("id").map(str::to_owned)).collect();
        let mut seen = HashSet::new();
        (numbered && ids.len() == self.ids.len() && ids.iter().all(|id| seen.insert(id))).then_some(ids)
    }

    /// The number of an id.
    fn number(&mut self, id: &str) -> usize {
        if let Some(number) = self.numbers.get(id) {
            return *number;
        }
        self.numbers.insert(id.to_owned(), self.row_of.len());
        self.row_of.push(None);
        self.row_of.len() - 1
    }

    /// The rows of the nodes at the ends of each edge, which programs that hold undirected graphs write in either order: by `node_a` and the
    /// `node` of both in that of willis, which its points and evidence have too.
    fn rows(&self) -> Result<Vec<[usize; 2]>, Fault> {
        let node = |edge: usize, side: &str, number: usize| {
            self.row_of[number].ok_or_else(|| {
                let id = self.numbers.iter().find(|(_, known)| **known == number).map_or("", |(id, _)| id);
                let found = format!("edge {edge}: {side} \"{id}\" does not exist");
                Fault::line(self.edges.get(edge).line, found, "expected the id of a node")
            })
        };
        let ends = self.ends.iter().enumerate();
        let rows = ends.map(|(edge, [a, b])| {
            let ends = [node(edge, "source", *a)?, node(edge, "target", *b)?];
            let first = self.edges.get(edge).text("node_a");
            let [a, b] = ends.map(|row| first.is_some() && self.nodes.get(row).text("node") == first);
            Ok(if b && !a { [ends[1], ends[0]] } else { ends })
        });
        rows.collect()
    }
}

/// Reads the data of a node or edge, which has begun, up to its end; `text` is for the texts.
fn item(records: &mut Records, keys: &mut Keys, events: &mut Events<impl BufRead>, text: &mut String) -> Result<(), Fault> {
    records.begin(events.tag.line);
    let depth = events.depth;
    while events.next_child(depth)? {
        let tag = &events.tag;
        if tag.name() != "data" {
            simple(tag)?;
            events.skip(simple)?;
            continue;
        }
        let key = keys.number(&tag.attribute("key")?.unwrap_or_default(), tag.line);
        if keys.is_wanted(key) {
            let line = tag.line;
            events.text(simple, text)?;
            // Attributes that are numbers are checked where they are read.
            if keys.keys[key].is_real_label && text.trim().parse().is_ok_and(f64::is_infinite) {
                return Err(Fault::line(line, format!("label {}", text.trim()), "expected a finite number, as its key says"));
            }
            records.put(key, text);
        } else {
            events.skip(simple)?;
        }
    }
    Ok(())
}

/// All attributes by their ids, in the order in which they were met.
#[derive(Default)]
struct Keys {
    number_of: BTreeMap<String, usize>,
    keys: Vec<Key>,
}

/// An attribute: its name (none for what only an editor needs), its default for nodes and for edges.
struct Key {
    name: Option<String>,
    default: Option<String>,
    on: String,
    /// Whether it holds labels that are real numbers.
    is_real_label: bool,
    declared: bool,
    /// The line on which it was met.
    line: usize,
}

impl Keys {
    /// Reads a `<key>`, which has begun, up to its end.
    fn declare(&mut self, events: &mut Events<impl BufRead>) -> Result<(), Fault> {
        let (tag, line) = (&events.tag, events.tag.line);
        let id = tag.attribute("id")?.ok_or_else(|| Fault::line(line, "a <key> has no id", "expected an id"))?;
        let number = self.number(&id, line);
        let wrong = || Fault::line(line, format!("key \"{id}\" is declared twice"), "expected every key once");
        ensure(!self.keys[number].declared, wrong)?;
        let on = tag.attribute("for")?.map_or_else(|| "all".to_owned(), Into::into);
        let name = tag.attribute("attr.name")?.map(Into::into);
        let is_real = tag.attribute("attr.type")?.is_some_and(|kind| kind == "double" || kind == "float");
        let is_real_label = is_real && name.as_deref() == Some("label");
        let mut default = None;
        let depth = events.depth;
        while events.next_child(depth)? {
            if events.tag.name() == "default" && default.is_none() {
                events.text(|_| Ok(()), default.insert(String::new()))?;
            } else {
                events.skip(|_| Ok(()))?;
            }
        }
        self.keys[number] = Key { name, default, on, is_real_label, declared: true, line };
        Ok(())
    }

    /// Whether what a key names is read; that is known once it is declared.
    fn is_wanted(&self, number: usize) -> bool {
        let key = &self.keys[number];
        !key.declared || key.name.as_deref().is_some_and(is_wanted)
    }

    /// The number of a key, which may be declared later.
    fn number(&mut self, id: &str, line: usize) -> usize {
        if let Some(number) = self.number_of.get(id) {
            return *number;
        }
        self.number_of.insert(id.to_owned(), self.keys.len());
        self.keys.push(Key { name: None, default: None, on: String::new(), is_real_label: false, declared: false, line });
        self.keys.len() - 1
    }

    /// Whether a key is that of the graph's frame.
    fn is_frame(&self, id: &str) -> bool {
        let key = self.number_of.get(id).map(|number| &self.keys[*number]);
        key.is_some_and(|key| key.name.as_deref() == Some(FRAME) && (key.on == "graph" || key.on == "all"))
    }

    /// Gives the records of all nodes (`on` "node") or edges ("edge") the names and defaults.
    fn name(&self, records: &mut Records, on: &str) -> Result<(), Fault> {
        let undeclared = |(_, number): &(&String, &usize)| !self.keys[**number].declared;
        if let Some((id, number)) = self.number_of.iter().filter(undeclared).min_by_key(|(_, number)| **number) {
            let found = format!("key \"{id}\" is not declared");
            return Err(Fault::line(self.keys[*number].line, found, "expected the id of a <key> element"));
        }
        let mut defaults = HashMap::new();
        for key in self.number_of.values().map(|number| &self.keys[*number]).filter(|key| key.on == "all" || key.on == on) {
            if let (Some(name), Some(default)) = (&key.name, &key.default) {
                defaults.insert(name.clone(), default.clone());
            }
        }
        (records.names, records.defaults) = (self.keys.iter().map(|key| key.name.clone()).collect(), defaults);
        Ok(())
    }
}

/// Writes the nodes with their ids, the vessels in their order, and the columns as attributes.
///
/// NaN and empty text are left out, and so is a column `id`, which is the node's own. A vessel with a path has it as
/// the attribute `points`: `x y z r;x y z r` in mm. The graph has its frame as the attribute `frame`, where it is known.
///
/// # Errors
///
/// A column without one value for each row (`InvalidInput`), or the writer's own.
pub fn write_graphml(mut out: impl Write, network: &Network, of_nodes: &[Column], of_vessels: &[Column]) -> io::Result<()> {
    check_rows(of_nodes, network.node_count())?;
    check_rows(of_vessels, network.vessel_count())?;
    let with_points = network.vessels().any(|(_, v)| !v.path.is_empty()) && of_vessels.iter().all(|c| c.name != "points");
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(out, r#"<graphml xmlns="http://graphml.graphdrawing.org/xmlns">"#)?;
    keys(&mut out, "node", of_nodes)?;
    keys(&mut out, "edge", of_vessels)?;
    if with_points {
        writeln!(out, r#"  <key id="points" for="edge" attr.name="points" attr.type="string"/>"#)?;
    }
    if network.frame.is_known() {
        writeln!(out, r#"  <key id="frame" for="graph" attr.name="{FRAME}" attr.type="string"/>"#)?;
    }
    writeln!(out, r#"  <graph edgedefault="undirected">"#)?;
    if let Some(name) = network.frame.name() {
        writeln!(out, r#"    <data key="frame">{name}</data>"#)?;
    }
    for (row, node) in network.nodes().enumerate() {
        writeln!(out, r#"    <node id="{}">"#, escape(&node.id))?;
        data(&mut out, "node", of_nodes, row)?;
        writeln!(out, "    </node>")?;
    }
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let [a, b] = ends.map(|end| escape(&network.node(end).id));
        writeln!(out, r#"    <edge source="{a}" target="{b}">"#)?;
        data(&mut out, "edge", of_vessels, row)?;
        if with_points && !vessel.path.is_empty() {
            writeln!(out, r#"      <data key="points">{}</data>"#, super::tables::graph::points(&vessel.path))?;
        }
        writeln!(out, "    </edge>")?;
    }
    writeln!(out, "  </graph>\n</graphml>")?;
    out.flush()
}

/// The columns that are written as attributes, by their numbers.
fn written(columns: &[Column]) -> impl Iterator<Item = (usize, &Column)> {
    columns.iter().enumerate().filter(|(_, column)| column.name != "id")
}

fn keys(out: &mut impl Write, on: &str, columns: &[Column]) -> io::Result<()> {
    for (n, column) in written(columns) {
        let kind = match column.values {
            Values::Real(_) => "double",
            Values::Integer(_) => "long",
            Values::Text(_) => "string",
        };
        writeln!(out, r#"  <key id="{on}{n}" for="{on}" attr.name="{}" attr.type="{kind}"/>"#, escape(&column.name))?;
    }
    Ok(())
}

/// The attributes of one node or edge.
fn data(out: &mut impl Write, on: &str, columns: &[Column], row: usize) -> io::Result<()> {
    for (n, column) in written(columns) {
        let text = column.values.text(row);
        if !text.is_empty() {
            writeln!(out, r#"      <data key="{on}{n}">{}</data>"#, escape(&text))?;
        }
    }
    Ok(())
}
