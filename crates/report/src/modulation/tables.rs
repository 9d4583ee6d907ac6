//! The tables of a resistance modulation: one distribution per row, and the histograms of hypertension.

use super::outcome::ModulationRun;
use willis_core::modulation::{Class, Hypertension, Instances};
use willis_core::network::units::{ml_per_min, mmhg, mmhg_per_mm2};
use willis_core::support::Distribution;
use willis_io::formats::Column;

/// A quantity in a class: its distribution over the instances, and its value in the unperturbed network.
struct DistributionRow {
    class: Class,
    /// The row of a node or vessel.
    item: usize,
    quantity: &'static str,
    unit: &'static str,
    distribution: Distribution,
    unperturbed: f64,
}

/// The columns of rows: the class, those `of_item`, the quantity, its unit where there is one, and the distribution.
fn columns(rows: &[DistributionRow], of_item: Vec<Column>) -> Vec<Column> {
    let text = |name: &'static str, of: fn(&DistributionRow) -> String| Column::text(name, rows.iter().map(of));
    let real = |name: &'static str, of: &dyn Fn(&DistributionRow) -> f64| Column::real(name, rows.iter().map(of));
    let mut columns = vec![text("class", |r| r.class.to_string())];
    columns.extend(of_item);
    columns.push(text("quantity", |r| r.quantity.to_owned()));
    if rows.iter().any(|r| !r.unit.is_empty()) {
        columns.push(text("unit", |r| r.unit.to_owned()));
    }
    columns.extend([real("mean", &|r| r.distribution.mean), real("std", &|r| r.distribution.std)]);
    let quantiles = ["q05", "q25", "median", "q75", "q95"].into_iter().enumerate();
    columns.extend(quantiles.map(|(at, name)| real(name, &|r| r.distribution.quantiles[at])));
    columns.push(real("unperturbed", &|r| r.unperturbed));
    columns
}

/// The figures of the whole network by instance: name, unit and values.
fn of_network(outcome: &ModulationRun<'_>, instances: &Instances) -> [(&'static str, &'static str, Vec<f64>); 5] {
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

/// classes.csv: the figures of the whole network. Mean drops are means of |ΔP|; mean pressures leave out nodes of fixed pressure.
/// Floating components are left out.
pub fn class_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
    let mut rows = Vec::new();
    let at_rest = of_network(outcome, &outcome.result.unperturbed);
    for (class, instances) in &outcome.result.classes {
        for ((quantity, unit, values), (.., rest)) in of_network(outcome, instances).into_iter().zip(&at_rest) {
            let distribution = Distribution::of(values);
            rows.push(DistributionRow { class: *class, item: 0, quantity, unit, distribution, unperturbed: rest[0] });
        }
    }
    let [low, high] = [|r: &DistributionRow| r.class.low, |r: &DistributionRow| r.class.high].map(|of| rows.iter().map(of));
    let mut columns = columns(&rows, vec![Column::real("low", low), Column::real("high", high)]);
    let ratio = |r: &DistributionRow| if r.unperturbed == 0.0 { f64::NAN } else { r.distribution.mean / r.unperturbed };
    columns.push(Column::real("ratio", rows.iter().map(ratio)));
    columns
}

/// A quantity: its name, its table in the instances, and the conversion to its unit.
type InstanceFigure = (&'static str, fn(&Instances) -> &Vec<f64>, fn(f64) -> f64);

/// One row for each class, node or vessel, and quantity.
fn by_item(outcome: &ModulationRun<'_>, items: usize, quantities: &[InstanceFigure]) -> Vec<DistributionRow> {
    let mut rows = Vec::new();
    for (class, instances) in &outcome.result.classes {
        for item in 0..items {
            for (quantity, table, unit) in quantities {
                let distribution = Instances::column(table(instances), items, item, unit);
                let unperturbed = unit(table(&outcome.result.unperturbed)[item]);
                rows.push(DistributionRow { class: *class, item, quantity, unit: "", distribution, unperturbed });
            }
        }
    }
    rows
}

/// nodes.csv: the pressure of every node by class.
pub fn node_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
    let network = &*outcome.network;
    let rows = by_item(outcome, network.node_count(), &[("pressure_mmHg", |i| &i.pressure, mmhg)]);
    let of_node = vec![
        Column::whole("node", rows.iter().map(|r| r.item)),
        Column::text("id", rows.iter().map(|r| network.node(r.item).id.clone())),
        Column::text("label", rows.iter().map(|r| network.node(r.item).label.clone())),
    ];
    columns(&rows, of_node)
}

