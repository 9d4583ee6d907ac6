//! The functional phenotype: what a circle makes of the loss of a feeder, the paper's controlled perturbation at its inlets.

use super::arteries::{Artery, RING, Side};
use super::circle::Circle;
use crate::error::Result;
use crate::flow::Boundary;
use crate::flow::state::State;
use crate::network::Network;
use crate::simulation::{Change, Perturbation, rounding, simulate};

/// The arteries that feed a circle: closed one at a time.
pub const FEEDERS: [Artery; 3] = [Artery::Ica(Side::Left), Artery::Ica(Side::Right), Artery::Ba];

/// The territories of the brain, by the arteries that lead to them.
pub const TERRITORIES: [Artery; 6] = [
    Artery::A2(Side::Left),
    Artery::A2(Side::Right),
    Artery::M1(Side::Left),
    Artery::M1(Side::Right),
    Artery::P2(Side::Left),
    Artery::P2(Side::Right),
];

/// Which vessels the arteries of a circle are: rows of its network.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Courses {
    /// Per feeder of [`FEEDERS`] the vessels by which it comes in.
    pub feeders: [Vec<usize>; 3],
    /// Per segment of [`RING`] vessels along it; none where it is missing.
    pub segments: [Vec<usize>; 7],
    /// Per territory of [`TERRITORIES`] vessels that lead to it; none where it is not seen.
    pub territories: [Vec<usize>; 6],
}

/// The flow in a circle without one of its feeders, beside that with all of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Collateral {
    /// The feeder that is closed.
    pub occluded: Artery,
    /// Per segment of [`RING`] Q before and after, m³/s, whatever its direction; `None` where it is missing.
    pub segments: [Option<[f64; 2]>; 7],
    /// Per territory of [`TERRITORIES`] the same.
    pub territories: [Option<[f64; 2]>; 6],
    /// The communicating artery whose flow grows most, where one grows at all.
    pub takes_over: Option<Artery>,
}

impl Collateral {
    /// Per territory the share of its flow that is left; `None` where none came before, or it is not seen.
    pub fn residual(&self) -> [Option<f64>; 6] {
        self.territories.map(|flows| flows.filter(|[before, _]| *before > 0.0).map(|[before, after]| after / before))
    }
}

/// Closes each feeder that is there in turn, in the topology of the vessels that `kept` admits. `viscosity` in Pa s; the circle must
/// have been found in `network`.
///
/// # Errors
///
/// As [`simulate`]: above all a network that blood cannot flow through.
pub fn collaterals(
    circle: &Circle,
    network: &Network,
    kept: impl Fn(usize) -> bool,
    boundary: &Boundary,
    viscosity: f64,
) -> Result<Vec<Collateral>> {
    let (network, rows) = &network.subgraph(kept);
    let courses = circle.in_part(rows).courses(network);
    let mut found = Vec::new();
    for (occluded, vessels) in FEEDERS.into_iter().zip(&courses.feeders) {
        if vessels.is_empty() {
            continue;
        }
        let close = |vessel: &usize| Perturbation { vessel: *vessel, change: Change::Occlusion };
        let simulation = simulate(network, boundary, viscosity, &vessels.iter().map(close).collect::<Vec<_>>())?;
        let Some(after) = &simulation.perturbed else { continue };
        let before = &simulation.unperturbed;
        // Along an artery most blood flows where it begins, before branches leave.
        let most = |state: &State, rows: &[usize]| rows.iter().map(|row| state.vessels[*row].flow.abs()).fold(0.0, f64::max);
        let both = |rows: &Vec<usize>| (!rows.is_empty()).then(|| [most(before, rows), most(after, rows)]);
        let segments = courses.segments.each_ref().map(both);
        let cut = rounding(before, after);
        let gains = RING.into_iter().zip(&segments).filter_map(|(artery, flows)| {
            let communicates = matches!(artery, Artery::AComm | Artery::PComm(_));
            flows.filter(|_| communicates).map(|[before, after]| (artery, after - before)).filter(|(_, gain)| *gain > cut)
        });
        let takes_over = gains.max_by(|a, b| (a.1 as f32).total_cmp(&(b.1 as f32)).then(b.0.cmp(&a.0))).map(|(artery, _)| artery);
        found.push(Collateral { occluded, segments, territories: courses.territories.each_ref().map(both), takes_over });
    }
    Ok(found)
}
