//! Fits the calibration: a logistic regression of "the link is right" on the log-odds of the model.

use super::calibration::Calibration;
use super::minimise::minimise;

const L2: f64 = 1e-5;
const ITERATIONS: usize = 300;

/// The calibration of links with their probability by the model, whether they are right, and how much each counts: minimises
/// Σ ω (ln(1 + e^z) - z right) / Σ ω + 1e-5 (b'² + c'²), b' and c' the slopes times the standard deviation of their column.
pub fn calibrate(links: &[(f64, bool, f64)]) -> Calibration {
    let total: f64 = links.iter().map(|(.., weight)| weight).sum();
    let rows: Vec<([f64; 3], f64, f64)> =
        links.iter().map(|(p, right, w)| (Calibration::design(*p), f64::from(u8::from(*right)), w / total)).collect();
    let mean = |f: &dyn Fn(&[f64; 3]) -> f64| rows.iter().map(|(x, ..)| f(x)).sum::<f64>() / rows.len().max(1) as f64;
    let scale = [0, 1, 2].map(|k| {
        let middle = mean(&|x| x[k]);
        let spread = mean(&|x| (x[k] - middle).powi(2)).sqrt();
        if spread > 0.0 { spread } else { 1.0 }
    });
    let loss = |y: &[f64]| {
        let (mut value, mut slope) = (L2 * (y[1] * y[1] + y[2] * y[2]), vec![0.0, 2.0 * L2 * y[1], 2.0 * L2 * y[2]]);
        for (x, right, weight) in &rows {
            let z: f64 = (0..3).map(|k| y[k] / scale[k] * x[k]).sum();
            value += weight * (z.max(0.0) + (-z.abs()).exp().ln_1p() - right * z);
            let residual = weight * (1.0 / (1.0 + (-z).exp()) - right);
            slope.iter_mut().zip(x).zip(&scale).for_each(|((g, x), s)| *g += residual * x / s);
        }
        (value, slope)
    };
    let found = minimise(vec![0.0; 3], ITERATIONS, &loss).point;
    Calibration([0, 1, 2].map(|k| found[k] / scale[k]))
}
