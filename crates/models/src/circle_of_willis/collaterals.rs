//! The functional phenotype: how a circle compensates the loss of a feeder, the paper's controlled perturbation at its inlets.

use super::arteries::{Artery, FEEDERS, RING};
use super::circle::Circle;
use willis_core::error::Result;
use willis_core::flow::Boundary;
use willis_core::flow::state::State;
use willis_core::network::Network;
use willis_core::simulation::{Change, Perturbation, rounding, simulate};

/// The flow in a circle with all of its feeders and without one of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Collateral {
    /// The feeder that is closed.
    pub occluded: Artery,
    /// For each segment of [`RING`] |Q| before and after, m³/s; `None` where it is missing.
    pub segments: [Option<[f64; 2]>; 7],
    /// The same for each territory of [`TERRITORIES`](super::TERRITORIES).
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
    let (network, rows) = &network.subgraph(kept);
    let arteries = circle.restricted_to(rows).artery_vessels(network);
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
