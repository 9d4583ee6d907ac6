//! Who feeds what in a circle, and how late, over the plausible topologies; and how it compensates the loss of a feeder.

use super::arteries::{Artery, FEEDERS, RING, TERRITORIES};
use super::circle::Circle;
use willis_core::flow::{Boundary, state::State};
use willis_core::network::{Network, Role};
use willis_core::simulation::{Change, Perturbation, rounding, simulate, transport::Transports};
use willis_core::{error::Result, support::in_order, support::list_of, support::weighted_quantiles};

/// Of more topologies so many are followed, drawn by their weights, ...
pub const MOST_TOPOLOGIES: usize = 1000;
/// ... and of a network of more vessels than any circle has so few that they have so many vessels together, but ...
const MOST_VESSELS: usize = 2_000_000;
/// ... no fewer than these.
const LEAST_TOPOLOGIES: usize = 100;
/// The interval has this probability on each side of it.
const TAIL: f64 = 0.05;

/// Where blood goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Destination {
    /// A territory of [`TERRITORIES`].
    Territory(Artery),
    /// An outlet, by its node.
    Outlet(usize),
}

/// A figure over topologies, between the bounds of its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Its mean, or its median.
    pub middle: f64,
    /// The bounds between which it lies with a probability of 90 % or more.
    pub interval: [f64; 2],
}

/// The blood of one destination.
#[derive(Debug, Clone, PartialEq)]
pub struct Supply {
    /// Where it goes.
    pub destination: Destination,
    /// The probability that any arrives.
    pub fed: f64,
    /// Where any arrives, the share from each of [`FEEDERS`], the mean over topologies; what passes none of them is left over.
    pub shares: [Spread; 3],
    /// Where any arrives, the mean time since it entered, s, the median over topologies: in one in which blood hardly moves it is hours.
    pub arrival: Spread,
}

/// The blood at a destination in one topology: its shares by feeder, and the mean time since it entered, s.
type ArrivingBlood = ([f64; 3], f64);

/// Follows the blood through the steady flow of each of some topologies, given as the vessels that they keep with their weights.
/// `viscosity` in Pa s. The circle must have been found in `network`. A topology through which no blood can flow feeds nothing.
pub fn supplies(
    circle: &Circle,
    network: &Network,
    topologies: &[(Vec<bool>, f64)],
    boundary: &Boundary,
    viscosity: f64,
) -> Vec<Supply> {
    let outlets = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Outlet);
    let destinations = TERRITORIES.into_iter().map(Destination::Territory).chain(outlets.map(Destination::Outlet));
    let destinations: Vec<Destination> = destinations.collect();
    let chosen = by_weight(topologies, most_followed(network.vessel_count()));
    // The blood of each destination in one topology; `None` where nothing flows at all.
    let one = |kept: &[bool]| -> Option<Vec<Option<ArrivingBlood>>> {
        let boundary = &boundary.held(network, |row| kept[row]);
        let (network, arteries) = &circle.arteries_in(network, |row| kept[row]);
        let simulation = simulate(network, boundary, viscosity, &[]).ok()?;
        let transport = Transports::of(network, boundary, &simulation).unperturbed;
        let marks = list_of(network.vessel_count(), &arteries.feeders);
        let flow = |row: usize| simulation.unperturbed.vessels[row].flow;
        let ends: Vec<[usize; 2]> = network.vessels().map(|(ends, _)| ends).collect();
        let passed = transport.passed(&ends, &(0..ends.len()).map(flow).collect::<Vec<f64>>(), &marks, FEEDERS.len());
        let at_node = |node: usize| {
            let (shares, blood) = (passed[node].as_ref()?, transport.nodes[node].as_ref()?);
            Some(([shares[0], shares[1], shares[2]], blood.mean))
        };
        let blood = |destination: &Destination| match destination {
            Destination::Outlet(node) if boundary.roles[*node] == Role::Outlet => at_node(*node),
            // An end that was joined is none.
            Destination::Outlet(_) => None,
            Destination::Territory(artery) => {
                let at = TERRITORIES.iter().position(|territory| territory == artery)?;
                // The flow in an artery is largest where it begins, before branches leave.
                let begins = arteries.territories[at].iter().max_by(|a, b| flow(**a).abs().total_cmp(&flow(**b).abs()))?;
                at_node(transport.vessels[*begins]?.0)
            }
        };
        Some(destinations.iter().map(blood).collect())
    };
    let all = in_order(&chosen, |_, (kept, _)| one(kept));
    let total: f64 = chosen.iter().map(|(_, weight)| weight).sum();
    let supply = |(at, destination): (usize, &Destination)| {
        let found = all.iter().zip(&chosen).filter_map(|(found, (_, weight))| Some((found.as_ref()?[at]?, *weight)));
        let found: Vec<(ArrivingBlood, f64)> = found.collect();
        // Of none 0, where a sum is -0.
        let fed = found.iter().fold(0.0, |sum, (_, weight)| sum + weight);
        let each = |of: &dyn Fn(&ArrivingBlood) -> f64| -> Vec<(f64, f64)> {
            found.iter().map(|(blood, weight)| (of(blood), *weight)).collect()
        };
        Supply {
            destination: *destination,
            fed: if total > 0.0 { fed / total } else { 0.0 },
            shares: [0, 1, 2].map(|feeder| Spread::about_mean(&each(&|(shares, _)| shares[feeder]))),
            arrival: Spread::about_median(&each(&|(_, arrival)| *arrival)),
        }
    };
    destinations.iter().enumerate().map(supply).collect()
}

