//! run.json of a resistance modulation: how the run was made, and its results in short.

use serde::Serialize;
use serde_json::{Value, json};

use super::outcome::ModulationOutcome;
use crate::run_record::{ConditionRecords, Recorded, conditions, counts, outlets_found};
use willis_core::modulation::{Hypertension, Instances};
use willis_core::network::units::{centipoise, ml_per_min, mmhg_per_mm2};
use willis_core::support::Distribution;

/// The results of a class, or of the unperturbed instance.
fn figures(outcome: &ModulationOutcome<'_>, instances: &Instances, hypertension: &Hypertension) -> Value {
    let mean = |values: Vec<f64>| Distribution::of(values).mean;
    json!({
        "rho_G_W_per_m3": mean(instances.network_resilience.clone()),
        "total_inflow_mL_per_min": mean(instances.inflow.iter().map(|q| ml_per_min(*q)).collect()),
        "mean_pressure_mmHg": mean(outcome.mean_pressure(instances)),
        "gamma_shape": hypertension.fit.map(|fit| fit.gamma.shape),
        "gamma_scale_mmHg_per_mm2": hypertension.fit.map(|fit| mmhg_per_mm2(fit.gamma.scale)),
        "share_above_threshold": hypertension.above,
    })
}

/// The content of run.json.
#[derive(Debug, Clone, Serialize)]
pub(super) struct ModulationRecord<'a> {
    willis: &'static str,
    command: &'a str,
    input: Value,
    seed: u64,
    parameters: Value,
    boundary_conditions: ConditionRecords,
    counts: Value,
    unperturbed: Value,
    classes: Vec<Value>,
    solver: Value,
    notes: &'a [String],
    time: Value,
}

impl Recorded for ModulationRecord<'_> {
    fn conditions(&mut self) -> &mut ConditionRecords {
        &mut self.boundary_conditions
    }
}

impl<'a> ModulationRecord<'a> {
    /// Gathers the record of a run.
    pub(super) fn of(outcome: &ModulationOutcome<'a>) -> Self {
        let (network, boundary, params, provenance) = (outcome.network, outcome.boundary, outcome.params, outcome.provenance);
        let modulated = params.vessels.as_ref().map(|vessels| (0..vessels.len()).filter(|v| vessels[*v]).collect::<Vec<_>>());
        let by_class = outcome.result.classes.iter().zip(&outcome.hypertension.classes);
        let classes = by_class.map(|((class, instances), hypertension)| {
            let mut value = figures(outcome, instances, hypertension);
            value["class"] = json!(class.to_string());
            value
        });
        Self {
            willis: env!("CARGO_PKG_VERSION"),
            command: &provenance.command,
            input: provenance.of_input(),
            seed: params.seed,
            parameters: json!({
                "classes": params.classes.iter().map(ToString::to_string).collect::<Vec<_>>(),
                "samples": params.samples,
                "reading": params.reading.name(),
                "modulated_edges": modulated,
                "viscosity_cP": centipoise(params.viscosity),
                "threshold_mmHg_per_mm2": mmhg_per_mm2(outcome.hypertension.threshold),
                "outlets_found": outlets_found(outcome.outlets),
            }),
            boundary_conditions: conditions(network, boundary, None),
            counts: counts(network, boundary),
            unperturbed: figures(outcome, &outcome.result.unperturbed, &outcome.hypertension.unperturbed),
            classes: classes.collect(),
            solver: json!({ "flow": outcome.result.solver }),
            notes: &provenance.notes,
            time: json!({ "solving_s": outcome.seconds }),
        }
    }
}

impl ModulationOutcome<'_> {
    /// The content of run.json.
    pub fn record(&self) -> impl serde::Serialize {
        ModulationRecord::of(self)
    }
}
