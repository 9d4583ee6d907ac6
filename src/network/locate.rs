//! Finding a node by what a person calls it: its id, its label, or a position.

use super::Network;
use crate::geometry::{Point, distance};
use crate::suggestion::did_you_mean;
use crate::units::{metres, millimetres};

/// A node found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Located {
    /// Its row.
    pub node: usize,
    /// The distance (m) from the position asked for, when it was a position.
    pub distance: Option<f64>,
}

/// The node nearest to a position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Its row.
    pub node: usize,
    /// How far from the position it is, m.
    pub distance: f64,
}

/// Finds the node whose `id` is exactly `spec`, else whose label is exactly `spec`, else nearest to `x,y,z` in mm.
///
/// # Errors
///
/// No node or more than one answers to it: says so in words.
pub fn locate(network: &Network, spec: &str) -> Result<Located, String> {
    let rows = |hit: &dyn Fn(&super::Node) -> bool| -> Vec<usize> {
        network.nodes().enumerate().filter(|(_, n)| hit(n)).map(|(row, _)| row).collect()
    };
    let ids = rows(&|n| n.id == spec);
    let named = if ids.is_empty() { rows(&|n| !n.label.is_empty() && n.label == spec) } else { ids };
    match named[..] {
        [node] => return Ok(Located { node, distance: None }),
        [] => {}
        _ => {
            let ids: Vec<&str> = named.iter().map(|row| network.node(*row).id.as_str()).take(5).collect();
            return Err(format!("more than one node is called so ({}); give the id of one", ids.join(", ")));
        }
    }
    let Some(position) = parse_position(spec) else {
        let names = network.nodes().flat_map(|n| [n.id.as_str(), n.label.as_str()]);
        // A number near to another is not what was meant.
        let meant = if spec.parse::<f64>().is_ok() { String::new() } else { did_you_mean(spec, names) };
        return Err(format!(
            "no node has this id or label; {meant}expected an id, a label or x,y,z in mm (inner points of a vessel are no nodes)"
        ));
    };
    let found = nearest(network, position, |_| true).ok_or("the nodes have no coordinates; give an id or a label")?;
    Ok(Located { node: found.node, distance: Some(found.distance) })
}

/// The node nearest to a position (m) among those in the rows that `admit` takes, ties to the lower row.
pub fn nearest(network: &Network, position: Point, admit: impl Fn(usize) -> bool) -> Option<Nearest> {
    let nodes = network.nodes().enumerate().filter(|(row, _)| admit(*row));
    let away = nodes.filter_map(|(node, n)| Some(Nearest { node, distance: distance(n.position?, position) }));
    away.min_by(|a, b| a.distance.total_cmp(&b.distance).then(a.node.cmp(&b.node)))
}

/// `x,y,z` in mm, as m.
pub fn parse_position(text: &str) -> Option<Point> {
    let numbers: Vec<f64> = text.split(',').map(|x| x.trim().parse().ok()).collect::<Option<_>>()?;
    let point: Point = numbers.try_into().ok()?;
    point.iter().all(|x| x.is_finite()).then(|| point.map(metres))
}

impl Located {
    /// How far away it is, in words; empty when it was called by name.
    pub fn note(&self) -> String {
        self.distance.map_or(String::new(), |m| format!(" ({:.3} mm from the position given)", millimetres(m)))
    }
}
