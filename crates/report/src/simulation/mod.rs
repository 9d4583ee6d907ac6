//! What is written of a forward simulation: its record, tables, pictures and page.

mod states;

use serde_json::{Value, json};

use super::figures::{SaveOptions, VesselFlow, flow_bars};
use super::page::{ColourScale, Colouring, Page, PagePicture, PageTable, condition_table, facts, lead, list, scene, take};
use super::run_record::{CONDITIONS, RunRecord, conditions, counts, outlets_found};
use states::{
    MIXED, flow_samples, harmonics, inlet_colours, picture_names, pulse_node_columns, supply_columns, supply_picture,
    territory_columns, transit_columns, transport_columns, waveform_arrays, waveform_columns, waveform_picture,
};
use willis_core::flow::FoundOutlets;
use willis_core::flow::state::{LAMINAR_LIMIT, State, VesselState};
use willis_core::network::Network;
use willis_core::network::units::{centipoise, millimetres, milliseconds, ml_per_min, mmhg, mmhg_s_per_ml};
use willis_core::simulation::pulse::Pulses;
use willis_core::simulation::{Change, FlowChange, PERTURBED, Perturbation, Simulation, gains, reversals};
use willis_io::formats::{
    Column, END_POSITION_COLUMNS, NamedArray, condition_columns, node_columns, vessel_columns, wall_columns, windkessel_columns,
    write_arrays, write_csv, write_vtp,
};
use willis_io::output::names::{EDGES, HARMONICS, NODES, OCCLUSIONS, TERRITORIES, TOPOLOGY, TRANSIT, WAVEFORM_TABLE, WAVEFORMS};
use willis_io::output::{StagedFolder, write_file, write_record};

pub use states::{SimulationRun, end_name, pulse_vessel_columns};

/// The largest number of vessels whose waveforms are written as a table.
const MOST_IN_TABLE: usize = 1000;
/// How many collaterals are listed, those of the largest gain of flow.
pub const MOST_COLLATERALS: usize = 5;

