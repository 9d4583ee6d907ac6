//! run.json of a resistance modulation: how the run was made, and its results in short.

use serde_json::{Value, json};

use super::outcome::ModulationRun;
use crate::run_record::{RunRecord, conditions, counts, outlets_found};
use willis_core::modulation::{Hypertension, Instances};
use willis_core::network::units::{centipoise, ml_per_min, mmhg_per_mm2};
use willis_core::support::Distribution;

/// The results of a class, or of the unperturbed instance.
fn figures(outcome: &ModulationRun<'_>, instances: &Instances, hypertension: &Hypertension) -> Value {
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

impl ModulationRun<'_> {
    /// The content of run.json.
    pub(super) fn run_record(&self) -> RunRecord {
        let (network, boundary, params) = (&*self.network, &self.boundary, &self.params);
        let modulated = params.vessels.as_ref().map(|vessels| (0..vessels.len()).filter(|v| vessels[*v]).collect::<Vec<_>>());
        let by_class = self.result.classes.iter().zip(&self.hypertension.classes);
        let classes = by_class.map(|((class, instances), hypertension)| {
            let mut value = figures(self, instances, hypertension);
            value["class"] = json!(class.to_string());
            value
        });
        let parameters = json!({
            "classes": params.classes.iter().map(ToString::to_string).collect::<Vec<_>>(),
            "samples": params.samples,
            "reading": params.reading.name(),
            "modulated_edges": modulated,
            "viscosity_cP": centipoise(params.viscosity),
            "threshold_mmHg_per_mm2": mmhg_per_mm2(self.hypertension.threshold),
            "outlets_found": outlets_found(self.outlets),
        });
        RunRecord::new(
            &self.provenance,
            [("seed", json!(params.seed)), ("parameters", parameters)],
            conditions(network, boundary, None),
            [
                ("counts", counts(network, boundary)),
                ("unperturbed", figures(self, &self.result.unperturbed, &self.hypertension.unperturbed)),
                ("classes", classes.collect()),
                ("solver", json!({ "flow": self.result.solver })),
                ("notes", json!(self.provenance.notes)),
                ("time", json!({ "solving_s": self.seconds })),
            ],
        )
    }
}
