//! What is written of a resistance modulation: tables, arrays, pictures, its record and its page.

use std::borrow::Cow;

use serde_json::{Value, json};

use crate::figures::axis::decimals;
use crate::figures::{Boxes, Figure, Histogram, Histograms, Panel, SaveOptions, hypertension, modulation};
use crate::page::{ColourScale, Colouring, Page, PagePicture, PageTable, condition_table, facts, lead, scene};
use crate::run_record::{CONDITIONS, Provenance, RunRecord, conditions, counts, outlets_found};
use willis_core::flow::{Boundary, FoundOutlets};
use willis_core::modulation::{
    BINS, Class, Hypertension, HypertensionByClass, Instances, Modulation, ModulationOptions, Reading,
};
use willis_core::network::units::{centipoise, ml_per_min, mmhg, mmhg_per_mm2};
use willis_core::network::{Condition, Network};
use willis_core::support::Distribution;
use willis_io::formats::{Column, NamedArray, Values, write_arrays, write_csv};
use willis_io::output::{names, write_file, write_record};

/// How a network responds to resistances that vary at random, with everything that its files need.
#[derive(Debug)]
pub struct ModulationRun<'a> {
    /// The network.
    pub network: Cow<'a, Network>,
    /// Its boundary conditions.
    pub boundary: Boundary,
    /// The condition of outlets without one.
    pub outlets: FoundOutlets,
    /// The command and input of the run.
    pub provenance: Cow<'a, Provenance>,
    /// The options of the modulation.
    pub params: ModulationOptions,
    /// The instances.
    pub result: Modulation,
    /// The distribution of hypertension.
    pub hypertension: HypertensionByClass,
    /// The time of the solves, s.
    pub seconds: f64,
}

impl ModulationRun<'_> {
    /// For each node whether its pressure can change.
    pub fn free(&self) -> Vec<bool> {
        let fixed = |node| matches!(self.boundary.condition(node), Some(Condition::Pressure(_)));
        (0..self.network.node_count()).map(|node| !fixed(node)).collect()
    }

    /// The mean pressure of the free nodes by instance, mmHg.
    pub fn mean_pressure(&self, instances: &Instances) -> Vec<f64> {
        Instances::means(&instances.pressure, self.network.node_count(), &self.free(), mmhg)
    }

    /// The record of the run.
    pub fn record(&self) -> Value {
        json!(self.run_record())
    }

    /// The content of run.json.
    fn run_record(&self) -> RunRecord {
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
            conditions(network, boundary, None),
            vec![
                ("seed", json!(params.seed)),
                ("parameters", parameters),
                CONDITIONS,
                ("counts", counts(network, boundary)),
                ("unperturbed", figures(self, &self.result.unperturbed, &self.hypertension.unperturbed)),
                ("classes", classes.collect()),
                ("solver", json!({ "flow": self.result.solver })),
                ("notes", json!(self.provenance.notes)),
                ("time", json!({ "solving_s": self.seconds })),
            ],
        )
    }

    /// Writes every file into a folder that is there, `samples.npz` with every instance where `instances` is set.
    ///
    /// # Errors
    ///
    /// A file that cannot be written.
    pub fn write(&self, folder: &std::path::Path, instances: bool, options: &SaveOptions) -> willis_core::error::Result<()> {
        options.validate()?;
        let tables = [class_columns(self), node_columns(self), vessel_columns(self), hypertension_columns(self)];
        for (name, columns) in [names::CLASSES, names::NODES, names::EDGES, names::HYPERTENSION].into_iter().zip(&tables) {
            write_file(&folder.join(name), |out| write_csv(out, columns))?;
        }
        if instances {
            write_file(&folder.join(names::INSTANCES), |out| write_arrays(out, arrays(self)))?;
        }
        let (response, hypertension) = (response(self), hypertension_picture(self));
        let figures = vec![
            PagePicture::write("Response", RESPONSE, &response, folder, options.dpi)?,
            PagePicture::write("Hypertension", HYPERTENSION, &hypertension, folder, options.dpi)?,
        ];
        let record = self.run_record();
        write_record(folder, &record)?;
        page(self, &record, tables, figures).write(folder)
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
    let by_class = classes.iter().enumerate();
    let by_class = by_class.flat_map(|(at, (_, of))| of_instances(outcome, &format!("class{}", at + 1), of, true));
    let at_rest = of_instances(outcome, "unperturbed", &outcome.result.unperturbed, false);
    std::iter::once(bounds).chain(at_rest).chain(by_class)
}

