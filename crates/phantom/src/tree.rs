//! A bifurcating tree by Murray's law: radii, angles and terminal resistances.

use rand::RngExt;

use super::curve::{Bow, course};
use super::{add_curved_vessel, add_node, check_length, check_range, make_inlet, state};
use willis_core::error::Result;
use willis_core::network::{Condition, INLET_PRESSURE, Network, Role, metres, units::cubic_metres_per_second};
use willis_core::support::{cross, dot, random, random::stream, sub, unit};

/// The shape of a branching tree.
#[derive(Debug, Clone, PartialEq)]
pub struct BranchingTree {
    /// Generations of branching g, 0 to 16: the tree has 2^(g + 1) - 1 vessels.
    pub generations: u32,
    /// Radius of the first vessel, m, positive.
    pub radius: f64,
    /// Length over radius of every vessel, 4 to 1000.
    pub slenderness: f64,
    /// How unlike two daughters may be, 0 (equal) to 0.9: the wider takes a share of r³ between 1/2 and (1 + asymmetry) / 2.
    pub asymmetry: f64,
    /// Distance between centerline points, m, positive.
    pub spacing: f64,
    /// The seed.
    pub seed: u64,
}

impl Default for BranchingTree {
    fn default() -> Self {
        Self { generations: 5, radius: metres(2.0), slenderness: 20.0, asymmetry: 0.3, spacing: metres(0.5), seed: 0 }
    }
}

impl BranchingTree {
    /// Refuses a field out of its range.
    ///
    /// # Errors
    ///
    /// Names the field, its value and its range.
    pub fn validate(&self) -> Result<()> {
        check_range("generations", self.generations, 0, 16)?;
        check_length("radius", self.radius)?;
        check_range("slenderness", self.slenderness, 4.0, 1000.0)?;
        check_range("asymmetry", self.asymmetry, 0.0, 0.9)?;
        check_length("spacing", self.spacing)
    }
}

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
///
/// # Errors
///
/// Those of [`BranchingTree::validate`].
pub fn branching_tree(params: &BranchingTree) -> Result<Network> {
    params.validate()?;
    let mut rng = stream(params.seed, random::ANATOMY);
    let mut network = Network::new();
    let root = add_node(&mut network, [0.0; 3], Some(params.radius));
    make_inlet(&mut network, root);
    let first = PlannedVessel {
        from: root,
        along: [0.0, 0.0, 1.0],
        side: [1.0, 0.0, 0.0],
        radius: params.radius,
        label: "T".into(),
        generation: 0,
    };
    let mut branches = std::collections::VecDeque::from([first]);
    while let Some(branch) = branches.pop_front() {
        let tip = branch.grow(&mut network, params);
        if branch.generation == params.generations {
            make_terminal(&mut network, tip, branch.radius);
        } else {
            let share = 0.5 * (1.0 + params.asymmetry * rng.random::<f64>());
            branches.extend(branch.daughters(tip, share));
        }
    }
    Ok(network)
}

/// Makes a node an outlet of a vessel of this radius (m). Its terminal resistance gives Murray's flow at 100 mmHg.
pub(crate) fn make_terminal(network: &mut Network, row: usize, radius: f64) {
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
        let length = self.radius * params.slenderness;
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
