//! Centerlines written point by point as SWC, ids as they are, with the links that a tree cannot hold beside it.

use std::io::{self, Write};

use super::swc_labels::TypeCodes;
use crate::centerline::{Centerlines, is_radius};
use crate::units::millimetres;

/// Writes centerlines as SWC in mm and returns the id pairs of the links that would close a loop.
///
/// A point's parent is the first point of the first link that ends in it; the type stands for the label of that link; a missing
/// radius is 0.
///
/// # Errors
///
/// The writer's own.
pub fn write_centerlines_swc(mut out: impl Write, lines: &Centerlines) -> io::Result<Vec<[u64; 2]>> {
    let mut parent = vec![None; lines.points.len()];
    let mut loops = Vec::new();
    let mut trees = petgraph::unionfind::UnionFind::<usize>::new(lines.points.len());
    for (row, [a, b]) in lines.links.iter().map(|link| link.map(|p| p as usize)).enumerate() {
        if parent[b].is_none() && trees.union(a, b) {
            parent[b] = Some((a, row));
        } else {
            loops.push([lines.ids[a], lines.ids[b]]);
        }
    }
    writeln!(out, "# centerlines; coordinates and radii in mm")?;
    let types = TypeCodes::of((0..lines.links.len()).map(|row| lines.labels.of(row)));
    types.write(&mut out)?;
    writeln!(out, "# id type x y z radius parent")?;
    for (point, parent) in parent.iter().enumerate() {
        let [x, y, z] = lines.points[point].map(millimetres);
        let radius = Some(lines.radii[point]).filter(|r| is_radius(*r)).map_or(0.0, millimetres);
        match parent {
            Some((parent, row)) => {
                let (kind, parent) = (types.code(lines.labels.of(*row)), lines.ids[*parent]);
                writeln!(out, "{} {kind} {x} {y} {z} {radius} {parent}", lines.ids[point])?;
            }
            None => writeln!(out, "{} 0 {x} {y} {z} {radius} -1", lines.ids[point])?,
        }
    }
    out.flush()?;
    Ok(loops)
}