impl SimulationRun<'_> {
    /// The tables of nodes and of vessels, as nodes.csv and edges.csv have them.
    pub fn tables(&self) -> [Vec<Column>; 2] {
        let Self { network, boundary, result, .. } = self;
        let (before, after) = (&result.unperturbed, result.perturbed.as_ref());
        let stated = boundary.stated();
        let mut nodes = node_columns(network, &stated, before.pressure.iter().copied(), &vec![0; network.node_count()]);
        nodes.retain(|column| !["radius_mm", "component"].contains(&&*column.name));
        let pressure = |state: &State| state.pressure.iter().map(|p| p.map_or(f64::NAN, mmhg)).collect::<Vec<_>>();
        nodes.extend(after.map(|state| Column::real("pressure_mmHg_perturbed", pressure(state).into_iter())));
        nodes.extend(condition_columns(&stated));
        nodes.extend(windkessel_columns(network));
        let mut vessels = vessel_columns(network);
        vessels.retain(|column| column.name != "origin" && !END_POSITION_COLUMNS.as_flattened().contains(&&*column.name));
        vessels.extend(flow_columns(before, ""));
        if let Some(after) = after {
            vessels.extend(flow_columns(after, PERTURBED));
            let pairs = before.vessels.iter().zip(&after.vessels);
            let change = pairs.map(|(before, after)| ml_per_min(after.flow) - ml_per_min(before.flow));
            vessels.push(Column::real("flow_change", change));
        }
        vessels.extend(wall_columns(network));
        if let Some((pulses, _)) = &self.pulses {
            nodes.extend(pulse_node_columns(pulses));
            vessels.extend(pulse_vessel_columns(pulses));
        }
        vessels.extend(self.transports.as_ref().map(|found| transport_columns(self, found)).unwrap_or_default());
        [nodes, vessels]
    }

    /// The tables of who feeds what and when blood arrives, as territories.csv and transit.csv have them, if that was asked for.
    pub fn transport_tables(&self) -> Option<[Vec<Column>; 2]> {
        let transports = self.transports.as_ref()?;
        Some([territory_columns(self, transports), transit_columns(self, transports)])
    }

    /// What each closed vessel does, a row each, as occlusions.csv has it, if that was asked for.
    pub fn occlusion_table(&self) -> Option<Vec<Column>> {
        let closures = self.closures.as_ref()?;
        let network = &*self.network;
        let names = picture_names(network);
        let real = |name, of: &dyn Fn(usize) -> f64| Column::real(name, (0..closures.len()).map(of));
        let gain = |row: usize| closures[row].takes_over.map_or(0.0, |change| change.gain());
        let text = |name, of: &dyn Fn(&willis_core::simulation::ClosedVessel) -> Option<String>| {
            Column::text(name, closures.iter().map(|closure| of(closure).unwrap_or_default()))
        };
        Some(vec![
            Column::whole("edge", 0..closures.len()),
            Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
            real("flow_mL_per_min", &|row| ml_per_min(self.result.unperturbed.vessels[row].flow)),
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
        ])
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
    pub fn save(&self, folder: &std::path::Path, force: bool, options: &SaveOptions) -> willis_core::error::Result<Vec<String>> {
        options.validate()?;
        let staged = StagedFolder::new(folder, force)?;
        let (folder, dpi, mut notes) = (&staged.path(), options.dpi, Vec::new());
        let [nodes, vessels] = self.tables();
        write_file(&folder.join(EDGES), |out| write_csv(out, &vessels))?;
        write_file(&folder.join(NODES), |out| write_csv(out, &nodes))?;
        if self.network.has_positions() {
            write_file(&folder.join(format!("{TOPOLOGY}.vtp")), |out| write_vtp(out, &self.network, &vessels))?;
        } else {
            notes.push("topology.vtp is left out: the nodes have no coordinates".to_owned());
        }
        let Simulation { unperturbed, perturbed } = &self.result;
        let flow = |(row, name): (usize, String)| VesselFlow {
            name,
            unperturbed: ml_per_min(unperturbed.vessels[row].flow),
            perturbed: perturbed.as_ref().map(|state| ml_per_min(state.vessels[row].flow)),
        };
        let bars = flow_bars(&picture_names(&self.network).into_iter().enumerate().map(flow).collect::<Vec<_>>());
        let caption = "The flow of every vessel, and its flow in the perturbed network if there is one.";
        let mut figures = vec![PagePicture::write("Flow", caption, &bars, folder, dpi)?];
        if let Some((transports, [territories, transit])) = self.transports.as_ref().zip(self.transport_tables()) {
            write_file(&folder.join(TERRITORIES), |out| write_csv(out, &territories))?;
            write_file(&folder.join(TRANSIT), |out| write_csv(out, &transit))?;
            let caption = "From which inlet the blood of every outlet comes, and how long ago it entered on average.";
            figures.push(PagePicture::write("Territories", caption, &supply_picture(self, transports), folder, dpi)?);
        }
        if let Some(columns) = self.occlusion_table() {
            write_file(&folder.join(OCCLUSIONS), |out| write_csv(out, &columns))?;
        }
        if let Some((pulses, _)) = &self.pulses {
            write_file(&folder.join(WAVEFORMS), |out| write_arrays(out, waveform_arrays(self, pulses)))?;
            write_file(&folder.join(HARMONICS), |out| write_arrays(out, harmonics(pulses)))?;
            if self.network.vessel_count() <= MOST_IN_TABLE {
                write_file(&folder.join(WAVEFORM_TABLE), |out| write_csv(out, &waveform_columns(pulses)))?;
            }
            let caption =
                "The flow in the middle of the arteries over a cycle, before and after the perturbations if there are any.";
            figures.push(PagePicture::write("Waveforms", caption, &waveform_picture(self, pulses), folder, dpi)?);
        }
        let record = self.record();
        write_record(folder, &record)?;
        page(self, &record, [vessels, nodes], figures).write(folder)?;
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
        let collateral = |c: &FlowChange| {
            json!({
                "edge": c.vessel,
                "label": network.vessel(c.vessel).label,
                "flow_mL_per_min": ml_per_min(c.before),
                "flow_mL_per_min_perturbed": ml_per_min(c.after),
                "gain_mL_per_min": ml_per_min(c.gain()),
                "reversed": c.is_reversed(),
            })
        };
        let list = |found: &[FlowChange]| found.iter().map(collateral).collect::<Value>();
        // The exponent that the radii of the network have at its bifurcations, beside the one by which outlets found have their resistance.
        let figures = willis_core::morphometry::network_figures(network, |node| boundary.roles[node], Default::default());
        let murray = json!({
            "exponent_median": Some(figures.murray).filter(|k| k.is_finite()),
            "bifurcations": figures.bifurcations,
            "exponent_of_outlets": matches!(outlets, FoundOutlets::Murray(_)).then_some(3),
        });
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
            ("murray", murray),
        ];
        let pulse = self.pulses.as_ref().map(|(_, record)| ("pulse", record.clone()));
        let mut fields = vec![("parameters", parameters), CONDITIONS, ("counts", counts)];
        fields.extend(of_states.into_iter().flatten().chain(results).chain(pulse));
        fields.push(("notes", json!(provenance.notes)));
        RunRecord::new(provenance, conditions(network, boundary, None), fields)
    }
}

