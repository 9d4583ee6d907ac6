//! Kinds of centerlines, and centerlines at one step, so that decisions do not depend on how densely a reader or another program puts points along a vessel.

use super::features::Extraction;
use willis_core::network::path_places::{PathPlace, at_even_steps, length_of};
use willis_core::network::{Network, Origin, Vessel, cycles, fragments};
use willis_core::support::geometry::distance;
use willis_core::support::ties::steady;

/// How centerlines came about. Each kind has a model of its own, which knows them with points at a step of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CenterlineKind {
    /// A person traced trees of vessels in an image, one point after the other.
    Tracing,
    /// A person drew vessel by vessel, each from within the lumen of the one it leaves, as in TubeTK.
    Tubes,
    /// A mask was thinned.
    Skeleton,
}

/// Of a skeleton the step is so many times the radius that a quarter of the length falls short of: about one and a half voxels.
const STEP_RADII: f64 = std::f64::consts::SQRT_2;
const NARROW: f64 = 0.25;
/// Of a tracing and of tubes it is the side of a cube as large as all vessels over this, ...
const STEPS_PER_SIDE: f64 = 30.0;
/// ... but no less and no more than so many times that radius.
const TRACING_RADII: [f64; 2] = [0.25, 2.0];
/// How often the range of radii is halved to find that radius.
const HALVINGS: usize = 50;
/// More points than so many for each one given are not made, nor more than four million; 200,000 always are: a step is no shorter than this share of
/// the whole length. A single coordinate with a wrong exponent would else fill the memory.
const MOST_TIMES: f64 = 200.0;
const MOST_POINTS: [f64; 2] = [2e5, 4e6];

/// The observed vessels of a network with points at one step.
pub struct Resampled {
    /// The network; rows of nodes and vessels are those of the original.
    pub network: Network,
    /// The step, m, positive.
    pub step: f64,
    /// Per vessel and point of its path the place of that point on the original path.
    pub places: Vec<Vec<PathPlace>>,
}

impl Resampled {
    /// Resamples the observed vessels: points at equal distances along each, about one [`step_of`] apart. Nodes stay
    /// where they are.
    pub fn new(network: &Network, kind: CenterlineKind) -> Self {
        let step = step_of(network, kind);
        let mut places = Vec::with_capacity(network.vessel_count());
        let mut resampled = network.clone();
        for row in 0..network.vessel_count() {
            let vessel = resampled.vessel_mut(row);
            let (path, length) = (&vessel.path, length_of(&vessel.path));
            // Its own points where it is not observed, or has no length.
            let place = if vessel.origin != Origin::Observed || path.len() < 2 || length <= 0.0 {
                (0..path.len()).map(|point| PathPlace { point, share: 0.0 }).collect()
            } else {
                at_even_steps(path, (steady(length / step).round() as usize).max(1))
            };
            vessel.path = place.iter().map(|place| place.on(&vessel.path)).collect();
            places.push(place);
        }
        Self { network: resampled, step, places }
    }

    /// Its points, the step their spacing; `inlets` are nodes where blood is known to enter.
    ///
    /// # Errors
    ///
    /// A node without a position.
    pub fn extraction(&self, inlets: &[usize]) -> willis_core::error::Result<Extraction> {
        Extraction::new(&self.network, inlets, self.step)
    }
}

