//! A bifurcating tree by Murray's law: radii, angles and terminal resistances. And twelve arterial trees that fill the volume of a brain, by
//! recursive bisection of space and Murray's law.

use rand::{Rng, RngExt, seq::SliceRandom};
use rand_distr::StandardNormal;

use super::curve::{Bow, course};
use super::{Large, add_curved_vessel, add_node, state};
use willis_core::network::{Condition, INLET_PRESSURE, Network, Role, metres, units::cubic_metres_per_second};
use willis_core::support::{Point, cross, distance, dot, lerp, random, random::stream, sub, unit};

/// The shape of a branching tree.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchingTree {
    /// Generations of branching g, 0 to 16: the tree has 2^(g + 1) - 1 vessels.
    pub generations: u32,
    /// Distance between centerline points, m, positive.
    pub spacing: f64,
    /// The seed.
    pub seed: u64,
}

impl Default for BranchingTree {
    fn default() -> Self {
        Self { generations: 5, spacing: metres(0.5), seed: 0 }
    }
}

/// Radius of the first vessel, mm.
const FIRST_RADIUS: f64 = 2.0;
/// Length over radius of every vessel.
const SLENDERNESS: f64 = 20.0;
/// How unlike two daughters may be: the wider takes a share of r³ between 1/2 and (1 + this) / 2.
const ASYMMETRY: f64 = 0.3;
/// Arc length over chord of a tree's vessels.
const TORTUOSITY: f64 = 1.03;
/// Flow through a vessel of 2 mm radius, mL/min: about that of an internal carotid. Murray's law gives that of other radii.
const FLOW_AT_2_MM: f64 = 250.0;

/// A tree that grows upwards from the origin. The plane of each branching is at a right angle to the one before.
///
/// At a branching r₀³ = r₁³ + r₂³, and the daughters leave at Murray's angles, cos θ₁ = (r₀⁴ + r₁⁴ - r₂⁴) / (2 r₀² r₁²).
/// The root is an inlet at 100 mmHg, and the ends carry terminal resistances in proportion to 1/r³, as Murray's
/// flow Q ~ r³ requires. Labels give the path from the root (`T`, `T.1`, `T.1.2`, ...; 1 is the wider daughter). Distant branches of
/// a large tree may touch.
pub fn branching_tree(params: &BranchingTree) -> Network {
    let mut rng = stream(params.seed, random::ANATOMY);
    let mut network = Network::new();
    let root = add_node(&mut network, [0.0; 3], Some(metres(FIRST_RADIUS)));
    state(&mut network, root, Role::Inlet, Condition::INLET);
    let first = PlannedVessel {
        from: root,
        along: [0.0, 0.0, 1.0],
        side: [1.0, 0.0, 0.0],
        radius: metres(FIRST_RADIUS),
        label: "T".into(),
        generation: 0,
    };
    let mut branches = std::collections::VecDeque::from([first]);
    while let Some(branch) = branches.pop_front() {
        let tip = branch.grow(&mut network, params);
        if branch.generation == params.generations {
            make_terminal(&mut network, tip, branch.radius);
        } else {
            let share = 0.5 * (1.0 + ASYMMETRY * rng.random::<f64>());
            branches.extend(branch.daughters(tip, share));
        }
    }
    network
}

/// Makes a node an outlet of a vessel of this radius (m). Its terminal resistance gives Murray's flow at 100 mmHg.
fn make_terminal(network: &mut Network, row: usize, radius: f64) {
    let flow = cubic_metres_per_second(FLOW_AT_2_MM) * (radius / metres(2.0)).powi(3);
    state(network, row, Role::Outlet, Condition::Resistance { resistance: INLET_PRESSURE / flow, venous: 0.0 });
}

/// A vessel that the tree will get: its first node, its direction, and the direction in which it will branch.
struct PlannedVessel {
    from: usize,
    along: [f64; 3],
    side: [f64; 3],
    radius: f64,
    label: String,
    generation: u32,
}