fn perturbation(network: &Network, Perturbation { vessel, change }: &Perturbation) -> Value {
    let label = &network.vessel(*vessel).label;
    match change {
        Change::Occlusion => json!({ "edge": vessel, "label": label, "kind": "occlusion" }),
        Change::Tortuosity(factor) => json!({ "edge": vessel, "label": label, "kind": "tortuosity", "length_factor": factor }),
        Change::Stenosis(stenosis) => json!({
            "edge": vessel, "label": label, "kind": "stenosis",
            "open_diameter_share": stenosis.open_diameter, "stretch_mm": stenosis.stretch.map(millimetres),
        }),
    }
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

/// The figures that colour the vessels: name, unit, column.
const COLOURINGS: [(&str, &str, &str); 6] = [
    ("flow", "mL/min", "flow_mL_per_min"),
    ("resilience \u{3c1}", "W/m\u{b3}", "resilience_W_per_m3"),
    ("wall shear stress", "Pa", "wall_shear_Pa"),
    ("pressure drop", "mmHg", "drop_mmHg"),
    ("velocity", "mm/s", "velocity_mm_per_s"),
    ("Reynolds number", "", "reynolds"),
];

/// The page of a simulation from the columns of edges.csv and nodes.csv.
fn page(
    simulated: &SimulationRun<'_>,
    of_run: &RunRecord,
    [vessels, nodes]: [Vec<Column>; 2],
    figures: Vec<PagePicture>,
) -> Page {
    let perturbed = simulated.result.perturbed.is_some();
    let mut page = Page::new("simulate", of_run, scene(&simulated.network, &simulated.boundary), figures);
    page.lead = lead::simulation(&page.record);
    let of_changes: &[_] = if perturbed { &PERTURBED_FACTS } else { &[] };
    page.facts = facts(&page.record, &[&FACTS, of_changes].concat());
    let mut part = |title, name, columns| list(title, take(&mut page.record, name).as_array()?, columns);
    let lists = [
        part("Perturbations", "perturbations", &PERTURBATION),
        part("Collaterals", "collaterals", &COLLATERAL),
        part("Reversed flows", "reversed", &COLLATERAL),
        condition_table(&of_run.conditions),
    ];
    let (tables, colours) = (&mut page.tables, &mut page.colourings);
    tables.extend([PageTable::new("Vessels", vessels, true), PageTable::new("Nodes", nodes, false)]);
    tables.extend(lists.into_iter().flatten());
    let of = |(name, unit, column)| Colouring::new(name, unit, ColourScale::Log, variants(0, column, perturbed));
    colours.extend(COLOURINGS.map(of));
    let of_change = perturbed.then(|| vec![(String::new(), 0, "flow_change".to_owned())]);
    colours.extend(of_change.map(|column| Colouring::new("change of flow", "mL/min", ColourScale::Diverging, column)));
    if let Some(transports) = &simulated.transports {
        // By where blood comes from and when; the colours are in the next table.
        let (legend, mixed) = (inlet_colours(simulated, transports), variants(tables.len(), MIXED, perturbed));
        colours.push(Colouring { legend, ..Colouring::new("blood from", "", ColourScale::Mixed, mixed) });
        let arrival = variants(0, "arrival_ms", perturbed);
        colours.push(Colouring::new("mean time since entry", "ms", ColourScale::Linear, arrival));
        tables.push(PageTable::new("Blood of each vessel by inlet", supply_columns(simulated, transports), true));
        tables.push(PageTable::new("Arrival", transit_columns(simulated, transports), false));
    }
    let cycle = simulated.pulses.as_ref().and_then(|(pulses, _)| cycle(simulated, pulses, tables.len()));
    if let Some((flows, over_the_cycle)) = cycle {
        tables.push(flows);
        colours.push(over_the_cycle);
    }
    page
}

const PERTURBATION: [&str; 6] = ["edge", "label", "kind", "open_diameter_share", "stretch_mm", "length_factor"];
const COLLATERAL: [&str; 6] = ["edge", "label", "flow_mL_per_min", "flow_mL_per_min_perturbed", "gain_mL_per_min", "reversed"];

/// The figures of every simulation, and those of one with perturbations.
const FACTS: [(&str, &str, &str); 5] = [
    ("nodes", "/counts/nodes", ""),
    ("vessels", "/counts/vessels", ""),
    ("\u{3c1}_G", "/rho_G_W_per_m3", "W/m\u{b3}"),
    ("inflow", "/total_inflow_mL_per_min", "mL/min"),
    ("vessels beyond laminar flow", "/not_laminar/vessels", ""),
];
const PERTURBED_FACTS: [(&str, &str, &str); 5] = [
    ("\u{3c1}_G perturbed", "/rho_G_W_per_m3_perturbed", "W/m\u{b3}"),
    ("inflow perturbed", "/total_inflow_mL_per_min_perturbed", "mL/min"),
    ("perturbations", "/perturbations", ""),
    ("reversed flows", "/reversed", ""),
    ("vessels beyond laminar flow, perturbed", "/not_laminar/vessels_perturbed", ""),
];

/// What the table `at` has in a column of each state, where there are two; the page starts with the first.
fn variants(at: usize, column: &str, perturbed: bool) -> Vec<(String, usize, String)> {
    let states = [("perturbed", PERTURBED), ("unperturbed", "")].into_iter().filter(|(_, suffix)| perturbed || suffix.is_empty());
    states.map(|(name, suffix)| (name.to_owned(), at, format!("{column}{suffix}"))).collect()
}

/// At how many times of the cycle the slider stops, and up to how many figures in all the page holds.
const STOPS: usize = 40;
const MOST_FIGURES: usize = 400_000;

/// The name of the figure by which the page knows that its variants are times.
const OVER_THE_CYCLE: &str = "flow over the cycle";

/// The table of flows by time, and the colouring that it gives, where the table is number `at`; none of a large network.
fn cycle(simulated: &SimulationRun<'_>, pulses: &Pulses, at: usize) -> Option<(PageTable, Colouring)> {
    let network = &*simulated.network;
    if network.vessel_count() * STOPS > MOST_FIGURES {
        return None;
    }
    let shown = pulses.both.perturbed.as_ref().unwrap_or(&pulses.both.unperturbed);
    let mut columns = vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
    ];
    let name = |stop: usize| format!("{:.0} ms", milliseconds(shown.period * stop as f64 / STOPS as f64));
    let flows: Vec<Vec<f64>> = shown.vessels.iter().map(|vessel| flow_samples(&vessel.flow[1], STOPS)).collect();
    columns.extend((0..STOPS).map(|stop| Column::real(name(stop), flows.iter().map(|flow| flow[stop]))));
    let title = if pulses.both.perturbed.is_some() { "Flow over the cycle, perturbed" } else { "Flow over the cycle" };
    let variants = (0..STOPS).map(|stop| (name(stop), at, name(stop))).collect();
    let colouring = Colouring::new(OVER_THE_CYCLE, "mL/min", ColourScale::Linear, variants);
    Some((PageTable::new(title, columns, true), colouring))
}
