//! Forward simulation and resistance modulation of an input; its conditions put into a network for a solver in time.

use std::{borrow::Cow, f64::consts::PI, time::Instant};

use super::pulse::{Waves, fluid, law};
use super::{BoundaryOptions, FlowOptions, Follow, Input, Silent, Step, require};
use crate::{
    Change, Error, FoundOutlets, ModulationOptions, ModulationRun, Network, Result, SimulationRun, Thickness, Unfed, WallLaw,
};
use willis_core::network::{Role, Wall, Windkessel, vessels_called};
use willis_core::{
    error::ensure, flow::Boundary, flow::Tube, modulation::HypertensionByClass, simulation::Perturbation, simulation::close_each,
    simulation::pulse::terminals, simulation::pulse::walled, simulation::transport::Transports, support::limits::fits_memory,
};
use willis_io::{formats::SolverSetting, formats::tables::reader::plural};

/// Solves the flow of an input as it is, and beside it with all `changes` at once; each names its vessels, by label or `edge:ROW`.
///
/// # Errors
///
/// An option or change out of its range, a vessel that is not there, no way for blood to flow, a breakdown of the solver.
pub fn simulate<'a>(input: &'a Input, changes: &[(&str, Change)], options: &FlowOptions) -> Result<SimulationRun<'a>> {
    simulate_with(input, changes, options, &mut Silent)
}

/// As [`simulate`], followed by `progress`.
///
/// # Errors
///
/// As [`simulate`].
pub fn simulate_with<'a>(
    input: &'a Input,
    changes: &[(&str, Change)],
    options: &FlowOptions,
    progress: &mut dyn Follow,
) -> Result<SimulationRun<'a>> {
    options.validate()?;
    let solved = Solved::of(input, &options.boundary, options.unfed, progress)?;
    let network = &*solved.network;
    let mut perturbations = Vec::new();
    for (name, change) in changes {
        let refused = |why: String| Error::parameter(change.field(), format!("\"{name}\""), why);
        for row in vessels_called(&input.network, name).map_err(refused)? {
            let stays = solved.rows.as_ref().map_or(Some(row), |rows| rows.binary_search(&row).ok());
            let left_out = || refused("no blood comes there, and `unfed=drop` left it out".to_owned());
            perturbations.push(Perturbation { vessel: stays.ok_or_else(left_out)?, change: *change });
        }
    }
    let boundary = solved.boundary.clone();
    let waves = options.pulse.as_ref().map(|pulse| Waves::load(network, &boundary, pulse, progress)).transpose()?;
    let boundary = waves.as_ref().map_or(Ok(boundary.clone()), |waves| waves.steady(&boundary))?;
    let viscosity = options.viscosity;
    let simulation = willis_core::simulation::simulate(network, &boundary, viscosity, &perturbations)?;
    if options.transport {
        check_memory(network, &boundary, simulation.states().count())?;
    }
    let transports = options.transport.then(|| Transports::of(network, &boundary, &simulation));
    let close_all = || close_each(network, &boundary, viscosity, &simulation.unperturbed);
    let closures = options.occlude_each.then(close_all).transpose()?;
    let driven = waves.as_ref().zip(options.pulse.as_ref());
    let solve = |(waves, pulse): (&Waves, _)| waves.solve(network, &boundary, (pulse, options), &perturbations, &simulation);
    let pulses = driven.map(solve).transpose()?;
    let Solved { network, outlets, provenance, .. } = solved;
    Ok(SimulationRun {
        network,
        boundary,
        outlets,
        provenance,
        radius_rule: input.options.radius_rule,
        perturbations,
        result: simulation,
        viscosity,
        transports,
        closures,
        pulses,
    })
}

