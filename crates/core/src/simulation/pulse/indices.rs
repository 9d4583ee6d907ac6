//! The figures by which the trade describes a waveform: pulsatility, resistance, reversed share, delay.

use std::f64::consts::TAU;

use num_complex::Complex64;

use super::fourier::samples;

/// Even times of a period at which a waveform is looked at.
const TIMES: usize = 1000;

/// The figures of a waveform. Those that a mean of zero leaves undefined are NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Indices {
    /// The mean, with its sign.
    pub mean: f64,
    /// The largest value.
    pub max: f64,
    /// The smallest value.
    pub min: f64,
    /// (max - min)/|mean| (Gosling).
    pub pulsatility: f64,
    /// (max - min)/max along the direction of the mean (Pourcelot).
    pub resistive: f64,
    /// ∫ of what moves against the mean over ∫ of |f|.
    pub reversed_share: f64,
    /// What moves against the mean in a period: ∫, unit of f times s.
    pub reversed: f64,
    /// The phase of the first harmonic along the mean as a time, s, in (-T/2, T/2] when taken from that of a reference.
    pub phase: f64,
}

impl Indices {
    /// The figures of a signal of period T (s). A mean below `rounding` is none.
    pub fn of(coefficients: &[Complex64], period: f64, rounding: f64) -> Self {
        let mean = coefficients[0].re;
        let forward = if mean < 0.0 { -1.0 } else { 1.0 };
        let values = samples(coefficients, TIMES);
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
        let against: f64 = values.iter().map(|x| (-forward * x).max(0.0)).sum();
        let all: f64 = values.iter().map(|x| x.abs()).sum();
        let first = coefficients.get(1).map_or(0.0, |c| -(c * forward).arg() / TAU * period);
        let top = if forward > 0.0 { high } else { -low };
        let defined = mean.abs() > rounding;
        let only = |x: f64| if defined { x } else { f64::NAN };
        Self {
            mean,
            max: high,
            min: low,
            pulsatility: only((high - low) / mean.abs()),
            resistive: only((high - low) / top),
            reversed_share: only(if all > 0.0 { against / all } else { 0.0 }),
            reversed: only(against / TIMES as f64 * period),
            phase: only(first),
        }
    }
}

/// A time taken from a reference, in (-T/2, T/2].
pub fn behind(time: f64, reference: f64, period: f64) -> f64 {
    let late = (time - reference).rem_euclid(period);
    if late > period / 2.0 { late - period } else { late }
}
