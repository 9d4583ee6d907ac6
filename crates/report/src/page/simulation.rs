//! The page of a forward simulation: vessels by flow, before and after the changes.

use super::content::{self, ColourScale, Colouring, Page, PagePicture, PageTable, conditions, list, take, warnings};
use super::scene::scene;
use crate::figures::colour::Rgb;
use crate::run_record::RunRecord;
use crate::simulation::SimulationRun;
use crate::simulation::pulse::flows_by_time;
use crate::simulation::transport::{MIXED, inlet_colours, supply_columns, transit_columns};
use willis_core::network::units::milliseconds;
use willis_core::simulation::PERTURBED;
use willis_core::simulation::pulse::Pulses;
use willis_io::formats::Column;

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
pub fn page(
    simulated: &SimulationRun<'_>,
    of_run: &RunRecord,
    vessels: Vec<Column>,
    nodes: Vec<Column>,
    figures: Vec<PagePicture>,
) -> Page {
    let perturbed = simulated.result.perturbed.is_some();
    let mut record = of_run.for_page();
    let warnings = warnings(&record, &of_run.conditions);
    let lead = super::lead::simulation(&record);
    let mut facts = content::facts(&record, &FACTS);
    facts.extend(content::facts(&record, if perturbed { &PERTURBED_FACTS } else { &[] }));
    let mut part = |name| take(&mut record, name);
    let lists = [
        list("Perturbations", &part("perturbations"), &PERTURBATION),
        list("Collaterals", &part("collaterals"), &COLLATERAL),
        list("Reversed flows", &part("reversed"), &COLLATERAL),
        conditions(&of_run.conditions),
    ];
    let mut tables = vec![PageTable::new("Vessels", vessels, true), PageTable::new("Nodes", nodes, false)];
    tables.extend(lists.into_iter().flatten());
    let mut colourings = colourings(perturbed);
    if let Some(transports) = &simulated.transports {
        colourings.extend(transport_colourings(inlet_colours(simulated, transports), tables.len(), perturbed));
        tables.push(PageTable::new("Blood of each vessel by inlet", supply_columns(simulated, transports), true));
        tables.push(PageTable::new("Arrival", transit_columns(simulated, transports), false));
    }
    if let Some((flows, over_the_cycle)) =
        simulated.pulses.as_ref().and_then(|(pulses, _)| cycle(simulated, pulses, tables.len()))
    {
        tables.push(flows);
        colourings.push(over_the_cycle);
    }
    let scene = scene(&simulated.network, &simulated.boundary);
    Page { colourings, facts, lead, tables, warnings, ..Page::new("simulate", record, scene, &[], figures) }
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

fn colourings(perturbed: bool) -> Vec<Colouring> {
    let each = COLOURINGS.map(|(name, unit, column)| {
        let mut variants = vec![("unperturbed".to_owned(), 0, column.to_owned())];
        if perturbed {
            variants.insert(0, ("perturbed".to_owned(), 0, format!("{column}{PERTURBED}")));
        }
        Colouring::new(name, unit, ColourScale::Log, variants)
    });
    let of_change = vec![(String::new(), 0, "flow_change".to_owned())];
    let change = Colouring::new("change of flow", "mL/min", ColourScale::Diverging, of_change);
    each.into_iter().chain(perturbed.then_some(change)).collect()
}

/// The colourings by where blood comes from and when; the colours are in the table `at`.
fn transport_colourings(legend: Vec<(String, Rgb)>, at: usize, perturbed: bool) -> [Colouring; 2] {
    let variants = |table: usize, column: &str| {
        let suffixes = [("perturbed", PERTURBED), ("unperturbed", "")];
        let shown = suffixes.into_iter().filter(|(_, suffix)| perturbed || suffix.is_empty());
        shown.map(|(name, suffix)| (name.to_owned(), table, format!("{column}{suffix}"))).collect()
    };
    let supply = Colouring { legend, ..Colouring::new("blood from", "", ColourScale::Mixed, variants(at, MIXED)) };
    [supply, Colouring::new("mean time since entry", "ms", ColourScale::Linear, variants(0, "arrival_ms"))]
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
    let shown = pulses.perturbed.as_ref().unwrap_or(&pulses.unperturbed);
    let mut columns = vec![
        Column::whole("edge", 0..network.vessel_count()),
        Column::text("label", network.vessels().map(|(_, vessel)| vessel.label.clone())),
    ];
    let name = |stop: usize| format!("{:.0} ms", milliseconds(shown.period * stop as f64 / STOPS as f64));
    let flows = flows_by_time(shown, STOPS).into_iter().enumerate();
    columns.extend(flows.map(|(stop, flows)| Column::real(name(stop), flows.into_iter())));
    let title = if pulses.perturbed.is_some() { "Flow over the cycle, perturbed" } else { "Flow over the cycle" };
    let variants = (0..STOPS).map(|stop| (name(stop), at, name(stop))).collect();
    let colouring = Colouring::new(OVER_THE_CYCLE, "mL/min", ColourScale::Linear, variants);
    Some((PageTable::new(title, columns, true), colouring))
}
