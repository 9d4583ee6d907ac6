//! What a file holds, whether its lengths look like those of brain vessels in the unit that was given, and the network that it becomes.

use willis_core::network::{
    Centerlines, LengthUnit, Network, RadiusRule, Scale, WELD_TOLERANCE, contract, is_radius, millimetres,
};
use willis_core::support::geometry::{Point, box_diagonal};
use willis_core::{error::Fault, network::units::MOST_METRES, support::statistics::median};

/// The content of a file.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "a file has one")]
pub enum Content {
    /// Points and links, to be contracted.
    Centerlines(Centerlines),
    /// Observed vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Vessels(Network),
    /// A graph whose edges are vessels, ready as they are; a missing radius, where radii are optional, is NaN.
    Graph(Network),
}

/// A network made of a file's content.
#[derive(Debug, Clone)]
pub struct BuiltNetwork {
    /// The network.
    pub network: Network,
    /// The centerlines that it was made of, with coincident points merged.
    pub lines: Option<Centerlines>,
    /// Vessels with more than one label along them; they have that of the longest part.
    pub mixed_labels: usize,
    /// Notes for the user about how it was made, one line each.
    pub notes: Vec<String>,
}

/// A label as its author meant it: a missing one is none, and a class that went through real numbers (`3.0`, as pandas writes it) is
/// whole.
fn label(text: &str) -> String {
    let whole = text.parse::<f64>().ok().filter(|x| text.contains('.') && x.fract() == 0.0);
    if super::tables::reader::is_missing(text) { String::new() } else { whole.map_or_else(|| text.to_owned(), |x| x.to_string()) }
}

impl Content {
    /// Makes the labels, of whichever format, what they mean.
    pub(super) fn settle_labels(&mut self) {
        match self {
            Self::Centerlines(lines) => lines.labels.rename(label),
            Self::Vessels(network) | Self::Graph(network) => {
                (0..network.vessel_count()).for_each(|row| network.vessel_mut(row).label = label(&network.vessel(row).label));
                (0..network.node_count()).for_each(|row| network.node_mut(row).label = label(&network.node(row).label));
            }
        }
    }

    /// Makes a network of centerlines, or of ready vessels; `default_radius` (m) is for vessels without any radius.
    ///
    /// # Errors
    ///
    /// No vessel, one without length, or one without a radius where no default is given.
    pub fn into_network(self, rule: RadiusRule, default_radius: Option<f64>) -> Result<BuiltNetwork, Fault> {
        let mut notes = Vec::new();
        let mut note = |count: usize, noun: &str, what: &str| notes.extend(super::tables::reader::counted(count, noun, what));
        let taken = default_radius.map_or(String::new(), |r| millimetres(r).to_string());
        let defaulted = format!("without any radius: took `default_radius`, {taken} mm");
        let (mut network, lines, mixed_labels) = match self {
            Self::Centerlines(mut lines) => {
                note(lines.weld(WELD_TOLERANCE), "point", "coinciding with another: merged with it");
                let made = contract(&lines, rule, default_radius)?;
                note(made.repaired_radii, "point", "without a positive finite radius: interpolated along the vessel");
                note(made.default_radii, "vessel", &defaulted);
                (made.network, Some(lines), made.mixed_labels)
            }
            Self::Vessels(mut network) | Self::Graph(mut network) => {
                let without: Vec<usize> = (0..network.vessel_count()).filter(|v| network.vessel(*v).radius.is_nan()).collect();
                for row in &without {
                    let accepted = "expected a positive radius, or `default_radius`";
                    let lacking = || Fault::item(format!("vessel {row}"), "no valid radius", accepted);
                    network.vessel_mut(*row).radius = default_radius.ok_or_else(lacking)?;
                }
                note(without.len(), "vessel", &defaulted);
                (network, None, 0)
            }
        };
        let none = || Fault::file("no vessel", "expected centerlines with at least two linked points, or edges");
        super::ensure(network.vessel_count() > 0, none)?;
        network.shrink_to_fit();
        Ok(BuiltNetwork { network, lines, mixed_labels, notes })
    }
}

/// The range of median radii of brain vessels, mm: from capillaries to the internal carotid artery.
const MEDIAN_RADIUS_MM: std::ops::Range<f64> = 0.002..2.4;
/// The diagonal of the box around the vessels of a head and a neck is shorter, mm.
const MOST_EXTENT_MM: f64 = 300.0;
/// Median radii, and extents, that arteries of a brain have where their centimetres are taken as millimetres.
const RADIUS_OF_CM: std::ops::Range<f64> = 0.02..0.15;
const EXTENT_OF_CM: std::ops::Range<f64> = 3.0..30.0;
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
