//! Forward simulation: the flow in a network, and the flow after vessels are narrowed, occluded or lengthened; and what each closed vessel
//! does: the flow again without each vessel in turn.

pub mod pulse;
pub mod transport;

use crate::error::{Error, Result, require};
use crate::flow::{BatchSolver, Boundary, Circuit, Factors, Tube, check_viscosity, drives_flow, state::State};
use crate::network::{Network, Role, millimetres};
use crate::{perturbation::Stenosis, support::in_order, support::ties::largest_first};

/// How the names of columns of the perturbed network end.
pub const PERTURBED: &str = "_perturbed";

/// How a vessel is changed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Change {
    /// It is narrowed.
    Stenosis(Stenosis),
    /// It is closed: R is infinite, and it no longer counts among the vessels present in ρ_G.
    Occlusion,
    /// It is lengthened by this factor, at least 1: R and the volume of the lumen are multiplied by it.
    Tortuosity(f64),
}

/// A change of one vessel. A stenosis over a stretch keeps its length when the vessel is also lengthened. An occluded vessel is closed
/// whatever other changes it has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Perturbation {
    /// The vessel's row.
    pub vessel: usize,
    /// Its change.
    pub change: Change,
}

/// Something of a network before and after the changes.
#[derive(Debug, Clone, PartialEq)]
pub struct BothStates<T> {
    /// Of the network without changes.
    pub unperturbed: T,
    /// Of the network with all its perturbations; `None` without any.
    pub perturbed: Option<T>,
}

/// The flow before and after the changes.
pub type Simulation = BothStates<State>;

impl<T> BothStates<T> {
    /// Each state with how the names of its columns end.
    pub fn states(&self) -> impl Iterator<Item = (&T, &'static str)> {
        std::iter::once((&self.unperturbed, "")).chain(self.perturbed.iter().map(|state| (state, PERTURBED)))
    }
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

/// Solves a network without and with all `perturbations` together. `viscosity` in Pa s.
///
/// # Errors
///
/// A viscosity that is not positive; boundary conditions that drive no flow; a perturbation out of its range, or two of a kind on one
/// vessel; a conductance that no double can hold; a breakdown of the solver.
pub fn simulate(network: &Network, boundary: &Boundary, viscosity: f64, perturbations: &[Perturbation]) -> Result<Simulation> {
    check_viscosity(viscosity)?;
    let at_rest = Tube::at_rest(network, viscosity);
    let changed = perturbed(network, &at_rest, perturbations)?;
    drives_flow(network, boundary)?;
    let solve = |tubes: &[Tube]| State::solve(network, boundary, tubes, viscosity);
    let unperturbed = solve(&at_rest)?;
    let perturbed = if perturbations.is_empty() { None } else { Some(solve(&changed)?) };
    Ok(Simulation { unperturbed, perturbed })
}

/// The vessels `at_rest` with the perturbations.
///
/// # Errors
///
/// A perturbation out of its range, or two of a kind on one vessel.
pub fn perturbed(network: &Network, at_rest: &[Tube], perturbations: &[Perturbation]) -> Result<Vec<Tube>> {
    let mut tubes = at_rest.to_vec();
    let mut lengths: Vec<f64> = network.vessels().map(|(_, vessel)| vessel.length).collect();
    for (at, Perturbation { vessel, change }) in perturbations.iter().enumerate() {
        let same = |p: &&Perturbation| p.vessel == *vessel && p.change.field() == change.field();
        let accepted = "is given twice; expected one perturbation of a kind on a vessel";
        require(!perturbations[..at].iter().any(|p| same(&p)), change.field(), network.vessel_name(*vessel), accepted)?;
        if let Change::Tortuosity(factor) = change {
            let accepted = "expected a factor of length of at least 1";
            require(factor.is_finite() && *factor >= 1.0, "tortuosity", factor, accepted)?;
            lengths[*vessel] *= factor;
            let longer = Factors { resistance: *factor, volume: *factor, length: *factor, ..Factors::ONE };
            tubes[*vessel] = tubes[*vessel].times(&longer);
        }
    }
    for Perturbation { vessel, change } in perturbations {
        let tube = &mut tubes[*vessel];
        match change {
            Change::Tortuosity(_) => {}
            Change::Occlusion => tube.resistance = f64::INFINITY,
            Change::Stenosis(stenosis) => {
                let (open, length) = (stenosis.open_diameter, lengths[*vessel]);
                let reduction = format!("{}%", 100.0 * (1.0 - open));
                let accepted = "expected a reduction from 0% to below 100%; 100% is an occlusion";
                require(open > 0.0 && open <= 1.0, "stenosis", reduction, accepted)?;
                if let Some(stretch) = stenosis.stretch.filter(|stretch| !(*stretch > 0.0 && *stretch <= length)) {
                    let found = format!("over {} mm of {}", millimetres(stretch), network.vessel_name(*vessel));
                    let accepted = format!("expected a positive length of at most the vessel's, {} mm", millimetres(length));
                    return Err(Error::parameter("stenosis", found, accepted));
                }
                *tube = tube.times(&stenosis.factors(length));
            }
        }
    }
    Ok(tubes)
}

/// Flows and gains up to this share of the total inflow count as rounding.
const ROUNDING: f64 = 1e-9;

/// The flow (m³/s) up to which flows and gains between two states count as rounding.
pub fn rounding(before: &State, after: &State) -> f64 {
    ROUNDING * before.inflow.max(after.inflow)
}

/// The flow before and after in a vessel that is not perturbed itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FlowChange {
    /// The vessel's row.
    pub vessel: usize,
    /// Q before, m³/s.
    pub before: f64,
    /// Q after, m³/s.
    pub after: f64,
}

