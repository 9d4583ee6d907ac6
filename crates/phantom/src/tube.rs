//! Vessels as tubes in the frame of an image, and which voxels lie near them. Veins beside the arteries of a phantom, so near that a mask may
//! join the two.

use rand::{Rng, RngExt};
use rand_distr::{StandardNormal, UnitSphere};

use super::damage::{SampledVessel, scattered};
use willis_core::network::{Network, metres, millimetres};
use willis_core::support::{Point, arc_lengths::arc_lengths, cross, distance, dot, lerp, norm_squared, sub, unit};
use willis_io::masks::{indices_of, row_at};

/// A vessel as stations along its centerline, mm.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnTube {
    /// Its label.
    pub label: String,
    /// The rows of its nodes in the network; `None` for a tube that hangs on nothing.
    pub nodes: Option<[usize; 2]>,
    /// Stations from its first node to its second, at most a voxel apart, mm.
    pub stations: Vec<Point>,
    /// The radius at each station, mm.
    pub radii: Vec<f64>,
    /// Whether it ends flat at its first and at its last station. At a junction it ends round.
    pub is_free: [bool; 2],
}

impl DrawnTube {
    /// The vessels of a network, all of whose nodes have a position, with stations at most `voxel` (mm) apart.
    pub(super) fn all(network: &Network, voxel: f64) -> Vec<Self> {
        let degrees = network.degrees(|_| true);
        let tube = |row: usize| {
            let sampled = SampledVessel::at(network, row, |length| ((length / metres(voxel)).ceil() as usize).max(1));
            let nodes = network.ends(row);
            Self {
                label: network.vessel(row).label.clone(),
                nodes: Some(nodes),
                stations: sampled.points.iter().map(|(position, _)| position.map(millimetres)).collect(),
                radii: sampled.points.iter().map(|(_, radius)| millimetres(*radius)).collect(),
                is_free: nodes.map(|node| degrees[node] == 1),
            }
        };
        (0..network.vessel_count()).map(tube).collect()
    }

    /// The arc length from the first station to each, mm.
    pub fn arc(&self) -> Vec<f64> {
        arc_lengths(self.stations.iter().copied())
    }

    /// The largest radius, mm.
    pub fn widest(&self) -> f64 {
        self.radii.iter().copied().fold(0.0, f64::max)
    }

    /// Where it ends flat: the place, and the direction out of it.
    fn flat_ends(&self) -> impl Iterator<Item = (Point, Point)> {
        let last = self.stations.len() - 1;
        let ends = [(0, 1), (last, last - 1)].into_iter().zip(self.is_free).filter(|(_, is_free)| *is_free);
        ends.map(|((end, inner), _)| (self.stations[end], unit(sub(self.stations[end], self.stations[inner]))))
    }
}

/// A voxel near a tube.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    /// Its row among the voxels of the grid.
    pub row: usize,
    /// The nearer station of the nearest link between two stations.
    pub station: usize,
    /// How far its centre lies from that link, mm.
    pub away: f64,
    /// The radius there, mm.
    pub radius: f64,
    /// How far beyond a flat end its centre lies, mm; negative inside.
    pub beyond: f64,
}

/// Cubic voxels in the scanner's frame, x fastest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct VoxelGrid {
    /// Voxels along each axis.
    pub shape: [usize; 3],
    /// Where the centre of the first voxel is, mm.
    pub origin: Point,
    /// The length of a voxel, mm.
    pub spacing: f64,
}

impl VoxelGrid {
    /// Where the centre of a voxel is, mm.
    pub fn position(&self, voxel: [usize; 3]) -> Point {
        [0, 1, 2].map(|axis| self.origin[axis] + voxel[axis] as f64 * self.spacing)
    }

    /// The indices of the voxel of a row.
    pub fn voxel(&self, row: usize) -> [usize; 3] {
        indices_of(self.shape, row)
    }

    /// The row of the voxel in which a place lies; outside the grid of the nearest.
    pub fn row(&self, place: Point) -> usize {
        let nearest = |axis: usize| {
            let at = ((place[axis] - self.origin[axis]) / self.spacing).round();
            (at.max(0.0) as usize).min(self.shape[axis] - 1)
        };
        row_at(self.shape, [0, 1, 2].map(nearest))
    }

    /// The rows of the voxels that touch one by a face, an edge or a corner.
    pub fn neighbours(&self, row: usize) -> impl Iterator<Item = usize> {
        let (shape, at) = (self.shape, self.voxel(row));
        (0..27_usize).filter(|n| *n != 13).filter_map(move |n| {
            let to = [at[0] + n % 3, at[1] + n / 3 % 3, at[2] + n / 9].map(|index| index.wrapping_sub(1));
            (0..3).all(|axis| to[axis] < shape[axis]).then(|| row_at(shape, to))
        })
    }

