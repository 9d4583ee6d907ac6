//! Which ways to draw masks, and which control variates, make the standard error of L smaller at equal cost.
//!
//! `variance GRAPH` writes rows of CSV for one graph to standard output: `header`, `circle-20`, or the stem of a
//! benchmark graph.

mod array;
mod cost;
mod exact;
mod masks;
mod model;
mod moments;

use std::path::Path;

use rayon::prelude::*;
use willis::error::Result;
use willis::internals::formats::{Content, ReadOptions, read};
use willis::internals::network::Network;
use willis::internals::phantom::{cerebral, circle_of_willis};
use willis::internals::support::statistics::{median, quantile};

use array::Shape;
use cost::Cost;
use exact::Exact;
use masks::{Masks, Scheme};
use model::{Model, Work};
use moments::{Control, Moments, Shares, Totals, second_order};

const EPSILON: f64 = 0.3;
/// Blocks of the long plain run: 2¹⁸ samples.
const LONG: u64 = 1 << 12;
/// Blocks of the run in pairs that bounds the second order, and the share of bits that a pair has in common.
const PAIRED: u64 = 1 << 10;
const IN_COMMON: f64 = 0.3;
/// Vessels that are in fewer forests than this share say little about a scheme in replicates this short.
const RARE: f64 = 0.01;

const HEADER: &str = "graph,kind,scheme,vessels,q10,median,q90,near,wrong,cost,equal_cost,rms_z,max_z,reported";

/// Masks and estimators in the order of the table.
const TRIALS: [(Scheme, Control); 15] = [
    (Scheme::Plain, Control::None),
    (Scheme::Antithetic, Control::None),
    (Scheme::Stratified, Control::None),
    (Scheme::Latin, Control::None),
    (Scheme::Net, Control::None),
    (Scheme::Array(Shape { levels: 3, digits: 7 }), Control::None),
    (Scheme::Array(Shape { levels: 13, digits: 3 }), Control::None),
    (Scheme::Array(Shape { levels: 7, digits: 5 }), Control::None),
    (Scheme::Plain, Control::Own),
    (Scheme::Plain, Control::Neighbours),
    (Scheme::Plain, Control::All),
    (Scheme::Plain, Control::OpenNeighbours),
    (Scheme::Plain, Control::OpenAll),
    (Scheme::Stratified, Control::OpenNeighbours),
    (Scheme::Stratified, Control::OpenAll),
];

fn main() -> Result<()> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "header".into());
    match name.as_str() {
        "header" => println!("{HEADER}"),
        "circle-20" => study(&name, &cerebral(&circle_of_willis(1e-3)), 1000)?,
        _ => {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/bench").join(format!("{name}.graphml"));
            if !path.exists() {
                eprintln!("skipped: {name}, the benchmark graphs are not here");
                return Ok(());
            }
            if let Content::Graph(network) = read(&path, &ReadOptions::default())?.content {
                study(&name, &network, if network.vessel_count() < 500 { 1000 } else { 200 })?;
            }
        }
    }
    Ok(())
}

/// What the schemes are held against.
struct Reference {
    /// Of one contribution, and the standard error of that mean.
    mean: Vec<f64>,
    error: Vec<f64>,
    variance: Vec<f64>,
    /// Vessels that are not rare, and the quarter of them nearest to the median threshold.
    common: Vec<usize>,
    near: Vec<usize>,
    /// The median of the means that are positive. Held fixed when decisions are compared: in short runs the median itself
    /// moves with the number of rare vessels seen at all, which no scheme is to blame for.
    threshold: f64,
}

impl Reference {
    fn new(model: &Model, long: &Moments, exact: Option<&Exact>) -> Self {
        let rows = 0..model.vessels();
        let mean: Vec<f64> = exact.map_or_else(|| long.sum.iter().map(|s| s / long.samples).collect(), |x| x.mean.clone());
        let variance = exact.map_or_else(|| rows.clone().map(|e| long.variance(e)).collect(), |x| x.variance.clone());
        let error = variance.iter().map(|v| if exact.is_some() { 0.0 } else { (v / long.samples).sqrt() }).collect();
        let mut common: Vec<usize> = rows.filter(|e| long.count[*e] >= RARE * long.samples && model.keep[*e] < 1.0).collect();
        let positive: Vec<f64> = mean.iter().copied().filter(|l| *l > 0.0).collect();
        let threshold = median(&positive).unwrap_or(0.0);
        let distance = |e: &usize| (mean[*e] / threshold).ln().abs();
        let mut near = common.clone();
        near.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        near.truncate(common.len().div_ceil(4));
        common.sort_unstable();
        Self { mean, error, variance, common, near, threshold }
    }

