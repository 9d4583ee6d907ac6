//! Forward simulation: the flow in a network as it is, and beside it with vessels narrowed, occluded or lengthened.

mod flow_changes;

pub use flow_changes::{FlowChange, gains, reversals, rounding};

use crate::error::{Error, Result};
use crate::flow::floating::drives_flow;
use crate::flow::poiseuille::check_viscosity;
use crate::flow::state::State;
use crate::flow::{Boundary, Factors, Tube};
use crate::network::Network;
use crate::network::units::millimetres;
use crate::perturbation::stenosis::Stenosis;

/// What is done to a vessel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// It is narrowed.
    Stenosis(Stenosis),
    /// It is closed: R is infinite, and it no longer counts among the vessels present in ρ_G.
    Occlusion,
    /// It is lengthened by this factor, at least 1: R and the volume of the lumen are multiplied by it.
    Tortuosity(f64),
}

/// A change of one vessel. A stretch of stenosis keeps its length in a vessel that is lengthened too; a vessel that is
/// occluded is closed whatever else is done to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// The vessel's row.
    pub vessel: usize,
    /// What is done to it.
    pub change: Change,
}

/// The flow before and after.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// The network as it is.
    pub unperturbed: State,
    /// The network with all its perturbations; `None` without any.
    pub perturbed: Option<State>,
}

impl Change {
    /// The name of the change, as errors say it.
    pub fn field(&self) -> &'static str {
        match self {
            Self::Stenosis(_) => "stenosis",
            Self::Occlusion => "occlude",
            Self::Tortuosity(_) => "tortuosity",
        }
    }
}

/// Solves a network as it is, and with all `perturbations` at once. `viscosity` in Pa s.
///
/// # Errors
///
/// A viscosity that is not positive; no two boundary conditions between which blood could flow; a perturbation that is out of
/// its range or comes twice on one vessel; a vessel whose conductance no double can hold; a breakdown of the solver.
pub fn simulate(network: &Network, boundary: &Boundary, viscosity: f64, perturbations: &[Perturbation]) -> Result<Simulation> {
    check_viscosity(viscosity)?;
    let at_rest = Tube::at_rest(network, viscosity);
    let changed = perturbed(network, &at_rest, perturbations)?;
    drives_flow(network, boundary)?;
    let solve = |tubes: &[Tube]| State::solve(network, boundary, tubes, viscosity);
    Ok(Simulation {
        unperturbed: solve(&at_rest)?,
        perturbed: if perturbations.is_empty() { None } else { Some(solve(&changed)?) },
    })
}

/// The vessels `at_rest` with the perturbations.
///
/// # Errors
///
/// A perturbation that is out of its range, or comes twice on one vessel.
pub fn perturbed(network: &Network, at_rest: &[Tube], perturbations: &[Perturbation]) -> Result<Vec<Tube>> {
    let mut tubes = at_rest.to_vec();
    let mut lengths: Vec<f64> = network.vessels().map(|(_, vessel)| vessel.length).collect();
    for (at, Perturbation { vessel, change }) in perturbations.iter().enumerate() {
        let same = |p: &&Perturbation| p.vessel == *vessel && p.change.field() == change.field();
        if perturbations[..at].iter().any(|p| same(&p)) {
            let accepted = "is given twice; expected one perturbation of a kind on a vessel";
            return Err(Error::parameter(change.field(), network.vessel_name(*vessel), accepted));
        }
        if let Change::Tortuosity(factor) = change {
            if !(factor.is_finite() && *factor >= 1.0) {
                return Err(Error::parameter("tortuosity", factor, "expected a factor of length of at least 1"));
            }
            lengths[*vessel] *= factor;
            tubes[*vessel] = tubes[*vessel].times(&Factors::of_length(*factor));
        }
    }
    for Perturbation { vessel, change } in perturbations {
        let tube = &mut tubes[*vessel];
        match change {
            Change::Tortuosity(_) => {}
            Change::Occlusion => tube.resistance = f64::INFINITY,
            Change::Stenosis(stenosis) => {
                check(network, *vessel, stenosis, lengths[*vessel])?;
                *tube = tube.times(&stenosis.factors(lengths[*vessel]));
            }
        }
    }
    Ok(tubes)
}

fn check(network: &Network, vessel: usize, stenosis: &Stenosis, length: f64) -> Result<()> {
    let open = stenosis.open_diameter;
    if !(open > 0.0 && open <= 1.0) {
        let reduction = format!("{}%", 100.0 * (1.0 - open));
        return Err(Error::parameter("stenosis", reduction, "expected a reduction from 0% to below 100%; see --occlude"));
    }
    match stenosis.stretch {
        Some(stretch) if !(stretch > 0.0 && stretch <= length) => Err(Error::parameter(
            "stenosis",
            format!("over {} mm of {}", millimetres(stretch), network.vessel_name(vessel)),
            format!("expected a positive length of at most the vessel's, {} mm", millimetres(length)),
        )),
        _ => Ok(()),
    }
}
