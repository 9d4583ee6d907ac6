//! Turns the polylines and named arrays of a VTK file into centerlines: cut lines joined, lines labelled.

mod data;
mod overlap;
mod tracts;

pub(crate) use data::{ArrayValues, LIMIT, NamedValues, PolyData};
use data::{PolyLine, PolyLines};

use crate::formats::{Centerlines, Fault, ReadOptions, ensure, parts_of};

/// Whether an array is read: it may hold radii, areas or labels, or tells how VMTK cut a line into pieces.
pub(crate) fn is_wanted(name: &str, options: &ReadOptions) -> bool {
    let of_lines = tracts::IDS.contains(&name) || NODES.contains(&name);
    data::is_of_radii(name, options) || NAMES.contains(&letters_only(name).as_str()) || of_lines
}

/// The arrays in which willis states the nodes of a line. A file with them has one point for each node, and points in one place that are two
/// are two nodes.
const NODES: [&str; 2] = ["node_a", "node_b"];

/// Whether the radii are called as `vmtkcenterlines` calls them, which traces every line from a source to a target.
fn is_of_vmtk(piece: &PolyData) -> bool {
    piece.point_data.iter().any(|array| array.name == "MaximumInscribedSphereRadius")
}

/// Refuses a file without lines, by what is accepted there; says which other cells are left out.
pub(crate) fn check_cells(lines: usize, verts: usize, faces: usize, accepted: &str) -> Result<Vec<String>, Fault> {
    match (lines, faces) {
        (0, 0) => Err(Fault::file("no lines", accepted)),
        (0, _) => Err(Fault::file(format!("a surface of {faces} polygons, not centerlines"), accepted)),
        _ => {
            let others = [(verts, "vertex cells"), (faces, "polygons")].into_iter().filter(|(n, _)| *n > 0);
            Ok(others.map(|(n, what)| format!("{n} {what} are ignored")).collect())
        }
    }
}

/// Makes centerlines of polylines: every point that a line uses, in order of first use; returns also notes for the user.
///
/// # Errors
///
/// Lines that contradict the points, a point on a line without finite coordinates, no array of radii.
pub(crate) fn centerlines(mut pieces: Vec<PolyData>, options: &ReadOptions) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut all = PolyLines { names: vec![String::new()], line_radii: vec![f64::NAN], ..PolyLines::default() };
    let (mut notes, mut cut) = (Vec::new(), Vec::new());
    let mut ids = Vec::new();
    for piece in &mut pieces {
        let cells = cells(piece)?;
        let (radii, are_of_lines, found) = data::radii(piece, &cells, options)?;
        notes.extend(found.into_iter().filter(|note| !notes.contains(note)).collect::<Vec<_>>());
        let first = all.at.len();
        all.at.extend(piece.points.iter().map(|p| options.scale.position(*p)));
        all.radii.extend(radii.into_iter().map(|r| options.scale.length(r)));
        ids.extend((0..piece.points.len()).map(|point| (piece.before[0] + point) as u64));
        let (mut labels, from) = (labels_of_lines(piece), all.each.len());
        if are_of_lines {
            labels.resize(cells.len(), String::new());
            all.line_radii.extend(data::radii_of_lines(piece, options)?.into_iter().map(|r| options.scale.length(r)));
        }
        for (line, cell) in cells.iter().enumerate() {
            let points: Vec<u32> = cell.iter().map(|p| (first + p) as u32).collect();
            let links = points.len().saturating_sub(1);
            let name = labels.get(line).map_or(0, |_| all.names.len() + line) as u32;
            all.each.push(PolyLine { points, names: vec![name; links] });
        }
        all.names.extend(labels);
        all.line_radii.resize(all.names.len(), f64::NAN);
        cut.extend(tracts::tracts_of_lines(piece, from));
    }
    if !cut.is_empty() {
        all.sources = tracts::source(&all, &cut);
    }
    let starts: Vec<u32> = all.each.iter().filter_map(|line| line.points.first().copied()).collect();
    let is_cut = !cut.is_empty();
    notes.extend(tracts::join(&mut all, cut));
    let states_nodes = pieces.iter().all(|piece| NODES.iter().all(|name| data::numbers(&piece.line_data, name).is_some()));
    let run_together = if states_nodes { None } else { overlap::merge(&mut all) };
    if run_together.is_some() && !is_cut && pieces.iter().all(is_of_vmtk) {
        all.sources = tracts::common_start(&all, starts);
    }
    notes.extend(run_together);
    Ok((build(&all, &ids, states_nodes), notes))
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
            let place = || format!("point {}", piece.before[0] + row);
            let wrong = || Fault::item(place(), format!("coordinates {x} {y} {z}"), "expected finite numbers");
            ensure([x, y, z].into_iter().all(f64::is_finite), wrong).map(|()| row)
        };
        out.push(cell.iter().map(check).collect::<Result<_, _>>()?);
    }
    Ok(out)
}

