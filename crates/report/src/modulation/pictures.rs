//! The pictures of a resistance modulation: their boxes and histograms from the instances.

use super::outcome::ModulationRun;
use crate::figures::figure::Figure;
use crate::figures::hypertension::{Histogram, Histograms};
use crate::figures::modulation::{Boxes, Panel};
use willis_core::modulation::{BINS, Class, Hypertension, Instances};
use willis_core::network::units::{mmhg, mmhg_per_mm2};
use willis_core::support::Distribution;
use willis_core::support::gamma::Gamma;

/// The name of a class in the pictures.
fn name(class: Class) -> String {
    format!("{}\u{2013}{}", class.low, class.high)
}

/// The picture `modulation`: change of pressure, and flow and resilience divided by those of the unperturbed network.
pub fn response(outcome: &ModulationRun<'_>) -> Figure {
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
    crate::figures::modulation::modulation(&names, &panels)
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
pub fn hypertension(outcome: &ModulationRun<'_>) -> Figure {
    let found = &outcome.hypertension;
    let vessels = outcome.result.unperturbed.force.iter().filter(|force| **force > 0.0).count();
    let many = bins_in_one(vessels);
    let edges: Vec<f64> = found.edges.iter().take(BINS + 1).step_by(many).map(|edge| mmhg_per_mm2(*edge)).collect();
    let one = |(class, found): (Class, &Hypertension)| {
        let total = found.counts.iter().sum::<u64>() as f64;
        let counts = found.counts.chunks(many).map(|counts| counts.iter().sum::<u64>() as f64);
        let density = counts.zip(edges.windows(2)).map(|(count, bin)| count / (total * (bin[1] - bin[0])));
        let fit = found.fit.filter(|_| found.distance <= FAR / (vessels as f64).sqrt());
        let fit = fit.map(|fit| Gamma { scale: mmhg_per_mm2(fit.gamma.scale), ..fit.gamma });
        let percent = |share: f64| if share.is_nan() { "-".to_owned() } else { format!("{:.1} %", 100.0 * share) };
        let risk = format!("{} at risk", percent(found.above));
        let heading = match fit {
            Some(gamma) => {
                let (shape, mean, by_fit) = (gamma.shape, figures(gamma.shape * gamma.scale), percent(found.above_by_fit));
                format!("u {}: {risk}, {by_fit} by the fit (shape {shape:.2}, mean {mean} mmHg/mm\u{b2})", name(class))
            }
            None if found.distance.is_nan() => format!("u {}: {risk}", name(class)),
            None => format!("u {}: {risk}; no gamma distribution fits", name(class)),
        };
        Histogram { heading, density: density.collect(), fit }
    };
    let classes = outcome.result.classes.iter().map(|(class, _)| *class).zip(&found.classes);
    let histograms =
        Histograms { threshold: mmhg_per_mm2(found.threshold), classes: classes.map(one).collect(), edges: edges.clone() };
    crate::figures::hypertension::hypertension(&histograms)
}

/// A positive number with three digits.
fn figures(x: f64) -> String {
    let decimals = (2.0 - x.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{x:.decimals$}")
}