/// The arrays of some instances, those of the factors of every vessel where they were modulated.
fn of_instances(outcome: &ModulationRun<'_>, of: &str, instances: &Instances, modulated: bool) -> Vec<NamedArray> {
    let (n, nodes, vessels) = (instances.count(), outcome.network.node_count(), outcome.network.vessel_count());
    let array = |name: &str, shape: &[usize], table: &[f64], unit: fn(f64) -> f64| NamedArray {
        name: format!("{of}_{name}"),
        shape: shape.to_vec(),
        values: table.iter().map(|x| unit(*x)).collect(),
    };
    let mut arrays = vec![
        array("pressure_mmHg", &[n, nodes], &instances.pressure, mmhg),
        array("flow_mL_per_min", &[n, vessels], &instances.flow, ml_per_min),
        array("drop_mmHg", &[n, vessels], &instances.drop, mmhg),
        array("resilience_W_per_m3", &[n, vessels], &instances.resilience, |r| r),
        array("rho_G_W_per_m3", &[n], &instances.network_resilience, |r| r),
        array("total_inflow_mL_per_min", &[n], &instances.inflow, ml_per_min),
    ];
    if modulated {
        arrays.push(array("resistance_factor", &[n, vessels], &instances.resistance_factor, |x| x));
        if outcome.params.reading == Reading::Geometry {
            arrays.push(array("radius_factor", &[n, vessels], &instances.radius_factor, |x| x));
            arrays.push(array("length_factor", &[n, vessels], &instances.length_factor, |x| x));
        }
    }
    arrays
}

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
fn class_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
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
fn node_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
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
fn vessel_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
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

/// A row of hypertension.csv.
struct HypertensionRow<'a> {
    class: &'a str,
    kind: &'static str,
    quantity: &'static str,
    /// The range of forces, Pa/m².
    range: [f64; 2],
    value: f64,
    std_error: f64,
}

