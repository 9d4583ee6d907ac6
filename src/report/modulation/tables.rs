//! The tables of a resistance modulation, one row a distribution.

use super::ModulationOutcome;
use crate::io::Column;
use crate::modulation::{Class, Hypertension, Instances};
use crate::network::units::{ml_per_min, mmhg, mmhg_per_mm2};
use crate::support::Distribution;

/// A figure by class: its distribution, and its value in the unperturbed network.
struct Row {
    class: Class,
    /// The row of a node or vessel.
    item: usize,
    quantity: &'static str,
    unit: &'static str,
    distribution: Distribution,
    unperturbed: f64,
}

fn distribution_columns(rows: &[Row]) -> Vec<Column> {
    let quantile = |at: usize| rows.iter().map(move |r| r.distribution.quantiles[at]);
    vec![
        Column::real("mean", rows.iter().map(|r| r.distribution.mean)),
        Column::real("std", rows.iter().map(|r| r.distribution.std)),
        Column::real("q05", quantile(0)),
        Column::real("q25", quantile(1)),
        Column::real("median", quantile(2)),
        Column::real("q75", quantile(3)),
        Column::real("q95", quantile(4)),
        Column::real("unperturbed", rows.iter().map(|r| r.unperturbed)),
    ]
}

fn names(rows: &[Row], of: impl Fn(&Row) -> String) -> impl Iterator<Item = String> {
    rows.iter().map(of)
}

/// The figures of the whole network by instance.
fn of_network(outcome: &ModulationOutcome<'_>, instances: &Instances) -> [(&'static str, &'static str, Vec<f64>); 5] {
    let vessels = outcome.network.vessel_count();
    let all = vec![true; vessels];
    let inflow = instances.inflow.iter().map(|q| ml_per_min(*q)).collect();
    [
        ("rho_G_W_per_m3", "W/m3", instances.network_resilience.clone()),
        ("total_inflow_mL_per_min", "mL/min", inflow),
        ("mean_drop_mmHg", "mmHg", Instances::means(&instances.drop, vessels, &all, |drop| mmhg(drop.abs()))),
        ("mean_pressure_mmHg", "mmHg", outcome.mean_pressure(instances)),
        ("mean_hypertension_mmHg_per_mm2", "mmHg/mm2", Instances::means(&instances.force, vessels, &all, mmhg_per_mm2)),
    ]
}

/// classes.csv: the figures of the whole network. A drop counts without its sign; the mean pressure is over the nodes without a
/// fixed one; figures of floating components are left out.
pub fn class_columns(outcome: &ModulationOutcome<'_>) -> Vec<Column> {
    let mut rows = Vec::new();
    let at_rest = of_network(outcome, &outcome.result.unperturbed);
    for (class, instances) in &outcome.result.classes {
        for ((quantity, unit, values), (.., rest)) in of_network(outcome, instances).into_iter().zip(&at_rest) {
            let distribution = Distribution::of(values);
            rows.push(Row { class: *class, item: 0, quantity, unit, distribution, unperturbed: rest[0] });
        }
    }
    let mut columns = vec![
        Column::text("class", names(&rows, |r| r.class.to_string())),
        Column::real("low", rows.iter().map(|r| r.class.low)),
        Column::real("high", rows.iter().map(|r| r.class.high)),
        Column::text("quantity", names(&rows, |r| r.quantity.to_owned())),
        Column::text("unit", names(&rows, |r| r.unit.to_owned())),
    ];
    columns.extend(distribution_columns(&rows));
    let ratio = |r: &Row| if r.unperturbed == 0.0 { f64::NAN } else { r.distribution.mean / r.unperturbed };
    columns.push(Column::real("ratio", rows.iter().map(ratio)));
    columns
}

