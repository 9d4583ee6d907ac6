//! run.json of a forward simulation: how it was made, ρ_G, the inflow, and what a perturbation changed.

use serde::Serialize;
use serde_json::{Value, json};

use super::simulated::Simulated;
use super::summary::{Provenance, conditions, outlets_found};
use crate::hemodynamics::FoundOutlets;
use crate::network::{Network, RadiusRule, Role};
use crate::simulation::{Change, FlowChange, Perturbation, gains, reversals};
use crate::state::{LAMINAR_LIMIT, State};
use crate::units::{centipoise, millimetres, ml_per_min};

/// Collaterals that are named: those of the largest gain of flow.
pub const MOST_COLLATERALS: usize = 5;

/// Everything that run.json of a simulation holds.
#[derive(Debug, Clone, Serialize)]
pub struct FlowRecord {
    willis: &'static str,
    command: String,
    input: Value,
    parameters: Value,
    boundary_conditions: Vec<Value>,
    counts: Value,
    #[serde(rename = "rho_G_W_per_m3")]
    network_resilience: f64,
    #[serde(rename = "rho_G_W_per_m3_perturbed", skip_serializing_if = "Option::is_none")]
    network_resilience_perturbed: Option<f64>,
    #[serde(rename = "total_inflow_mL_per_min")]
    inflow: f64,
    #[serde(rename = "total_inflow_mL_per_min_perturbed", skip_serializing_if = "Option::is_none")]
    inflow_perturbed: Option<f64>,
    not_laminar: Value,
    perturbations: Vec<Value>,
    collaterals: Vec<Value>,
    reversed: Vec<Value>,
    notes: Vec<String>,
}

impl FlowRecord {
    /// Gathers the record of a simulation.
    pub fn new(simulated: &Simulated<'_>, provenance: &Provenance, radius_rule: RadiusRule, outlets: FoundOutlets) -> Self {
        let (network, boundary, result) = (simulated.network, simulated.boundary, simulated.result);
        let (before, after) = (&result.unperturbed, result.perturbed.as_ref());
        let changes = simulated.perturbations;
        let changed = |find: fn(&State, &State, &[Perturbation]) -> Vec<FlowChange>| {
            after.map_or_else(Vec::new, |after| find(before, after, changes))
        };
        let turbulent = |state: &State| -> Vec<Value> {
            let beyond = |(row, reynolds)| json!({ "edge": row, "label": network.vessel(row).label, "reynolds": reynolds });
            state.beyond_laminar().map(beyond).collect()
        };
        let mut counts = json!({
            "nodes": network.node_count(),
            "vessels": network.vessel_count(),
            "inlets": boundary.count(Role::Inlet),
            "outlets": boundary.count(Role::Outlet),
            "diffused": before.diffused(),
        });
        let mut not_laminar = json!({ "above_reynolds": LAMINAR_LIMIT, "vessels": turbulent(before) });
        if let Some(after) = after {
            counts["diffused_perturbed"] = json!(after.diffused());
            not_laminar["vessels_perturbed"] = json!(turbulent(after));
        }
        Self {
            willis: env!("CARGO_PKG_VERSION"),
            command: provenance.command.clone(),
            input: provenance.of_input(),
            parameters: json!({
                "viscosity_cP": centipoise(simulated.viscosity),
                "radius": radius_rule.name(),
                "outlets_found": outlets_found(outlets),
                "stenosis_model": "poiseuille",
            }),
            boundary_conditions: conditions(network, boundary),
            counts,
            network_resilience: before.network_resilience,
            network_resilience_perturbed: after.map(|state| state.network_resilience),
            inflow: ml_per_min(before.inflow),
            inflow_perturbed: after.map(|state| ml_per_min(state.inflow)),
            not_laminar,
            perturbations: changes.iter().map(|p| perturbation(network, p)).collect(),
            collaterals: changed(gains).iter().take(MOST_COLLATERALS).map(|c| collateral(network, c)).collect(),
            reversed: changed(reversals).iter().map(|c| collateral(network, c)).collect(),
            notes: provenance.notes.clone(),
        }
    }
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