/// hypertension.csv: histogram, fit and share at risk, of the unperturbed network and by class.
fn hypertension_columns(outcome: &ModulationRun<'_>) -> Vec<Column> {
    const NONE: f64 = f64::NAN;
    let found = &outcome.hypertension;
    let names: Vec<String> = outcome.result.classes.iter().map(|(class, _)| class.to_string()).collect();
    let by_class = names.iter().map(String::as_str).zip(&found.classes);
    let [positive, above] = [0.0, found.threshold].map(|from| [from, f64::INFINITY]);
    let mut rows: Vec<HypertensionRow<'_>> = Vec::new();
    for (class, of_class) in std::iter::once(("unperturbed", &found.unperturbed)).chain(by_class) {
        let mut row = |kind, quantity, range, [value, std_error]: [f64; 2]| {
            rows.push(HypertensionRow { class, kind, quantity, range, value, std_error });
        };
        for (bin, count) in found.edges.windows(2).zip(&of_class.counts) {
            row("histogram", "count", [bin[0], bin[1]], [*count as f64, NONE]);
        }
        if let Some(fit) = &of_class.fit {
            row("fit", "shape", positive, [fit.gamma.shape, fit.shape_error]);
            row("fit", "scale_mmHg_per_mm2", positive, [fit.gamma.scale, fit.scale_error].map(mmhg_per_mm2));
            row("fit", "ks_distance", positive, [of_class.distance, NONE]);
        }
        row("fit", "share_without_force", [NONE; 2], [of_class.without_force, NONE]);
        row("risk", "share_empirical", above, [of_class.above, NONE]);
        row("risk", "share_by_fit", above, [of_class.above_by_fit, NONE]);
    }
    let text = |name, of: fn(&HypertensionRow<'_>) -> String| Column::text(name, rows.iter().map(of));
    let real = |name, of: fn(&HypertensionRow<'_>) -> f64| Column::real(name, rows.iter().map(of));
    vec![
        text("class", |row| row.class.to_owned()),
        text("kind", |row| row.kind.to_owned()),
        text("quantity", |row| row.quantity.to_owned()),
        real("from_mmHg_per_mm2", |row| mmhg_per_mm2(row.range[0])),
        real("to_mmHg_per_mm2", |row| mmhg_per_mm2(row.range[1])),
        real("value", |row| row.value),
        real("std_error", |row| row.std_error),
    ]
}

/// The name of a class in the pictures.
fn name(class: Class) -> String {
    format!("{}\u{2013}{}", class.low, class.high)
}

/// The picture `modulation`: change of pressure, and flow and resilience divided by those of the unperturbed network.
fn response(outcome: &ModulationRun<'_>) -> Figure {
    let (rest, classes) = (&outcome.result.unperturbed, &outcome.result.classes);
    let free = outcome.free();
    let pressure_at_rest = outcome.mean_pressure(rest)[0];
    let panel = |name: &str, unchanged, boxes: &dyn Fn(&Instances) -> Boxes| Panel {
        name: name.to_owned(),
        unchanged,
        boxes: classes.iter().map(|(_, instances)| boxes(instances)).collect(),
    };
    let panels = [
        panel("pressure change (mmHg)", 0.0, &|i| Boxes {
            each: each(&i.pressure, &rest.pressure, |node, p, at_rest| free[node].then(|| mmhg(p - at_rest))),
            whole: quantiles(outcome.mean_pressure(i).into_iter().map(|p| p - pressure_at_rest)),
        }),
        panel("flow / unperturbed", 1.0, &|i| Boxes {
            each: each(&i.flow, &rest.flow, ratio),
            whole: quantiles(i.inflow.iter().map(|q| q / rest.inflow[0])),
        }),
        panel("resilience / unperturbed", 1.0, &|i| Boxes {
            each: each(&i.resilience, &rest.resilience, ratio),
            whole: quantiles(i.network_resilience.iter().map(|r| r / rest.network_resilience[0])),
        }),
    ];
    let names: Vec<String> = classes.iter().map(|(class, _)| name(*class)).collect();
    modulation(&names, &panels)
}

/// A figure divided by that of the unperturbed network; `None` where that is zero.
fn ratio(_: usize, figure: f64, at_rest: f64) -> Option<f64> {
    (at_rest != 0.0).then(|| figure / at_rest)
}

/// The quantiles of `change` over all items and instances; it gets the item, its figure and its unperturbed figure.
fn each(table: &[f64], at_rest: &[f64], change: impl Fn(usize, f64, f64) -> Option<f64>) -> [f64; 5] {
    let rows = table.chunks_exact(at_rest.len());
    let changes =
        rows.flat_map(|row| row.iter().zip(at_rest).enumerate().filter_map(|(item, (x, rest))| change(item, *x, *rest)));
    quantiles(changes)
}

fn quantiles(figures: impl Iterator<Item = f64>) -> [f64; 5] {
    Distribution::of(figures.filter(|x| !x.is_nan()).collect()).quantiles
}

/// A fit further from the forces than this over the root of the number of vessels is not drawn: the Kolmogorov-Smirnov bound of 5 %. The
/// instances of one vessel are nearly equal, so that vessels are what counts.
const FAR: f64 = 1.36;

/// How many of the bins of hypertension.csv the picture draws as one: so many that at least 2 n^⅓ remain for n vessels (Rice's rule).
pub fn bins_in_one(vessels: usize) -> usize {
    let wanted = 2.0 * (vessels as f64).cbrt();
    (1..=BINS).rev().find(|many| BINS.is_multiple_of(*many) && (BINS / many) as f64 >= wanted).unwrap_or(1)
}

/// The picture `hypertension`: the bins of equal width, some of them drawn as one. The last bin is in hypertension.csv only.
fn hypertension_picture(outcome: &ModulationRun<'_>) -> Figure {
    let found = &outcome.hypertension;
    let vessels = outcome.result.unperturbed.force.iter().filter(|force| **force > 0.0).count();
    let many = bins_in_one(vessels);
    let edges: Vec<f64> = found.edges.iter().take(BINS + 1).step_by(many).map(|edge| mmhg_per_mm2(*edge)).collect();
    let one = |(class, found): (Class, &Hypertension)| {
        let total = found.counts.iter().sum::<u64>() as f64;
        let counts = found.counts.chunks(many).map(|counts| counts.iter().sum::<u64>() as f64);
        let density = counts.zip(edges.windows(2)).map(|(count, bin)| count / (total * (bin[1] - bin[0])));
        let fit = found.fit.filter(|_| found.distance <= FAR / (vessels as f64).sqrt());
        let fit = fit.map(|fit| willis_core::support::gamma::Gamma { scale: mmhg_per_mm2(fit.gamma.scale), ..fit.gamma });
        let percent = |share: f64| if share.is_nan() { "-".to_owned() } else { format!("{:.1} %", 100.0 * share) };
        let risk = format!("{} at risk", percent(found.above));
        let heading = match fit {
            Some(gamma) => {
                let (shape, mean, by_fit) = (gamma.shape, gamma.shape * gamma.scale, percent(found.above_by_fit));
                let fit = format!("shape {shape:.2}, mean {mean:.*} mmHg/mm\u{b2}", decimals(mean).min(9));
                format!("u {}: {risk}, {by_fit} by the fit ({fit})", name(class))
            }
            None if found.distance.is_nan() => format!("u {}: {risk}", name(class)),
            None => format!("u {}: {risk}; no gamma distribution fits", name(class)),
        };
        Histogram { heading, density: density.collect(), fit }
    };
    let classes = outcome.result.classes.iter().map(|(class, _)| *class).zip(&found.classes);
    let histograms =
        Histograms { threshold: mmhg_per_mm2(found.threshold), classes: classes.map(one).collect(), edges: edges.clone() };
    hypertension(&histograms)
}

/// The quantities of a vessel in the order of edges.csv: name, unit, start of the names of its columns; column of its variation, and name of that.
const QUANTITIES: [[&str; 5]; 4] = [
    ["flow", "mL/min", "flow_mL_per_min", "flow_variation", "variation of flow"],
    ["pressure drop", "mmHg", "drop_mmHg", "drop_variation", "variation of pressure drop"],
    ["resilience \u{3c1}", "W/m\u{b3}", "resilience_W_per_m3", "resilience_variation", "variation of resilience"],
    ["hypertension", "mmHg/mm\u{b2}", "hypertension_mmHg_per_mm2", "hypertension_variation", "variation of hypertension"],
];

/// The figures of the page.
const FACTS: [(&str, &str, &str); 8] = [
    ("nodes", "/counts/nodes", ""),
    ("vessels", "/counts/vessels", ""),
    ("instances per class", "/parameters/samples", ""),
    ("reading", "/parameters/reading", ""),
    ("seed", "/seed", ""),
    ("\u{3c1}_G unperturbed", "/unperturbed/rho_G_W_per_m3", "W/m\u{b3}"),
    ("inflow unperturbed", "/unperturbed/total_inflow_mL_per_min", "mL/min"),
    ("threshold of hypertension", "/parameters/threshold_mmHg_per_mm2", "mmHg/mm\u{b2}"),
];

/// The page of a modulation from its tables: classes, nodes, vessels and hypertension.
fn page(outcome: &ModulationRun<'_>, of_run: &RunRecord, tables: [Vec<Column>; 4], figures: Vec<PagePicture>) -> Page {
    let mut page = Page::new("modulate", of_run, scene(&outcome.network, &outcome.boundary), figures);
    page.lead = lead::modulation(&page.record);
    page.facts = facts(&page.record, &FACTS);
    let classes: Vec<String> = outcome.result.classes.iter().map(|(class, _)| class.to_string()).collect();
    page.colourings = colourings(&classes);
    let [of_classes, nodes, vessels, hypertension] = tables;
    let of = |(at, class)| PageTable::new(format!("Vessels, u in {class}"), of_class(outcome, &vessels, at), true);
    page.tables = classes.iter().enumerate().map(of).collect();
    let others = [("Classes", of_classes), ("Nodes", nodes), ("Hypertension", hypertension)];
    page.tables.extend(others.map(|(title, columns)| PageTable::new(title, columns, false)));
    page.tables.extend(condition_table(&of_run.conditions));
    page
}

/// One row per vessel, from the rows of edges.csv of one class; these are in the order of class, vessel, quantity (flow, drop, resilience,
/// hypertension).
fn of_class(outcome: &ModulationRun<'_>, tidy: &[Column], class: usize) -> Vec<Column> {
    let vessels = outcome.network.vessel_count();
    let row = |vessel: usize, quantity: usize| (class * vessels + vessel) * QUANTITIES.len() + quantity;
    let figures = |name: &str| match tidy.iter().find(|c| c.name == name).map(|c| &c.values) {
        Some(Values::Real(values)) => &values[..],
        _ => &[],
    };
    let first = |column: &&Column| ["edge", "node_a", "node_b", "label"].contains(&&*column.name);
    let rows: Vec<usize> = (0..vessels).map(|vessel| row(vessel, 0)).collect();
    let mut columns: Vec<Column> = tidy.iter().filter(first).map(|column| crate::inference::picked(column, &rows)).collect();
    for (quantity, [_, _, name, variation_name, _]) in QUANTITIES.into_iter().enumerate() {
        let of = |name: &str| (0..vessels).map(|v| figures(name)[row(v, quantity)]).collect::<Vec<f64>>();
        let (mean, std) = (of("mean"), of("std"));
        let variation = mean.iter().zip(&std).map(|(mean, std)| if *mean == 0.0 { f64::NAN } else { std / mean.abs() });
        let variation: Vec<f64> = variation.collect();
        columns.extend([
            Column::real(format!("{name}_mean"), mean.into_iter()),
            Column::real(format!("{name}_std"), std.into_iter()),
            Column::real(variation_name, variation.into_iter()),
            Column::real(format!("{name}_unperturbed"), of("unperturbed").into_iter()),
        ]);
    }
    columns
}

fn colourings(classes: &[String]) -> Vec<Colouring> {
    let by_class = |column: String| {
        let variant = move |(at, class): (usize, &String)| (format!("u in {class}"), at, column.clone());
        classes.iter().enumerate().map(variant)
    };
    let each = QUANTITIES.into_iter().map(|[name, unit, column, variation, of]| {
        let at_rest = std::iter::once(("unperturbed".to_owned(), 0, format!("{column}_unperturbed")));
        let mean = Colouring::new(name, unit, ColourScale::Log, by_class(format!("{column}_mean")).chain(at_rest).collect());
        [mean, Colouring::new(of, "std / |mean|", ColourScale::Log, by_class(variation.to_owned()).collect())]
    });
    each.flatten().collect()
}
