//! Periodic signals by their harmonics: f(t) = Re Σ c_n e^{iω_n t}, ω_n = 2πn/T, c_0 the mean. And the figures by which the trade
//! describes a waveform: pulsatility, resistance, reversed share, delay.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::network::waveform::Waveform;

/// c_0 to c_H of the line through the points of a waveform, exactly, without taking samples: by parts, a slope s between t and t' gives
/// 2s (e^{-iωt'} - e^{-iωt})/(ω²T), and a step gives 2 step e^{-iωt}/(iωT). c_0 is the mean by the trapezoid rule.
pub fn coefficients(waveform: &Waveform, period: f64, harmonics: usize) -> Vec<Complex64> {
    let (mut t, mut f) = (waveform.times.clone(), waveform.values.clone());
    if t[t.len() - 1] - t[0] < period * (1.0 - 1e-12) {
        t.push(t[0] + period);
        f.push(f[0]);
    }
    let pieces = || t.windows(2).zip(f.windows(2));
    let mean = pieces().map(|(t, f)| f64::midpoint(f[0], f[1]) * (t[1] - t[0])).sum::<f64>() / period;
    let mut out = vec![Complex64::new(mean, 0.0)];
    for n in 1..=harmonics {
        let frequency = TAU * n as f64 / period;
        let at = |t: f64| Complex64::cis(-frequency * t);
        let (mut steps, mut slopes) = (at(t[0]) * (f[0] - f[f.len() - 1]), Complex64::ZERO);
        for (t, f) in pieces() {
            if t[1] > t[0] {
                slopes += (at(t[1]) - at(t[0])) * ((f[1] - f[0]) / (t[1] - t[0]));
            } else {
                steps += at(t[0]) * (f[1] - f[0]);
            }
        }
        out.push((steps / Complex64::new(0.0, frequency) + slopes / (frequency * frequency)) * (2.0 / period));
    }
    out
}

/// The share of a waveform's variance in the harmonics above those given; at least zero.
pub fn beyond(waveform: &Waveform, period: f64, coefficients: &[Complex64]) -> f64 {
    let (mut t, mut f) = (waveform.times.clone(), waveform.values.clone());
    t.push(t[0] + period);
    f.push(f[0]);
    let mean = coefficients[0].re;
    let square = |t: &[f64], f: &[f64]| {
        let (a, b) = (f[0] - mean, f[1] - mean);
        (a * a + a * b + b * b) / 3.0 * (t[1] - t[0])
    };
    let variance: f64 = t.windows(2).zip(f.windows(2)).map(|(t, f)| square(t, f)).sum::<f64>() / period;
    let held: f64 = coefficients[1..].iter().map(|c| c.norm_sqr() / 2.0).sum();
    if variance > 0.0 { (1.0 - held / variance).max(0.0) } else { 0.0 }
}

/// The values of a signal at `count` even times in [0, T).
pub fn samples(coefficients: &[Complex64], count: usize) -> Vec<f64> {
    let turns: Vec<Complex64> = (0..count).map(|k| Complex64::cis(TAU * k as f64 / count as f64)).collect();
    let value = |k: usize| coefficients.iter().enumerate().map(|(n, c)| (c * turns[n * k % count]).re).sum();
    (0..count).map(value).collect()
}

/// The value of a signal of period T (s) at a time (s).
pub fn at(coefficients: &[Complex64], time: f64, period: f64) -> f64 {
    coefficients.iter().enumerate().map(|(n, c)| (c * Complex64::cis(TAU * n as f64 * time / period)).re).sum()
}

/// The coefficients of the derivative of a signal of period T, per s.
pub fn derivative(coefficients: &[Complex64], period: f64) -> Vec<Complex64> {
    coefficients.iter().enumerate().map(|(n, c)| c * Complex64::new(0.0, TAU * n as f64 / period)).collect()
}

/// Even times of a period at which a waveform is looked at.
const TIMES: usize = 1000;

/// The figures of a waveform. Those that a mean of zero leaves undefined are NaN, as all but the mean are of a waveform whose harmonics are undefined.
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
        let (low, high) = values.iter().fold((f64::NAN, f64::NAN), |(low, high), x| (low.min(*x), high.max(*x)));
        let against: f64 = values.iter().map(|x| (-forward * x).max(0.0)).sum();
        let all: f64 = values.iter().map(|x| x.abs()).sum();
        let first = coefficients.get(1).map_or(0.0, |c| -(c * forward).arg() / TAU * period);
        let top = if forward > 0.0 { high } else { -low };
        let defined = mean.abs() > rounding && high >= low;
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
