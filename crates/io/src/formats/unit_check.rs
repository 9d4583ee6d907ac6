//! Checks whether the lengths of a file look like brain vessels in the unit that was given.

use super::Content;
use willis_core::network::{LengthUnit, Scale, is_radius, millimetres};
use willis_core::support::geometry::{Point, box_diagonal};
use willis_core::{error::Fault, support::statistics::median};

/// The range of median radii of brain vessels, mm: from capillaries to the internal carotid artery.
const MEDIAN_RADIUS_MM: std::ops::Range<f64> = 0.002..2.4;
/// The diagonal of the box around the vessels of a head and a neck is shorter, mm.
const MOST_EXTENT_MM: f64 = 300.0;
/// Median radii, and extents, that arteries of a brain have where their centimetres are taken as millimetres.
const RADIUS_OF_CM: std::ops::Range<f64> = 0.02..0.15;
const EXTENT_OF_CM: std::ops::Range<f64> = 3.0..30.0;
/// The largest coordinate that is accepted, m.
const MOST_METRES: f64 = 1e9;
/// The fraction of coordinates or radii that must be whole numbers for a warning.
const MOST: f64 = 0.95;
/// The fewest points for a warning.
const FEWEST: usize = 10;
/// How far from a whole number a voxel index or a squared distance of voxels may lie.
const ROUNDING: f64 = 1e-4;

/// Checks that positions are close enough for their distances to be finite.
pub(crate) fn check_extent(content: &Content) -> Result<(), Fault> {
    let check = |item: &dyn Fn() -> String, p: Point| match p.into_iter().find(|x| x.abs() > MOST_METRES) {
        None => Ok(()),
        Some(x) => {
            let found = format!("coordinate {:e} mm", millimetres(x));
            Err(Fault::item(item(), found, format!("expected one within {:e} mm", millimetres(MOST_METRES))))
        }
    };
    match content {
        Content::Centerlines(lines) => {
            lines.points.iter().zip(&lines.ids).try_for_each(|(p, id)| check(&|| format!("point {id}"), *p))
        }
        Content::Vessels(network) | Content::Graph(network) => network.nodes().try_for_each(|node| {
            let item = || format!("node {}", node.id);
            node.position.map_or(Ok(()), |p| check(&item, p))
        }),
    }
}

/// Warns the user, one line each, if the lengths look like another unit than the one given. A mask states the size of its voxels.
pub fn unit_check(content: &Content, scale: &Scale, is_mask: bool) -> Vec<String> {
    let (points, radii) = measures(content);
    let extent = millimetres(box_diagonal(points.iter().copied()));
    let found = median(&radii).map(millimetres);
    let fits = found.is_none_or(|radius| MEDIAN_RADIUS_MM.contains(&radius));
    let mut notes = Vec::new();
    if !is_mask && scale.unit != LengthUnit::Voxel && points.len() >= FEWEST {
        let file = |mm: f64, axis: usize| millimetres(mm) / scale.axes()[axis];
        let whole = |x: f64| (x - x.round()).abs() <= ROUNDING;
        let share = |n: usize, of: usize| n as f64 >= MOST * of as f64;
        let lattice = points.iter().filter(|p| (0..3).all(|axis| whole(2.0 * file(p[axis], axis)))).count();
        let is_square = |r: f64| r * r > 0.5 && whole(r * r);
        let squares = radii.iter().filter(|r| is_square(file(**r, 0))).count();
        let distinct = radii.iter().any(|r| *r != radii[0]);
        if share(lattice, points.len()) {
            notes.push(format!("the coordinates are whole or half numbers: {VOXELS}"));
        } else if radii.len() >= FEWEST && distinct && share(squares, radii.len()) {
            notes.push(format!("the radii are square roots of whole numbers, as a distance transform gives: {VOXELS}"));
        } else if extent > MOST_EXTENT_MM && fits {
            notes.push(format!("the extent is {extent:.0} mm, more than a head has: {VOXELS}"));
        }
    }
    // Radii and extent are some ten times too small for the arteries of a brain.
    let as_of_cm = |radius: &f64| RADIUS_OF_CM.contains(radius) && EXTENT_OF_CM.contains(&extent);
    if let Some(radius) = found.filter(|radius| !is_mask && scale.unit == LengthUnit::Millimetre && as_of_cm(radius)) {
        notes.push(format!(
            "the median radius is {radius:.3} mm and the extent {extent:.3} mm: if the lengths are cm, give `units=cm`"
        ));
    }
    let Some(found) = found.filter(|_| !fits) else { return notes };
    let per_unit = |unit: LengthUnit| Scale { unit, spacing: None }.axes()[0];
    let raw = found / scale.axes()[0];
    let others = [LengthUnit::Micrometre, LengthUnit::Millimetre, LengthUnit::Centimetre, LengthUnit::Metre];
    let fitting = others.into_iter().filter(|unit| *unit != scale.unit && MEDIAN_RADIUS_MM.contains(&(raw * per_unit(*unit))));
    let advice = if is_mask {
        "is the size of its voxels in mm?".to_owned()
    } else if scale.unit == LengthUnit::Voxel {
        "see `spacing`".to_owned()
    } else {
        let names: Vec<&str> = fitting.map(LengthUnit::symbol).chain(["voxels"]).collect();
        format!("perhaps they are {}: see `units` and `spacing`", names.join(" or "))
    };
    notes.push(format!(
        "the median radius is {found:.3} mm and the extent {extent:.3} mm, with lengths in {}, which no brain vessels have; {advice}",
        scale.unit.symbol()
    ));
    notes
}

const VOXELS: &str = "if lengths are in voxels, give `units=voxel` `spacing=S`";

/// Positions and radii, m: of the points, or of the nodes and vessels.
fn measures(content: &Content) -> (Vec<Point>, Vec<f64>) {
    match content {
        Content::Centerlines(lines) => (lines.points.clone(), lines.radii.iter().copied().filter(|r| is_radius(*r)).collect()),
        Content::Vessels(network) | Content::Graph(network) => (
            network.nodes().filter_map(|n| n.position).collect(),
            network.vessels().map(|(_, v)| v.radius).filter(|r| is_radius(*r)).collect(),
        ),
    }
}