    /// Visits the voxels of some layers (along z) whose centre lies within the radius and `reach` (mm) of a tube's centerline, once for
    /// each link between stations that is so near.
    pub fn near(&self, tube: &DrawnTube, reach: f64, layers: [usize; 2], mut visit: impl FnMut(Near)) {
        for (link, ends) in tube.stations.windows(2).enumerate() {
            let radii = [tube.radii[link], tube.radii[link + 1]];
            let within = radii[0].max(radii[1]) + reach;
            let Some([low, high]) = self.around(ends, within, layers) else { continue };
            // An end cuts flat what lies near it.
            let flat: Vec<_> = tube.flat_ends().filter(|(at, _)| distance(*at, ends[0]) <= 2.0 * within + self.spacing).collect();
            let (along, length) = (unit(sub(ends[1], ends[0])), distance(ends[0], ends[1]));
            for z in low[2]..=high[2] {
                for y in low[1]..=high[1] {
                    let line = row_at(self.shape, [0, y, z]);
                    for x in low[0]..=high[0] {
                        let centre = self.position([x, y, z]);
                        let on = dot(sub(centre, ends[0]), along).clamp(0.0, length);
                        let share = on / length.max(f64::MIN_POSITIVE);
                        let foot = lerp(ends[0], ends[1], share);
                        let squared = norm_squared(sub(centre, foot));
                        if squared > within * within {
                            continue;
                        }
                        let beyond = flat.iter().map(|(at, out)| dot(sub(centre, *at), *out)).fold(f64::NEG_INFINITY, f64::max);
                        visit(Near {
                            row: line + x,
                            station: link + usize::from(share > 0.5),
                            away: squared.sqrt(),
                            radius: radii[0] + share * (radii[1] - radii[0]),
                            beyond,
                        });
                    }
                }
            }
        }
    }

    /// The first and the last voxel whose centre lies in the box around two places and `within` mm more, in some layers; `None` where
    /// there is none.
    fn around(&self, ends: &[Point], within: f64, [first, end]: [usize; 2]) -> Option<[[usize; 3]; 2]> {
        let mut found = [[0; 3]; 2];
        for axis in 0..3 {
            let (a, b) = (ends[0][axis].min(ends[1][axis]), ends[0][axis].max(ends[1][axis]));
            let low = ((a - within - self.origin[axis]) / self.spacing).ceil().max(0.0) as usize;
            let high = ((b + within - self.origin[axis]) / self.spacing).floor();
            let (least, most) = if axis == 2 { (first, end) } else { (0, self.shape[axis]) };
            if high < least as f64 || low >= most {
                return None;
            }
            found[0][axis] = low.max(least);
            found[1][axis] = (high as usize).min(most - 1);
        }
        Some(found)
    }
}

/// Attempts for a vein before the space counts as too crowded.
const ATTEMPTS: usize = 100;
/// Space between the walls of a vein and its artery, in voxels: uniform between these.
const SPACE: [f64; 2] = [-0.3, 0.6];
/// The radius of a vein in radii of its artery.
const WIDTH: [f64; 2] = [0.5, 1.0];
/// How far a vein goes either way from where it is nearest, in sums of the two radii.
const REACH: [f64; 2] = [4.0, 10.0];
/// The radius of its curve away from the artery, in sums of the two radii.
const CURVE: [f64; 2] = [5.0, 12.0];

/// Up to `wanted` veins, each beside one artery and clear of all others.
pub(super) fn veins(arteries: &[DrawnTube], wanted: usize, voxel: f64, rng: &mut impl Rng) -> Vec<DrawnTube> {
    let taken = arteries.iter().flat_map(|tube| tube.stations.iter().copied().zip(tube.radii.iter().copied())).collect();
    let draw = || beside(&arteries[rng.random_range(0..arteries.len())], voxel, rng);
    let vein = |(row, points): (usize, Vec<(Point, f64)>)| {
        let (stations, radii) = points.into_iter().unzip();
        DrawnTube { label: format!("vein {}", row + 1), nodes: None, stations, radii, is_free: [true; 2] }
    };
    scattered(taken, [wanted, ATTEMPTS], SPACE[0] * voxel, draw).into_iter().enumerate().map(vein).collect()
}

/// A vein that passes an artery at a random station, and curves away from it.
fn beside(artery: &DrawnTube, voxel: f64, rng: &mut impl Rng) -> Vec<(Point, f64)> {
    let at = rng.random_range(1..artery.stations.len());
    let along = unit(sub(artery.stations[at], artery.stations[at - 1]));
    let side: Point = rng.sample(UnitSphere);
    let side = unit([0, 1, 2].map(|axis| side[axis] - dot(side, along) * along[axis]));
    let (lumen, other) = (artery.radii[at], cross(along, side));
    let radius = lumen * rng.random_range(WIDTH[0]..WIDTH[1]);
    let both = lumen + radius;
    let away = both + voxel * rng.random_range(SPACE[0]..SPACE[1]);
    let reach = [0, 1].map(|_| both * rng.random_range(REACH[0]..REACH[1]));
    let curve = both * rng.random_range(CURVE[0]..CURVE[1]);
    let (twist, tilt): (f64, f64) = (rng.sample(StandardNormal), 0.3 * rng.sample::<f64, _>(StandardNormal));
    // The curve is at most about twice as long as its chord.
    let steps = (2.0 * (reach[0] + reach[1]) / voxel).ceil().max(1.0) as usize;
    let place = |step: usize| {
        let s = (reach[0] + reach[1]) * step as f64 / steps as f64 - reach[0];
        let bend = s * s / (2.0 * curve);
        let (out, turned) = (away + bend, tilt * s + 0.5 * twist * bend);
        [0, 1, 2].map(|axis| artery.stations[at][axis] + s * along[axis] + out * side[axis] + turned * other[axis])
    };
    (0..=steps).map(|step| (place(step), radius)).collect()
}
