//! Fits the calibration: a logistic regression of "the link is right" on the log-odds of the model.

use super::calibration::Calibration;
use super::logistic::{Row, logistic};

const L2: f64 = 1e-5;

/// The calibration of links with their probability by the model, whether they are right, and how much each counts.
pub fn calibrate(links: &[(f64, bool, f64)]) -> Calibration {
    let rows: Vec<Row> = links.iter().map(|(p, right, weight)| (Calibration::design(*p).to_vec(), *right, *weight)).collect();
    let found = logistic(&rows, L2);
    Calibration([0, 1, 2].map(|k| found.get(k).copied().unwrap_or(0.0)))
}