/// edges.csv: flow, drop, resilience and hypertension of every vessel by class. Flow and drop are positive from `node_a` to `node_b`.
pub fn vessel_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
    let network = &*outcome.network;
    let quantities: [InstanceFigure; 4] = [
        ("flow_mL_per_min", |i| &i.flow, ml_per_min),
        ("drop_mmHg", |i| &i.drop, mmhg),
        ("resilience_W_per_m3", |i| &i.resilience, |r| r),
        ("hypertension_mmHg_per_mm2", |i| &i.force, mmhg_per_mm2),
    ];
    let rows = by_item(outcome, network.vessel_count(), &quantities);
    let of_vessel = vec![
        Column::whole("edge", rows.iter().map(|r| r.item)),
        Column::whole("node_a", rows.iter().map(|r| network.ends(r.item)[0])),
        Column::whole("node_b", rows.iter().map(|r| network.ends(r.item)[1])),
        Column::text("label", rows.iter().map(|r| network.vessel(r.item).label.clone())),
    ];
    columns(&rows, of_vessel)
}

/// A row of hypertension.csv: class, kind and quantity; the range of forces (Pa/m²); value and its standard error.
type HypertensionRow<'a> = ([&'a str; 3], [f64; 2], [f64; 2]);

fn hypertension_rows<'a>(class: &'a str, found: &Hypertension, edges: &[f64], threshold: f64) -> Vec<HypertensionRow<'a>> {
    const NONE: f64 = f64::NAN;
    let bins = edges.windows(2).zip(&found.counts);
    let mut rows: Vec<HypertensionRow<'_>> =
        bins.map(|(bin, count)| ([class, "histogram", "count"], [bin[0], bin[1]], [*count as f64, NONE])).collect();
    if let Some(fit) = &found.fit {
        let positive = [0.0, f64::INFINITY];
        rows.push(([class, "fit", "shape"], positive, [fit.gamma.shape, fit.shape_error]));
        rows.push(([class, "fit", "scale_mmHg_per_mm2"], positive, [fit.gamma.scale, fit.scale_error].map(mmhg_per_mm2)));
        rows.push(([class, "fit", "ks_distance"], positive, [found.distance, NONE]));
    }
    rows.push(([class, "fit", "share_without_force"], [NONE; 2], [found.without_force, NONE]));
    let above = [threshold, f64::INFINITY];
    rows.push(([class, "risk", "share_empirical"], above, [found.above, NONE]));
    rows.push(([class, "risk", "share_by_fit"], above, [found.above_by_fit, NONE]));
    rows
}

/// hypertension.csv: histogram, fit and share at risk, of the unperturbed network and by class.
pub fn hypertension_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
    let found = &outcome.hypertension;
    let names: Vec<String> = outcome.result.classes.iter().map(|(class, _)| class.to_string()).collect();
    let by_class = names.iter().map(String::as_str).zip(&found.classes);
    let all = std::iter::once(("unperturbed", &found.unperturbed)).chain(by_class);
    let rows: Vec<_> =
        all.flat_map(|(class, of_class)| hypertension_rows(class, of_class, &found.edges, found.threshold)).collect();
    let text = |name: &'static str, at: usize| Column::text(name, rows.iter().map(move |row| row.0[at].to_owned()));
    let real = |name: &'static str, of: fn(&HypertensionRow<'_>) -> f64| Column::real(name, rows.iter().map(of));
    vec![
        text("class", 0),
        text("kind", 1),
        text("quantity", 2),
        real("from_mmHg_per_mm2", |row| mmhg_per_mm2(row.1[0])),
        real("to_mmHg_per_mm2", |row| mmhg_per_mm2(row.1[1])),
        real("value", |row| row.2[0]),
        real("std_error", |row| row.2[1]),
    ]
}
