//! Polylines with named arrays, as VTK's XML and legacy files hold them, and how they become centerlines.

mod labels;
mod overlap;
pub(crate) mod radius;
mod tracts;
mod tree;

use std::collections::HashMap;

use crate::error::Fault;
use crate::network::centerlines::Centerlines;
use crate::network::units::Scale;
use crate::support::geometry::Point;
use radius::RadiusArray;

/// More points, cells or indices than any centerline has: a file that announces them is broken.
pub(crate) const LIMIT: usize = 1 << 26;

/// A named array with one value for each point, or for each line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Array {
    /// Its name without the blanks around it.
    pub(crate) name: String,
    /// Its values.
    pub(crate) values: Values,
}

/// The values of an array.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Values {
    /// Numbers, one for each point or line.
    Numbers(Vec<f64>),
    /// Texts, one for each point or line.
    Texts(Vec<String>),
    /// Left out by the reader: nothing here asks for it.
    Unread,
}

/// Polylines and what the file says about their points and about themselves.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PolyData {
    /// How many points and lines of the file come before these.
    pub(crate) before: [usize; 2],
    /// Positions in the file's unit.
    pub(crate) points: Vec<[f64; 3]>,
    /// Per line where it ends in `cells`.
    pub(crate) ends: Vec<i64>,
    /// The points of the lines, one line after the other.
    pub(crate) cells: Vec<i64>,
    /// One value for each point.
    pub(crate) point_data: Vec<Array>,
    /// One value for each line.
    pub(crate) line_data: Vec<Array>,
}

/// Whether an array is read: it may hold radii, areas or names, or says how VMTK cut a line up.
pub(crate) fn is_wanted(name: &str, choice: RadiusArray<'_>) -> bool {
    radius::is_wanted(name, choice) || labels::is_wanted(name) || tracts::is_wanted(name)
}

/// A line of the file, or what is left of it.
#[derive(Debug, Clone, PartialEq)]
struct Line {
    /// The rows of its points.
    points: Vec<u32>,
    /// Per link the row of its name; 0 for none.
    names: Vec<u32>,
    /// Its number in the file.
    strand: u32,
}

/// All pieces together, points counted through, in m.
#[derive(Debug, Default)]
struct Lines {
    at: Vec<Point>,
    radii: Vec<f64>,
    /// The names of links; the first one is empty.
    names: Vec<String>,
    each: Vec<Line>,
    /// Points that are no more, each with the one that stands for it.
    merged: Vec<[u32; 2]>,
}

/// Makes centerlines of polylines: every point that a line uses, in order of first use; returns also what a person should know.
///
/// # Errors
///
/// Lines that contradict the points, a point on a line without finite coordinates, no array of radii.
pub(crate) fn centerlines(
    pieces: &[PolyData],
    scale: &Scale,
    choice: RadiusArray<'_>,
) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut all = Lines { names: vec![String::new()], ..Lines::default() };
    let (mut notes, mut cut) = (Vec::new(), Vec::new());
    let mut ids = Vec::new();
    for piece in pieces {
        let cells = cells(piece)?;
        let (radii, found) = radius::radii(piece, &cells, choice)?;
        notes.extend(found.into_iter().filter(|note| !notes.contains(note)).collect::<Vec<_>>());
        let first = all.at.len();
        all.at.extend(piece.points.iter().map(|p| scale.position(*p)));
        all.radii.extend(radii.into_iter().map(|r| scale.length(r)));
        ids.extend((0..piece.points.len()).map(|point| (piece.before[0] + point) as u64));
        let names = labels::of_lines(piece, &mut all.names);
        let from = all.each.len();
        for (line, cell) in cells.iter().enumerate() {
            let points: Vec<u32> = cell.iter().map(|p| (first + p) as u32).collect();
            let links = points.len().saturating_sub(1);
            let strand = (piece.before[1] + line) as u32;
            all.each.push(Line { points, names: vec![names.get(line).copied().unwrap_or_default(); links], strand });
        }
        cut.extend(tracts::of_lines(piece, from));
    }
    notes.extend(tracts::join(&mut all, cut));
    notes.extend(overlap::merge(&mut all));
    Ok((build(&all, &ids), notes))
}

/// The points of each line, checked.
fn cells(piece: &PolyData) -> Result<Vec<Vec<usize>>, Fault> {
    let count = piece.points.len();
    let mut start = 0;
    let mut out = Vec::with_capacity(piece.ends.len());
    for (line, end) in piece.ends.iter().enumerate() {
        let name = || format!("line {}", piece.before[1] + line);
        let cell = usize::try_from(*end).ok().and_then(|end| piece.cells.get(start..end));
        let cell = cell.ok_or_else(|| Fault::item(name(), format!("offset {end} after {start}"), "expected rising offsets"))?;
        start += cell.len();
        let check = |point: &i64| {
            let row = usize::try_from(*point).ok().filter(|p| *p < count).ok_or_else(|| {
                Fault::item(name(), format!("point {point}"), format!("expected a point from 0 to {}", count.saturating_sub(1)))
            })?;
            let [x, y, z] = piece.points[row];
            if ![x, y, z].into_iter().all(f64::is_finite) {
                let (point, found) = (piece.before[0] + row, format!("coordinates {x} {y} {z}"));
                return Err(Fault::item(format!("point {point}"), found, "expected finite numbers"));
            }
            Ok(row)
        };
        out.push(cell.iter().map(check).collect::<Result<_, _>>()?);
    }
    Ok(out)
}

fn build(all: &Lines, ids: &[u64]) -> Centerlines {
    let mut out = Centerlines::default();
    let mut row_of: HashMap<u32, u32> = HashMap::new();
    for line in &all.each {
        let mut before = None;
        for (n, point) in line.points.iter().enumerate() {
            let p = *point as usize;
            let row = *row_of.entry(*point).or_insert_with(|| out.add_point(all.at[p], all.radii[p], ids[p], line.strand));
            if let Some(before) = before.replace(row).filter(|before| *before != row) {
                out.add_link([before, row], &all.names[line.names[n - 1] as usize]);
            }
        }
    }
    let merged = all.merged.iter().filter_map(|[gone, stays]| Some((ids[*gone as usize], *row_of.get(stays)?)));
    out.merged = merged.filter(|(id, row)| out.ids[*row as usize] != *id).collect();
    out
}
