//! Draws a network as the segmentation mask of a scan: blur, slow flow, noise, one threshold; or clean.

use rand::RngExt;
use rand_distr::StandardNormal;

use super::interruptions::Stations;
use super::tube::{DrawnTube, VoxelGrid, veins};
use super::{check_positions, truth::MaskTruth};
use willis_core::error::{Error, Result, ensure, require};
use willis_core::network::{Network, Role, millimetres};
use willis_core::support::{Point, bounds, dot, gamma::Gamma, median, random, random::stream};
use willis_io::masks::{Image, Mask};

/// No mask has more voxels.
pub const MOST_VOXELS: usize = 1 << 28;
/// No axis has more: NIfTI-1 counts in 16 bits.
const MOST_ALONG_AXIS: f64 = 32767.0;
/// Background around the vessels, in voxels.
const MARGIN: f64 = 5.0;
/// Layers of voxels that are drawn at once.
const LAYERS: usize = 16;
/// The blur reaches this many of its standard deviations.
const REACH: f64 = 3.0;
/// Waves that add up to the signal along vessels.
const WAVES: usize = 64;
/// The brightest signal, as a logarithm.
const BRIGHTEST: f64 = 0.3;

/// How a scan shows the vessels, and how they are segmented. The defaults break some of the thin vessels of `cerebral`.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// The seed; the same seed gives the same mask.
    pub seed: u64,
    /// Standard deviation of the point spread in voxels, 0 to 10.
    pub blur: f64,
    /// The radius at which slow flow halves the signal, in median radii of the vessels, 0 to 10.
    pub slow: f64,
    /// Standard deviation of ln signal along the vessels, 0 to 2.
    pub field: f64,
    /// How far the signal is alike, in median radii: its correlation over a distance d is exp(-d²/2l²); 0.1 to 1000.
    pub alike: f64,
    /// Standard deviation of the noise, as a share of the signal of a wide vessel, 0 to 1.
    pub noise: f64,
    /// The threshold, in the same unit, 0 to 1.
    pub threshold: f64,
    /// Components of fewer voxels are removed, 0 to 1 000 000.
    pub least_voxels: usize,
    /// Veins beside the arteries, per artery; 0 to 10.
    pub veins: f64,
}

impl Default for Scan {
    fn default() -> Self {
        Self { seed: 0, blur: 0.7, slow: 0.5, field: 0.4, alike: 4.0, noise: 0.02, threshold: 0.32, least_voxels: 30, veins: 0.2 }
    }
}

impl Scan {
    /// Neither blur nor noise: a voxel is a vessel where its centre lies inside.
    const CLEAN: Self =
        Self { seed: 0, blur: 0.0, slow: 0.0, field: 0.0, alike: 1.0, noise: 0.0, threshold: 0.5, least_voxels: 0, veins: 0.0 };
}

/// Draws a network as a mask of cubic voxels (`spacing`, m), and says what the mask hides. `scan` breaks vessels and lets others touch;
/// without it the mask is clean, and a vessel thinner than a voxel is a line of voxels.
///
/// The seed alone decides: two calls give the same bits.
///
/// # Errors
///
/// A node without position, more than [`MOST_VOXELS`], a mask in which no vessel is left.
pub fn draw_mask(network: &Network, spacing: f64, scan: Option<&Scan>) -> Result<(Mask, MaskTruth)> {
    draw(network, spacing, scan, false).map(|(mask, truth, _)| (mask, truth))
}

/// The same with the image in which the threshold was drawn: 0 is background, 1 the signal of a wide vessel.
///
/// # Errors
///
/// Those of [`draw_mask`].
pub fn draw_scan(network: &Network, spacing: f64, scan: Option<&Scan>) -> Result<(Mask, MaskTruth, Image)> {
    draw(network, spacing, scan, true)
}