    /// How many vessels `likelihood`, of `n` samples, puts on the wrong side of the threshold; one that lies on it has none.
    fn wrong(&self, likelihood: &[f64], n: f64) -> usize {
        let off = self.common.iter().filter(|e| (self.mean[**e] / self.threshold - 1.0).abs() > 1e-9);
        off.filter(|e| (likelihood[**e] > n * self.threshold) != (self.mean[**e] > self.threshold)).count()
    }
}

fn study(name: &str, network: &Network, replicates: u64) -> Result<()> {
    let model = Model::new(name, network, EPSILON)?;
    let mut schemes: Vec<Scheme> = TRIALS.iter().filter(|t| t.1 == Control::None).map(|t| t.0).collect();
    schemes.retain(|s| !matches!(s, Scheme::Array(shape) if shape.vessels() < model.vessels() as u64));
    let cost = Cost::measure(&model, &schemes);
    let exact = Exact::of(&model);
    let long = Moments::of(&model, 0, LONG);
    let reference = Reference::new(&model, &long, exact.as_ref());
    eprintln!("{name}: {} vessels, {:.1} us a plain sample, {} replicates", model.vessels(), cost.plain_sample(), replicates);
    limits(&model, &long, &reference, exact.as_ref());
    for scheme in schemes {
        let controls: Vec<Control> = TRIALS.iter().filter(|t| t.0 == scheme).map(|t| t.1).collect();
        let long_enough = if scheme.samples() > 10_000 { replicates.min((1 << 20) / scheme.samples()) } else { replicates };
        let runs: Vec<Replicate> = (1..=long_enough)
            .into_par_iter()
            .map_init(Work::default, |work, seed| replicate(&model, &long, scheme, &controls, seed, work))
            .collect();
        for (at, control) in controls.iter().enumerate() {
            let estimates: Vec<&[f64]> = runs.iter().map(|r| &r.estimates[at][..]).collect();
            let relative = cost.relative(scheme, *control);
            let plain_error = *control == Control::None && !matches!(scheme, Scheme::Net | Scheme::Array(_));
            let reported: Option<Vec<&[f64]>> = plain_error.then(|| runs.iter().map(|r| &r.variance[..]).collect());
            report(name, &label(scheme, *control), &reference, (scheme.samples(), &estimates), reported.as_deref(), relative);
        }
    }
    Ok(())
}

fn label(scheme: Scheme, control: Control) -> String {
    match (scheme, control) {
        (_, Control::None) => scheme.name(),
        (Scheme::Plain, _) => format!("control: {}", control.name()),
        _ => format!("stratified; control: {}", control.name()),
    }
}

/// L of each vessel by each control, and its variance as estimated from the spread between blocks.
struct Replicate {
    estimates: Vec<Vec<f64>>,
    variance: Vec<f64>,
}

fn replicate(model: &Model, long: &Moments, scheme: Scheme, controls: &[Control], seed: u64, work: &mut Work) -> Replicate {
    let pairs = controls.iter().any(|c| matches!(c, Control::OpenNeighbours | Control::OpenAll));
    let totals = Totals::of(model, &mut Masks::new(scheme, &model.keep, seed), scheme.samples(), pairs, work);
    let blocks = (scheme.samples() / 64) as f64;
    let spread = totals.sum.iter().zip(&totals.block_square);
    Replicate {
        estimates: controls
            .iter()
            .map(|control| (0..model.vessels()).map(|e| totals.estimate(*control, model, long, e)).collect())
            .collect(),
        variance: spread.map(|(sum, square)| blocks / (blocks - 1.0) * (square - sum * sum / blocks)).collect(),
    }
}

