//! The true answer to an extraction, and the landmarks that a person would set on it.

use std::io::{self, Write};

use serde::{Serialize, Serializer};
use serde_json::json;

use willis_core::network::Network;
use willis_core::network::units::millimetres;
use willis_core::support::geometry::Point;
use willis_io::formats::MarkedPoint;

/// The labelled free ends of a complete network, except those of the vessels (rows) that are lost: label and true position, m, in node
/// order.
pub fn landmarks(network: &Network, lost: &[usize]) -> Vec<MarkedPoint> {
    let degree = network.degrees(|_| true);
    let mut found: Vec<(usize, &str, Point)> = Vec::new();
    for (row, (ends, vessel)) in network.vessels().enumerate() {
        let shown = !vessel.label.is_empty() && !lost.contains(&row);
        for node in ends.into_iter().filter(|node| shown && degree[*node] == 1) {
            found.extend(network.node(node).position.map(|position| (node, vessel.label.as_str(), position)));
        }
    }
    found.sort_by_key(|(node, ..)| *node);
    found.into_iter().map(|(_, label, position)| MarkedPoint::new(label, position)).collect()
}

/// Where a vessel was broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum BreakKind {
    /// Next to a junction: the first id is the point of the junction, the second the loose end of the vessel.
    Junction,
    /// Along the vessel: both ids are loose ends.
    Vessel,
}

/// A missing stretch that a correct connection closes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Break {
    /// The ids of the points at its two ends.
    pub ids: [u64; 2],
    /// Next to a junction or along the vessel.
    pub kind: BreakKind,
    /// The row of the vessel in the complete network.
    pub vessel: usize,
    /// Its label.
    pub label: String,
    /// The arc lengths from the first node of the vessel at which the stretch begins and ends, m.
    #[serde(flatten, serialize_with = "in_millimetres")]
    pub stretch: [f64; 2],
}

/// The true answer to an extraction.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Truth {
    /// The labels of the complete network's vessels by row.
    pub vessels: Vec<String>,
    /// The rows of the vessels that are missing completely.
    #[serde(rename = "lost_vessels")]
    pub lost: Vec<usize>,
    /// The ids of the points at the inlets.
    pub inlets: Vec<u64>,
    /// For each fragment (the strand of its points) whether it is spurious.
    #[serde(rename = "fragments", serialize_with = "numbered")]
    pub spurious: Vec<bool>,
    /// The missing stretches between two points of the extraction, in order of vessel and arc length.
    pub breaks: Vec<Break>,
    /// For each point the row of its vessel (at a junction the widest), `None` where it is spurious.
    pub points: Vec<Option<usize>>,
}

impl Break {
    /// The length of the missing stretch along the true vessel, m.
    pub fn length(&self) -> f64 {
        self.stretch[1] - self.stretch[0]
    }
}

fn in_millimetres<S: Serializer>(stretch: &[f64; 2], out: S) -> Result<S::Ok, S::Error> {
    let [from, to] = *stretch;
    out.collect_map([("from_mm", from), ("to_mm", to), ("gap_mm", to - from)].map(|(key, length)| (key, millimetres(length))))
}

fn numbered<S: Serializer>(spurious: &[bool], out: S) -> Result<S::Ok, S::Error> {
    out.collect_seq(spurious.iter().enumerate().map(|(fragment, spurious)| json!({ "fragment": fragment, "spurious": spurious })))
}

impl Truth {
    /// Writes the answer as one JSON object and a line end.
    ///
    /// | key | what |
    /// |---|---|
    /// | `vessels` | labels of the complete network's vessels; rows below count from 0 in this list |
    /// | `lost_vessels` | rows of vessels that are missing completely |
    /// | `inlets` | point ids of the inlets |
    /// | `fragments` | one `{fragment, spurious}` each; fragments count from 0 in the order of their first points |
    /// | `breaks` | one `{ids, kind, vessel, label, from_mm, to_mm, gap_mm}` each: the two point ids that a correct connection joins, `junction` or `vessel`, row and label of the vessel, arc length from its first node at which the stretch begins and ends, its length |
    /// | `points` | for each point, in order of id from 1, the row of its vessel, or `null` where it is spurious |
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write_json(&self, mut out: impl Write) -> io::Result<()> {
        serde_json::to_writer(&mut out, self)?;
        writeln!(out)?;
        out.flush()
    }
}
