//! Centerlines at one step, so that decisions do not depend on how densely a reader or another program puts points along a vessel.

use super::features::extraction::Extraction;
use super::kind::CenterlineKind;
use willis_core::error::Result;
use willis_core::network::path_places::{PathPlace, at_even_steps, length_of};
use willis_core::network::{Network, Origin, Vessel};
use willis_core::support::geometry::distance;
use willis_core::support::ties::steady;

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
    places: Vec<Vec<PathPlace>>,
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
            let place = places_at(vessel, step);
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
    pub fn extraction(&self, inlets: &[usize]) -> Result<Extraction> {
        Extraction::new(&self.network, inlets, self.step)
    }

    /// The place on the original path of a point of a vessel's path.
    pub fn place(&self, vessel: usize, point: usize) -> PathPlace {
        self.places[vessel][point]
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
    let thin = narrowest_quarter(&stretches, whole);
    if thin <= 0.0 {
        return 1.0;
    }
    let step = match kind {
        CenterlineKind::Skeleton => STEP_RADII * thin,
        CenterlineKind::Tracing | CenterlineKind::Tubes => {
            let [low, high] = TRACING_RADII.map(|radii| radii * thin);
            (volume(&stretches).cbrt() / STEPS_PER_SIDE).clamp(low, high)
        }
    };
    let most = (MOST_TIMES * stretches.len() as f64).clamp(MOST_POINTS[0], MOST_POINTS[1]);
    steady(step).max(whole / most)
}

/// The radius (m) that the narrowest quarter of the length has at most; zero without vessels.
fn narrowest_quarter(stretches: &[([f64; 2], f64)], whole: f64) -> f64 {
    let narrower = |radius: f64| {
        let share =
            |[least, most]: [f64; 2]| if most <= radius { 1.0 } else { ((radius - least) / (most - least)).clamp(0.0, 1.0) };
        stretches.iter().map(|(radii, length)| share(*radii) * length).sum::<f64>()
    };
    let (mut low, mut high) = (0.0, stretches.iter().map(|(radii, _)| radii[1]).fold(0.0, f64::max));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        (low, high) = if narrower(middle) >= NARROW * whole { (low, middle) } else { (middle, high) };
    }
    high
}

/// The volume (m³) of cone by cone.
fn volume(stretches: &[([f64; 2], f64)]) -> f64 {
    stretches.iter().map(|([a, b], length)| std::f64::consts::PI / 3.0 * (a * a + a * b + b * b) * length).sum()
}

/// Places at equal distances along an observed vessel, about one step apart; those of its points where it is none, or has no length.
fn places_at(vessel: &Vessel, step: f64) -> Vec<PathPlace> {
    let (path, length) = (&vessel.path, length_of(&vessel.path));
    if vessel.origin != Origin::Observed || path.len() < 2 || length <= 0.0 {
        return (0..path.len()).map(|point| PathPlace { point, share: 0.0 }).collect();
    }
    at_even_steps(path, (steady(length / step).round() as usize).max(1))
}