/// Refuses to follow the blood of more inlets than there is memory for: each has a share and a time at every node, and a row for every vessel and
/// outlet in territories.csv.
fn check_memory(network: &Network, boundary: &Boundary, states: usize) -> Result<()> {
    /// Bytes of a row in memory, and what each state adds.
    const ROW: [usize; 2] = [80, 24];
    let rows = network.vessel_count() + boundary.count(Role::Outlet);
    let each = (rows * ROW[0] + states * (rows * ROW[1] + 16 * network.node_count())) as f64;
    let inlets = boundary.count(Role::Inlet);
    fits_memory("transport", format!("of {inlets} inlets"), each * inlets as f64, |left| left / each)
}

/// What flow is solved for: the vessels of an input, or those that inlets feed, with their conditions.
#[derive(Debug)]
pub(super) struct Solved<'a> {
    pub(super) network: Cow<'a, Network>,
    pub(super) boundary: Boundary,
    outlets: FoundOutlets,
    /// The rows that its vessels have in the input, where some are left out.
    rows: Option<Vec<usize>>,
    provenance: Cow<'a, willis_report::Provenance>,
}

impl<'a> Solved<'a> {
    pub(super) fn of(input: &'a Input, options: &BoundaryOptions, unfed: Unfed, progress: &mut dyn Follow) -> Result<Self> {
        input.network.validate()?;
        // The boundary conditions of a network whose vessels are taken as they are, found as infer finds them.
        let outlets = options.found_outlets.unwrap_or_else(|| input.usual_outlets());
        let given = options.given(&input.network, progress)?;
        let boundary = Boundary::resolve_knowing(&input.network, &given, outlets, &input.inlets_by_labels())?;
        // Every vessel is there, and a condition that was found holds at a free end only.
        let boundary = boundary.held(&input.network, |_| true);
        if options.found_outlets.is_some() && boundary.found_outlets.is_empty() {
            progress.step(Step::OutletsAllStated);
        }
        progress.step(Step::Boundary { graph: &input.network, boundary: &boundary });
        let (network, provenance) = (Cow::Borrowed(&input.network), Cow::Borrowed(&input.provenance));
        let whole = Self { network, boundary, outlets, rows: None, provenance };
        let part = if unfed == Unfed::Drop { whole.boundary.fed_part(&input.network) } else { None };
        let Some((part, boundary, rows)) = part else { return Ok(whole) };
        let left_out = input.network.vessel_count() - rows.len();
        let note = format!("{} that no inlet feeds, left out; rows are those that stay", plural(left_out, "vessel"));
        progress.step(Step::Note(&note));
        let mut provenance = input.provenance.clone();
        provenance.notes.push(note);
        Ok(Self { network: Cow::Owned(part), boundary, rows: Some(rows), provenance: Cow::Owned(provenance), ..whole })
    }
}

/// Modulates the resistances of an input's vessels at random. `threshold` (Pa/m²) is where hypertension becomes a risk; by default a
/// twentieth of the unperturbed vessels lies above it.
///
/// # Errors
///
/// An option out of its range, no way for blood to flow, a breakdown of the solver.
pub fn modulate<'a>(
    input: &'a Input,
    boundary: &BoundaryOptions,
    options: &ModulationOptions,
    threshold: Option<f64>,
) -> Result<ModulationRun<'a>> {
    modulate_with(input, boundary, options, threshold, &mut Silent)
}

