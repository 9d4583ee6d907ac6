//! What a person decided on connections, as the page of a run writes it: a list that the next run takes as certain.

use std::collections::HashMap;

use serde::{Deserialize, Serialize};

use willis_core::{error::Fault, network::Edit};

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
    let mut rows = super::reader::TableReader::open(bytes)?;
    let [of_edge, a, b, decision] = rows.columns([&["edge"], &["id_a"], &["id_b"], &["decision"]], WHAT)?;
    let [who, when, comment, input, stated] = ["who", "when", "comment", "input_sha256", "places"].map(|name| rows.find(&[name]));
    let mut all = ListedDecisions::default();
    let mut lines: HashMap<usize, usize> = HashMap::new();
    while let Some(row) = rows.row()? {
        let text = |column: Option<usize>| column.map_or_else(String::new, |column| row.text(column).to_owned());
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
        let accepted = match word {
            "accept" => Some(true),
            "reject" => Some(false),
            "unsure" => None,
            other => {
                let found = format!("decision \"{other}\"");
                return Err(Fault::line(line, found, "expected accept, reject, unsure, join, part or delete"));
            }
        };
        if let Some(first) = lines.insert(edge, line) {
            let found = format!("edge {edge} comes again, after line {first}");
            return Err(Fault::line(line, found, "expected one decision an edge"));
        }
        let places =
            if let Ok(Edit::Join(way)) = Edit::parse("join", &placed) { <[[f64; 3]; 2]>::try_from(way).ok() } else { None };
        if places.is_none() && !placed.is_empty() {
            let expected = "expected those of its two nodes, as in 1 2 3 + 4 5 6";
            return Err(Fault::line(line, format!("places \"{placed}\""), expected));
        }
        let (ids, input) = ([a, b].map(|column| row.text(column).to_owned()), text(input));
        let made = ConnectionDecision { edge, accepted, who, when, comment };
        all.connections.push(ListedDecision { made, line, ids, input, places });
    }
    Ok(all)
}
