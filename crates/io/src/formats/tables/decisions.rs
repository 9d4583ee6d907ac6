//! What a person decided on connections, as the page of a run writes it: a list that the next run takes as certain.

use crate::formats::tables::reader::TableReader;
use willis_core::error::Fault;

/// A decision in a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ListedDecision {
    /// Its line, counted from 1.
    pub line: usize,
    /// The row of the vessel in edges.csv.
    pub edge: usize,
    /// The ids of its two nodes.
    pub ids: [String; 2],
    /// Whether the connection is there; none where the reader was unsure.
    pub accepted: Option<bool>,
    /// Who decided; empty where the list does not say.
    pub who: String,
    /// When; empty where the list does not say.
    pub when: String,
    /// What was said of it; empty where the list does not say.
    pub comment: String,
    /// The SHA-256 of the input of the run that was looked at; empty where the list does not say.
    pub input: String,
}

/// Reads the columns `edge,id_a,id_b,decision` (`accept`, `reject` or `unsure`), and where they are there `who`, `when`, `comment` and `input_sha256`.
///
/// # Errors
///
/// A missing column, an `edge` that is no row, a decision that is none of the words, a connection that comes twice.
pub fn read_decisions(bytes: &[u8]) -> Result<Vec<ListedDecision>, Fault> {
    const WHAT: &str = "edge,id_a,id_b,decision";
    let mut rows = TableReader::open(bytes)?;
    let [edge, a, b, decision] = ["edge", "id_a", "id_b", "decision"].map(|name| rows.column(&[name], WHAT));
    let (edge, a, b, decision) = (edge?, a?, b?, decision?);
    let [who, when, comment, input] = ["who", "when", "comment", "input_sha256"].map(|name| rows.find(&[name]));
    let mut all: Vec<ListedDecision> = Vec::new();
    while let Some(row) = rows.row()? {
        let number = row.text(edge).parse().map_err(|_| {
            Fault::line(row.line, format!("edge \"{}\"", row.text(edge)), "expected the row of a vessel in edges.csv, from 0")
        })?;
        let accepted = match row.text(decision) {
            "accept" => Some(true),
            "reject" => Some(false),
            "unsure" => None,
            other => return Err(Fault::line(row.line, format!("decision \"{other}\""), "expected accept, reject or unsure")),
        };
        if let Some(first) = all.iter().find(|d| d.edge == number) {
            let found = format!("edge {number} comes again, after line {}", first.line);
            return Err(Fault::line(row.line, found, "expected one decision an edge"));
        }
        let text = |column: Option<usize>| column.map_or_else(String::new, |column| row.text(column).to_owned());
        all.push(ListedDecision {
            line: row.line,
            edge: number,
            ids: [a, b].map(|column| row.text(column).to_owned()),
            accepted,
            who: text(who),
            when: text(when),
            comment: text(comment),
            input: text(input),
        });
    }
    Ok(all)
}