/// As [`modulate`], followed by `progress`, which may stop it.
///
/// # Errors
///
/// As [`modulate`], or [`Error::Stopped`].
pub fn modulate_with<'a>(
    input: &'a Input,
    boundary: &BoundaryOptions,
    options: &ModulationOptions,
    threshold: Option<f64>,
    progress: &mut dyn Follow,
) -> Result<ModulationRun<'a>> {
    options.validate()?;
    let (chosen, all) = (options.vessels.as_ref().map(Vec::len), input.network.vessel_count());
    let accepted = format!("expected one for each of {all} vessels");
    require(chosen.is_none_or(|chosen| chosen == all), "vessels", chosen.unwrap_or_default(), accepted)?;
    let limit = threshold.unwrap_or(1.0);
    require(limit.is_normal() && limit > 0.0, "threshold", limit, "expected a positive number of Pa/m2")?;
    let solved = Solved::of(input, boundary, options.unfed, progress)?;
    let mut options = options.clone();
    if let (Some(rows), Some(vessels)) = (&solved.rows, &mut options.vessels) {
        *vessels = rows.iter().map(|row| vessels[*row]).collect();
    }
    let begun = Instant::now();
    let modulation = willis_core::modulation::modulate(&solved.network, &solved.boundary, &options, progress)?;
    let hypertension = HypertensionByClass::of(&modulation, threshold);
    let seconds = begun.elapsed().as_secs_f64();
    let Solved { network, boundary, outlets, provenance, .. } = solved;
    Ok(ModulationRun { network, boundary, outlets, provenance, params: options, result: modulation, hypertension, seconds })
}

/// The network of an input with the conditions that [`simulate`] would give it, for a solver in time: at its ends the Windkessels,
/// in its vessels the walls, and beside it the courses of inlets and the blood. Vessels that no blood enters stay.
///
/// # Errors
///
/// As [`simulate`] of the same options; rigid walls.
pub fn solver_model(input: &Input, options: &FlowOptions, progress: &mut dyn Follow) -> Result<(Network, SolverSetting)> {
    options.validate()?;
    let Solved { network, mut boundary, .. } = Solved::of(input, &options.boundary, Unfed::Keep, progress)?;
    let mut setting = SolverSetting { viscosity: options.viscosity, ..SolverSetting::default() };
    let mut windkessels = options.boundary.windkessels(&network)?;
    let mut walls: Vec<Option<Wall>> = network.vessels().map(|(_, vessel)| vessel.wall).collect();
    if let Some(pulse) = &options.pulse {
        let gives = pulse.wall != Some(WallLaw::Rigid);
        ensure(gives, || Error::parameter("wall", "rigid", "expected walls that give, as a solver in time needs"))?;
        let waves = Waves::load(&network, &boundary, pulse, progress)?;
        boundary = waves.steady(&boundary)?;
        let steady = willis_core::simulation::simulate(&network, &boundary, options.viscosity, &[])?.unperturbed;
        (setting.period, setting.courses, setting.density) = (waves.period, waves.courses(&network, &steady), pulse.density);
        let (fluid, law) = (fluid(pulse, options.viscosity), law(pulse, &network));
        let vessels = walled(&network, &Tube::at_rest(&network, options.viscosity), &[], &law, &fluid)?;
        for (node, found) in
            terminals(&network, &boundary, &windkessels, &vessels, &fluid, pulse.time_constant).into_iter().enumerate()
        {
            if let Some(found) = found.filter(|found| found.compliance > 0.0) {
                windkessels[node] = Windkessel { proximal: Some(found.proximal), compliance: Some(found.compliance) };
            }
        }
        for (row, (_, vessel)) in network.vessels().enumerate() {
            let radius = vessel.radius;
            let compliance = law.compliance(radius, vessel.wall, pulse.density, &network.vessel_name(row))?;
            walls[row] = match law {
                WallLaw::Stated => vessel.wall,
                WallLaw::Elastic { young, thickness: Thickness::Length(thickness) } => Some(Wall::Elastic { young, thickness }),
                WallLaw::Elastic { young, thickness: Thickness::OfRadius(share) } => {
                    Some(Wall::Elastic { young, thickness: share * radius })
                }
                // The speed that gives this compliance.
                _ => Some(Wall::Speed((PI * radius * radius / (pulse.density * compliance)).sqrt())),
            };
        }
    }
    let mut model = boundary.stated_in(network.into_owned());
    (0..model.node_count()).for_each(|node| model.node_mut(node).windkessel = windkessels[node].stated());
    (0..model.vessel_count()).for_each(|row| model.vessel_mut(row).wall = walls[row]);
    Ok((model, setting))
}
