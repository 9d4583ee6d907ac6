//! Logistic regression with a penalty of large slopes.

use ndarray::ArrayView1;

use super::minimise::minimise;
use willis_core::support::calibration::Calibration;
use willis_core::support::statistics::sigmoid;

const ITERATIONS: usize = 300;

/// A row of a regression: its columns, of which the first is constant, whether it is true, and how much it counts.
pub type RegressionRow = (Vec<f64>, bool, f64);

/// The coefficients that minimise Σ ω (ln(1 + e^z) - z true) / Σ ω + l2 Σ b'², b' the slopes times the standard deviation of
/// their column; the constant is free. Zeros without a row.
pub fn logistic(rows: &[RegressionRow], l2: f64) -> Vec<f64> {
    let columns = rows.first().map_or(0, |(x, ..)| x.len());
    let total: f64 = rows.iter().map(|(.., weight)| weight).sum();
    let design: Vec<ArrayView1<f64>> = rows.iter().map(|(x, ..)| ArrayView1::from(x)).collect();
    let scale: Vec<f64> = spread(columns, &design).into_iter().map(|spread| if spread > 0.0 { spread } else { 1.0 }).collect();
    let loss = |y: &[f64]| {
        let mut value = l2 * y.iter().skip(1).map(|y| y * y).sum::<f64>();
        let mut slope: Vec<f64> = y.iter().enumerate().map(|(k, y)| if k > 0 { 2.0 * l2 * y } else { 0.0 }).collect();
        for (x, is_true, weight) in rows {
            let z: f64 = y.iter().zip(x).zip(&scale).map(|((y, x), s)| y / s * x).sum();
            let truth = f64::from(u8::from(*is_true));
            value += weight / total * (z.max(0.0) + (-z.abs()).exp().ln_1p() - truth * z);
            let residual = weight / total * (sigmoid(z) - truth);
            slope.iter_mut().zip(x).zip(&scale).for_each(|((g, x), s)| *g += residual * x / s);
        }
        (value, slope)
    };
    let found = minimise(vec![0.0; columns], ITERATIONS, &loss).point;
    found.iter().zip(&scale).map(|(y, s)| y / s).collect()
}

/// The standard deviation of each column over some rows; 0 without a row.
pub(crate) fn spread(columns: usize, rows: &[ArrayView1<f64>]) -> Vec<f64> {
    let mean_of = |f: &dyn Fn(usize, f64) -> f64| {
        let mut sum = vec![0.0; columns];
        for row in rows {
            sum.iter_mut().zip(row).enumerate().for_each(|(column, (sum, x))| *sum += f(column, *x));
        }
        sum.into_iter().map(|s| s / rows.len().max(1) as f64).collect::<Vec<f64>>()
    };
    let mean = mean_of(&|_, x| x);
    mean_of(&|column, x| (x - mean[column]).powi(2)).into_iter().map(f64::sqrt).collect()
}

const L2: f64 = 1e-5;

/// a and b of P = σ(a + b l) of probabilities with whether they were right, l their log-odds; b is at least 0, so that the order stays.
/// `None` without a pair.
pub fn calibrate_in_order(pairs: &[(f64, bool)]) -> Option<[f64; 2]> {
    let rows = |columns: usize| -> Vec<RegressionRow> {
        pairs.iter().map(|(p, right)| (Calibration::design(*p)[..columns].to_vec(), *right, 1.0)).collect()
    };
    match logistic(&rows(2), L2)[..] {
        [a, b] if b >= 0.0 => Some([a, b]),
        [..] => logistic(&rows(1), L2).first().map(|a| [*a, 0.0]),
    }
}

/// The calibration of pairs of points with their probability by the model, further figures beside it, whether they are right, and how much
/// each counts; and the slopes of the further figures.
pub fn calibrate<const N: usize>(pairs: impl Iterator<Item = (f64, [f64; N], bool, f64)>) -> ([f64; 3], [f64; N]) {
    let rows: Vec<RegressionRow> =
        pairs.map(|(p, further, right, weight)| ([&Calibration::design(p)[..], &further].concat(), right, weight)).collect();
    let found = logistic(&rows, L2);
    let at = |k: usize| found.get(k).copied().unwrap_or(0.0);
    (std::array::from_fn(at), std::array::from_fn(|k| at(3 + k)))
}
