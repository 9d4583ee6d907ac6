//! Small tables that a person writes beside an input on its connections: correct ones, links that close loops, priors A (a matrix over pairs of nodes, or a
//! table of vessels), and what was decided on each as the page of a run writes it, a list that the next run takes as certain.

use std::collections::{HashMap, HashSet};
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use super::reader::{Row, TableReader, columns, uncommented};
use crate::formats::{ensure, numpy::array::read_npy_matrix};
use willis_core::network::{Edit, Network};
use willis_core::{error::Fault, support::geometry::Point};

/// A candidate that a person lists as correct.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownConnection {
    /// Its line, counted from 1.
    pub line: usize,
    /// The positions of its two ends, m.
    pub ends: [Point; 2],
}

/// Reads the correct candidates, as a person lists them or leaves them in a corrected edges.csv: the columns
/// `ax_mm,ay_mm,az_mm,bx_mm,by_mm,bz_mm`. With a column `kept` only the rows with 1 count, with a
/// column `origin` only the candidates.
///
/// # Errors
///
/// A missing column, a value that is wrong, a table without a correct candidate.
pub fn read_links(bytes: &[u8]) -> Result<Vec<KnownConnection>, Fault> {
    let mut rows = TableReader::open(bytes)?;
    let [a, b] = crate::formats::END_POSITION_COLUMNS;
    let of_end = |[x, y, z]: [&str; 3]| rows.columns([&[x], &[y], &[z]], "the ends of every correct candidate");
    let columns = [of_end(a)?, of_end(b)?];
    let (kept, origin) = (rows.find(&["kept"]), rows.find(&["origin"]));
    let mut out = Vec::new();
    while let Some(row) = rows.row()? {
        match kept.map(|column| row.text(column)) {
            None | Some("1") => {}
            Some("0") => continue,
            Some(other) => return Err(Fault::line(row.line, format!("kept \"{other}\""), "expected 1 or 0")),
        }
        match origin.map(|column| row.text(column)) {
            None | Some("candidate") => {}
            Some("observed" | "contact") => continue,
            Some(other) => {
                return Err(Fault::line(row.line, format!("origin \"{other}\""), "expected observed, candidate or contact"));
            }
        }
        let ends = [row.position(columns[0])?, row.position(columns[1])?].map(|p| p.map(willis_core::network::metres));
        out.push(KnownConnection { line: row.line, ends });
    }
    let which = if kept.is_some() { "at least one candidate with kept 1" } else { "at least one row" };
    ensure(!out.is_empty(), || Fault::file("no correct candidate", format!("expected {which}")))?;
    Ok(out)
}

const ACCEPTED: &str = "expected two point ids (id_a,id_b)";

/// Links the pairs of point ids that SWC cannot hold, since they close loops: a table headed `id_a,id_b` or `a,b`, or without a
/// header. A link has the label of the vessel that ends at its first point, or else at its second. Returns how many links were not there
/// before.
///
/// # Errors
///
/// A row that is not a pair of ids of different points.
pub fn add_loops(bytes: &[u8], lines: &mut willis_core::network::Centerlines) -> Result<usize, Fault> {
    let row_of: HashMap<u64, u32> = lines.ids.iter().enumerate().map(|(row, id)| (*id, row as u32)).collect();
    let before = lines.links.len();
    let mut known: HashSet<[u32; 2]> = lines.links.iter().map(|[a, b]| [*a.min(b), *a.max(b)]).collect();
    let sides = lines.links.iter().enumerate().flat_map(|(link, ends)| ends.map(|point| (point as usize, link)));
    let links_at = willis_core::support::numbered::grouped(lines.points.len(), sides);
    let mut link = |line: usize, pair: [&str; 2]| {
        let row = |word: &str| {
            let word = word.split('#').next().unwrap_or_default().trim_end();
            let id = word.parse::<u64>().map_err(|_| Fault::line(line, format!("\"{word}\""), ACCEPTED))?;
            row_of.get(&id).copied().ok_or_else(|| Fault::line(line, format!("point {id} does not exist"), ACCEPTED))
        };
        let [a, b] = [row(pair[0])?, row(pair[1])?];
        ensure(a != b, || Fault::line(line, format!("point {} twice", pair[0]), "expected two different points"))?;
        if known.insert([a.min(b), a.max(b)]) {
            let of_end = |point: u32| if let [only] = links_at[point as usize][..] { Some(only) } else { None };
            let label = of_end(a).or_else(|| of_end(b)).map_or("", |link| lines.labels.of(link)).to_owned();
            lines.add_link([a, b], &label);
        }
        Ok(())
    };
    let text = uncommented(bytes);
    let mut rows = TableReader::open(&text)?;
    let [a, b] = if let [Some(a), Some(b)] = [rows.find(&["id_a", "a"]), rows.find(&["id_b", "b"])] {
        [a, b]
    } else {
        let [a, b] = rows.header.as_slice() else {
            return Err(Fault::line(rows.header_line, format!("\"{}\"", rows.header.join(",")), ACCEPTED));
        };
        link(rows.header_line, [a, b])?;
        [0, 1]
    };
    while let Some(row) = rows.row()? {
        link(row.line, [row.text(a), row.text(b)])?;
    }
    Ok(lines.links.len() - before)
}