/// The step of a network's observed vessels, m. It follows the vessels, and not the points: of a skeleton √2 times the radius that the
/// narrowest quarter of the length has at most, which is the resolution of an image where thin vessels are one voxel wide; of a tracing or of tubes
/// a thirtieth of the side of a cube as large as the vessels, from 1/4 to 2 times that radius.
pub fn step_of(network: &Network, kind: CenterlineKind) -> f64 {
    // Radii at the two ends of each stretch, the smaller first, and its length. In between the radius is linear, as in more points.
    let mut stretches: Vec<([f64; 2], f64)> = Vec::new();
    for (_, vessel) in network.vessels().filter(|(_, vessel)| vessel.origin == Origin::Observed) {
        let steps = vessel.path.windows(2).map(|w| {
            let radii = [w[0].radius, w[1].radius];
            ([radii[0].min(radii[1]), radii[0].max(radii[1])], distance(w[0].position, w[1].position))
        });
        stretches.extend(steps.filter(|(radii, length)| radii[0] > 0.0 && *length > 0.0));
    }
    let whole: f64 = stretches.iter().map(|(_, length)| length).sum();
    // The radius that the narrowest quarter of the length has at most; zero without vessels.
    let narrower = |radius: f64| {
        let share =
            |[least, most]: [f64; 2]| if most <= radius { 1.0 } else { ((radius - least) / (most - least)).clamp(0.0, 1.0) };
        stretches.iter().map(|(radii, length)| share(*radii) * length).sum::<f64>()
    };
    let (mut low, mut thin) = (0.0, stretches.iter().map(|(radii, _)| radii[1]).fold(0.0, f64::max));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + thin);
        (low, thin) = if narrower(middle) >= NARROW * whole { (low, middle) } else { (middle, thin) };
    }
    if thin <= 0.0 {
        return 1.0;
    }
    let step = match kind {
        CenterlineKind::Skeleton => STEP_RADII * thin,
        CenterlineKind::Tracing | CenterlineKind::Tubes => {
            let [low, high] = TRACING_RADII.map(|radii| radii * thin);
            // In m³, cone by cone.
            let cone = |([a, b], length): &([f64; 2], f64)| std::f64::consts::PI / 3.0 * (a * a + a * b + b * b) * length;
            (stretches.iter().map(cone).sum::<f64>().cbrt() / STEPS_PER_SIDE).clamp(low, high)
        }
    };
    let most = (MOST_TIMES * stretches.len() as f64).clamp(MOST_POINTS[0], MOST_POINTS[1]);
    steady(step).max(whole / most)
}

/// Arteries have no more independent loops than this, those of the circle and some to spare.
const MOST_LOOPS: usize = 4;
/// Vessels are drawn one by one where this share of them begins in the lumen of another, ...
const INSIDE: f64 = 2.0 / 3.0;
/// ... and there are so many.
const LEAST_VESSELS: usize = 4;
/// A lumen is looked for within so many radii of an end, for a branch is hardly thinner than its parent over this.
const REACH: f64 = 4.0;

impl CenterlineKind {
    /// The kind of observed vessels: a skeleton where they come from a mask or have more loops than arteries have, which come where vessels
    /// touch; tubes where two thirds of the pieces have a free end inside the lumen of another piece; else a tracing.
    pub fn of(network: &Network, from_mask: bool) -> Self {
        if from_mask || cycles(network) > MOST_LOOPS {
            Self::Skeleton
        } else if begin_in_lumens(network) {
            Self::Tubes
        } else {
            Self::Tracing
        }
    }
}

fn begin_in_lumens(network: &Network) -> bool {
    let observed = fragments(network, |_, vessel| vessel.origin == Origin::Observed);
    if observed.count < LEAST_VESSELS || !network.has_positions() {
        return false;
    }
    let resampled = Resampled::new(network, CenterlineKind::Tubes).network;
    let degree = resampled.degrees(|vessel| vessel.origin == Origin::Observed);
    let (mut points, mut piece, mut radius, mut free) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    // A vessel of a ready graph may have no course.
    let traced = |vessel: &Vessel| vessel.origin == Origin::Observed && !vessel.path.is_empty();
    for (ends, vessel) in resampled.vessels().filter(|(_, vessel)| traced(vessel)) {
        let first = points.len();
        points.extend(vessel.path.iter().map(|at| at.position));
        piece.resize(points.len(), observed.of_node[ends[0]]);
        radius.extend(vessel.path.iter().map(|at| at.radius));
        let at = [first, points.len().max(1) - 1];
        free.extend(ends.iter().zip(at).filter(|(node, _)| degree[**node] == 1).map(|(_, point)| point));
    }
    let index = super::search::PointIndex::new(points.clone());
    // Per piece with a free end whether one is inside another piece.
    let mut inside: Vec<Option<bool>> = vec![None; observed.count];
    for end in free {
        let around = index.around(points[end], REACH * radius[end]);
        let found = around.iter().any(|(away, point)| piece[*point] != piece[end] && *away <= radius[*point]);
        let of_piece = inside[piece[end]].get_or_insert(false);
        *of_piece |= found;
    }
    let known: Vec<bool> = inside.into_iter().flatten().collect();
    let begun_inside = known.iter().filter(|inside| **inside).count();
    known.len() >= LEAST_VESSELS && begun_inside as f64 >= INSIDE * known.len() as f64
}
