//! The true answer to an extraction, and the landmarks that a person would set on it. And the true answer to a mask: the vessels that were
//! drawn, where the mask interrupts them, and where it joins what is apart.

use std::{io, io::Write};

use serde::{Serialize, Serializer, ser::SerializeMap};
use serde_json::json;

use super::tube::DrawnTube;
use willis_core::network::{Network, millimetres};
use willis_core::support::Point;
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

/// A place where the mask interrupts a vessel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MaskBreak {
    /// The ends of the vessel's two pieces, mm. Next to a junction the first or the last lies in the lumen of another vessel.
    pub ends_mm: [Point; 2],
    /// Next to a junction or along the vessel.
    pub kind: BreakKind,
    /// The row of the vessel.
    pub vessel: usize,
    /// Its label.
    pub label: String,
    /// The arc length from the first node of the vessel at which the missing stretch begins, mm.
    pub from_mm: f64,
    /// The arc length at which it ends, mm.
    pub to_mm: f64,
    /// Its length, mm.
    pub gap_mm: f64,
}

/// A place where two vessels that are apart touch in the mask.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contact {
    /// The rows of the two vessels.
    pub vessels: [usize; 2],
    /// Their labels.
    pub labels: [String; 2],
    /// The middle of the voxels that touch, mm.
    pub position_mm: Point,
}

/// The true answer to a mask.
#[derive(Debug, Clone, PartialEq)]
pub struct MaskTruth {
    /// The vessels by row: those of the network, then the veins.
    pub tubes: Vec<DrawnTube>,
    /// The ids of the nodes of the network.
    pub nodes: Vec<String>,
    /// The rows of the vessels of which the mask shows nothing outside the lumen of others.
    pub lost: Vec<usize>,
    /// Where the inlets are, mm.
    pub inlets: Vec<Point>,
    /// Where the mask interrupts a vessel, in order of vessel and arc length.
    pub breaks: Vec<MaskBreak>,
    /// Where vessels touch that are apart, in order of vessels.
    pub contacts: Vec<Contact>,
    /// The length of a voxel, mm.
    pub voxel: f64,
}

#[derive(Serialize)]
struct Centerline<'a> {
    vessel: usize,
    nodes: Option<[&'a str; 2]>,
    points_mm: Vec<Point>,
    radii_mm: Vec<f64>,
}

/// A length in whole micrometres.
fn micrometres(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

fn rounded(point: &Point) -> Point {
    point.map(micrometres)
}

impl MaskTruth {
    /// Writes the answer as one JSON object and a line end. Positions are in mm in the mask's frame, RAS.
    ///
    /// | key | what |
    /// |---|---|
    /// | `vessels` | labels of the vessels, then of the veins; rows below count from 0 in this list |
    /// | `lost_vessels` | rows of vessels of which the mask shows nothing outside the lumen of others |
    /// | `spurious_vessels` | rows of the veins |
    /// | `voxel_mm` | the length of a voxel |
    /// | `inlets_mm` | positions of the inlets |
    /// | `breaks` | one `{ends_mm, kind, vessel, label, from_mm, to_mm, gap_mm}` each: the two places that a correct connection joins, `junction` or `vessel`, row and label of the vessel, arc length from its first node at which the missing stretch begins and ends, its length |
    /// | `contacts` | one `{vessels, labels, position_mm}` each: two vessels that are apart and touch in the mask |
    /// | `centerlines` | one `{vessel, nodes, points_mm, radii_mm}` each: the ids of the two nodes (`null` for a vein), points at most two voxels apart |
    ///
    /// # Errors
    ///
    /// Those of `out`.
    pub fn write_json(&self, mut out: impl Write) -> io::Result<()> {
        let in_micrometres = |gap: &MaskBreak| MaskBreak {
            ends_mm: gap.ends_mm.each_ref().map(rounded),
            from_mm: micrometres(gap.from_mm),
            to_mm: micrometres(gap.to_mm),
            gap_mm: micrometres(gap.gap_mm),
            ..gap.clone()
        };
        let place_in_micrometres = |at: &Contact| Contact { position_mm: rounded(&at.position_mm), ..at.clone() };
        let centerline = |(vessel, tube)| self.centerline(vessel, tube);
        let mut json = serde_json::Serializer::new(&mut out);
        let mut object = json.serialize_map(None)?;
        object.serialize_entry("vessels", &self.tubes.iter().map(|tube| &tube.label).collect::<Vec<_>>())?;
        object.serialize_entry("lost_vessels", &self.lost)?;
        object.serialize_entry("spurious_vessels", &self.spurious().collect::<Vec<_>>())?;
        object.serialize_entry("voxel_mm", &self.voxel)?;
        object.serialize_entry("inlets_mm", &self.inlets.iter().map(rounded).collect::<Vec<_>>())?;
        object.serialize_entry("breaks", &self.breaks.iter().map(in_micrometres).collect::<Vec<_>>())?;
        object.serialize_entry("contacts", &self.contacts.iter().map(place_in_micrometres).collect::<Vec<_>>())?;
        object.serialize_entry("centerlines", &self.tubes.iter().enumerate().map(centerline).collect::<Vec<_>>())?;
        object.end()?;
        writeln!(out)?;
        out.flush()
    }

    /// The rows of the veins.
    pub fn spurious(&self) -> impl Iterator<Item = usize> {
        (0..self.tubes.len()).filter(|row| self.tubes[*row].nodes.is_none())
    }

    /// Every second station of a tube, and its last.
    fn centerline<'a>(&'a self, vessel: usize, tube: &DrawnTube) -> Centerline<'a> {
        let last = tube.stations.len() - 1;
        let chosen = || (0..last).step_by(2).chain([last]);
        Centerline {
            vessel,
            nodes: tube.nodes.map(|nodes| nodes.map(|node| self.nodes[node].as_str())),
            points_mm: chosen().map(|at| rounded(&tube.stations[at])).collect(),
            radii_mm: chosen().map(|at| micrometres(tube.radii[at])).collect(),
        }
    }
}