impl PlannedVessel {
    /// Adds the vessel and its far node, whose row is returned.
    fn grow(&self, network: &mut Network, params: &BranchingTree) -> usize {
        let length = self.radius * SLENDERNESS;
        let start = network.node(self.from).position.unwrap_or_default();
        let end = [0, 1, 2].map(|axis| start[axis] + self.along[axis] * length / TORTUOSITY);
        let tip = add_node(network, end, Some(self.radius));
        let points = course(start, end, length, Bow { side: self.side, swings: 1 }, params.spacing);
        add_curved_vessel(network, [self.from, tip], points, length, self.radius, &self.label);
        tip
    }

    /// The two daughters at the tip; the first takes `share` of r³.
    fn daughters(&self, tip: usize, share: f64) -> [Self; 2] {
        let radii = [share, 1.0 - share].map(|part| self.radius * part.cbrt());
        let [r0, r1, r2] = [self.radius, radii[0], radii[1]];
        let cosine = |r: f64, other: f64| (r0.powi(4) + r.powi(4) - other.powi(4)) / (2.0 * (r0 * r).powi(2));
        let normal = unit(cross(self.along, self.side));
        [(r1, r2, 1.0), (r2, r1, -1.0)].map(|(radius, other, sign)| {
            let cos = cosine(radius, other).clamp(-1.0, 1.0);
            let sin = sign * (1.0 - cos * cos).sqrt();
            let along = unit([0, 1, 2].map(|axis| cos * self.along[axis] + sin * self.side[axis]));
            let side = unit(sub(normal, along.map(|x| x * dot(normal, along))));
            let label = format!("{}.{}", self.label, if sign > 0.0 { 1 } else { 2 });
            Self { from: tip, along, side, radius, label, generation: self.generation + 1 }
        })
    }
}

/// Territories along each axis: in all two for each of the six cerebral arteries.
const TERRITORIES: [usize; 3] = [3, 2, 2];
/// The sides of the box that the territories fill, m: 1.2 L, the volume of a brain.
const BOX: [f64; 3] = [0.138, 0.110, 0.080];
/// The radius of every root, m: that of A2, the middle one of the three cerebral arteries in [`super::circle`].
const ROOT_RADIUS: f64 = 0.0012;
/// The share of a territory's volume that its first half gets: uniform, with mean 1/2.
const CUT: std::ops::Range<f64> = 0.35..0.65;
/// How far a node may lie from the middle of its territory, in sides of the territory: uniform.
const JITTER: f64 = 0.08;
/// How much the flow of a half may differ from its share of the volume: uniform.
const UNEVEN: f64 = 0.2;
/// How far a point between two vessels of a branch lies off the straight line, in lengths of the branch: normal, along each axis.
const BEND: f64 = 0.05;

/// Exactly `edges` vessels in 12 trees. Each tree grows from the surface of the box into a territory of its own.
///
/// A territory with more than one leaf is cut across its longest side. A branch runs to about the middle of each half and branches
/// there. A half has as much volume as it has leaves, so that leaves fill space evenly. At a branching r₀³ = r₁³ + r₂³, where r³ is
/// in proportion to the volume, within a fifth. A branch is one to three vessels in series, two in the mean.
///
/// Every root is an inlet at 100 mmHg, every leaf an outlet with the terminal resistance that [`super::tree::branching_tree`] gives it.
/// There are 12 nodes more than vessels, about a quarter of them outlets; all have degree 1 to 3. Ids are numbers from 1, vessels have no
/// labels. The phantom has the size and the graph of the arteries of a brain, not their courses.
pub fn arterial(params: &Large) -> Network {
    let mut rng = stream(params.seed, random::ANATOMY);
    let trees = TERRITORIES.iter().product::<usize>();
    // Two vessels a branch, and L leaves make 2 L - 1 branches a tree.
    let leaves = (params.edges / 2 + trees).div_ceil(2);
    let mut vessels = vessels_of_branches(2 * leaves - trees, params.edges, &mut rng).into_iter();
    let mut network = Network::new();
    for tree in 0..trees {
        let first = territory(&mut network, tree, leaves / trees + usize::from(tree < leaves % trees));
        let mut open = vec![first];
        while let Some(territory) = open.pop() {
            let tip = territory.grow(&mut network, usize::from(vessels.next().unwrap_or(1)), params, &mut rng);
            if territory.leaves == 1 {
                make_terminal(&mut network, tip, territory.radius);
            } else {
                open.extend(territory.halves(tip, &mut rng));
            }
        }
    }
    network
}