fn build(all: &PolyLines, ids: &[u64], states_nodes: bool) -> Centerlines {
    let mut out = Centerlines { states_nodes, ..Centerlines::default() };
    let mut row_of = std::collections::HashMap::<u32, u32>::new();
    let states_radii = all.line_radii.iter().any(|radius| !radius.is_nan());
    for line in &all.each {
        let mut before = None;
        for (n, point) in line.points.iter().enumerate() {
            let p = *point as usize;
            let row = *row_of.entry(*point).or_insert_with(|| out.add_point(all.at[p], all.radii[p], ids[p], 0));
            if let Some(before) = before.replace(row).filter(|before| *before != row) {
                let name = line.names[n - 1] as usize;
                out.add_link([before, row], all.names[name].trim());
                out.link_radii.extend(states_radii.then_some(all.line_radii[name]));
            }
        }
    }
    // Lines that share points are one tree, as it is in SWC.
    out.strand = parts_of(out.points.len(), &out.links);
    let merged = all.merged.iter().filter_map(|[gone, stays]| Some((ids[*gone as usize], *row_of.get(stays)?)));
    out.merged = merged.filter(|(id, row)| out.ids[*row as usize] != *id).collect();
    out.sources = all.sources.iter().map(|point| ids[*point as usize]).collect();
    out
}

// VMTK's `GroupIds`, SimVascular's `BranchId` and `BifurcationId` and BraVa's `Vessel Ids` number the pieces of a tree. They say
// how the pieces are connected, which the lines say already, and not which vessel each is: they are no labels.

/// The usual names of such arrays, letters only, the first one first.
const NAMES: [&str; 8] =
    ["label", "labels", "vesselname", "vessellabel", "segmentname", "anatomicallabel", "anatomicalname", "name"];
/// What CoW_Centerline_Extraction means by its numbers (`extract_cow_variant_from_graph.py`).
const CIRCLE: [&str; 16] = [
    "", "BA", "R-PCA", "L-PCA", "R-ICA", "R-MCA", "L-ICA", "L-MCA", "R-Pcom", "L-Pcom", "Acom", "R-ACA", "L-ACA", "", "",
    "3rd-A2",
];
/// Arrays that show a file to be of that program.
const CIRCLE_RADII: [&str; 2] = ["ce_radius", "mis_radius"];

fn letters_only(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The labels of the lines; none without an array of them. Whole numbers become text, 0 none.
fn labels_of_lines(piece: &PolyData) -> Vec<String> {
    let has = |name: &str| piece.line_data.iter().chain(&piece.point_data).any(|array| array.name == name);
    let circle = CIRCLE_RADII.iter().any(|name| has(name));
    let labels = NAMES.iter().find_map(|usual| {
        let mut arrays = piece.line_data.iter().filter(|array| letters_only(&array.name) == *usual);
        arrays.find_map(|array| texts(array, circle))
    });
    labels.unwrap_or_default()
}

fn texts(array: &NamedValues, circle: bool) -> Option<Vec<String>> {
    let name = |number: &f64| {
        if number.is_nan() || *number == 0.0 {
            return String::new();
        }
        let number = *number as i64;
        let known = usize::try_from(number).ok().and_then(|number| CIRCLE.get(number)).filter(|_| circle);
        known.filter(|name| !name.is_empty()).map_or_else(|| number.to_string(), |name| (*name).to_owned())
    };
    match &array.values {
        ArrayValues::Texts(texts) => Some(texts.clone()),
        ArrayValues::Numbers(numbers) if numbers.iter().all(|x| x.is_nan() || x.fract() == 0.0) => {
            Some(numbers.iter().map(name).collect())
        }
        _ => None,
    }
}
