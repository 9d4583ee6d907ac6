//! What a page holds of space: centerlines without points that make no visible difference, the image around doubtful vessels, and the segmentation.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::{Deserialize, Serialize};

use crate::figures::CoursePoint;
use willis_core::network::{Network, Role, millimetres};
use willis_core::support::geometry::{Point, box_diagonal};
use willis_io::masks::cubes::ImageCube;
use willis_io::masks::{Affine, Foreground, RunLengths};

/// Points nearer to the line than this share of the box around the network are left out, since no screen shows them.
const INVISIBLE: f64 = 1.0 / 4000.0;

/// The vessels of a page in space.
#[derive(Debug, Clone, Default)]
pub struct PageScene {
    /// The centerline of each vessel, at least two points.
    pub vessels: Vec<Vec<CoursePoint>>,
    /// Where blood enters and leaves, and what is cut.
    pub markers: Vec<Marker>,
}

/// A place that the page marks: the position of a node with a condition and the radius of its widest vessel, or the middle of a contact that is cut
/// and its radius; what is there (`inlet`, `outlet`, `cut` or `suggested`); and the node's label or id, or the probability of the contact.
pub type Marker = (CoursePoint, &'static str, String);

/// A network in space.
///
/// # Errors
///
/// A message for the reader when nodes have no coordinates.
pub fn scene(network: &Network, boundary: &willis_core::flow::Boundary) -> Result<PageScene, String> {
    if !network.has_positions() {
        return Err("The nodes have no coordinates, so the vessels cannot be drawn in space.".to_owned());
    }
    let position = |node: usize| network.node(node).position.unwrap_or_default();
    let visible = INVISIBLE * millimetres(box_diagonal((0..network.node_count()).map(position)));
    let place = |p: [f64; 3], radius: f64| [p[0], p[1], p[2], radius].map(millimetres);
    let mut widest = vec![0.0_f64; network.node_count()];
    let vessels = network.vessels().map(|(ends, vessel)| {
        for node in ends {
            widest[node] = widest[node].max(vessel.radius);
        }
        if vessel.path.len() < 2 {
            return ends.map(|node| place(position(node), vessel.radius)).to_vec();
        }
        thinned(&vessel.path.iter().map(|p| place(p.position, p.radius)).collect::<Vec<_>>(), visible)
    });
    let vessels = vessels.collect();
    let markers = boundary.roles.iter().enumerate().filter(|(_, role)| **role != Role::Inner);
    let markers = markers.map(|(row, role)| {
        let node = network.node(row);
        let name = if node.label.is_empty() { node.id.clone() } else { node.label.clone() };
        (place(position(row), widest[row]), role.name(), name)
    });
    Ok(PageScene { vessels, markers: markers.collect() })
}

/// A mark of a kind where vessels touch that are one with a probability.
pub fn cut(kind: &'static str, position: Point, radius: f64, probability: f64) -> Marker {
    let [x, y, z] = position.map(millimetres);
    ([x, y, z, millimetres(radius)], kind, format!("P = {probability:.3}"))
}

/// A line without the points within `distance` of the remaining line, in position and radius (Douglas & Peucker 1973).
pub fn thinned(line: &[CoursePoint], distance: f64) -> Vec<CoursePoint> {
    let mut kept = vec![false; line.len()];
    let mut open = vec![(0, line.len() - 1)];
    while let Some((first, last)) = open.pop() {
        (kept[first], kept[last]) = (true, true);
        let far = |at: usize| from_segment(line[at], line[first], line[last]);
        let farthest = (first + 1..last).max_by(|a, b| far(*a).total_cmp(&far(*b)));
        if let Some(at) = farthest.filter(|at| far(*at) > distance) {
            open.extend([(first, at), (at, last)]);
        }
    }
    line.iter().zip(kept).filter(|(_, kept)| *kept).map(|(place, _)| *place).collect()
}

/// The distance of a place from the segment between two others, in all four coordinates.
fn from_segment(p: CoursePoint, a: CoursePoint, b: CoursePoint) -> f64 {
    let along: CoursePoint = std::array::from_fn(|i| b[i] - a[i]);
    let from: CoursePoint = std::array::from_fn(|i| p[i] - a[i]);
    let product = |u: CoursePoint, v: CoursePoint| u.iter().zip(v).map(|(x, y)| x * y).sum::<f64>();
    let length = product(along, along);
    let share = if length > 0.0 { (product(from, along) / length).clamp(0.0, 1.0) } else { 0.0 };
    let off: CoursePoint = std::array::from_fn(|i| from[i] - share * along[i]);
    product(off, off).sqrt()
}

/// What the image shows around a doubtful vessel or contact, for the page; see [`ImageCube`].
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ImagePlace {
    /// The rows of the vessels that lie there.
    pub vessels: Vec<usize>,
    /// The middle of the cube, mm.
    pub centre: [f64; 3],
    /// [`ImageCube::held`].
    pub held: [f64; 2],
    /// [`ImageCube::shown`].
    pub shown: [f64; 2],
    /// Whether vessels are dark.
    pub is_dark: bool,
    /// [`ImageCube::samples`] in base64.
    pub samples: String,
}

impl ImagePlace {
    /// A cube around a place (m) at which vessels lie, by row.
    pub fn of(vessels: Vec<usize>, centre: Point, cube: &ImageCube) -> Self {
        let samples = STANDARD.encode(&cube.samples);
        Self { vessels, centre: centre.map(millimetres), held: cube.held, shown: cube.shown, is_dark: cube.is_dark, samples }
    }
}

/// The faces of a segmentation's surface beyond which the page holds it in blocks of voxels: a graphics chip in a laptop draws so many.
const MOST_FACES: usize = 400_000;
/// The blocks of its box beyond which the page holds it in larger ones: a browser takes a byte for each.
const MOST_CELLS: usize = 1 << 26;

/// The segmentation that the vessels were found in, for the page, which makes a surface of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Segmentation {
    /// The lengths of the box around it.
    pub shape: [usize; 3],
    /// Where the centre of each block of the box is, mm.
    pub affine: Affine,
    /// Voxels along each side of a block.
    pub block: usize,
    /// [`RunLengths::bytes`] in base64.
    pub runs: String,
}

impl Segmentation {
    /// The voxels inside vessels, in blocks where they are very many.
    pub fn of(vessels: &Foreground) -> Self {
        let RunLengths { shape, affine, block, bytes } = RunLengths::of(vessels, MOST_FACES, MOST_CELLS);
        Self { shape, affine, block, runs: STANDARD.encode(bytes) }
    }
}