/// The mask, its truth and the values of the image, which are left out unless they are wanted.
fn draw(network: &Network, spacing: f64, scan: Option<&Scan>, with_image: bool) -> Result<(Mask, MaskTruth, Image)> {
    check_positions(network)?;
    let voxel = f64::from(millimetres(spacing) as f32);
    let of_spacing = |holds: bool, accepted: &str| require(holds, "spacing", format!("{} mm", voxel as f32), accepted);
    of_spacing((1e-4..=100.0).contains(&(voxel as f32)), "expected 0.0001 to 100 mm")?;
    check_steps(network, voxel)?;
    let mut tubes = DrawnTube::all(network, voxel);
    let is_clean = scan.is_none();
    let scan = scan.unwrap_or(&Scan::CLEAN);
    let wanted = (scan.veins * tubes.len() as f64).round() as usize;
    if wanted > 0 {
        let beside = veins(&tubes, wanted, voxel, &mut stream(scan.seed, random::VEINS));
        tubes.extend(beside);
    }
    let grid = grid_around(&tubes, voxel)?;
    let mut values = Vec::new();
    let mut classes = Signal::new(scan, &tubes).segment(&grid, &tubes, with_image.then_some(&mut values));
    if is_clean {
        tubes.iter().flat_map(|tube| &tube.stations).for_each(|at| classes[grid.row(*at)] = 1);
    } else {
        remove_small(&mut classes, &grid, scan.least_voxels);
    }
    of_spacing(classes.contains(&1), "leaves no vessel in the mask; expected less, for vessels so thin")?;
    let [x, y, z] = grid.origin;
    let affine = [[voxel, 0.0, 0.0, x], [0.0, voxel, 0.0, y], [0.0, 0.0, voxel, z]];
    let mut mask = Mask::new(grid.shape, classes, affine);
    if !is_clean {
        mask.fill_cavities();
    }
    // What the mask shows of the vessels that were drawn.
    let stations = Stations::new(&tubes, network.node_count(), &grid, &mask);
    let lost: Vec<usize> = (0..tubes.len()).filter(|row| stations.is_lost(*row)).collect();
    let (breaks, contacts) = (stations.breaks(), stations.contacts());
    let inlets = network.nodes().filter(|node| node.role == Some(Role::Inlet)).filter_map(|node| node.position);
    let inlets = inlets.map(|at| at.map(millimetres)).collect();
    let nodes = network.nodes().map(|node| node.id.clone()).collect();
    let truth = MaskTruth { lost, inlets, breaks, contacts, voxel: grid.spacing, nodes, tubes };
    Ok((mask, truth, Image { shape: grid.shape, values, affine }))
}

/// Refuses voxels so small that the stations along the vessels alone are too many.
fn check_steps(network: &Network, voxel: f64) -> Result<()> {
    let length: f64 = network.vessels().map(|(_, vessel)| millimetres(vessel.length)).sum();
    ensure(length / voxel <= MOST_VOXELS as f64, || too_small(voxel, &format!("{length:.0} mm of vessels")))
}

fn too_small(voxel: f64, what: &str) -> Error {
    let accepted = format!("too small for {what}; expected at most {MOST_VOXELS} voxels, 32767 along an axis");
    Error::parameter("spacing", format!("{} mm", voxel as f32), accepted)
}

/// The voxels around all tubes, with a margin.
fn grid_around(tubes: &[DrawnTube], voxel: f64) -> Result<VoxelGrid> {
    let corners = tubes.iter().flat_map(|tube| {
        let around = tube.widest() + MARGIN * voxel;
        tube.stations.iter().flat_map(move |at| [at.map(|x| x - around), at.map(|x| x + around)])
    });
    let [low, high] = bounds(corners);
    require(low[0] <= high[0], "network", "empty", "expected vessels to draw")?;
    // As the file stores it, so that the truth is in the very frame of the mask.
    let origin = low.map(|x| f64::from(x as f32));
    let lengths = [0, 1, 2].map(|axis| ((high[axis] - origin[axis]) / voxel).ceil() + 1.0);
    if lengths.iter().any(|n| *n > MOST_ALONG_AXIS) || lengths.iter().product::<f64>() > MOST_VOXELS as f64 {
        return Err(too_small(voxel, &format!("an image of {} x {} x {} voxels", lengths[0], lengths[1], lengths[2])));
    }
    Ok(VoxelGrid { shape: lengths.map(|n| n as usize), origin, spacing: voxel })
}

/// What the scanner sees of the tubes.
struct Signal<'a> {
    scan: &'a Scan,
    /// The signal of each station of each tube.
    signals: Vec<Vec<f64>>,
    below: NormalTable,
}

impl<'a> Signal<'a> {
    fn new(scan: &'a Scan, tubes: &[DrawnTube]) -> Self {
        let radii: Vec<f64> = tubes.iter().flat_map(|tube| tube.radii.iter().copied()).collect();
        let typical = median(&radii).unwrap_or_default();
        let field = RandomField::new(scan, scan.alike * typical);
        let signal = |at: Point, radius: f64| {
            let along = if scan.field > 0.0 { (scan.field * field.at(at)).min(BRIGHTEST).exp() } else { 1.0 };
            along * radius / (radius + scan.slow * typical)
        };
        let of_tube = |tube: &DrawnTube| tube.stations.iter().zip(&tube.radii).map(|(at, radius)| signal(*at, *radius)).collect();
        Self { scan, signals: tubes.iter().map(of_tube).collect(), below: NormalTable::new() }
    }