impl FlowChange {
    /// The gain of flow, |Q after| - |Q before|, m³/s.
    pub fn gain(&self) -> f64 {
        self.after.abs() - self.before.abs()
    }

    /// Whether the flow changed its direction.
    pub fn is_reversed(&self) -> bool {
        self.before * self.after < 0.0
    }
}

/// The vessels that gain flow, |Q after| > |Q before|, without being perturbed themselves; the largest gain first.
pub fn gains(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<FlowChange> {
    let cut = rounding(before, after);
    largest_first(untouched(before, after, perturbations).filter(|c| c.gain() > cut), FlowChange::gain)
}

/// The vessels whose flow changes its direction without being perturbed themselves; the largest flow after it first.
pub fn reversals(before: &State, after: &State, perturbations: &[Perturbation]) -> Vec<FlowChange> {
    let cut = rounding(before, after);
    let turned = |c: &FlowChange| c.is_reversed() && c.before.abs() > cut && c.after.abs() > cut;
    largest_first(untouched(before, after, perturbations).filter(turned), |c| c.after.abs())
}

fn untouched(before: &State, after: &State, perturbations: &[Perturbation]) -> impl Iterator<Item = FlowChange> {
    let pairs = before.vessels.iter().zip(&after.vessels).enumerate();
    let others = pairs.filter(|(row, _)| perturbations.iter().all(|p| p.vessel != *row));
    others.map(|(vessel, (b, a))| FlowChange { vessel, before: b.flow, after: a.flow })
}

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
    // Compiled once: a closed vessel is a row that is not open.
    let circuit = Circuit::new(network, boundary, viscosity)?;
    let solver = BatchSolver::for_few(&circuit)?;
    let outlets: Vec<usize> = (0..network.node_count()).filter(|node| boundary.roles[*node] == Role::Outlet).collect();
    let had = delivered(network, before, &outlets);
    let all: f64 = had.iter().sum();
    let rows: Vec<usize> = (0..network.vessel_count()).collect();
    let close = |_: usize, vessel: &usize| {
        let closed = [Perturbation { vessel: *vessel, change: Change::Occlusion }];
        let mut tubes = at_rest.clone();
        tubes[*vessel].resistance = f64::INFINITY;
        let above_level = solver.above_level(&circuit, |row| tubes[row].is_open())?;
        let after = State::at_pressures(&circuit, boundary, &tubes, viscosity, &above_level, Some(&solver));
        let cut = rounding(before, &after);
        let both = outlets.iter().zip(&had).zip(delivered(network, &after, &outlets));
        let pairs: Vec<(usize, f64, f64)> = both.map(|((node, before), after)| (*node, *before, after)).collect();
        let fed = || pairs.iter().filter(|(_, before, _)| *before > cut);
        let less = pairs.iter().map(|(_, before, after)| before - after).filter(|less| *less > cut);
        let lost = less.fold(0.0, |sum: f64, less| sum + less);
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
