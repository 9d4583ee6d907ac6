//! The output folder of a forward simulation: its record, tables, picture and page.

pub mod pulse;
mod simulated;
pub mod transport;

use std::path::Path;

use serde_json::{Value, json};

use super::figures::SaveOptions;
use super::figures::flow_bars::{VesselFlow, flow_bars};
use super::inference::tables::condition_columns;
use super::page::{PagePicture, simulation_page, write_page};
use super::run_record::{RunRecord, conditions, counts, outlets_found};
use pulse::{pulse_node_columns, pulse_vessel_columns, waveform_arrays, write_pulses};
use simulated::picture_names;
use transport::{territory_columns, transit_columns, transport_columns, write_transports};
use willis_core::error::Result;
use willis_core::flow::state::{LAMINAR_LIMIT, State, VesselState};
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::morphometry::{MeasureContext, network_figures};
use willis_core::network::units::{centipoise, millimetres, ml_per_min, mmhg, mmhg_s_per_ml};
use willis_core::network::{Network, Node};
use willis_core::simulation::ClosedVessel;
use willis_core::simulation::{Change, FlowChange, PERTURBED, Perturbation, Simulation, gains, reversals};
use willis_io::formats::{
    Column, END_POSITION_COLUMNS, NamedArray, vessel_columns as vessel_columns_of_graph, wall_columns, windkessel_columns,
    write_csv, write_vtp,
};
use willis_io::output::names::{EDGES, NODES, OCCLUSIONS, PAGE, TOPOLOGY};
use willis_io::output::{StagedFolder, write_file, write_record};

pub use simulated::SimulationRun;

/// How many collaterals are listed, those of the largest gain of flow.
pub const MOST_COLLATERALS: usize = 5;

impl SimulationRun<'_> {
    /// Pressures, flows and resilience, before and after.
    pub fn simulation(&self) -> &Simulation {
        &self.result
    }

    /// The tables of nodes and of vessels, as nodes.csv and edges.csv have them.
    pub fn tables(&self) -> [Vec<Column>; 2] {
        [node_columns(self), vessel_columns(self)]
    }

    /// The tables of who feeds what and when blood arrives, as territories.csv and transit.csv have them, if that was asked for.
    pub fn transport_tables(&self) -> Option<[Vec<Column>; 2]> {
        let transports = self.transports.as_ref()?;
        Some([territory_columns(self, transports), transit_columns(self, transports)])
    }

    /// What each closed vessel does, as occlusions.csv has it, if that was asked for.
    pub fn occlusion_table(&self) -> Option<Vec<Column>> {
        Some(occlusion_columns(self, self.closures.as_ref()?))
    }

    /// Pressures and flows over a cycle, as waveforms.npz has them, if the flow pulsates.
    pub fn waveforms(&self) -> Option<Vec<NamedArray>> {
        let (pulses, _) = self.pulses.as_ref()?;
        Some(waveform_arrays(self, pulses))
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
        let notes = write_simulated(&staged.path(), self, options.dpi)?;
        staged.commit()?;
        Ok(notes)
    }

    /// The record of the run.
    pub fn record(&self) -> RunRecord {
        let Self { network, boundary, outlets, provenance, result, perturbations: changes, .. } = self;
        let (before, after) = (&result.unperturbed, result.perturbed.as_ref());
        let changed = |find: fn(&State, &State, &[Perturbation]) -> Vec<FlowChange>| {
            after.map_or_else(Vec::new, |after| find(before, after, changes))
        };
        let turbulent = |state: &State| -> Vec<Value> {
            let beyond = |(row, reynolds)| json!({ "edge": row, "label": network.vessel(row).label, "reynolds": reynolds });
            state.beyond_laminar().map(beyond).collect()
        };
        let mut counts = counts(network, boundary);
        counts["diffused"] = json!(before.diffused());
        let mut not_laminar = json!({ "above_reynolds": LAMINAR_LIMIT, "vessels": turbulent(before) });
        if let Some(after) = after {
            counts["diffused_perturbed"] = json!(after.diffused());
            not_laminar["vessels_perturbed"] = json!(turbulent(after));
        }
        let parameters = json!({
            "viscosity_cP": centipoise(self.viscosity),
            "radius": self.radius_rule.name(),
            "outlets_found": outlets_found(*outlets),
            "stenosis_model": "poiseuille",
        });
        let inflow = |state: &State| json!(ml_per_min(state.inflow));
        let list = |found: &[FlowChange]| found.iter().map(|c| collateral(network, c)).collect::<Value>();
        let gained = changed(gains);
        let of_states = [
            Some(("rho_G_W_per_m3", json!(before.network_resilience))),
            after.map(|state| ("rho_G_W_per_m3_perturbed", json!(state.network_resilience))),
            Some(("total_inflow_mL_per_min", inflow(before))),
            after.map(|state| ("total_inflow_mL_per_min_perturbed", inflow(state))),
        ];
        let results = [
            ("not_laminar", not_laminar),
            ("perturbations", changes.iter().map(|p| perturbation(network, p)).collect()),
            ("collaterals", list(&gained[..gained.len().min(MOST_COLLATERALS)])),
            ("reversed", list(&changed(reversals))),
            ("murray", murray(network, boundary, *outlets)),
        ];
        let pulse = self.pulses.as_ref().map(|(_, record)| ("pulse", record.clone()));
        let fields = [("counts", counts)].into_iter().chain(of_states.into_iter().flatten()).chain(results).chain(pulse);
        let fields = fields.chain([("notes", json!(provenance.notes))]);
        RunRecord::new(provenance, [("parameters", parameters)], conditions(network, boundary, None), fields)
    }
}

