//! Writes a network as the tubes of an ITK scene.

use std::collections::VecDeque;
use std::io::{self, Write};

use crate::io::polylines::polylines;
use crate::io::swc::labels::clean;
use crate::io::tables::column::real;
use crate::network::centerlines::is_radius;
use crate::network::units::millimetres;
use crate::network::{Network, PathPoint, Role};

const PLACE: &str = "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nCenterOfRotation = 0 0 0\nElementSpacing = 1 1 1";

/// Where a tube hangs: the row of its parent, and whether it hangs on the parent's last point.
#[derive(Clone, Copy)]
struct Link {
    parent: usize,
    at_last: bool,
}

/// Writes every vessel as a tube, in the order of the vessels and with ids from 1; millimetres.
///
/// The tubes of a connected part hang together by `ParentID` and `ParentPoint` from its inlets, else from its first node, breadth
/// first, each with its first point at its parent; what closes a loop touches its other node by its coordinates alone. The label
/// is the name of the tube, without line breaks. A vessel without a path is straight, a missing radius 0.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_tre(mut out: impl Write, network: &Network) -> io::Result<()> {
    let mut tubes = polylines(network)?;
    let links = hang(network, &mut tubes);
    writeln!(out, "ObjectType = Scene\nNDims = 3\nNObjects = {}", tubes.len() + 1)?;
    writeln!(out, "ObjectType = Group\nNDims = 3\nID = 0\nBinaryData = False\n{PLACE}\nEndGroup = ")?;
    for (row, tube) in tubes.iter().enumerate() {
        writeln!(out, "ObjectType = Tube\nNDims = 3")?;
        let name = clean(&network.vessel(row).label);
        if !name.is_empty() {
            writeln!(out, "Name = {name}")?;
        }
        writeln!(out, "ID = {}", row + 1)?;
        if let Some(link) = links[row] {
            writeln!(out, "ParentID = {}", link.parent + 1)?;
        }
        writeln!(out, "BinaryData = False\n{PLACE}")?;
        if let Some(link) = links[row] {
            writeln!(out, "ParentPoint = {}", if link.at_last { tubes[link.parent].len() - 1 } else { 0 })?;
        }
        let root = if links[row].is_none() { "True" } else { "False" };
        writeln!(out, "Root = {root}\nArtery = True\nPointDim = x y z r\nNPoints = {}\nPoints = ", tube.len())?;
        for point in tube {
            let [x, y, z] = point.position.map(|x| real(millimetres(x)));
            let radius = if is_radius(point.radius) { real(millimetres(point.radius)) } else { "0".into() };
            writeln!(out, "{x} {y} {z} {radius}")?;
        }
    }
    out.flush()
}

/// Turns every tube so that it begins at its parent, and says where each hangs; roots hang nowhere.
fn hang(network: &Network, tubes: &mut [Vec<PathPoint>]) -> Vec<Option<Link>> {
    let mut around = vec![Vec::new(); network.node_count()];
    for (row, (ends, _)) in network.vessels().enumerate() {
        around[ends[0]].push(row);
        if ends[1] != ends[0] {
            around[ends[1]].push(row);
        }
    }
    let mut links = vec![None; tubes.len()];
    let mut done = vec![false; tubes.len()];
    let mut reached = vec![false; network.node_count()];
    let inlets = (0..network.node_count()).filter(|n| network.node(*n).role == Some(Role::Inlet));
    for root in inlets.chain(0..network.node_count()) {
        if std::mem::replace(&mut reached[root], true) {
            continue;
        }
        let mut open = VecDeque::from([(root, None)]);
        while let Some((node, mut from)) = open.pop_front() {
            for row in &around[node] {
                if std::mem::replace(&mut done[*row], true) {
                    continue;
                }
                let [a, b] = network.ends(*row);
                if a != node {
                    tubes[*row].reverse();
                }
                links[*row] = from;
                from.get_or_insert(Link { parent: *row, at_last: false });
                let next = a + b - node;
                if !std::mem::replace(&mut reached[next], true) {
                    open.push_back((next, Some(Link { parent: *row, at_last: true })));
                }
            }
        }
    }
    links
}