/// How many vessels each branch has: one, two and three equally often, adjusted to give the requested sum.
fn vessels_of_branches(branches: usize, vessels: usize, rng: &mut impl Rng) -> Vec<u8> {
    let mut of: Vec<u8> = (0..branches).map(|branch| [1, 2, 3][branch % 3]).collect();
    let mut sum = of.iter().map(|n| usize::from(*n)).sum::<usize>();
    for n in &mut of {
        match sum.cmp(&vessels) {
            std::cmp::Ordering::Less if *n < 3 => (*n, sum) = (*n + 1, sum + 1),
            std::cmp::Ordering::Greater if *n > 1 => (*n, sum) = (*n - 1, sum - 1),
            _ => {}
        }
    }
    of.shuffle(rng);
    of
}

/// The territory of a tree. The root is in the middle of the side on the surface of the box.
fn territory(network: &mut Network, tree: usize, leaves: usize) -> Territory {
    let cell = [tree % TERRITORIES[0], tree / TERRITORIES[0] % TERRITORIES[1], tree / (TERRITORIES[0] * TERRITORIES[1])];
    let side = [0, 1, 2].map(|axis| BOX[axis] / TERRITORIES[axis] as f64);
    let low = [0, 1, 2].map(|axis| cell[axis] as f64 * side[axis]);
    let high = [0, 1, 2].map(|axis| low[axis] + side[axis]);
    let mut root = lerp(low, high, 0.5);
    root[2] = if cell[2] == 0 { low[2] } else { high[2] };
    let from = add_node(network, root, None);
    state(network, from, Role::Inlet, Condition::INLET);
    Territory { from, low, high, leaves, radius: ROOT_RADIUS }
}

/// A box that a branch will reach, and the branch.
struct Territory {
    /// The node where the branch begins.
    from: usize,
    /// The corners of the box, m.
    low: Point,
    high: Point,
    /// How many leaves it gets.
    leaves: usize,
    /// The radius of the branch, m.
    radius: f64,
}

impl Territory {
    /// Adds the branch and returns its last node.
    fn grow(&self, network: &mut Network, vessels: usize, params: &Large, rng: &mut impl Rng) -> usize {
        let start = network.node(self.from).position.unwrap_or_default();
        let middle = lerp(self.low, self.high, 0.5);
        let tip = [0, 1, 2].map(|axis| middle[axis] + (self.high[axis] - self.low[axis]) * rng.random_range(-JITTER..JITTER));
        let length = distance(start, tip);
        let mut before = self.from;
        for vessel in 1..=vessels {
            let on_line = lerp(start, tip, vessel as f64 / vessels as f64);
            let off_line = on_line.map(|x| x + BEND * length * rng.sample::<f64, _>(StandardNormal));
            let position = if vessel == vessels { tip } else { off_line };
            let next = add_node(network, position, None);
            params.add_vessel(network, [before, next], self.radius);
            before = next;
        }
        before
    }

    /// Its two halves, on either side of a cut across the longest side, with branches from `tip`. The second half grows first.
    fn halves(&self, tip: usize, rng: &mut impl Rng) -> [Self; 2] {
        let wanted = self.leaves as f64 * rng.random_range(CUT);
        let first = (wanted.round() as usize).clamp(1, self.leaves - 1);
        let share = first as f64 / self.leaves as f64;
        let side = |axis: usize| self.high[axis] - self.low[axis];
        let longest = (1..3).fold(0, |longest, axis| if side(axis) > side(longest) { axis } else { longest });
        let cut = self.low[longest] + share * side(longest);
        let (mut high, mut low) = (self.high, self.low);
        (high[longest], low[longest]) = (cut, cut);
        let [one, other] = [share, 1.0 - share].map(|volume| volume * rng.random_range(1.0 - UNEVEN..1.0 + UNEVEN));
        let radius = |flow: f64| self.radius * (flow / (one + other)).cbrt();
        [
            Self { from: tip, low: self.low, high, leaves: first, radius: radius(one) },
            Self { from: tip, low, high: self.high, leaves: self.leaves - first, radius: radius(other) },
        ]
    }
}
