//! Makes random networks with boundary conditions and runs the inference on them, for the tests.

use willis::internals::flow::Boundary;
use willis::internals::network::{Condition, Network, Origin, Role, Vessel};
use willis::internals::sampling::{Likelihood, SamplingOptions, infer};

use crate::draw::Draw;
use crate::vessels::{network, tube};

/// Pa in one mmHg, by definition.
pub const MMHG: f64 = 133.322_387_415;
/// Pa s: the default viscosity of blood.
pub const VISCOSITY: f64 = 3.5e-3;

/// The conditions as they stand, nothing found.
pub fn boundary(network: &Network, conditions: &[(usize, Condition)]) -> Boundary {
    let mut conditions = conditions.to_vec();
    conditions.sort_by_key(|(node, _)| *node);
    Boundary { conditions, roles: vec![Role::Inner; network.node_count()], ..Boundary::default() }
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
pub fn run(network: &Network, conditions: &[(usize, Condition)], params: &SamplingOptions) -> Likelihood {
    infer(network, &boundary(network, conditions), params, &mut |_, _| true).unwrap().0
}