/// How many topologies of so many vessels are followed at the most.
pub fn most_followed(vessels: usize) -> usize {
    (MOST_VESSELS / vessels.max(1)).clamp(LEAST_TOPOLOGIES, MOST_TOPOLOGIES)
}

/// All topologies, or of more than `most` so many, at even steps of the summed weight.
pub fn by_weight(topologies: &[(Vec<bool>, f64)], most: usize) -> Vec<(&Vec<bool>, f64)> {
    if topologies.len() <= most {
        return topologies.iter().map(|(kept, weight)| (kept, *weight)).collect();
    }
    let total: f64 = topologies.iter().map(|(_, weight)| weight).sum();
    let mut chosen: Vec<(usize, f64)> = Vec::new();
    let (mut at, mut passed) = (0, topologies[0].1);
    for step in 0..most {
        let middle = (step as f64 + 0.5) / most as f64 * total;
        while passed < middle && at + 1 < topologies.len() {
            at += 1;
            passed += topologies[at].1;
        }
        match chosen.last_mut() {
            Some((last, weight)) if *last == at => *weight += 1.0,
            _ => chosen.push((at, 1.0)),
        }
    }
    chosen.into_iter().map(|(at, weight)| (&topologies[at].0, weight)).collect()
}

impl Spread {
    /// The median of values with weights, with their interval; NaN without any.
    pub fn about_median(values: &[(f64, f64)]) -> Self {
        let quantiles = weighted_quantiles(values.iter().copied(), [TAIL, 0.5, 1.0 - TAIL]);
        let [low, middle, high] = quantiles.map(|x| x.unwrap_or(f64::NAN));
        Self { middle, interval: [low, high] }
    }

    /// The mean of values with weights, which adds up where they do. What is seldom may bring it out of the interval of the median: the interval
    /// then goes on to it.
    pub fn about_mean(values: &[(f64, f64)]) -> Self {
        let total: f64 = values.iter().map(|(_, weight)| weight).sum();
        let middle = values.iter().map(|(x, weight)| x * weight).sum::<f64>() / total;
        let [low, high] = Self::about_median(values).interval;
        Self { middle, interval: [low.min(middle), high.max(middle)] }
    }
}

/// The flow in a circle with all of its feeders and without one of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Collateral {
    /// The feeder that is closed.
    pub occluded: Artery,
    /// For each segment of [`RING`] |Q| before and after, m³/s; `None` where it is missing.
    pub segments: [Option<[f64; 2]>; 7],
    /// The same for each territory of [`TERRITORIES`].
    pub territories: [Option<[f64; 2]>; 6],
    /// The communicating artery whose flow grows most, if any grows.
    pub takes_over: Option<Artery>,
}

impl Collateral {
    /// For each territory the share of its flow that is left; `None` where it had no flow before, or is not seen.
    pub fn residual(&self) -> [Option<f64>; 6] {
        self.territories.map(|flows| flows.filter(|[before, _]| *before > 0.0).map(|[before, after]| after / before))
    }
}

/// Closes each feeder in turn, in the topology of the vessels that `kept` selects. `viscosity` in Pa s. The circle must have been found
/// in `network`.
///
/// # Errors
///
/// Those of [`simulate`], usually that blood cannot flow through the network.
pub fn collaterals(
    circle: &Circle,
    network: &Network,
    kept: impl Fn(usize) -> bool,
    boundary: &Boundary,
    viscosity: f64,
) -> Result<Vec<Collateral>> {
    let (network, arteries) = &circle.arteries_in(network, kept);
    let mut found = Vec::new();
    for (occluded, vessels) in FEEDERS.into_iter().zip(&arteries.feeders) {
        if vessels.is_empty() {
            continue;
        }
        let close = |vessel: &usize| Perturbation { vessel: *vessel, change: Change::Occlusion };
        let simulation = simulate(network, boundary, viscosity, &vessels.iter().map(close).collect::<Vec<_>>())?;
        let Some(after) = &simulation.perturbed else { continue };
        let before = &simulation.unperturbed;
        // The flow in an artery is largest where it begins, before branches leave.
        let most = |state: &State, rows: &[usize]| rows.iter().map(|row| state.vessels[*row].flow.abs()).fold(0.0, f64::max);
        let both = |rows: &Vec<usize>| (!rows.is_empty()).then(|| [most(before, rows), most(after, rows)]);
        let segments = arteries.segments.each_ref().map(both);
        let cut = rounding(before, after);
        let gains = RING.into_iter().zip(&segments).filter_map(|(artery, flows)| {
            let communicates = matches!(artery, Artery::AComm | Artery::PComm(_));
            flows.filter(|_| communicates).map(|[before, after]| (artery, after - before)).filter(|(_, gain)| *gain > cut)
        });
        let takes_over = gains.max_by(|a, b| (a.1 as f32).total_cmp(&(b.1 as f32)).then(b.0.cmp(&a.0))).map(|(artery, _)| artery);
        found.push(Collateral { occluded, segments, territories: arteries.territories.each_ref().map(both), takes_over });
    }
    Ok(found)
}