/// The limits: what the standard error is divided by when a share of the variance is gone.
fn limits(model: &Model, long: &Moments, reference: &Reference, exact: Option<&Exact>) {
    let shares: Vec<Shares> = (0..model.vessels()).map(|e| long.shares(model, e)).collect();
    let second = second_order(model, 1 << 32, PAIRED, IN_COMMON, long);
    let kinds: [(&str, &dyn Fn(usize) -> f64); 7] = [
        ("own bit", &|e| shares[e].own),
        ("own and neighbours' bits", &|e| shares[e].neighbours),
        ("all bits: first order", &|e| shares[e].all),
        ("ratio + neighbours' bits if open", &|e| shares[e].open_neighbours),
        ("ratio + all bits if open", &|e| shares[e].open_all),
        ("first and second order (at most)", &|e| shares[e].all + second[e].max(0.0)),
        ("vessel forced open", &|e| shares[e].forced),
    ];
    for (kind, share) in kinds {
        limit(&model.name, kind, reference, share);
    }
    if let Some(exact) = exact {
        limit(&model.name, "exact first order", reference, |e| exact.orders[e][0]);
        limit(&model.name, "exact first and second order", reference, |e| exact.orders[e][..2].iter().sum());
        limit(&model.name, "exact first to third order", reference, |e| exact.orders[e][..3].iter().sum());
    }
}

fn limit(graph: &str, kind: &str, reference: &Reference, share: impl Fn(usize) -> f64) {
    let ratio = |e: &usize| 1.0 / (1.0 - share(*e)).max(1e-9).sqrt();
    let ratios: Vec<f64> = reference.common.iter().map(ratio).collect();
    let near: Vec<f64> = reference.near.iter().map(ratio).collect();
    println!("{graph},limit,{kind},{},{},,,,,,", ratios.len(), quantiles(&ratios, &near));
}

fn quantiles(ratios: &[f64], near: &[f64]) -> String {
    let q = |q: f64| quantile(ratios, q).unwrap_or(f64::NAN);
    format!("{:.3},{:.3},{:.3},{:.3}", q(0.1), q(0.5), q(0.9), median(near).unwrap_or(f64::NAN))
}

/// One row: ratios of standard errors, decisions that differ from the reference's, cost, bias.
fn report(
    graph: &str,
    scheme: &str,
    reference: &Reference,
    (n, estimates): (u64, &[&[f64]]),
    reported: Option<&[&[f64]]>,
    cost: f64,
) {
    let (n, r) = (n as f64, estimates.len() as f64);
    let mean: Vec<f64> = (0..reference.mean.len()).map(|e| estimates.iter().map(|x| x[e]).sum::<f64>() / r).collect();
    let variance = |e: usize| estimates.iter().map(|x| (x[e] - mean[e]).powi(2)).sum::<f64>() / (r - 1.0);
    let ratio = |e: &usize| (n * reference.variance[*e] / variance(*e)).sqrt();
    let ratios: Vec<f64> = reference.common.iter().map(ratio).collect();
    let near: Vec<f64> = reference.near.iter().map(ratio).collect();
    let z = |e: &usize| {
        let error = (variance(*e) / r + (n * reference.error[*e]).powi(2)).sqrt();
        (mean[*e] - n * reference.mean[*e]) / error
    };
    let z: Vec<f64> = reference.common.iter().map(z).collect();
    let rms = (z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64).sqrt();
    let most = z.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
    // Comparable at one number of samples only.
    let wrong = estimates.iter().map(|x| reference.wrong(x, n)).sum::<usize>() as f64 / r;
    let wrong = if n == Scheme::Plain.samples() as f64 { format!("{wrong:.2}") } else { String::new() };
    let reported = reported.map_or_else(String::new, |reported| {
        let said = |e: &usize| (reported.iter().map(|v| v[*e]).sum::<f64>() / r / variance(*e)).sqrt();
        format!("{:.3}", median(&reference.common.iter().map(said).collect::<Vec<_>>()).unwrap_or(f64::NAN))
    });
    println!(
        "{graph},scheme,{scheme},{},{},{wrong},{cost:.2},{:.3},{rms:.2},{most:.2},{reported}",
        ratios.len(),
        quantiles(&ratios, &near),
        median(&ratios).unwrap_or(f64::NAN) / cost.sqrt(),
    );
}