/// The exponent that the radii of the network have at its bifurcations, beside the one by which outlets found have their resistance.
fn murray(network: &Network, boundary: &Boundary, outlets: FoundOutlets) -> Value {
    let figures = network_figures(network, |node| boundary.roles[node], MeasureContext::default());
    json!({
        "exponent_median": Some(figures.murray).filter(|k| k.is_finite()),
        "bifurcations": figures.bifurcations,
        "exponent_of_outlets": matches!(outlets, FoundOutlets::Murray(_)).then_some(3),
    })
}

fn perturbation(network: &Network, Perturbation { vessel, change }: &Perturbation) -> Value {
    let mut value = json!({ "edge": vessel, "label": network.vessel(*vessel).label });
    match change {
        Change::Occlusion => value["kind"] = json!("occlusion"),
        Change::Tortuosity(factor) => {
            value["kind"] = json!("tortuosity");
            value["length_factor"] = json!(factor);
        }
        Change::Stenosis(stenosis) => {
            value["kind"] = json!("stenosis");
            value["open_diameter_share"] = json!(stenosis.open_diameter);
            value["stretch_mm"] = json!(stenosis.stretch.map(millimetres));
        }
    }
    value
}

fn collateral(network: &Network, c: &FlowChange) -> Value {
    json!({
        "edge": c.vessel,
        "label": network.vessel(c.vessel).label,
        "flow_mL_per_min": ml_per_min(c.before),
        "flow_mL_per_min_perturbed": ml_per_min(c.after),
        "gain_mL_per_min": ml_per_min(c.gain()),
        "reversed": c.is_reversed(),
    })
}

/// The columns of nodes.csv.
pub fn node_columns(simulated: &SimulationRun<'_>) -> Vec<Column> {
    let (network, boundary, result) = (&*simulated.network, &simulated.boundary, &simulated.result);
    let mut columns =
        super::inference::tables::node_columns(network, boundary, &result.unperturbed.pressure, &vec![0; network.node_count()]);
    columns.retain(|column| !["radius_mm", "component"].contains(&&*column.name));
    let pressure = |state: &State| state.pressure.iter().map(|p| p.map_or(f64::NAN, mmhg)).collect::<Vec<_>>();
    let perturbed = result.perturbed.as_ref().map(|state| Column::real("pressure_mmHg_perturbed", pressure(state).into_iter()));
    columns.extend(perturbed);
    columns.extend(condition_columns(network, boundary));
    columns.extend(windkessel_columns(&network.nodes().map(Node::windkessel).collect::<Vec<_>>()));
    columns.extend(simulated.pulses.as_ref().map(|(pulses, _)| pulse_node_columns(pulses)).unwrap_or_default());
    columns
}

/// The columns of edges.csv.
pub fn vessel_columns(simulated: &SimulationRun<'_>) -> Vec<Column> {
    let (network, result) = (&*simulated.network, &simulated.result);
    let mut columns = vessel_columns_of_graph(network);
    columns.retain(|column| column.name != "origin" && !END_POSITION_COLUMNS.as_flattened().contains(&&*column.name));
    columns.extend(flow_columns(&result.unperturbed, ""));
    if let Some(perturbed) = &result.perturbed {
        columns.extend(flow_columns(perturbed, PERTURBED));
        let pairs = result.unperturbed.vessels.iter().zip(&perturbed.vessels);
        columns.push(Column::real("flow_change", pairs.map(|(before, after)| ml_per_min(after.flow) - ml_per_min(before.flow))));
    }
    columns.extend(wall_columns(network));
    columns.extend(simulated.pulses.as_ref().map(|(pulses, _)| pulse_vessel_columns(pulses)).unwrap_or_default());
    columns.extend(simulated.transports.as_ref().map(|found| transport_columns(simulated, found)).unwrap_or_default());
    columns
}