/// A table of instances and how its figures are written.
type Quantity = (&'static str, fn(&Instances) -> &Vec<f64>, fn(f64) -> f64);

/// One row a class, node or vessel, and quantity.
fn by_item(outcome: &ModulationOutcome<'_>, items: usize, quantities: &[Quantity]) -> Vec<Row> {
    let mut rows = Vec::new();
    for (class, instances) in &outcome.result.classes {
        for item in 0..items {
            for (quantity, table, unit) in quantities {
                rows.push(Row {
                    class: *class,
                    item,
                    quantity,
                    unit: "",
                    distribution: Instances::column(table(instances), items, item, unit),
                    unperturbed: unit(table(&outcome.result.unperturbed)[item]),
                });
            }
        }
    }
    rows
}

/// nodes.csv: the pressure of every node by class.
pub fn node_columns(outcome: &ModulationOutcome<'_>) -> Vec<Column> {
    let network = outcome.network;
    let rows = by_item(outcome, network.node_count(), &[("pressure_mmHg", |i| &i.pressure, mmhg)]);
    let mut columns = vec![
        Column::text("class", names(&rows, |r| r.class.to_string())),
        Column::whole("node", rows.iter().map(|r| r.item)),
        Column::text("id", names(&rows, |r| network.node(r.item).id.clone())),
        Column::text("label", names(&rows, |r| network.node(r.item).label.clone())),
        Column::text("quantity", names(&rows, |r| r.quantity.to_owned())),
    ];
    columns.extend(distribution_columns(&rows));
    columns
}

/// edges.csv: what flows in every vessel by class; flow and drop are positive from `node_a` to `node_b`.
pub fn vessel_columns(outcome: &ModulationOutcome<'_>) -> Vec<Column> {
    let network = outcome.network;
    let quantities: [Quantity; 4] = [
        ("flow_mL_per_min", |i| &i.flow, ml_per_min),
        ("drop_mmHg", |i| &i.drop, mmhg),
        ("resilience_W_per_m3", |i| &i.resilience, |r| r),
        ("hypertension_mmHg_per_mm2", |i| &i.force, mmhg_per_mm2),
    ];
    let rows = by_item(outcome, network.vessel_count(), &quantities);
    let mut columns = vec![
        Column::text("class", names(&rows, |r| r.class.to_string())),
        Column::whole("edge", rows.iter().map(|r| r.item)),
        Column::whole("node_a", rows.iter().map(|r| network.ends(r.item)[0])),
        Column::whole("node_b", rows.iter().map(|r| network.ends(r.item)[1])),
        Column::text("label", names(&rows, |r| network.vessel(r.item).label.clone())),
        Column::text("quantity", names(&rows, |r| r.quantity.to_owned())),
    ];
    columns.extend(distribution_columns(&rows));
    columns
}

/// The columns of hypertension.csv in the making.
#[derive(Default)]
struct Tidy {
    class: Vec<String>,
    kind: Vec<String>,
    quantity: Vec<String>,
    from: Vec<f64>,
    to: Vec<f64>,
    value: Vec<f64>,
    std_error: Vec<f64>,
}

impl Tidy {
    fn push(&mut self, class: &str, [kind, quantity]: [&str; 2], [from, to]: [f64; 2], [value, std_error]: [f64; 2]) {
        self.class.push(class.to_owned());
        self.kind.push(kind.to_owned());
        self.quantity.push(quantity.to_owned());
        self.from.push(mmhg_per_mm2(from));
        self.to.push(mmhg_per_mm2(to));
        self.value.push(value);
        self.std_error.push(std_error);
    }

    fn class(&mut self, class: &str, found: &Hypertension, edges: &[f64], threshold: f64) {
        const NONE: f64 = f64::NAN;
        for (bin, count) in edges.windows(2).zip(&found.counts) {
            self.push(class, ["histogram", "count"], [bin[0], bin[1]], [*count as f64, NONE]);
        }
        if let Some(fit) = &found.fit {
            let positive = [0.0, f64::INFINITY];
            self.push(class, ["fit", "shape"], positive, [fit.gamma.shape, fit.shape_error]);
            let scale = [fit.gamma.scale, fit.scale_error].map(mmhg_per_mm2);
            self.push(class, ["fit", "scale_mmHg_per_mm2"], positive, scale);
            self.push(class, ["fit", "ks_distance"], positive, [found.distance, NONE]);
        }
        self.push(class, ["fit", "share_without_force"], [NONE; 2], [found.without_force, NONE]);
        let risk = [threshold, f64::INFINITY];
        self.push(class, ["risk", "share_empirical"], risk, [found.above, NONE]);
        self.push(class, ["risk", "share_by_fit"], risk, [found.above_by_fit, NONE]);
    }
}

/// hypertension.csv: histogram, fit and risk area, of the unperturbed network and by class.
pub fn hypertension_columns(outcome: &ModulationOutcome<'_>) -> Vec<Column> {
    let (found, mut rows) = (outcome.hypertension, Tidy::default());
    rows.class("unperturbed", &found.unperturbed, &found.edges, found.threshold);
    for ((class, _), of_class) in outcome.result.classes.iter().zip(&found.classes) {
        rows.class(&class.to_string(), of_class, &found.edges, found.threshold);
    }
    vec![
        Column::text("class", rows.class.into_iter()),
        Column::text("kind", rows.kind.into_iter()),
        Column::text("quantity", rows.quantity.into_iter()),
        Column::real("from_mmHg_per_mm2", rows.from.into_iter()),
        Column::real("to_mmHg_per_mm2", rows.to.into_iter()),
        Column::real("value", rows.value.into_iter()),
        Column::real("std_error", rows.std_error.into_iter()),
    ]
}
