//! The page of a forward simulation: vessels by flow, before and after.

use serde_json::Value;

use super::lists::{Figure, conditions, list};
use super::scene::scene;
use super::{Colouring, Fact, Page, Scale, Table, record, take, title};
use crate::io::Column;
use crate::report::simulation::{FlowRecord, PERTURBED, Simulated};

/// By what vessels are coloured: name, unit, column.
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
    simulated: &Simulated<'_>,
    flow_record: &FlowRecord,
    vessels: Vec<Column>,
    nodes: Vec<Column>,
    figures: Vec<Figure>,
) -> Page {
    let perturbed = simulated.result.perturbed.is_some();
    let mut record = record(flow_record);
    let facts = facts(&record, perturbed);
    let mut part = |name| take(&mut record, name);
    let lists = [
        list("Perturbations", &part("perturbations"), &PERTURBATION),
        list("Collaterals", &part("collaterals"), &COLLATERAL),
        list("Reversed flows", &part("reversed"), &COLLATERAL),
        conditions(&part("boundary_conditions")),
    ];
    let table = |title: &str, columns, of_vessels| Table { title: title.to_owned(), columns, exact: &[], of_vessels };
    Page {
        title: title("simulate", &record),
        record,
        facts,
        scene: scene(simulated.network, simulated.boundary),
        colourings: colourings(perturbed),
        threshold: None,
        figures,
        tables: [Some(table("Vessels", vessels, true)), Some(table("Nodes", nodes, false))]
            .into_iter()
            .chain(lists)
            .flatten()
            .collect(),
    }
}

const PERTURBATION: [&str; 6] = ["edge", "label", "kind", "open_diameter_share", "stretch_mm", "length_factor"];
const COLLATERAL: [&str; 6] = ["edge", "label", "flow_mL_per_min", "flow_mL_per_min_perturbed", "gain_mL_per_min", "reversed"];

fn facts(record: &Value, perturbed: bool) -> Vec<Fact> {
    let fact = |name, pointer: &str, unit| Fact::of(record, name, pointer, unit);
    let count = |name, list: &str| {
        let items = record.pointer(list).and_then(Value::as_array).map_or(0, Vec::len);
        Fact { name, value: items.into(), unit: "" }
    };
    let mut facts = vec![
        fact("nodes", "/counts/nodes", ""),
        fact("vessels", "/counts/vessels", ""),
        fact("\u{3c1}_G", "/rho_G_W_per_m3", "W/m\u{b3}"),
        fact("inflow", "/total_inflow_mL_per_min", "mL/min"),
        count("vessels beyond laminar flow", "/not_laminar/vessels"),
    ];
    if perturbed {
        facts.extend([
            fact("\u{3c1}_G perturbed", "/rho_G_W_per_m3_perturbed", "W/m\u{b3}"),
            fact("inflow perturbed", "/total_inflow_mL_per_min_perturbed", "mL/min"),
            count("perturbations", "/perturbations"),
            count("reversed flows", "/reversed"),
            count("vessels beyond laminar flow, perturbed", "/not_laminar/vessels_perturbed"),
        ]);
    }
    facts
}

fn colourings(perturbed: bool) -> Vec<Colouring> {
    let each = COLOURINGS.map(|(name, unit, column)| {
        let mut variants = vec![("unperturbed".to_owned(), 0, column.to_owned())];
        if perturbed {
            variants.insert(0, ("perturbed".to_owned(), 0, format!("{column}{PERTURBED}")));
        }
        Colouring { name, unit, scale: Scale::Log, uncertain_only: false, variants }
    });
    let change = Colouring {
        name: "change of flow",
        unit: "mL/min",
        scale: Scale::Diverging,
        uncertain_only: false,
        variants: vec![(String::new(), 0, "flow_change".to_owned())],
    };
    each.into_iter().chain(perturbed.then_some(change)).collect()
}
