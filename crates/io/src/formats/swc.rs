//! SWC: one centerline point a line, each linked to its parent; the type column holds the labels.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet, hash_map::Entry};
use std::io::{self, BufRead, Write};

use crate::formats::polylines::{between, node_points, parents_first, steps_from_inlets};
use crate::formats::{
    Centerlines, Fault, Frame, Network, PathPoint, Scale, figures, is_missing, is_radius, lerp, millimetres, plural,
};

const COLUMNS: [&str; 7] = ["id", "type", "x", "y", "z", "radius", "parent"];
const ROW: &str = "expected 7 (id type x y z radius parent)";

/// Reads SWC in any order of ids, with any number of roots; returns also notes for the user.
///
/// The columns are separated by blanks or tabs; a zero, negative or infinite radius stands for a missing one and is kept as NaN,
/// to be repaired along its vessel. A parent of 0 where no point has the id 0 is none, as Vaa3D writes it. The strand of a point is the number of its tree. The label of a link is the type of its child
/// point: the name that a line `# label TYPE NAME` gives it, else the number itself unless it is 0. Without such lines types are
/// no labels where all are the same, or where only the first and last points of trees have one. A comment `SPACE=RAS` or `SPACE=LPS`
/// states the frame, and another that points in one place are apart unless they are linked, as [`write_swc`] writes it. `SCALE` and `OFFSET` of
/// comments are not applied.
///
/// # Errors
///
/// A line with fewer than seven columns, a value that is no number, a coordinate that is not finite, an id that comes
/// twice, a parent that does not exist or that descends from its child; a file without points.
pub fn read_swc(input: impl BufRead, scale: &Scale) -> Result<(Centerlines, Vec<String>), Fault> {
    let mut lines = Centerlines::default();
    let mut parents = Vec::new();
    let mut row_of = HashMap::new();
    let mut line_of = Vec::new();
    let mut wide = None;
    let (mut types, mut names, mut notes) = (Vec::new(), BTreeMap::new(), Vec::new());
    let mut at = 0;
    for chunk in input.split(b'\n') {
        let chunk = chunk.map_err(|e| Fault::line(at + 1, format!("cannot be read: {e}"), "expected text"))?;
        let chunk = chunk.strip_suffix(b"\r").unwrap_or(&chunk);
        // Old programs end lines by a carriage return alone.
        for line in chunk.split(|byte| *byte == b'\r') {
            at += 1;
            let line = String::from_utf8_lossy(line);
            let line = line.trim_start_matches('\u{feff}');
            let text = line.split('#').next().unwrap_or_default();
            let words: Vec<&str> = text.split_whitespace().collect();
            if words.is_empty() {
                let frame = Frame::of_header(line);
                lines.states_nodes |= line.trim() == APART;
                if let Some((code, name)) = type_name(line) {
                    names.insert(code, name);
                } else if frame.is_known() {
                    lines.frame = frame;
                } else if is_unapplied(line) {
                    notes.push(format!(
                        "line {at}: {} is not applied; `units` and `spacing` scale lengths",
                        line.trim_matches(['#', ' '])
                    ));
                }
                continue;
            }
            let [id, kind, x, y, z, radius, parent, ..] = words[..] else {
                return Err(Fault::line(at, plural(words.len(), "column"), ROW));
            };
            if words.len() > COLUMNS.len() {
                wide.get_or_insert((at, words.len()));
            }
            let id = index(id, at, 0)?
                .ok_or_else(|| Fault::line(at, format!("id {id} is negative"), "expected a whole number from 0 on"))?;
            let kind = code(number(kind, at, 1)?);
            let position = [number(x, at, 2)?, number(y, at, 3)?, number(z, at, 4)?];
            if let Some(axis) = (0..3).find(|axis| !f64::is_finite(position[*axis])) {
                return Err(Fault::line(at, format!("{} {}", COLUMNS[axis + 2], position[axis]), "expected a finite number"));
            }
            match row_of.entry(id) {
                Entry::Vacant(slot) => slot.insert(lines.points.len() as u32),
                Entry::Occupied(slot) => {
                    let first = line_of[*slot.get() as usize];
                    return Err(Fault::line(at, format!("id {id} is that of line {first} too"), "expected every id once"));
                }
            };
            let radius = if is_missing(radius) { f64::NAN } else { scale.length(number(radius, at, 5)?) };
            types.push(kind);
            lines.add_point(scale.position(position), if is_radius(radius) { radius } else { f64::NAN }, id, 0);
            parents.push(index(parent, at, 6)?);
            line_of.push(at);
        }
    }
    let wrong = || Fault::file("no points", "expected lines of 7 columns (id type x y z radius parent)");
    crate::formats::ensure(!lines.points.is_empty(), wrong)?;
    let mut up = Vec::with_capacity(parents.len());
    for (row, id) in parents.into_iter().enumerate() {
        let parent = id.and_then(|id| row_of.get(&id).copied());
        if let Some(id) = id.filter(|id| *id != 0 && parent.is_none()) {
            return Err(Fault::line(line_of[row], format!("parent {id} does not exist"), "expected the id of a point, or -1"));
        }
        lines.links.extend(parent.map(|parent| [parent, row as u32]));
        up.push(parent.map(|parent| parent as usize));
    }
    let order = parents_first(&up).map_err(|row| {
        let found = format!("point {} is its own ancestor", lines.ids[row]);
        Fault::line(line_of[row], found, "expected a tree; links that close loops go into the file of `loops`")
    })?;
    // The trees are numbered in the order of their first points.
    let mut trees = 0..;
    for row in order {
        lines.strand[row] = up[row].map_or_else(|| trees.next().unwrap_or_default(), |parent| lines.strand[parent]);
    }
    let mut roots = lines.ids.iter().zip(&up).filter(|(_, parent)| parent.is_none()).map(|(id, _)| *id);
    lines.root = roots.next().filter(|_| roots.next().is_none());
    name_links(&mut lines, &types, &names);
    notes.extend(
        wide.map(|(at, n)| format!("line {at} and perhaps others have {n} columns; those after the seventh are ignored")),
    );
    Ok((lines, notes))
}

