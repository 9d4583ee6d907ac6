//! Forward simulation and resistance modulation of an input, and the folders that hold them.

use std::borrow::Cow;
use std::time::Instant;

use super::pulse::Waves;
use super::{BoundaryOptions, FlowOptions, Follow, Input, Silent, Step};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, FoundOutlets, Unfed};
use willis_core::modulation::{HypertensionByClass, ModulationOptions};
use willis_core::network::{Network, vessels_called};
use willis_core::simulation::close_each;
use willis_core::simulation::transport::Transports;
use willis_core::simulation::{Change, Perturbation};
use willis_io::formats::tables::reader::plural;
use willis_report::{ModulationRun, Provenance, SimulationRun};

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

/// What flow is solved for: the vessels of an input, or those that inlets feed, with their conditions.
#[derive(Debug)]
pub(super) struct Solved<'a> {
    pub(super) network: Cow<'a, Network>,
    pub(super) boundary: Boundary,
    outlets: FoundOutlets,
    /// The rows that its vessels have in the input, where some are left out.
    rows: Option<Vec<usize>>,
    provenance: Cow<'a, Provenance>,
}

impl<'a> Solved<'a> {
    pub(super) fn of(input: &'a Input, options: &BoundaryOptions, unfed: Unfed, progress: &mut dyn Follow) -> Result<Self> {
        // The boundary conditions of a network whose vessels are taken as they are, found as infer finds them.
        let outlets = options.found_outlets.unwrap_or_else(|| input.usual_outlets());
        let boundary = options.resolve(&input.network, outlets, &input.inlets_by_labels(), progress)?;
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
