//! Forward simulation and resistance modulation of an input, and the folders that hold them.

use std::borrow::Cow;
use std::path::Path;
use std::time::Instant;

use serde_json::{Value, json};

use super::pulse::Waves;
use super::{BoundaryOptions, FlowOptions, Follow, Input, SaveOptions, Silent, Step};
use willis_core::error::{Error, Result};
use willis_core::flow::{Boundary, FoundOutlets, Unfed};
use willis_core::modulation::{HypertensionByClass, Modulation, ModulationOptions};
use willis_core::network::{Network, vessels_called};
use willis_core::simulation::closures::{ClosedVessel, close_each};
use willis_core::simulation::pulse::Pulses;
use willis_core::simulation::transport::Transports;
use willis_core::simulation::{Change, Perturbation, Simulation};
use willis_io::formats::tables::reader::plural;
use willis_io::formats::{Column, NamedArray};
use willis_io::output::atomic::StagedFolder;
use willis_report::{
    ModulationOutcome, Provenance, RunRecord, Simulated, flow_record, occlusion_columns, simulated_nodes, simulated_vessels,
    territory_columns, transit_columns, waveform_arrays, write_modulation, write_simulated,
};

/// The flow in a network as it is, and beside it with vessels changed.
#[derive(Debug)]
pub struct SimulationRun<'a> {
    solved: Solved<'a>,
    perturbations: Vec<Perturbation>,
    simulation: Simulation,
    viscosity: f64,
    transports: Option<Transports>,
    closures: Option<Vec<ClosedVessel>>,
    pulses: Option<(Pulses, Value)>,
}

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
            let vessel =
                solved.row(row).ok_or_else(|| refused("no blood comes there, and `unfed=drop` left it out".to_owned()))?;
            perturbations.push(Perturbation { vessel, change: *change });
        }
    }
    let boundary = solved.boundary.clone();
    let waves = options.pulse.as_ref().map(|pulse| Waves::load(network, &boundary, pulse, progress)).transpose()?;
    let boundary = waves.as_ref().map_or(Ok(boundary.clone()), |waves| waves.steady(&boundary))?;
    let viscosity = options.viscosity;
    let simulation = willis_core::simulation::simulate(network, &boundary, viscosity, &perturbations)?;
    let follow = || Transports::of(network, &boundary, viscosity, &perturbations, &simulation);
    let transports = options.transport.then(follow).transpose()?;
    let close_all = || close_each(network, &boundary, viscosity, &simulation.unperturbed);
    let closures = options.occlude_each.then(close_all).transpose()?;
    let driven = waves.as_ref().zip(options.pulse.as_ref());
    let pulses = driven
        .map(|(waves, pulse)| waves.solve(network, &boundary, (pulse, options), &perturbations, &simulation))
        .transpose()?;
    Ok(SimulationRun {
        solved: Solved { boundary, ..solved },
        perturbations,
        simulation,
        viscosity,
        transports,
        closures,
        pulses,
    })
}

/// What flow is solved for: the vessels of an input, or those that inlets feed, with their conditions.
#[derive(Debug)]
pub(super) struct Solved<'a> {
    input: &'a Input,
    pub(super) network: Cow<'a, Network>,
    pub(super) boundary: Boundary,
    outlets: FoundOutlets,
    /// The rows that its vessels have in the input, where some are left out.
    rows: Option<Vec<usize>>,
    provenance: Cow<'a, Provenance>,
}

impl<'a> Solved<'a> {
    pub(super) fn of(input: &'a Input, options: &BoundaryOptions, unfed: Unfed, progress: &mut dyn Follow) -> Result<Self> {
        let (boundary, outlets) = conditions(input, options, progress)?;
        let (network, provenance) = (Cow::Borrowed(&input.network), Cow::Borrowed(&input.provenance));
        let whole = Self { input, network, boundary, outlets, rows: None, provenance };
        let part = if unfed == Unfed::Drop { whole.boundary.fed_part(&input.network) } else { None };
        let Some((part, boundary, rows)) = part else { return Ok(whole) };
        let left_out = input.network.vessel_count() - rows.len();
        let note = format!("{} that no inlet feeds, left out; rows are those that stay", plural(left_out, "vessel"));
        progress.step(Step::Note(&note));
        let mut provenance = input.provenance.clone();
        provenance.notes.push(note);
        Ok(Self { network: Cow::Owned(part), boundary, rows: Some(rows), provenance: Cow::Owned(provenance), ..whole })
    }

    /// The row of a vessel of the input, if it stays.
    fn row(&self, row: usize) -> Option<usize> {
        self.rows.as_ref().map_or(Some(row), |rows| rows.binary_search(&row).ok())
    }
}