fn number(word: &str, line: usize, column: usize) -> Result<f64, Fault> {
    word.parse().map_err(|_| Fault::line(line, format!("{} \"{word}\"", COLUMNS[column]), "expected a number"))
}

/// A whole number, perhaps written as `1.0`; `None` for a negative one.
fn index(word: &str, line: usize, column: usize) -> Result<Option<u64>, Fault> {
    if let Ok(id) = word.parse() {
        return Ok(Some(id));
    }
    match word.parse::<f64>() {
        Ok(x) if x.fract() == 0.0 && x.abs() < 9e15 => Ok((x >= 0.0).then_some(x as u64)),
        _ => Err(Fault::line(line, format!("{} \"{word}\"", COLUMNS[column]), "expected a whole number")),
    }
}

/// Writes a network as SWC: every vessel along its path, or straight where it has none; ids from 1; millimetres. Returns the id
/// pairs of the links that close loops, which SWC cannot hold: none for a forest.
///
/// The roots are the inlets, then the first node of every tree without one. A node without radius has that of
/// its widest vessel; one that has none of either is written with 0. The type of a point is the label of the vessel that leads
/// to it, as [`read_swc`] takes it. Where vessels have labels, a straight one that closes a loop has a point of its own, midway.
///
/// # Errors
///
/// A node without position (`InvalidInput`), or the writer's own.
pub fn write_swc(mut out: impl Write, network: &Network) -> io::Result<Vec<[u64; 2]>> {
    let at = node_points(network)?;
    let types = type_codes(network.vessels().map(|(_, vessel)| vessel.label.as_str()));
    let inner = network.vessels().flat_map(|(_, vessel)| vessel.path.iter().skip(1).take(vessel.path.len().saturating_sub(2)));
    let mut places = HashSet::new();
    let are_apart = at.iter().chain(inner).any(|point| !places.insert(point.position.map(|x| (x + 0.0).to_bits())));
    head(&mut out, network.frame, are_apart, &types)?;
    let mut used = 0_u64;
    let mut write = |point: &PathPoint, kind: u64, parent: Option<u64>| -> io::Result<u64> {
        used += 1;
        let parent = parent.map_or("-1".to_owned(), |parent| parent.to_string());
        writeln!(out, "{used} {kind} {} {parent}", figures(point, "0").join(" "))?;
        Ok(used)
    };
    let mut id_of = vec![0; network.node_count()];
    let mut loops = Vec::new();
    for (by, to, is_new) in steps_from_inlets(network, true) {
        let Some((row, from)) = by else {
            id_of[to] = write(&at[to], 0, None)?;
            continue;
        };
        let vessel = network.vessel(row);
        let (kind, mut parent) = (type_of(&vessel.label, &types), id_of[from]);
        let (begins, stops) = (at[from], at[to]);
        let mut inner = between(&vessel.path, begins.position, stops.position, network.ends(row)[0] == from);
        if inner.is_empty() && !is_new && !types.is_empty() {
            let (position, radius) = (lerp(begins.position, stops.position, 0.5), f64::midpoint(begins.radius, stops.radius));
            inner.push(PathPoint { position, radius, id: None });
        }
        for point in inner {
            parent = write(&point, kind, Some(parent))?;
        }
        if is_new {
            id_of[to] = write(&at[to], kind, Some(parent))?;
        } else {
            loops.push([parent, id_of[to]]);
        }
    }
    out.flush()?;
    Ok(loops)
}

/// Writes centerlines as SWC in mm and returns the id pairs of the links that would close a loop.
///
/// A point's parent is the first point of the first link that ends in it; the type means the label of that link; a missing
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
    let types = type_codes((0..lines.links.len()).map(|row| lines.labels.of(row)));
    head(&mut out, lines.frame, lines.states_nodes, &types)?;
    for (point, parent) in parent.iter().enumerate() {
        let [x, y, z] = lines.points[point].map(millimetres);
        let radius = Some(lines.radii[point]).filter(|r| is_radius(*r)).map_or(0.0, millimetres);
        let kind = parent.map_or(0, |(_, row)| type_of(lines.labels.of(row), &types));
        let parent = parent.map_or("-1".to_owned(), |(parent, _)| lines.ids[parent].to_string());
        writeln!(out, "{} {kind} {x} {y} {z} {radius} {parent}", lines.ids[point])?;
    }
    out.flush()?;
    Ok(loops)
}