    /// The voxels above the threshold, noise included: 1, else 0; all values are put into `image`.
    fn segment(&self, grid: &VoxelGrid, tubes: &[DrawnTube], mut image: Option<&mut Vec<f32>>) -> Vec<u8> {
        let mut noise = stream(self.scan.seed, random::NOISE);
        let (layer, blur) = (grid.shape[0] * grid.shape[1], self.scan.blur * grid.spacing);
        let mut classes = Vec::with_capacity(layer * grid.shape[2]);
        let (mut all, mut own) = (Vec::new(), vec![0.0_f32; layer * LAYERS.min(grid.shape[2])]);
        let mut touched = Vec::new();
        for first in (0..grid.shape[2]).step_by(LAYERS) {
            let end = (first + LAYERS).min(grid.shape[2]);
            all.clear();
            all.resize(layer * (end - first), 0.0_f32);
            for (tube, signals) in tubes.iter().zip(&self.signals) {
                // The largest signal that the links of a tube give each voxel.
                grid.near(tube, REACH * blur, [first, end], |near| {
                    let inside = self.profile(near.away, near.radius, blur) * self.edge(-near.beyond, blur);
                    let (value, row) = ((signals[near.station] * inside) as f32, near.row - first * layer);
                    if value > own[row] {
                        if own[row] == 0.0 {
                            touched.push(row);
                        }
                        own[row] = value;
                    }
                });
                // Vessels side by side add up.
                for row in touched.drain(..) {
                    let value = std::mem::take(&mut own[row]).min(1.0);
                    all[row] = 1.0 - (1.0 - all[row]) * (1.0 - value);
                }
            }
            classes.extend(all.iter().map(|value| {
                let mut value = f64::from(*value);
                if self.scan.noise > 0.0 {
                    value += self.scan.noise * noise.sample::<f64, _>(StandardNormal);
                }
                if let Some(image) = &mut image {
                    image.push(value as f32);
                }
                u8::from(value > self.scan.threshold)
            }));
        }
        classes
    }

    /// The signal at a distance from the axis of a cylinder after a Gaussian blur, of 1 where it is wide.
    fn profile(&self, away: f64, radius: f64, blur: f64) -> f64 {
        if blur <= 0.0 {
            return f64::from(u8::from(away <= radius));
        }
        let share = -(-radius * radius / (2.0 * blur * blur)).exp_m1();
        share * self.edge(radius - away, blur) / self.edge(radius, blur)
    }

    /// The signal so far inside a blurred plane edge.
    fn edge(&self, inside: f64, blur: f64) -> f64 {
        if blur > 0.0 { self.below.at(inside / blur) } else { f64::from(u8::from(inside >= 0.0)) }
    }
}

/// A smooth random field in space of mean 0 and variance 1: waves of random direction, length and phase.
struct RandomField {
    waves: Vec<(Point, f64)>,
}

impl RandomField {
    /// The field whose correlation falls as exp(-d²/2l²) for a length l (mm).
    fn new(scan: &Scan, length: f64) -> Self {
        let mut rng = stream(scan.seed, random::SIGNAL);
        let mut wave =
            || ([0; 3].map(|_| rng.sample::<f64, _>(StandardNormal) / length), std::f64::consts::TAU * rng.random::<f64>());
        Self { waves: (0..WAVES).map(|_| wave()).collect() }
    }

    fn at(&self, place: Point) -> f64 {
        let sum: f64 = self.waves.iter().map(|(wave, phase)| (dot(*wave, place) + phase).cos()).sum();
        sum * (2.0 / WAVES as f64).sqrt()
    }
}

/// The normal distribution's cumulative function as a table.
struct NormalTable(Vec<f64>);

impl NormalTable {
    const REACH: f64 = 6.0;
    const STEPS: f64 = 100.0;

    fn new() -> Self {
        let square = Gamma { shape: 0.5, scale: 2.0 };
        let at = |n: usize| {
            let x = n as f64 / Self::STEPS - Self::REACH;
            0.5 * (1.0 + x.signum() * square.cumulative(x * x))
        };
        Self((0..=(2.0 * Self::REACH * Self::STEPS) as usize + 1).map(at).collect())
    }

    /// The probability of less than x.
    fn at(&self, x: f64) -> f64 {
        if x.abs() >= Self::REACH {
            return f64::from(u8::from(x > 0.0));
        }
        let place = (x + Self::REACH) * Self::STEPS;
        let (low, share) = (place as usize, place.fract());
        self.0[low] + share * (self.0[low + 1] - self.0[low])
    }
}

/// Removes the 26-connected components of fewer voxels.
fn remove_small(classes: &mut [u8], grid: &VoxelGrid, least: usize) {
    const SEEN: u8 = 2;
    let mut component = Vec::new();
    for first in 0..classes.len() {
        if classes[first] != 1 {
            continue;
        }
        component.clear();
        component.push(first);
        classes[first] = SEEN;
        let mut next = 0;
        while let Some(row) = component.get(next).copied() {
            next += 1;
            for to in grid.neighbours(row) {
                if classes[to] == 1 {
                    classes[to] = SEEN;
                    component.push(to);
                }
            }
        }
        if component.len() < least {
            for row in &component {
                classes[*row] = 0;
            }
        }
    }
    for class in classes {
        *class = u8::from(*class != 0);
    }
}