/// The boundary conditions of a network whose vessels are taken as they are, found as infer finds them.
fn conditions(input: &Input, options: &BoundaryOptions, progress: &mut dyn Follow) -> Result<(Boundary, FoundOutlets)> {
    let outlets = options.found_outlets.unwrap_or_else(|| input.usual_outlets());
    // Every vessel is there, and a condition that was found holds at a free end only.
    let boundary = options.resolve(&input.network, outlets, &input.inlets_by_labels(), progress)?.held(&input.network, |_| true);
    if options.found_outlets.is_some() && boundary.found_outlets.is_empty() {
        progress.step(Step::OutletsAllStated);
    }
    progress.step(Step::Boundary { graph: &input.network, boundary: &boundary });
    Ok((boundary, outlets))
}

impl SimulationRun<'_> {
    /// Pressures, flows and resilience, before and after.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// Everything that the files of the run are made of.
    pub fn simulated(&self) -> Simulated<'_> {
        let Self { solved, perturbations, simulation, viscosity, transports, closures, pulses } = self;
        let (viscosity, transports, pulses) = (*viscosity, transports.as_ref(), pulses.as_ref());
        Simulated {
            network: &solved.network,
            boundary: &solved.boundary,
            perturbations,
            result: simulation,
            viscosity,
            transports,
            closures: closures.as_deref(),
            pulses,
        }
    }

    /// The tables of nodes and of vessels, as nodes.csv and edges.csv have them.
    pub fn tables(&self) -> [Vec<Column>; 2] {
        let simulated = self.simulated();
        [simulated_nodes(&simulated), simulated_vessels(&simulated)]
    }

    /// The tables of who feeds what and when blood arrives, as territories.csv and transit.csv have them, if that was asked for.
    pub fn transport_tables(&self) -> Option<[Vec<Column>; 2]> {
        let (simulated, transports) = (self.simulated(), self.transports.as_ref()?);
        Some([territory_columns(&simulated, transports), transit_columns(&simulated, transports)])
    }

    /// What each closed vessel does, as occlusions.csv has it, if that was asked for.
    pub fn occlusion_table(&self) -> Option<Vec<Column>> {
        Some(occlusion_columns(&self.simulated(), self.closures.as_ref()?))
    }

    /// Pressures and flows over a cycle, as waveforms.npz has them, if the flow pulsates.
    pub fn waveforms(&self) -> Option<Vec<NamedArray>> {
        let (pulses, _) = self.pulses.as_ref()?;
        Some(waveform_arrays(&self.simulated(), pulses))
    }

    /// The record of the run.
    pub fn record(&self) -> RunRecord {
        let Solved { input, provenance, outlets, .. } = &self.solved;
        flow_record(&self.simulated(), provenance, input.options.radius_rule, *outlets)
    }

    /// Saves every file in a new folder, which appears whole or not at all; an earlier run's is replaced with `force`. Returns what a
    /// person should know about files left out.
    ///
    /// # Errors
    ///
    /// The folder exists, or cannot be written.
    pub fn save(&self, folder: &Path, force: bool, options: &SaveOptions) -> Result<Vec<String>> {
        options.validate()?;
        let staged = StagedFolder::new(folder, force)?;
        let notes = write_simulated(&staged.path(), &self.simulated(), &self.record(), options.dpi)?;
        staged.commit()?;
        Ok(notes)
    }
}

/// How a network responds to resistances that vary at random.
#[derive(Debug)]
pub struct ModulationRun<'a> {
    solved: Solved<'a>,
    options: ModulationOptions,
    modulation: Modulation,
    hypertension: HypertensionByClass,
    seconds: f64,
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
    Ok(ModulationRun { solved, options, modulation, hypertension, seconds })
}

impl ModulationRun<'_> {
    /// Everything that the files of the run are made of.
    pub fn outcome(&self) -> ModulationOutcome<'_> {
        ModulationOutcome {
            network: &self.solved.network,
            boundary: &self.solved.boundary,
            outlets: self.solved.outlets,
            provenance: &self.solved.provenance,
            params: &self.options,
            result: &self.modulation,
            hypertension: &self.hypertension,
            seconds: self.seconds,
        }
    }

    /// The record of the run.
    pub fn record(&self) -> Value {
        json!(self.outcome().record())
    }

    /// Writes every file into a folder that is there, `samples.npz` with every instance where `instances` is set.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, instances: bool, options: &SaveOptions) -> Result<()> {
        options.validate()?;
        write_modulation(folder, &self.outcome(), instances, options.dpi)
    }
}
