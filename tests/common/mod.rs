//! What the tests share, from textbooks and independent of the library: a generator, small networks, and the exact answer.

#![allow(dead_code, reason = "each test file uses its part")]

pub mod exact;
pub mod figure;
pub mod grown;
pub mod textbook;

use willis::hemodynamics::Boundary;
use willis::inference::{Likelihood, Params, infer};
use willis::network::{Condition, Network, Node, Origin, Role, Vessel};

/// Pa in one mmHg, by definition.
pub const MMHG: f64 = 133.322_387_415;
/// Pa s: the default viscosity of blood.
pub const VISCOSITY: f64 = 3.5e-3;

/// SplitMix64 (Steele, Lea, Flood 2014): randomness that shares nothing with the library's generator.
pub struct Draw(u64);

impl Draw {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x2545_f491_4f6c_dd1d).wrapping_add(1))
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [low, high).
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in 0..n.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i + 1));
        }
    }
}

/// An observed vessel of a length and radius in mm.
pub fn tube(length_mm: f64, radius_mm: f64) -> Vessel {
    Vessel::new(length_mm / 1e3, radius_mm / 1e3, Origin::Observed)
}

/// A network whose nodes are called by their rows.
pub fn network(nodes: usize, vessels: impl IntoIterator<Item = ([usize; 2], Vessel)>) -> Network {
    let mut network = Network::new();
    for row in 0..nodes {
        network.add_node(Node { id: row.to_string(), ..Node::default() });
    }
    for (ends, vessel) in vessels {
        network.add_vessel(ends, vessel);
    }
    network
}

/// The conditions as they stand, nothing found.
pub fn boundary(network: &Network, conditions: &[(usize, Condition)]) -> Boundary {
    let mut conditions = conditions.to_vec();
    conditions.sort_by_key(|(node, _)| *node);
    Boundary { conditions, roles: vec![Role::Inner; network.node_count()], found_inlets: Vec::new(), found_outlets: Vec::new() }
}

/// A pressure in mmHg.
pub fn pressure(mmhg: f64) -> Condition {
    Condition::Pressure(mmhg * MMHG)
}

/// A connected random network: a random tree and further vessels between random nodes, parallel ones among them, in random
/// order and direction; half are candidates, half of the priors below one.
pub fn random_network(draw: &mut Draw, nodes: usize, vessels: usize, mut radius_mm: impl FnMut(&mut Draw) -> f64) -> Network {
    let mut pairs: Vec<[usize; 2]> = (1..nodes).map(|i| [i, draw.below(i)]).collect();
    while pairs.len() < vessels {
        let pair = [draw.below(nodes), draw.below(nodes)];
        if pair[0] != pair[1] {
            pairs.push(pair);
        }
    }
    draw.shuffle(&mut pairs);
    let vessels = pairs.into_iter().map(|pair| {
        let prior = if draw.below(2) == 0 { 1.0 } else { draw.within(0.3, 0.95) };
        let origin = if draw.below(2) == 0 { Origin::Observed } else { Origin::Candidate };
        (pair, Vessel { prior, origin, ..tube(draw.within(3.0, 40.0), radius_mm(draw)) })
    });
    let vessels: Vec<_> = vessels.collect();
    network(nodes, vessels)
}

/// Radii between two bounds in mm.
pub fn radii(low: f64, high: f64) -> impl FnMut(&mut Draw) -> f64 {
    move |draw| draw.within(low, high)
}

/// Radii between two bounds in mm, even in their logarithm, so that conductances spread over many orders.
pub fn log_radii(low: f64, high: f64) -> impl FnMut(&mut Draw) -> f64 {
    move |draw| draw.within(low.ln(), high.ln()).exp()
}

/// An inlet, an outlet, and by chance a second inlet, a terminal resistance, an injected or withdrawn flow.
pub fn random_conditions(draw: &mut Draw, nodes: usize) -> Vec<(usize, Condition)> {
    let mut order: Vec<usize> = (0..nodes).collect();
    draw.shuffle(&mut order);
    let mut conditions = vec![(order[0], pressure(100.0)), (order[1], pressure(0.0))];
    if draw.below(2) == 0 {
        conditions.push((order[2], pressure(93.0)));
    }
    if draw.below(2) == 0 {
        let resistance = draw.within(1e9, 1e10);
        conditions.push((order[3], Condition::Resistance { resistance, venous: 5.0 * MMHG }));
    }
    if draw.below(2) == 0 {
        conditions.push((order[4], Condition::Flow(draw.within(-1e-6, 1e-6))));
    }
    conditions
}

/// A run, with the conditions as they stand.
pub fn run(network: &Network, conditions: &[(usize, Condition)], params: &Params) -> Likelihood {
    infer(network, &boundary(network, conditions), params, &mut |_, _| true).unwrap().0
}