/// The columns of the flow in each vessel; `suffix` ends their names.
fn flow_columns(state: &State, suffix: &str) -> Vec<Column> {
    let figure = |name: &str, of: fn(&VesselState) -> f64| Column::real(format!("{name}{suffix}"), state.vessels.iter().map(of));
    vec![
        figure("resistance_mmHg_s_per_mL", |v| mmhg_s_per_ml(v.resistance)),
        figure("drop_mmHg", |v| mmhg(v.drop)),
        figure("flow_mL_per_min", |v| ml_per_min(v.flow)),
        figure("velocity_mm_per_s", |v| millimetres(v.velocity)),
        figure("wall_shear_Pa", |v| v.wall_shear),
        figure("reynolds", |v| v.reynolds),
        figure("resilience_W_per_m3", |v| v.resilience),
        Column::whole(format!("diffused{suffix}"), state.vessels.iter().map(|v| usize::from(v.diffused))),
    ]
}

/// Writes every file of a simulation into a folder and returns notes about files that are left out.
///
/// # Errors
///
/// A file that cannot be written.
fn write_simulated(folder: &Path, simulated: &SimulationRun<'_>, dpi: u32) -> Result<Vec<String>> {
    let mut notes = Vec::new();
    let vessels = vessel_columns(simulated);
    write_file(&folder.join(EDGES), |out| write_csv(out, &vessels))?;
    let nodes = node_columns(simulated);
    write_file(&folder.join(NODES), |out| write_csv(out, &nodes))?;
    if simulated.network.has_positions() {
        write_file(&folder.join(format!("{TOPOLOGY}.vtp")), |out| write_vtp(out, &simulated.network, &vessels))?;
    } else {
        notes.push("topology.vtp is left out: the nodes have no coordinates".to_owned());
    }
    let bars = flow_bars(&flows(simulated));
    let caption = "The flow of every vessel, and its flow in the perturbed network if there is one.";
    let mut figures = vec![PagePicture::write("Flow", caption, &bars, folder, dpi)?];
    if let Some(transports) = &simulated.transports {
        let territories = write_transports(folder, simulated, transports)?;
        let caption = "From which inlet the blood of every outlet comes, and how long ago it entered on average.";
        figures.push(PagePicture::write("Territories", caption, &territories, folder, dpi)?);
    }
    if let Some(closures) = &simulated.closures {
        let columns = occlusion_columns(simulated, closures);
        write_file(&folder.join(OCCLUSIONS), |out| write_csv(out, &columns))?;
    }
    if let Some((pulses, _)) = &simulated.pulses {
        let waveforms = write_pulses(folder, simulated, pulses)?;
        let caption = "The flow in the middle of the arteries over a cycle, before and after the perturbations if there are any.";
        figures.push(PagePicture::write("Waveforms", caption, &waveforms, folder, dpi)?);
    }
    let record = simulated.record();
    write_record(folder, &record)?;
    let page = simulation_page(simulated, &record, vessels, nodes, figures);
    write_file(&folder.join(PAGE), |out| write_page(out, &page))?;
    Ok(notes)
}

/// The columns of occlusions.csv, a row for each vessel that is closed.
pub fn occlusion_columns(simulated: &SimulationRun<'_>, closures: &[ClosedVessel]) -> Vec<Column> {
    let network = &*simulated.network;
    let names = picture_names(network);
    let real = |name, of: &dyn Fn(usize) -> f64| Column::real(name, (0..closures.len()).map(of));
    let gain = |row: usize| closures[row].takes_over.map_or(0.0, |change| change.gain());
    let text = |name, of: &dyn Fn(&ClosedVessel) -> Option<String>| {
        Column::text(name, closures.iter().map(|closure| of(closure).unwrap_or_default()))
    };
    vec![
        Column::whole("edge", 0..closures.len()),
        Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
        real("flow_mL_per_min", &|row| ml_per_min(simulated.result.unperturbed.vessels[row].flow)),
        real("inflow_mL_per_min", &|row| ml_per_min(closures[row].inflow)),
        real("lost_mL_per_min", &|row| ml_per_min(closures[row].lost)),
        real("lost_share", &|row| closures[row].lost_share),
        Column::whole("outlets_unfed", closures.iter().map(|closure| closure.unfed)),
        text("worst_outlet", &|closure| Some(network.node(closure.worst?.0).id.clone())),
        real("worst_outlet_share_left", &|row| closures[row].worst.map_or(f64::NAN, |(_, share)| share)),
        text("takes_over", &|closure| Some(names[closure.takes_over?.vessel].clone())),
        real("gain_mL_per_min", &|row| ml_per_min(gain(row))),
        Column::whole("reversed", closures.iter().map(|closure| closure.reversed)),
        real("rho_G_W_per_m3", &|row| closures[row].network_resilience),
    ]
}

/// The flow of every vessel.
fn flows(simulated: &SimulationRun<'_>) -> Vec<VesselFlow> {
    let result = &simulated.result;
    let flow = |(row, name): (usize, String)| VesselFlow {
        name,
        unperturbed: ml_per_min(result.unperturbed.vessels[row].flow),
        perturbed: result.perturbed.as_ref().map(|state| ml_per_min(state.vessels[row].flow)),
    };
    picture_names(&simulated.network).into_iter().enumerate().map(flow).collect()
}
