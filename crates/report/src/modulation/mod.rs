//! The output folder of a resistance modulation: tables, arrays, pictures, page and record.

mod outcome;
pub mod pictures;
mod record;
mod tables;

use std::path::Path;

use serde_json::{Value, json};

use super::figures::SaveOptions;
use super::page::{PagePicture, modulation_page, write_page};
use willis_core::error::Result;
use willis_core::modulation::{Instances, Reading};
use willis_core::network::units::{ml_per_min, mmhg};
use willis_io::formats::{NamedArray, write_arrays, write_csv};
use willis_io::output::{names, write_file, write_record};

pub use outcome::ModulationRun;

impl ModulationRun<'_> {
    /// The record of the run.
    pub fn record(&self) -> Value {
        json!(self.run_record())
    }

    /// Writes every file into a folder that is there, `samples.npz` with every instance where `instances` is set.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &Path, instances: bool, options: &SaveOptions) -> Result<()> {
        options.validate()?;
        let tables = [
            tables::class_columns(self),
            tables::node_columns(self),
            tables::vessel_columns(self),
            tables::hypertension_columns(self),
        ];
        for (name, columns) in [names::CLASSES, names::NODES, names::EDGES, names::HYPERTENSION].into_iter().zip(&tables) {
            write_file(&folder.join(name), |out| write_csv(out, columns))?;
        }
        if instances {
            write_file(&folder.join(names::INSTANCES), |out| write_arrays(out, arrays(self)))?;
        }
        let mut figures = Vec::new();
        for (title, caption, picture) in
            [("Response", RESPONSE, pictures::response(self)), ("Hypertension", HYPERTENSION, pictures::hypertension(self))]
        {
            figures.push(PagePicture::write(title, caption, &picture, folder, options.dpi)?);
        }
        let record = self.run_record();
        write_record(folder, &record)?;
        let page = modulation_page(self, &record, tables, figures);
        write_file(&folder.join(names::PAGE), |out| write_page(out, &page))
    }
}

const RESPONSE: &str = "The change of pressure, and flow and resilience over those of the unperturbed network, by class.";
const HYPERTENSION: &str = "Histograms of the hypertension force by class, with the gamma distributions fitted to them.";

/// The arrays of samples.npz: `classes` (class x low, high), those of the unperturbed instance, then those of each class, numbered
/// from 1.
fn arrays<'a>(outcome: &'a ModulationRun<'_>) -> impl Iterator<Item = NamedArray> + 'a {
    let classes = &outcome.result.classes;
    let bounds = classes.iter().flat_map(|(class, _)| [class.low, class.high]).collect();
    let bounds = NamedArray { name: "classes".into(), shape: vec![classes.len(), 2], values: bounds };
    let by_class = classes.iter().enumerate().flat_map(move |(at, (_, instances))| {
        let name = format!("class{}", at + 1);
        of_instances(outcome, &name, instances).into_iter().chain(of_factors(outcome, &name, instances))
    });
    let at_rest = of_instances(outcome, "unperturbed", &outcome.result.unperturbed);
    std::iter::once(bounds).chain(at_rest).chain(by_class)
}

fn of_instances(outcome: &ModulationRun<'_>, of: &str, instances: &Instances) -> Vec<NamedArray> {
    let (n, nodes, vessels) = (instances.count(), outcome.network.node_count(), outcome.network.vessel_count());
    let array = |name: &str, shape: &[usize], table: &[f64], unit: fn(f64) -> f64| NamedArray {
        name: format!("{of}_{name}"),
        shape: shape.to_vec(),
        values: table.iter().map(|x| unit(*x)).collect(),
    };
    vec![
        array("pressure_mmHg", &[n, nodes], &instances.pressure, mmhg),
        array("flow_mL_per_min", &[n, vessels], &instances.flow, ml_per_min),
        array("drop_mmHg", &[n, vessels], &instances.drop, mmhg),
        array("resilience_W_per_m3", &[n, vessels], &instances.resilience, |r| r),
        array("rho_G_W_per_m3", &[n], &instances.network_resilience, |r| r),
        array("total_inflow_mL_per_min", &[n], &instances.inflow, ml_per_min),
    ]
}

/// The factors of every vessel.
fn of_factors(outcome: &ModulationRun<'_>, of: &str, instances: &Instances) -> Vec<NamedArray> {
    let shape = vec![instances.count(), outcome.network.vessel_count()];
    let array = |name, table: &[f64]| NamedArray { name: format!("{of}_{name}"), shape: shape.clone(), values: table.to_vec() };
    let mut arrays = vec![array("resistance_factor", &instances.resistance_factor)];
    if outcome.params.reading == Reading::Geometry {
        arrays.push(array("radius_factor", &instances.radius_factor));
        arrays.push(array("length_factor", &instances.length_factor));
    }
    arrays
}
