//! What each closed vessel does: the flow again without each vessel in turn.

use super::{Change, FlowChange, Perturbation, gains, perturbed, reversals, rounding};
use crate::flow::{Boundary, Tube, state::State};
use crate::network::{Network, Role};
use crate::{error::Result, support::in_order};

/// What becomes of the flow without a vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedVessel {
    /// The total inflow, m³/s.
    pub inflow: f64,
    /// What outlets get less than before, all those together that do, m³/s.
    pub lost: f64,
    /// That over what all outlets got.
    pub lost_share: f64,
    /// Outlets that got blood and get none any more.
    pub unfed: usize,
    /// The node of the outlet that keeps the least share of its flow, and that share.
    pub worst: Option<(usize, f64)>,
    /// The vessel whose flow grows most.
    pub takes_over: Option<FlowChange>,
    /// Vessels whose flow turns round.
    pub reversed: usize,
    /// ρ_G, W/m³.
    pub network_resilience: f64,
}

/// Closes each vessel of a network in turn; `before` is its state with all open. `viscosity` in Pa s.
///
/// # Errors
///
/// A conductance that no double can hold; a breakdown of the solver.
pub fn close_each(network: &Network, boundary: &Boundary, viscosity: f64, before: &State) -> Result<Vec<ClosedVessel>> {
    let at_rest = Tube::at_rest(network, viscosity);
    let outlets: Vec<usize> = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Outlet).collect();
    let had = delivered(network, before, &outlets);
    let all: f64 = had.iter().sum();
    let rows: Vec<usize> = (0..network.vessel_count()).collect();
    let close = |_: usize, vessel: &usize| {
        let closed = [Perturbation { vessel: *vessel, change: Change::Occlusion }];
        let after = State::solve(network, boundary, &perturbed(network, &at_rest, &closed)?, viscosity)?;
        let cut = rounding(before, &after);
        let both = outlets.iter().zip(&had).zip(delivered(network, &after, &outlets));
        let pairs: Vec<(usize, f64, f64)> = both.map(|((node, before), after)| (*node, *before, after)).collect();
        let fed = || pairs.iter().filter(|(_, before, _)| *before > cut);
        let lost: f64 = pairs.iter().map(|(_, before, after)| before - after).filter(|less| *less > cut).sum();
        let share = |(node, before, after): &(usize, f64, f64)| (*node, if *after > cut { after / before } else { 0.0 });
        // In single precision, so that rounding does not choose between equal outlets.
        let worst = fed().map(share).min_by(|a, b| (a.1 as f32).total_cmp(&(b.1 as f32)));
        Ok(ClosedVessel {
            inflow: after.inflow,
            lost,
            lost_share: if all > 0.0 { lost / all } else { f64::NAN },
            unfed: fed().filter(|(_, _, after)| *after <= cut).count(),
            worst: worst.filter(|_| lost > 0.0),
            takes_over: gains(before, &after, &closed).first().copied(),
            reversed: reversals(before, &after, &closed).len(),
            network_resilience: after.network_resilience,
        })
    };
    in_order(&rows, close).into_iter().collect()
}

/// What leaves through each outlet, m³/s; nothing where blood comes in.
fn delivered(network: &Network, state: &State, outlets: &[usize]) -> Vec<f64> {
    let mut arrives = vec![0.0; network.node_count()];
    for (([a, b], _), vessel) in network.vessels().zip(&state.vessels) {
        arrives[a] -= vessel.flow;
        arrives[b] += vessel.flow;
    }
    outlets.iter().map(|node| f64::max(arrives[*node], 0.0)).collect()
}