/// Writes id pairs as the table that [`add_loops`] reads.
///
/// # Errors
///
/// The writer's own.
pub fn write_loops(mut out: impl Write, loops: &[[u64; 2]]) -> io::Result<()> {
    writeln!(out, "id_a,id_b")?;
    loops.iter().try_for_each(|[a, b]| writeln!(out, "{a},{b}"))?;
    out.flush()
}

/// Gives every vessel the prior that a symmetric N x N matrix of numbers from 0 to 1 has for its two nodes, in the order of
/// nodes.csv.
///
/// # Errors
///
/// Another shape, an entry out of its range, or two that contradict each other.
pub fn read_prior_npy(bytes: &[u8], network: &mut Network) -> Result<(), Fault> {
    let matrix = read_npy_matrix(bytes, network.node_count())?;
    for vessel in 0..network.vessel_count() {
        let [a, b] = network.ends(vessel);
        let (prior, other) = (matrix[[a, b]], matrix[[b, a]]);
        let fault = |found: String, accepted: &str| Fault::item(format!("A[{a}, {b}]"), found, accepted);
        ensure((0.0..=1.0).contains(&prior), || fault(prior.to_string(), "expected a number from 0 to 1"))?;
        let apart = || fault(format!("{prior}, and A[{b}, {a}] {other}"), "expected a symmetric matrix");
        ensure(prior == other, apart)?;
        network.vessel_mut(vessel).prior = prior;
    }
    Ok(())
}

/// Gives vessels the priors of a table with a column `prior` (0 to 1) and either `edge`, the row in edges.csv, or `node_a` and
/// `node_b`, rows in nodes.csv; edges.csv itself is such a table. Vessels that the table does not name, or with an empty prior,
/// keep theirs.
///
/// # Errors
///
/// A table without these columns, a vessel that is not there, a number out of its range, two numbers for one vessel.
pub fn read_prior_csv(bytes: &[u8], network: &mut Network) -> Result<(), Fault> {
    let mut rows = TableReader::open(bytes)?;
    let prior = rows.column(&["prior"], "the prior of a vessel")?;
    let (edge, ends) = (rows.find(&["edge"]), [rows.find(&["node_a"]), rows.find(&["node_b"])]);
    let accepted = "expected a column edge, or columns node_a,node_b";
    let says_which = edge.is_some() || !ends.contains(&None);
    ensure(says_which, || Fault::line(rows.header_line, columns(&rows.header), accepted))?;
    let mut between = HashMap::<[usize; 2], Vec<usize>>::new();
    for vessel in 0..network.vessel_count() {
        let [a, b] = network.ends(vessel);
        between.entry([a.min(b), a.max(b)]).or_default().push(vessel);
    }
    let mut line_of: HashMap<usize, usize> = HashMap::new();
    while let Some(row) = rows.row()? {
        let value = row.real(prior)?;
        if value.is_nan() {
            continue;
        }
        let wrong = || Fault::line(row.line, format!("prior {value}"), "expected a number from 0 to 1");
        ensure((0.0..=1.0).contains(&value), wrong)?;
        let named = match (edge, ends) {
            (Some(edge), _) => vec![below(&row, edge, network.vessel_count())?],
            (None, [Some(a), Some(b)]) => {
                let [a, b] = [below(&row, a, network.node_count())?, below(&row, b, network.node_count())?];
                let apart = || Fault::line(row.line, format!("{a} - {b}"), "expected two nodes that a vessel joins");
                between.get(&[a.min(b), a.max(b)]).cloned().ok_or_else(apart)?
            }
            _ => Vec::new(),
        };
        for vessel in named {
            if let Some(first) = line_of.insert(vessel, row.line).filter(|_| network.vessel(vessel).prior != value) {
                let found = format!("prior {value} of edge {vessel}, which is another one on line {first}");
                return Err(Fault::line(row.line, found, "expected one a vessel; a column edge tells parallel ones apart"));
            }
            network.vessel_mut(vessel).prior = value;
        }
    }
    Ok(())
}

/// A whole number below a count.
fn below(row: &Row<'_>, column: usize, count: usize) -> Result<usize, Fault> {
    let text = row.text(column);
    text.parse::<usize>().ok().filter(|n| *n < count).ok_or_else(|| {
        Fault::line(row.line, format!("{} \"{text}\"", row.header[column]), format!("expected a row below {count}"))
    })
}

