//! The true connections as JSON: links between pieces as `gapbench` writes them, or the breaks of `willis phantom --break`.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::known_connections::{AttachmentSide, KnownConnections, TrueConnection};
use willis_core::error::Fault;
use willis_core::network::Network;
use willis_core::network::units::metres;
use willis_core::support::geometry::{Point, distance};
use willis_models::candidates::features::Extraction;

#[derive(Deserialize)]
struct TruthFile {
    subject: Option<String>,
    voxel_mm: Option<f64>,
    /// How far a point may be from the node that it shows, where that is not a voxel.
    reach_mm: Option<f64>,
    #[serde(default)]
    nodes: Vec<Vec<f64>>,
    links: Option<Vec<Vec<LinkMember>>>,
    breaks: Option<Vec<BreakPoints>>,
    /// Places where two vessels are fused; a candidate there is neither right nor wrong.
    #[serde(default)]
    fusions: Vec<Fusion>,
    #[serde(default)]
    /// Ids from `willis phantom`; others write more than that, which is in a file of its own too.
    inlets: Vec<serde_json::Value>,
}

#[derive(Deserialize)]
struct LinkMember {
    role: AttachmentSide,
    allowed: Vec<u64>,
}

#[derive(Deserialize)]
struct Fusion {
    place: [f64; 3],
    reach_mm: f64,
    #[serde(default)]
    judged: bool,
}

#[derive(Deserialize)]
struct BreakPoints {
    ids: [u64; 2],
}

/// The true connections of an extraction of a network, and the subject where it is named.
///
/// # Errors
///
/// No such JSON, a node that is not there, links that no point of the extraction reaches.
pub fn read(bytes: &[u8], network: &Network, extraction: &Extraction) -> Result<(KnownConnections, Option<String>), Fault> {
    const ACCEPTED: &str = "expected an object with links (and nodes, voxel_mm), or with breaks";
    let file: TruthFile = serde_json::from_slice(bytes).map_err(|e| Fault::line(e.line().max(1), e.to_string(), ACCEPTED))?;
    let reach = file.reach_mm.map_or(("voxel_mm", file.voxel_mm), |mm| ("reach_mm", Some(mm)));
    let mut truth = match (file.links, file.breaks) {
        (Some(links), None) => of_links(&links, &file.nodes, reach, extraction)?,
        (None, Some(breaks)) => of_breaks(&breaks, &file.inlets, network, extraction)?,
        (None, None) => return Err(Fault::file("neither links nor breaks", ACCEPTED)),
        (Some(_), Some(_)) => return Err(Fault::file("both links and breaks", ACCEPTED)),
    };
    let fusions = file.fusions.iter().filter(|fusion| fusion.judged);
    truth.unclear = fusions.map(|fusion| (fusion.place.map(metres), metres(fusion.reach_mm))).collect();
    Ok((truth, file.subject))
}

/// Groups of pieces that belong together, each with the nodes (numbered from 1) at which a candidate may attach.
fn of_links(
    links: &[Vec<LinkMember>],
    nodes: &[Vec<f64>],
    (name, reach_mm): (&str, Option<f64>),
    extraction: &Extraction,
) -> Result<KnownConnections, Fault> {
    let mut points = Vec::with_capacity(nodes.len());
    for (row, node) in nodes.iter().enumerate() {
        match node[..] {
            [x, y, z, ..] if [x, y, z].iter().all(|x| x.is_finite()) => points.push([x, y, z].map(metres)),
            _ => return Err(Fault::item(format!("node {}", row + 1), format!("{node:?}"), "expected [x, y, z, r] in mm")),
        }
    }
    let reach = match reach_mm {
        Some(h) if h > 0.0 && h.is_finite() => metres(h),
        Some(h) => return Err(Fault::item(name, h.to_string(), "expected a positive number")),
        None => extraction.spacing,
    };
    let mut out: Vec<TrueConnection> = Vec::new();
    for (row, members) in links.iter().enumerate() {
        let mut link = TrueConnection::new();
        for member in members {
            let mut rows = Vec::new();
            for id in &member.allowed {
                let there = usize::try_from(*id).ok().filter(|id| (1..=points.len()).contains(id));
                let accepted = || format!("expected nodes from 1 to {}", points.len());
                rows.push(there.ok_or_else(|| Fault::item(format!("link {row}"), format!("node {id}"), accepted()))? - 1);
            }
            link.push((member.role, rows));
        }
        out.push(link);
    }
    let truth = KnownConnections::snapped(extraction, &points, reach, &out);
    match truth.unreachable() {
        Some((link, piece)) => {
            let nodes: Vec<String> = links[link][piece].allowed.iter().take(3).map(u64::to_string).collect();
            let found = format!("no point of the fragments is at its nodes {}", nodes.join(", "));
            Err(Fault::item(format!("link {link}"), found, "expected the answer to these fragments"))
        }
        None => Ok(truth),
    }
}

/// Missing stretches between two points by their ids.
fn of_breaks(
    gaps: &[BreakPoints],
    inlets: &[serde_json::Value],
    network: &Network,
    extraction: &Extraction,
) -> Result<KnownConnections, Fault> {
    // Where each id is: a node, or a point of a vessel, which stands for the nearest that the model sees there.
    let nodes_by_id = network.nodes().enumerate().filter_map(|(row, node)| Some((node.id.parse().ok()?, row)));
    let nodes_by_id: BTreeMap<u64, usize> = nodes_by_id.collect();
    let mut along: BTreeMap<u64, (usize, Point)> = BTreeMap::new();
    for (row, (_, vessel)) in network.vessels().enumerate() {
        along.extend(vessel.path.iter().filter_map(|at| Some((at.id?, (row, at.position)))));
    }
    let point_of = |id: u64| {
        nodes_by_id.get(&id).copied().or_else(|| {
            let (row, position) = along.get(&id)?;
            let away = extraction.lines[*row].iter().map(|point| (distance(extraction.position[*point], *position), *point));
            away.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, point)| point)
        })
    };
    let find = |place: String, id: u64| {
        let accepted = "expected the id of a point of the fragments";
        point_of(id).ok_or_else(|| Fault::item(place, format!("point {id}"), accepted))
    };
    let mut pairs = Vec::new();
    for (row, gap) in gaps.iter().enumerate() {
        let [a, b] = gap.ids.map(|id| find(format!("break {row}"), id));
        pairs.push([a?, b?]);
    }
    let mut nodes = Vec::new();
    for id in inlets.iter().filter_map(serde_json::Value::as_u64) {
        let point = find("inlets".into(), id)?;
        nodes.extend(Some(point).filter(|point| *point < network.node_count()));
    }
    Ok(KnownConnections::between(extraction, &pairs, &nodes))
}