/// The comment of a file in which points in one place are not one.
const APART: &str = "# points in one place are apart unless they are linked";

/// The comments at the top: the units, the frame where it is known, whether points in one place are apart, the label of each type in their order,
/// the columns.
fn head(mut out: impl Write, frame: Frame, are_apart: bool, types: &BTreeMap<String, u64>) -> io::Result<()> {
    let frame = frame.name().map_or(String::new(), |name| format!("; SPACE={name}"));
    writeln!(out, "# centerlines; coordinates and radii in mm{frame}")?;
    if are_apart {
        writeln!(out, "{APART}")?;
    }
    let by_code: BTreeMap<u64, &String> = types.iter().map(|(label, code)| (*code, label)).collect();
    by_code.iter().try_for_each(|(code, label)| writeln!(out, "# label {code} {label}"))?;
    writeln!(out, "# id type x y z radius parent")
}

/// The first code for a label that is no whole number; the specification and its users have meanings for those below.
const FIRST_FREE: u64 = 16;
/// Whole numbers above are not exact in every reader.
const LARGEST: f64 = 9e15;

/// The type and its label that a comment line `# label CODE NAME` gives it.
fn type_name(line: &str) -> Option<(u64, String)> {
    let words = line.trim().strip_prefix('#')?.trim_start().strip_prefix("label ")?;
    let (code, name) = words.trim().split_once(char::is_whitespace)?;
    Some((code.parse().ok()?, name.trim().to_owned()))
}

/// Whether a comment states another scale than 1, or another offset than 0, as those of CNIC and NeuroMorpho may.
fn is_unapplied(line: &str) -> bool {
    let mut words = line.trim_matches(['#', ' ']).split_whitespace();
    let usual = match words.next() {
        Some("SCALE") => 1.0,
        Some("OFFSET") => 0.0,
        _ => return false,
    };
    words.any(|word| word.parse::<f64>().is_ok_and(|x| x != usual))
}

/// The label code in a type column; 0 for none.
fn code(kind: f64) -> u64 {
    if kind.fract() == 0.0 && (1.0..LARGEST).contains(&kind) { kind as u64 } else { 0 }
}

/// Gives every link (parent, child) the label that the type of its child means.
fn name_links(lines: &mut Centerlines, types: &[u64], names: &BTreeMap<u64, String>) {
    if names.is_empty() && !are_labels(lines, types) {
        return;
    }
    for row in 0..lines.links.len() {
        let code = types[lines.links[row][1] as usize];
        if code != 0 {
            lines.labels.set(row, names.get(&code).unwrap_or(&code.to_string()));
        }
    }
}

/// Whether types that no comment names are labels: not if all are the same, nor if only the first and last points of
/// trees have one, which are then landmarks (iCafe).
fn are_labels(lines: &Centerlines, types: &[u64]) -> bool {
    let child = |link: &[u32; 2]| types[link[1] as usize];
    let Some(first) = lines.links.first().map(child) else { return false };
    if lines.links.iter().all(|link| child(link) == first) {
        return false;
    }
    let mut linked = vec![[false; 2]; types.len()];
    for [parent, child] in &lines.links {
        linked[*parent as usize][1] = true;
        linked[*child as usize][0] = true;
    }
    let mut inner = linked.iter().zip(types).filter(|(linked, _)| **linked == [true, true]).peekable();
    inner.peek().is_none() || inner.any(|(_, code)| *code != 0)
}

/// The type numbers that stand for labels in a file: whole numbers as they are, the others from 16 on in order of appearance.
fn type_codes<'a>(labels: impl Iterator<Item = &'a str>) -> BTreeMap<String, u64> {
    let mut codes: BTreeMap<String, u64> = BTreeMap::new();
    let mut words = Vec::new();
    for label in labels.map(single_line).filter(|label| !label.is_empty()) {
        let is_code = |whole: &u64| *whole > 0 && code(*whole as f64) == *whole && whole.to_string() == label;
        let whole = label.parse().ok().filter(is_code);
        if codes.insert(label.clone(), whole.unwrap_or(0)).is_none() && whole.is_none() {
            words.push(label);
        }
    }
    let taken: BTreeSet<u64> = codes.values().copied().collect();
    codes.extend(words.into_iter().zip((FIRST_FREE..).filter(|code| !taken.contains(code))));
    codes
}

/// The type for a label; 0 for none.
fn type_of(label: &str, codes: &BTreeMap<String, u64>) -> u64 {
    codes.get(&single_line(label)).copied().unwrap_or(0)
}

/// A label on one line, without blanks around it.
pub(crate) fn single_line(label: &str) -> String {
    label.replace(char::is_control, " ").trim().to_owned()
}