/// A decision on one connection.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ConnectionDecision {
    /// The row of the vessel in edges.csv.
    pub edge: usize,
    /// Whether the connection is there; none where the reader was unsure, which changes nothing.
    pub accepted: Option<bool>,
    /// Who decided; may be empty.
    #[serde(default)]
    pub who: String,
    /// When; may be empty.
    #[serde(default)]
    pub when: String,
    /// What was said of it; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub comment: String,
}

/// The words for what a reader says of a connection.
pub const ANSWERS: [(Option<bool>, &str); 3] = [(Some(true), "accept"), (Some(false), "reject"), (None, "unsure")];

/// A decision in a list.
#[derive(Debug, Clone, PartialEq)]
pub struct ListedDecision {
    /// What was decided.
    pub made: ConnectionDecision,
    /// Its line, counted from 1.
    pub line: usize,
    /// The ids of its two nodes.
    pub ids: [String; 2],
    /// The SHA-256 of the input of the run that was looked at; empty where the list does not say.
    pub input: String,
    /// The places of its two nodes, mm, where the list says them.
    pub places: Option<[[f64; 3]; 2]>,
}

/// An edit of the graph by a person.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct GraphEdit {
    /// What is changed.
    pub edit: Edit,
    /// Who decided; may be empty.
    #[serde(default)]
    pub who: String,
    /// When; may be empty.
    #[serde(default)]
    pub when: String,
    /// What was said of it; may be empty.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub comment: String,
    /// The line of the list that it is on, from 1; 0 where it is from a program.
    #[serde(skip)]
    pub line: usize,
}

/// What a list has.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ListedDecisions {
    /// The decisions on connections.
    pub connections: Vec<ListedDecision>,
    /// The edits, in their order.
    pub edits: Vec<GraphEdit>,
}

/// Reads the columns `edge,id_a,id_b,decision` (`accept`, `reject` or `unsure`; or an edit: `join`, `part` or `delete`, with its `places`
/// and without an edge), and where they are there `places`, `who`, `when`, `comment` and `input_sha256`. `places` of a connection are those
/// of its two nodes, `x y z + x y z` in mm.
///
/// # Errors
///
/// A missing column, an `edge` that is no row, a decision that is none of the words, places that are none, a connection that comes twice.
pub fn read_decisions(bytes: &[u8]) -> Result<ListedDecisions, Fault> {
    const WHAT: &str = "edge,id_a,id_b,decision";
    let mut rows = TableReader::open(bytes)?;
    let [of_edge, a, b, decision] = rows.columns([&["edge"], &["id_a"], &["id_b"], &["decision"]], WHAT)?;
    let [who, when, comment, input, stated] = ["who", "when", "comment", "input_sha256", "places"].map(|name| rows.find(&[name]));
    let mut all = ListedDecisions::default();
    let mut lines: HashMap<usize, usize> = HashMap::new();
    while let Some(row) = rows.row()? {
        let text = |column: Option<usize>| column.map_or_else(String::new, |column| row.written(column).to_owned());
        let (word, line, who, when, comment) = (row.text(decision), row.line, text(who), text(when), text(comment));
        let placed = text(stated);
        if Edit::WORDS.contains(&word) {
            let edit =
                Edit::parse(word, &placed).map_err(|expected| Fault::line(line, format!("{word} \"{placed}\""), expected))?;
            all.edits.push(GraphEdit { edit, who, when, comment, line });
            continue;
        }
        let edge = row.text(of_edge).parse().map_err(|_| {
            let found = format!("edge \"{}\"", row.text(of_edge));
            Fault::line(line, found, "expected the row of a vessel in edges.csv, from 0")
        })?;
        let accepted = "expected accept, reject, unsure, join, part or delete";
        let other = || Fault::line(line, format!("decision \"{word}\""), accepted);
        let (accepted, _) = ANSWERS.into_iter().find(|(_, answer)| *answer == word).ok_or_else(other)?;
        if let Some(first) = lines.insert(edge, line) {
            let found = format!("edge {edge} comes again, after line {first}");
            return Err(Fault::line(line, found, "expected one decision an edge"));
        }
        let places =
            if let Ok(Edit::Join(way)) = Edit::parse("join", &placed) { <[[f64; 3]; 2]>::try_from(way).ok() } else { None };
        let expected = "expected those of its two nodes, as in 1 2 3 + 4 5 6";
        let are_read = places.is_some() || placed.is_empty();
        ensure(are_read, || Fault::line(line, format!("places \"{placed}\""), expected))?;
        let (ids, input) = ([a, b].map(|column| row.text(column).to_owned()), text(input));
        let made = ConnectionDecision { edge, accepted, who, when, comment };
        all.connections.push(ListedDecision { made, line, ids, input, places });
    }
    Ok(all)
}
