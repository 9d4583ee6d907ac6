//! Finds a node by its id, its label or a position, and vessels by their label or row.

use super::{Network, Node, metres, millimetres};
use crate::support::suggestions::{did_you_mean, nearest};
use crate::support::{Point, distance};

/// A position finds no node that is further away, m.
pub const REACH: f64 = 0.02;

/// A node found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Its row.
    pub node: usize,
    /// How it was found.
    pub by: FoundBy,
}

/// The node nearest to a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestNode {
    /// Its row.
    pub node: usize,
    /// How far from the position it is, m.
    pub distance: f64,
}

/// How a node was found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FoundBy {
    /// By its id or its label.
    Name,
    /// By the id of a point that was merged with it.
    Merged,
    /// By a position at this distance, m.
    Position(f64),
}

/// Finds the node whose `id` is `spec`, else with which a point of this id was merged, else whose label is `spec`,
/// else nearest to `x,y,z` in mm, within 20 mm.
///
/// # Errors
///
/// No node fits, or more than one: the text says so.
pub fn locate(network: &Network, spec: &str) -> Result<Located, String> {
    let rows = |is_called: &dyn Fn(&Node) -> bool| -> Vec<usize> {
        network.nodes().enumerate().filter(|(_, n)| is_called(n)).map(|(row, _)| row).collect()
    };
    let matches = [
        (rows(&|n| n.id == spec), FoundBy::Name),
        (rows(&|n| n.also.iter().any(|id| id == spec)), FoundBy::Merged),
        (rows(&|n| !n.label.is_empty() && n.label == spec), FoundBy::Name),
    ];
    for (rows, by) in matches {
        match rows[..] {
            [node] => return Ok(Located { node, by }),
            [] => {}
            _ => {
                let ids: Vec<&str> = rows.iter().map(|row| network.node(*row).id.as_str()).take(5).collect();
                return Err(format!("more than one node has this name ({}); give the id of one", ids.join(", ")));
            }
        }
    }
    let Some(position) = parse_position(spec) else { return Err(unknown(network, spec)) };
    let found = nearest_node(network, position, |_| true).ok_or("the nodes have no coordinates; give an id or a label")?;
    if found.distance > REACH {
        let [away, reach] = [found.distance, REACH].map(millimetres);
        let id = &network.node(found.node).id;
        return Err(format!("the nearest node, {id}, is {away:.1} mm away; expected a position within {reach} mm of one"));
    }
    Ok(Located { node: found.node, by: FoundBy::Position(found.distance) })
}

/// The node nearest to a position (m) among those in the rows that `admit` takes, however far away, ties to the lower row.
pub fn nearest_node(network: &Network, position: Point, admit: impl Fn(usize) -> bool) -> Option<NearestNode> {
    let nodes = network.nodes().enumerate().filter(|(row, _)| admit(*row));
    let away = nodes.filter_map(|(node, n)| Some(NearestNode { node, distance: distance(n.position?, position) }));
    away.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.node.cmp(&b.node)))
}

/// The message that no node was found: for a point inside a vessel its two ends, otherwise names that may have been meant.
fn unknown(network: &Network, spec: &str) -> String {
    let number = spec.parse::<u64>().ok();
    let vessel = number.and_then(|id| network.vessels().find(|(_, v)| v.path.iter().any(|point| point.id == Some(id))));
    if let Some((ends, _)) = vessel {
        let [a, b] = ends.map(|end| network.node(end).id.as_str());
        return format!("no node, but a point inside the vessel from {a} to {b}; expected one of its ends, {a} or {b}");
    }
    let names = network.nodes().flat_map(|n| [n.id.as_str(), n.label.as_str()]);
    // A similar number is not a misspelling.
    let meant = if spec.parse::<f64>().is_ok() { String::new() } else { did_you_mean(spec, names) };
    format!("no node has this id or label; {meant}expected an id, a label or x,y,z in mm (inner points of a vessel are no nodes)")
}

/// `x,y,z` in mm, as m.
pub fn parse_position(text: &str) -> Option<Point> {
    let numbers: Vec<f64> = text.split(',').map(|x| x.trim().parse().ok()).collect::<Option<_>>()?;
    let point: Point = numbers.try_into().ok()?;
    point.iter().all(|x| x.is_finite()).then(|| point.map(metres))
}

impl Located {
    /// How it was found, in words; empty if by its own id or label.
    pub fn note(&self) -> String {
        match self.by {
            FoundBy::Name => String::new(),
            FoundBy::Merged => " (merged with it)".into(),
            FoundBy::Position(m) => format!(" ({:.3} mm from the position given)", millimetres(m)),
        }
    }
}

/// How many names are offered for an unknown one.
const OFFERED: usize = 3;

/// The rows of the vessels called `name`: all with exactly this label; without such a label the vessel of
/// the row in `edge:12` or `12`, counted from 0.
///
/// # Errors
///
/// No vessel has this name; the text says what is accepted and offers the labels nearest by edit distance (insertions,
/// deletions, substitutions and swaps of neighbours, without regard to case).
pub fn vessels_called(network: &Network, name: &str) -> Result<Vec<usize>, String> {
    let name = name.trim();
    let labelled: Vec<usize> =
        network.vessels().enumerate().filter(|(_, (_, v))| !v.label.is_empty() && v.label == name).map(|(row, _)| row).collect();
    if !labelled.is_empty() {
        return Ok(labelled);
    }
    let digits = name.strip_prefix("edge:").unwrap_or(name);
    let last = network.vessel_count().saturating_sub(1);
    match digits.parse::<usize>() {
        Ok(row) if row < network.vessel_count() => Ok(vec![row]),
        Ok(row) => Err(format!("there is no edge {row}; expected a vessel's label, or edge:0 to edge:{last}")),
        Err(_) => Err(format!("no vessel is called \"{name}\"; expected {}", offer(network, name, last))),
    }
}

/// The labels nearest to `name`, or the rows if the network has no labels.
fn offer(network: &Network, name: &str, last: usize) -> String {
    let labels = nearest(name, network.vessels().map(|(_, v)| v.label.as_str()));
    if labels.is_empty() {
        return format!("edge:0 to edge:{last}, since the vessels have no labels");
    }
    let nearest: Vec<String> = labels.iter().take(OFFERED).map(|label| format!("\"{label}\"")).collect();
    format!("a label such as {}, or edge:0 to edge:{last}", nearest.join(", "))
}
