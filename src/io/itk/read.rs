//! Reads the tubes of a scene as linked points.

use std::collections::{HashMap, HashSet};

use super::points::Nearest;
use super::scene::{Object, read_scene};
use super::transform::{parents, to_scene};
use crate::error::Fault;
use crate::network::centerlines::{Centerlines, is_radius};
use crate::network::units::{LengthUnit, Scale};

/// Reads the tubes of an ITK scene; returns also what a person should know.
///
/// Points and radii are multiplied by `ElementSpacing` (the radius by its first number, as in ITK), then moved by `TransformMatrix`
/// and `Offset` of the tube and of its parents. A tube whose `ParentID` is a tube is linked with its first point to the parent's
/// point number `ParentPoint`, counted from 0, as TubeTK's ConvertTubesToTubeTree writes it; without that number, its nearer end to
/// the parent's nearest point. The label of a link is the `Name` of its tube, its strand the number of the tube. Points keep their
/// ids where these are whole and all different; otherwise they are numbered from 0.
///
/// # Errors
///
/// A scene that is cut off or miscounts its objects or points, values that are no numbers, a coordinate that is not finite, a
/// parent point that does not exist, a tube that is its own ancestor, tubes without a column for the radius unless
/// `radius_optional`, no tube.
pub fn read_tre(bytes: &[u8], scale: &Scale, radius_optional: bool) -> Result<(Centerlines, Vec<String>), Fault> {
    let objects = read_scene(bytes)?;
    let mut notes = Vec::new();
    let mut row_of = HashMap::new();
    let mut twice = 0;
    for (row, object) in objects.iter().enumerate() {
        if let Some(id) = object.index("ID")? {
            twice += usize::from(*row_of.entry(id).or_insert(row) != row);
        }
    }
    if twice > 0 {
        notes.push(format!("objects with the ID of one before them, to which its children belong: {twice}"));
    }
    let parents = parents(&objects, &row_of)?;
    let to_scene = to_scene(&objects, &parents)?;
    let mut lines = Centerlines::default();
    let mut ids = Vec::new();
    let mut span = vec![0..0; objects.len()];
    for (row, object) in objects.iter().enumerate().filter(|(_, object)| object.is_tube()) {
        if !radius_optional && !object.points.is_empty() && object.points.iter().all(|p| p.radius.is_nan()) {
            let (line, _) = object.field("PointDim").unwrap_or((object.line, ""));
            let found = format!("{} has no radius", object.name());
            return Err(Fault::line(line, found, "expected a column r in PointDim, or give --default-radius"));
        }
        let spacing = spacing(object)?;
        let scale = unit(object, scale)?;
        let stretch = to_scene[row].map_or(1.0, |transform| transform.stretch());
        let label = object.field("Name").map_or("", |(_, name)| name);
        let first = lines.points.len();
        for sample in &object.points {
            let own = [0, 1, 2].map(|axis| sample.position[axis] * spacing[axis]);
            let position = scale.position(to_scene[row].map_or(own, |transform| transform.apply(own)));
            if position.iter().any(|x| !x.is_finite()) {
                return Err(Fault::line(
                    object.line,
                    format!("{}: a point beyond all numbers", object.name()),
                    "expected finite ones",
                ));
            }
            let radius = scale.length(sample.radius * spacing[0] * stretch);
            let at = lines.add_point(position, if is_radius(radius) { radius } else { f64::NAN }, 0, row as u32);
            ids.push(sample.id);
            if at as usize > first {
                lines.add_link([at - 1, at], label);
            }
        }
        span[row] = first..lines.points.len();
    }
    if lines.points.is_empty() {
        return Err(Fault::file("no points in any tube", "expected objects of type Tube with points"));
    }
    number(&mut lines, &ids);
    let (mut lost, mut nearest) = (0, Nearest::default());
    for (row, object) in objects.iter().enumerate().filter(|(row, _)| !span[*row].is_empty()) {
        let Some(id) = object.index("ParentID")? else { continue };
        let Some(parent) = row_of.get(&id).copied() else {
            lost += 1;
            continue;
        };
        if !objects[parent].is_tube() || span[parent].is_empty() {
            continue;
        }
        let ends = match object.index("ParentPoint")? {
            Some(at) if at < span[parent].len() as u64 => [span[parent].start + at as usize, span[row].start],
            Some(at) => {
                let (line, _) = object.field("ParentPoint").unwrap_or((object.line, ""));
                let accepted = format!("expected 0 to {}: tube {id} has {} points", span[parent].len() - 1, span[parent].len());
                return Err(Fault::line(line, format!("ParentPoint {at}"), accepted));
            }
            None => nearest.pair(&lines.points, span[parent].clone(), [span[row].start, span[row].end - 1]),
        };
        lines.add_link(ends.map(|p| p as u32), object.field("Name").map_or("", |(_, name)| name));
    }
    if lost > 0 {
        notes.push(format!("tubes whose parent is not there, read as roots: {lost}"));
    }
    let others = objects.iter().filter(|o| !o.is_tube() && o.kind != "Group" && o.kind != "AffineTransform").count();
    if others > 0 {
        notes.push(format!("objects that are no tubes, left out: {others}"));
    }
    Ok((lines, notes))
}

/// The spacing by which a tube's numbers are multiplied.
fn spacing(object: &Object) -> Result<[f64; 3], Fault> {
    let flat = object.field("NDims").is_some_and(|(_, n)| n == "2");
    let mut spacing = [1.0; 3];
    for (axis, x) in object.numbers("ElementSpacing", if flat { 2 } else { 3 })?.into_iter().flatten().enumerate() {
        if x <= 0.0 {
            let (line, value) = object.field("ElementSpacing").unwrap_or((object.line, ""));
            return Err(Fault::line(line, format!("ElementSpacing \"{value}\""), "expected positive numbers"));
        }
        spacing[axis] = x;
    }
    Ok(spacing)
}

/// The unit that a tube states, unless a person said another one than mm.
fn unit(object: &Object, scale: &Scale) -> Result<Scale, Fault> {
    let unit = match object.field("DistanceUnits") {
        None | Some((_, "mm" | "?" | "")) => return Ok(*scale),
        Some((_, "um")) => LengthUnit::Micrometre,
        Some((_, "cm")) => LengthUnit::Centimetre,
        Some((line, other)) => return Err(Fault::line(line, format!("DistanceUnits {other}"), "expected um, mm or cm")),
    };
    Ok(if scale.unit == LengthUnit::Millimetre { Scale { unit, ..*scale } } else { *scale })
}

/// Gives points their own ids where these are whole and all different, else numbers from 0.
fn number(lines: &mut Centerlines, ids: &[f64]) {
    let mut seen = HashSet::with_capacity(ids.len());
    let own = ids.iter().all(|id| *id >= 0.0 && id.fract() == 0.0 && *id < 9e15 && seen.insert(*id as u64));
    for (row, id) in lines.ids.iter_mut().enumerate() {
        *id = if own { ids[row] as u64 } else { row as u64 };
    }
}
